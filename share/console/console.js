// The console's page: draws what the console says (docs/console.md). Whatever comes is set as text, never as HTML.
import { ForcePlot } from './force_plot.js';
import { WorldView } from './world_view.js';
import { showClients, showEvents, showLights, showLoops, showMarks } from './panels.js';

const by = (id) => document.getElementById(id);
const token = new URLSearchParams(location.hash.slice(1)).get('token') || '';
const plot = new ForcePlot(by('force-plot'));
const world = new WorldView(by('scene'));

const kPictureFor = 5000;  // ms for which a picture is taken for what is
let socket = null, lastHeard = 0, lastPicture = 0, toShow = null, viewers = 0;

function setConnection(words, fault) {
  by('connection').textContent = words;
  by('connection').className = fault ? 'fault' : '';
}

function connect() {
  const scheme = location.protocol === 'https:' ? 'wss://' : 'ws://';
  const query = token ? '?token=' + encodeURIComponent(token) : '';
  socket = new WebSocket(scheme + location.host + '/' + query, 'palpate.console.v1');
  socket.onopen = () => { lastHeard = performance.now(); setConnection('connected', false); };
  socket.binaryType = 'arraybuffer';
  socket.onmessage = (event) => {
    lastHeard = performance.now();
    if (typeof event.data === 'string') hear(JSON.parse(event.data)); else showPicture(event.data);
  };
  socket.onclose = (event) => {
    setConnection(event.reason ? 'the console has closed: ' + event.reason : 'the console does not answer; trying again', true);
    setTimeout(connect, 1000);
  };
}

function hear(message) {
  if (message.op === 'states') {
    plot.add(message);
    toShow = message;
  } else if (message.op === 'scene') {
    by('application').textContent = message.application;
    document.title = message.application + ': Palpate console';
    world.setScene(message);
  } else if (message.op === 'status') {
    showStatus(message);
  } else if (message.op === 'refusal') {
    setConnection(message.words, true);
  }
}

// The length of a JSON head, the head, a JPEG file.
function showPicture(bytes) {
  const size = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, size)));
  const image = by('picture'), before = image.src;
  image.src = URL.createObjectURL(new Blob([new Uint8Array(bytes, 4 + size)], { type: 'image/jpeg' }));
  if (before) URL.revokeObjectURL(before);
  image.hidden = false;
  lastPicture = performance.now();
  showMarks(by('marks'), head);
  by('picture-now').textContent = head.expected_overlay_px === null ? '' : `overlay within ${head.expected_overlay_px.toFixed(2)} px (rms, expected)`;
  by('picture-note').textContent = `Frame ${head.number}, ${head.width} x ${head.height}; camera's pose: ${head.pose}; `
    + `${head.landmarks_used} of ${head.landmarks_predicted} landmarks used (green rings; red: found and left out)`
    + (head.landmarks_used > 0 ? `, ${head.landmark_rms_px.toFixed(2)} px rms off.` : '.');
}

// What was seen a while ago is not what is.
function forgetPicture() {
  const image = by('picture');
  if (image.hidden) return;
  image.hidden = true;
  by('marks').replaceChildren();
  by('picture-now').textContent = '';
  by('picture-note').textContent = 'No graphics server of this machine shows one any more.';
}

function showStatus(message) {
  showLights(by('lights'), message.lights);
  showEvents(by('events'), by('no-events'), message.events);
  by('controls').hidden = !(message.console.controls && token);
  const status = message.status;
  if (status) {
    showLoops(by('loops'), status.loops);
    showClients(by('clients'), status.clients);
    const s = status.service;
    by('service').textContent = `${s.requests} states asked for, ${s.published} sent by themselves, ${s.rejected} messages refused, `
      + `${s.turned_away} turned away, ${s.unsent} not taken`;
    const forces = status.loops.find((loop) => loop.forces);
    if (forces && forces.limits_n) {
      plot.setLimits(forces.limits_n);
      by('force-note').textContent = `Limits: ${forces.limits_n.peak.toFixed(1)} N at most, ${forces.limits_n.continuous.toFixed(1)} N `
        + `as root mean square for long. ${forces.outages} ${forces.outages === 1 ? 'outage' : 'outages'} so far.`;
    }
  }
  const c = message.console;
  by('foot').textContent = (c.shown_after_ms > 0 ? `Shown ${c.shown_after_ms.toFixed(0)} ms after it happened (median). ` : '')
    + `${c.viewers} ${c.viewers === 1 ? 'viewer' : 'viewers'} of this console. ${c.states_missed} states missed on the way to it, `
    + `${c.page_dropped} messages on the way to this page.`;
  if (socket.readyState === WebSocket.OPEN) setConnection('connected', false);
}

// Once a picture: what came last is shown, and the console is told when.
function draw() {
  requestAnimationFrame(draw);
  if (performance.now() - lastHeard > 2000 && socket && socket.readyState === WebSocket.OPEN)
    setConnection('nothing heard for ' + ((performance.now() - lastHeard) / 1000).toFixed(0) + ' s', true);
  plot.draw();
  world.draw(toShow);
  if (performance.now() - lastPicture > kPictureFor) forgetPicture();
  if (!toShow) return;
  const f = toShow.force[toShow.force.length - 1];
  by('force-now').textContent = Math.hypot(f[0], f[1], f[2]).toFixed(2) + ' N';
  const shown = toShow.t_ns;
  toShow = null;
  // The next task after this picture has been handed over.
  setTimeout(() => { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ op: 'seen', t_ns: shown })); }, 0);
}

for (const button of by('controls').querySelectorAll('button'))
  button.onclick = () => socket.send(JSON.stringify({ op: 'control', control: button.dataset.control, token }));
connect();
draw();
