// The force on the hand over the last ten seconds, beside what the arm may give.
const kSeconds = 10, kEvery = 30;  // s; ms from one drawing to the next

const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class ForcePlot {
  constructor(parent) {
    this.parent = parent;
    this.times = [];  // s, of the physics clock
    this.norms = [];
    this.limits = null;
    this.changed = false;
    this.drawn = 0;
    const axis = { stroke: ink('--soft'), grid: { stroke: ink('--line'), width: 1 }, ticks: { stroke: ink('--line') } };
    this.plot = new uPlot({
      ...this.size(),
      scales: { x: { time: false }, y: { range: (u, low, high) => [0, Math.max(1, high * 1.1)] } },
      axes: [{ ...axis, values: (u, splits) => splits.map((s) => s.toFixed(0) + ' s') },
        { ...axis, values: (u, splits) => splits.map((n) => n + ' N'), size: 56 }],
      cursor: { drag: { x: false, y: false } },
      series: [{ label: 'time', value: (u, s) => (s === null ? '' : s.toFixed(2) + ' s') },
        { label: 'force', stroke: ink('--notice'), width: 1.5, value: (u, n) => (n === null ? '' : n.toFixed(2) + ' N') },
        { label: 'limit for long', stroke: ink('--warning'), dash: [6, 4], width: 1,
          value: (u, n) => (n === null ? '' : n.toFixed(2) + ' N') }],
    }, [[], [], []], parent);
    new ResizeObserver(() => this.plot.setSize(this.size())).observe(parent);
  }

  size() {
    const width = Math.max(200, this.parent.clientWidth);
    return { width, height: width < 400 ? 206 : 286 };  // the legend below takes what it needs
  }

  setLimits(limits) { this.limits = limits; }

  add(message) {
    const end = Number(BigInt(message.t_ns) / 1000n) / 1e6;
    // Of those that come together the largest: a blow of a millisecond is seen, and there is no more to draw than is seen.
    const norms = message.force.map(([x, y, z]) => Math.hypot(x, y, z));
    const largest = norms.indexOf(Math.max(...norms));
    const t = end + message.dt_ms[largest] / 1e3;
    // Another server's clock has begun anew, or stepped.
    if (this.times.length && t < this.times[this.times.length - 1]) this.times.length = this.norms.length = 0;
    this.times.push(t);
    this.norms.push(norms[largest]);
    const first = this.times.findIndex((t) => t >= end - kSeconds);
    if (first > 0) { this.times.splice(0, first); this.norms.splice(0, first); }
    this.changed = true;
  }

  draw() {
    if (!this.changed || !this.times.length || performance.now() - this.drawn < kEvery) return;
    this.drawn = performance.now();
    this.changed = false;
    const newest = this.times[this.times.length - 1];
    const limit = this.limits ? this.limits.continuous : null;
    this.plot.setData([this.times.map((t) => t - newest), this.norms, this.times.map(() => limit)], false);
    this.plot.setScale('x', { min: -kSeconds, max: 0 });
    // The legend tells the newest values where the pointer asks for no others.
    if (!(this.plot.cursor.left >= 0)) this.plot.setLegend({ idx: this.times.length - 1 }, false);
  }
}
