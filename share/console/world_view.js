// The real surfaces, the bodies and the force on the hand, seen from where one likes. World frame, y up, z towards the
// user (docs/conventions.md), metres.
//
// Drawn on a canvas of two dimensions: a few outlines, balls and an arrow need no graphics card, and a browser without one
// would draw WebGL by the processor, which the loops need, too.
const kMetresPerNewton = 0.01, kEvery = 30;  // ms from one drawing to the next
const kBodyRadius = 0.02, kTouchRadius = 0.006;  // m
const colours = ['#f2a33c', '#e4572e', '#4cc38a', '#6aa5ff', '#b388eb', '#d1d646', '#3bc9db', '#ff8fab'];

const plus = (a, b) => a.map((x, i) => x + b[i]);
const minus = (a, b) => a.map((x, i) => x - b[i]);
const times = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const length = (a) => Math.hypot(...a);

export class WorldView {
  constructor(parent) {
    this.parent = parent;
    this.canvas = document.createElement('canvas');
    this.context = this.canvas.getContext('2d');
    parent.append(this.canvas);
    this.surfaces = [];
    this.names = [];
    this.states = null;
    this.middle = [0, 0, 0];
    this.distance = 2;
    this.around = 0.6;  // rad, about y; 0: from the user's side
    this.above = 0.5;
    this.drawn = 0;
    this.canvas.addEventListener('pointerdown', (event) => this.canvas.setPointerCapture(event.pointerId));
    this.canvas.addEventListener('pointermove', (event) => this.turn(event));
    this.canvas.addEventListener('wheel', (event) => this.approach(event), { passive: false });
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
  }

  resize() {
    const scale = Math.min(2, window.devicePixelRatio);
    this.canvas.width = Math.max(100, this.parent.clientWidth) * scale;
    this.canvas.height = Math.max(100, this.parent.clientHeight) * scale;
    // At once: another size has emptied it.
    this.drawn = 0;
    this.draw(this.states);
  }

  turn(event) {
    if (!event.buttons) return;
    this.around -= event.movementX * 0.008;
    this.above = Math.min(1.5, Math.max(-1.5, this.above + event.movementY * 0.008));
    this.changed = true;
  }

  approach(event) {
    event.preventDefault();
    this.distance = Math.min(20, Math.max(0.1, this.distance * Math.exp(event.deltaY * 0.001)));
    this.changed = true;
  }

  setScene(scene) {
    this.surfaces = scene.surfaces;
    this.names = scene.bodies;
    const corners = scene.surfaces.flatMap((surface) => surface.corners);
    if (corners.length) {
      this.middle = times(corners.reduce(plus), 1 / corners.length);
      this.distance = 2.6 * Math.max(0.2, ...corners.map((corner) => length(minus(corner, this.middle))));
    }
    this.changed = true;
  }

  // Right, up and towards the eye, unit vectors in World.
  axes() {
    const [ca, sa, ce, se] = [Math.cos(this.around), Math.sin(this.around), Math.cos(this.above), Math.sin(this.above)];
    return [[ca, 0, -sa], [-se * sa, ce, -se * ca], [ce * sa, se, ce * ca]];
  }

  // Where on the canvas, px, and px for a metre there; null: behind the eye.
  place(point) {
    const from = minus(point, this.middle), [right, up, back] = this.view;
    const depth = this.distance - dot(from, back);
    if (depth < 0.02) return null;
    const scale = 1.3 * Math.min(this.canvas.width, this.canvas.height) / depth;
    return { x: this.canvas.width / 2 + dot(from, right) * scale, y: this.canvas.height / 2 - dot(from, up) * scale, scale, depth };
  }

  line(points, closed, stroke, fill, width = 1.5) {
    const places = points.map((point) => this.place(point));
    if (places.includes(null)) return;
    const c = this.context;
    c.beginPath();
    places.forEach((at, i) => (i ? c.lineTo(at.x, at.y) : c.moveTo(at.x, at.y)));
    if (closed) c.closePath();
    if (fill) { c.fillStyle = fill; c.fill(); }
    c.strokeStyle = stroke;
    c.lineWidth = width;
    c.stroke();
  }

  ball(at, radius, colour, name) {
    const c = this.context, size = Math.max(2, radius * at.scale);
    c.beginPath();
    c.arc(at.x, at.y, size, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
    if (!name) return;
    c.font = `${Math.round(this.canvas.height / 26)}px system-ui, sans-serif`;
    c.fillText(name, at.x + size + 4, at.y - size);
  }

  // Frames of the World: x red, y green, z blue, 10 cm.
  drawAxes() {
    [['#ff6b6b', [0.1, 0, 0]], ['#4cc38a', [0, 0.1, 0]], ['#6aa5ff', [0, 0, 0.1]]]
      .forEach(([colour, end]) => this.line([[0, 0, 0], end], false, colour, null, 2));
  }

  drawForce(touch, force) {
    const size = length(force);
    if (size < 0.01) return;
    const end = plus(touch, times(force, kMetresPerNewton)), from = this.place(touch), to = this.place(end);
    if (!from || !to) return;
    this.line([touch, end], false, '#ff5555', null, 3);
    const angle = Math.atan2(to.y - from.y, to.x - from.x), c = this.context;
    c.beginPath();
    for (const turn of [0, 2.6, -2.6]) c.lineTo(to.x + 10 * Math.cos(angle + turn), to.y + 10 * Math.sin(angle + turn));
    c.fillStyle = '#ff5555';
    c.fill();
  }

  draw(states) {
    if (states) this.states = states;
    this.changed = this.changed || states !== null || this.drawn === 0;
    if (!this.changed || performance.now() - this.drawn < kEvery) return;
    this.drawn = performance.now();
    this.changed = false;
    this.view = this.axes();
    this.context.fillStyle = '#141a22';
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    for (const surface of this.surfaces) this.line(surface.corners, true, '#6aa5ff', 'rgba(58, 110, 165, 0.25)');
    this.drawAxes();
    if (!this.states) return;
    // What is farther away first.
    this.states.bodies
      .map((body, i) => ({ at: body[7] ? this.place(body.slice(0, 3)) : null, i }))
      .filter((one) => one.at).sort((a, b) => b.at.depth - a.at.depth)
      .forEach((one) => this.ball(one.at, kBodyRadius, colours[one.i % colours.length], this.names[one.i]));
    const touch = this.states.touch;
    if (!touch) return;
    const at = this.place(touch);
    if (at) this.ball(at, kTouchRadius, '#ff5555');
    this.drawForce(touch, this.states.force[this.states.force.length - 1]);
  }
}
