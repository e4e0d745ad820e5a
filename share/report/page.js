// Draws the page's plots and clouds from the data elements in them, in the colours of the reader's light or dark setting.
//
//   <figure class="plot" data-x="s" data-y="px" ...> <figcaption class="above">title</figcaption>
//     <data class="series" data-name="tip" data-tone="ours" data-mark="points" data-x="[0,1]" data-y="[0.2,0.3]"></data>
//     <data class="series" data-name="tip" data-mark="bars"> <data data-x="before" data-y="3.1" data-written="3.1"></data> </data>
//     <data class="level" data-at="0.3" data-to="0.4" data-label="limit" data-tone="good" data-upright></data>
//   <figure class="cloud" data-unit="mm"> <data class="group" data-name="arm" data-tone="ours" data-p="[x,y,z,...]"></data>
'use strict';
(() => {
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
  const faded = (colour, alpha) => {
    const v = parseInt(colour.slice(1), 16);
    return `rgba(${v >> 16},${(v >> 8) & 255},${v & 255},${alpha})`;
  };
  const touch = matchMedia('(pointer: coarse)').matches;

  const list = (text) => (text ? JSON.parse(text) : []);

  // A series with points of its own has them as elements: those that there are, a template decides.
  const TONES = ['ours', 'rival', 'third', 'fourth', 'good', 'bad'];
  function seriesOf(element, number) {
    const d = element.dataset, own = [...element.children].map((e) => e.dataset);
    const told = own.some((p) => 'written' in p);
    return {
      name: d.name || '', mark: d.mark || 'line', tone: d.tone || TONES[number % TONES.length], legend: !('quiet' in d), dashed: 'dashed' in d, filled: 'filled' in d,
      x: own.length ? own.map((p) => p.x) : list(d.x), y: own.length ? own.map((p) => Number(p.y)) : list(d.y),
      hover: list(d.hover), written: own.length && told ? own.map((p) => p.written || '') : list(d.written),
    };
  }

  function plotOf(figure) {
    const d = figure.dataset, plot = { x: d.x || '', y: d.y || '' };
    for (const flag of ['equal', 'logx', 'logy', 'sideways', 'flipx', 'flipy', 'zero', 'stacked']) plot[flag] = flag in d;
    for (const range of ['xrange', 'yrange']) if (d[range]) plot[range] = JSON.parse(d[range]);
    plot.series = [...figure.querySelectorAll('data.series')].map(seriesOf);
    plot.levels = [...figure.querySelectorAll('data.level')].map((e) => ({
      at: Number(e.dataset.at), to: Number(e.dataset.to || e.dataset.at), label: e.dataset.label || '', tone: e.dataset.tone || 'muted',
      upright: 'upright' in e.dataset,
    }));
    return plot;
  }

  // Where a figure is drawn: below its title.
  function placed(figure, kind, height) {
    const title = figure.querySelector('figcaption.above');
    const place = document.createElement(kind);
    place.className = 'canvas';
    place.style.height = `${figure.dataset.height || height}px`;
    place.setAttribute('role', 'img');
    place.setAttribute('aria-label', title.textContent);
    title.after(place);
    return place;
  }

  function trace(s, plot) {
    const colour = css(s.tone);
    const t = { name: s.name, x: s.x, y: s.y, showlegend: s.legend && s.name !== '' };
    if (s.hover.length) Object.assign(t, { text: s.hover, hoverinfo: 'text' });
    if (s.mark === 'bars') {
      Object.assign(t, { type: 'bar', marker: { color: colour } });
      if (s.written.length) Object.assign(t, { text: s.written, textposition: 'outside', cliponaxis: false, textfont: { color: css('ink') } });
      if (plot.sideways) Object.assign(t, { orientation: 'h', x: s.y, y: s.x });
    } else {
      t.type = 'scatter';
      t.mode = s.mark === 'points' ? 'markers' : 'lines';
      t.line = { color: colour, width: 1.8, dash: s.dashed ? 'dash' : 'solid', shape: s.mark === 'steps' ? 'hv' : 'linear' };
      t.marker = { color: faded(colour, 0.75), size: 4.5 };
      if (s.mark === 'area') Object.assign(t, { fill: 'tozeroy', fillcolor: faded(colour, 0.18) });
      if (s.filled) Object.assign(t, { fill: 'toself', fillcolor: faded(colour, 0.15), line: { width: 0 }, hoverinfo: 'skip' });
    }
    return t;
  }

  // Ticks of a logarithmic axis: as fine as it takes for several to fall among the values.
  function logTicks(values) {
    const seen = values.filter((v) => v > 0), span = Math.max(...seen) / Math.min(...seen);
    const steps = span < 2.5 ? [1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 9] : span < 15 ? [1, 1.5, 2, 3, 4, 6, 8] : [1, 2, 5];
    const ticks = [];
    for (let e = -9; e < 7; e++) for (const m of steps) ticks.push(m * 10 ** e);
    return { type: 'log', tickvals: ticks, ticktext: ticks.map((v) => String(Number(v.toPrecision(2)))) };
  }

  function axis(label, log, range, values) {
    const a = {
      title: { text: log ? `${label} (log scale)` : label, font: { size: 13, color: css('soft') }, standoff: 8 }, gridcolor: css('line'), zerolinecolor: css('line'),
      linecolor: css('muted'), tickfont: { color: css('soft') },
    };
    if (log) Object.assign(a, logTicks(range || values));
    if (range) a.range = log ? range.map(Math.log10) : range;
    return a;
  }

  function layout(plot) {
    const l = {
      font: { family: getComputedStyle(document.body).fontFamily, size: 12.5, color: css('ink') },
      margin: { l: 50, r: plot.sideways ? 40 : 16, t: 34, b: 50 }, paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)', bargap: plot.sideways ? 0.35 : 0.06,
      legend: { orientation: 'h', x: 0, y: plot.levels.some((v) => v.upright) ? 1.07 : 1.01, yanchor: 'bottom', font: { size: 12 } }, dragmode: touch ? false : 'zoom', hovermode: 'closest',
      xaxis: axis(plot.x, plot.logx, plot.xrange, plot.series.flatMap((s) => s.x)),
      yaxis: axis(plot.y, plot.logy, plot.yrange, plot.series.flatMap((s) => s.y)), shapes: [], annotations: [],
      hoverlabel: { bgcolor: css('paper'), bordercolor: css('line'), font: { color: css('ink') } },
    };
    // Room for what stands beside each axis is found by itself, on that side alone: margins that chase each other draw a plot
    // again and again.
    l.xaxis.automargin = 'bottom';
    l.yaxis.automargin = 'left';
    if (plot.zero) l.yaxis.rangemode = 'tozero';
    if (plot.equal) Object.assign(l.yaxis, { scaleanchor: 'x', scaleratio: 1 });
    if (plot.flipx) l.xaxis.autorange = 'reversed';
    if (plot.flipy) l.yaxis.autorange = 'reversed';
    if (plot.sideways) Object.assign(l.yaxis, { autorange: 'reversed', ticksuffix: '  ' });
    if (plot.series.some((s) => s.mark === 'bars' && typeof s.x[0] === 'number')) { l.barmode = 'overlay'; l.bargap = 0; }
    if (plot.stacked) l.barmode = 'stack';
    for (const level of plot.levels) {
      const colour = css(level.tone);
      const log = level.upright ? plot.logx : plot.logy;
      const line = { type: 'line', line: { color: colour, width: 1.4, dash: 'dot' } };
      if (level.to !== level.at) Object.assign(line, { type: 'rect', fillcolor: faded(colour, 0.12), layer: 'below' });
      const note = { text: level.label, showarrow: false, bgcolor: faded(css('paper'), 0.8), borderpad: 1, font: { size: 11.5, color: colour } };
      if (level.upright) {
        l.shapes.push({ ...line, x0: level.at, x1: level.to, yref: 'paper', y0: 0, y1: 1 });
        l.annotations.push({ ...note, x: log ? Math.log10(level.at * level.to) / 2 : (level.at + level.to) / 2, yref: 'paper', y: 1, xanchor: 'center', yanchor: 'bottom' });
      } else {
        l.shapes.push({ ...line, y0: level.at, y1: level.to, xref: 'paper', x0: 0, x1: 1 });
        l.annotations.push({ ...note, y: log ? Math.log10(level.to) : level.to, xref: 'paper', x: 1, xanchor: 'right', yanchor: 'bottom' });
      }
    }
    return l;
  }

  // 1, 2 or 5 times a power of ten, of which some five make up the range.
  function roundStep(range) {
    const power = 10 ** Math.floor(Math.log10(Math.max(range, 1e-9) / 3));
    return power * [1, 2, 5, 10].find((m) => m * power >= range / 8);
  }
  const written = (v) => String(Number(v.toPrecision(10)));

  function cloud(figure) {
    const canvas = placed(figure, 'canvas', 380);
    const data = {
      unit: figure.dataset.unit, up: 1, turn: 35, tilt: 20,
      groups: [...figure.querySelectorAll('data.group')].map(({ dataset: d }) => ({
        name: d.name || '', tone: d.tone || 'ours', joined: 'joined' in d, size: Number(d.size || 2.5), p: list(d.p),
      })),
    };
    const all = [];
    for (const g of data.groups) for (let i = 0; i < g.p.length; i += 3) if (g.p[i] !== null) all.push(g.p.slice(i, i + 3));
    // The box around everything ends at round numbers, which can be written at its ends.
    const low = [0, 1, 2].map((k) => Math.min(...all.map((p) => p[k])));
    const high = [0, 1, 2].map((k) => Math.max(...all.map((p) => p[k])));
    for (let k = 0; k < 3; k++) {
      const step = roundStep(high[k] - low[k]);
      low[k] = step * Math.floor(low[k] / step);
      high[k] = step * Math.ceil(high[k] / step);
    }
    const ends = [0, 1, 2].map((k) => `${'xyz'[k]} from ${written(low[k])} to ${written(high[k])}`).join(', ');
    canvas.setAttribute('aria-label', `${canvas.getAttribute('aria-label')}; ${ends} ${data.unit}`);
    const middle = low.map((v, k) => (v + high[k]) / 2);
    const half = high.map((v, k) => Math.max(1e-9, (v - low[k]) / 2));
    const radius = Math.hypot(...half);
    // Axes in right-handed order with `up` second: right, up, towards the reader.
    const order = [(data.up + 2) % 3, data.up, (data.up + 1) % 3];
    let turn = (data.turn * Math.PI) / 180, tilt = (data.tilt * Math.PI) / 180;

    // The box, and along one outer edge for each axis its name and where it ends: what is written stands outside of the box.
    function drawBox(pen, see, [x, y]) {
      pen.strokeStyle = css('line');
      pen.fillStyle = css('soft');
      pen.lineWidth = 1;
      pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
      pen.textBaseline = 'middle';
      for (let a = 0; a < 3; a++) {
        const b = (a + 1) % 3, c = (a + 2) % 3, edges = [];
        for (const s of [low[b], high[b]]) for (const t of [low[c], high[c]]) {
          const p = [], q = [];
          p[a] = low[a]; q[a] = high[a]; p[b] = q[b] = s; p[c] = q[c] = t;
          const [x0, y0] = see(p), [x1, y1] = see(q);
          pen.beginPath(); pen.moveTo(x0, y0); pen.lineTo(x1, y1); pen.stroke();
          edges.push([x0, y0, x1, y1]);
        }
        // Across the axis, to the left for the upright one and down for the others.
        const [x0, y0, x1, y1] = edges[0], long = Math.hypot(x1 - x0, y1 - y0);
        if (long < 40) continue;  // it points at the reader
        let out = [(y1 - y0) / long, (x0 - x1) / long];
        if (a === data.up ? out[0] > 0 : out[1] < 0) out = out.map((v) => -v);
        const far = (e) => out[0] * ((e[0] + e[2]) / 2 - x) + out[1] * ((e[1] + e[3]) / 2 - y);
        const edge = edges.reduce((best, e) => (far(e) > far(best) ? e : best));
        pen.textAlign = Math.abs(out[0]) < 0.35 ? 'center' : out[0] < 0 ? 'right' : 'left';
        const write = (text, share) => pen.fillText(text, edge[0] + share * (edge[2] - edge[0]) + 12 * out[0], edge[1] + share * (edge[3] - edge[1]) + 12 * out[1]);
        write(written(low[a]), 0.06);  // a little inside the ends: two axes meet in a corner
        write(`${'xyz'[a]}, ${data.unit}`, 0.5);
        write(written(high[a]), 0.94);
      }
      pen.textAlign = 'left';
      pen.textBaseline = 'alphabetic';
    }

    function draw() {
      const width = canvas.clientWidth, height = canvas.clientHeight, dense = window.devicePixelRatio || 1;
      canvas.width = width * dense;
      canvas.height = height * dense;
      const pen = canvas.getContext('2d');
      pen.scale(dense, dense);
      // As large as the box allows at this tilt, whichever way it is turned.
      const wide = Math.hypot(half[order[0]], half[order[2]]);
      const tall = Math.cos(tilt) * half[order[1]] + Math.abs(Math.sin(tilt)) * wide;
      const scale = Math.min((0.5 * width - 58) / wide, (0.5 * height - 36) / tall);
      const see = (p) => {
        const [r, u, f] = order.map((k) => p[k] - middle[k]);
        const x = Math.cos(turn) * r - Math.sin(turn) * f, d = Math.sin(turn) * r + Math.cos(turn) * f;
        return [width / 2 + scale * x, height / 2 - scale * (Math.cos(tilt) * u - Math.sin(tilt) * d), Math.sin(tilt) * u + Math.cos(tilt) * d];
      };
      drawBox(pen, see, [width / 2, height / 2]);
      const dots = [];
      // Ours over all others, which are paler beside it.
      const groups = [...data.groups].sort((g, h) => (g.tone === 'ours') - (h.tone === 'ours'));
      for (const g of groups) {
        const colour = css(g.tone);
        if (g.joined) {
          pen.strokeStyle = colour;
          pen.globalAlpha = g.tone === 'ours' || groups.length === 1 ? 1 : 0.6;
          pen.lineCap = 'round';
          pen.lineWidth = g.size;
          pen.beginPath();
          let up = true;
          for (let i = 0; i < g.p.length; i += 3) {
            if (g.p[i] === null) { up = true; continue; }
            const [x, y] = see(g.p.slice(i, i + 3));
            if (up) pen.moveTo(x, y); else pen.lineTo(x, y);
            up = false;
          }
          pen.stroke();
          pen.globalAlpha = 1;
        } else for (let i = 0; i < g.p.length; i += 3) if (g.p[i] !== null) dots.push([...see(g.p.slice(i, i + 3)), g.size, colour]);
      }
      dots.sort((a, b) => a[2] - b[2]);
      for (const [x, y, depth, size, colour] of dots) {
        pen.globalAlpha = 0.55 + 0.4 * Math.min(1, Math.max(-1, depth / radius));
        pen.fillStyle = colour;
        pen.beginPath(); pen.arc(x, y, size * (1 + 0.25 * depth / radius), 0, 2 * Math.PI); pen.fill();
      }
      pen.globalAlpha = 1;
      let x = 8;
      pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
      for (const g of data.groups) {
        if (!g.name) continue;
        pen.fillStyle = css(g.tone); pen.beginPath(); pen.arc(x + 4, 12, 4, 0, 2 * Math.PI); pen.fill();
        pen.fillStyle = css('ink'); pen.fillText(g.name, x + 13, 16);
        x += pen.measureText(g.name).width + 32;
      }
    }
    let from = null;
    canvas.addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener('pointerup', () => { from = null; });
    canvas.addEventListener('pointercancel', () => { from = null; });
    canvas.addEventListener('pointermove', (e) => {
      if (!from) return;
      turn += (e.clientX - from[0]) / 120;
      if (!touch) tilt = Math.max(-1.5, Math.min(1.5, tilt + (e.clientY - from[1]) / 120));
      from = [e.clientX, e.clientY];
      draw();
    });
    addEventListener('resize', draw);
    return draw;
  }

  const plots = [...document.querySelectorAll('figure.plot')].map((figure) => ({
    data: plotOf(figure), canvas: placed(figure, 'div', 340),
  }));
  const clouds = [...document.querySelectorAll('figure.cloud')].map(cloud);
  const drawPlot = ({ canvas, data }) => Plotly.react(canvas, data.series.map((s) => trace(s, data)), layout(data),
    { responsive: true, displayModeBar: false, doubleClick: 'reset' });

  async function drawAll() {
    for (const draw of clouds) draw();
    for (const plot of plots) await drawPlot(plot);
    document.documentElement.dataset.drawn = String(plots.length + clouds.length);
  }
  drawAll();
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawAll);
  addEventListener('beforeprint', drawAll);
  addEventListener('afterprint', drawAll);
})();
