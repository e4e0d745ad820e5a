// Lights, loops, clients and events as they stand in a message.
function element(kind, words, name) {
  const made = document.createElement(kind);
  if (words !== undefined) made.textContent = words;
  if (name) made.className = name;
  return made;
}

const time = (us) => (us < 1000 ? us.toFixed(0) + ' µs' : us < 1e6 ? (us / 1e3).toFixed(1) + ' ms' : (us / 1e6).toFixed(1) + ' s');

export function showLights(list, lights) {
  list.replaceChildren(...lights.map((light) => {
    const item = element('li', undefined, light.level);
    item.append(element('b', light.name), element('span', light.level === 'off' ? light.words : `${light.level}: ${light.words}`));
    return item;
  }));
}

export function showEvents(list, none, news) {
  for (const event of news) {
    const item = element('li', undefined, event.level);
    const minutes = Math.floor(event.time_s / 60), seconds = (event.time_s % 60).toFixed(1).padStart(4, '0');
    item.append(element('time', `${minutes}:${seconds}`), document.createTextNode(event.words));
    list.prepend(item);
  }
  while (list.childElementCount > 200) list.lastChild.remove();
  none.hidden = list.childElementCount > 0;
}

// Ticks by how late they began; a column for each doubling from 1 us on, heights on a logarithmic scale.
function lateness(octaves) {
  const first = 6;  // 16 ns * 2^6
  const counts = [];
  octaves.forEach((count, i) => { const k = Math.max(0, i - first); counts[k] = (counts[k] || 0) + count; });
  while (counts.length && !counts[counts.length - 1]) counts.pop();
  const most = Math.log1p(Math.max(1, ...counts));
  const bars = element('div', undefined, 'bars');
  counts.forEach((count, k) => {
    const bar = element('i');
    bar.style.height = `${100 * Math.log1p(count || 0) / most}%`;
    bar.title = `${count || 0} ticks less than ${time(1.024 * 2 ** k)} late`;
    bars.append(bar);
  });
  const scale = element('div', undefined, 'bars-scale');
  scale.append(element('span', 'under 1 µs late'), element('span', counts.length ? 'under ' + time(1.024 * 2 ** (counts.length - 1)) : ''));
  return [bars, scale];
}

export function showLoops(parent, loops) {
  parent.replaceChildren(...loops.map((loop) => {
    const one = element('div', undefined, 'loop');
    one.append(element('h3', `${loop.name}: ${loop.rate_hz.toFixed(1)} Hz${loop.condition ? ', forces ' + loop.condition : ''}`),
      element('p', `late ${time(loop.late_us.p50)} (median), ${time(loop.late_us.p99)} (99 of 100), ${time(loop.late_us.max)} at most; `
        + `${loop.overruns} overruns, ${loop.missed} ticks missed of ${loop.ticks}`),
      ...lateness(loop.late_octaves_from_16_ns));
    return one;
  }));
}

export function showClients(table, clients) {
  const [body] = table.tBodies;
  const headings = [...table.tHead.rows[0].cells].map((cell) => cell.textContent);
  body.replaceChildren(...clients.map((client) => {
    const row = element('tr');
    const draws = client.frames > 0;
    const cells = [`${client.name} (${client.role})`,
      draws ? client.rate_hz.toFixed(1) : '',
      draws ? `${client.late} of ${client.frames}` : '',
      draws ? `${time(client.round_trip_us.median)}, ${time(client.round_trip_us.p99)}` : '',
      draws ? `${(client.clock_offset_s * 1e6).toFixed(0)} ± ${client.clock_uncertainty_us.toFixed(0)} µs` : ''];
    row.append(...cells.map((words, i) => {
      const cell = element('td', words);
      if (i > 0) cell.dataset.label = headings[i];  // a narrow page shows it beside the cell
      return cell;
    }));
    return row;
  }));
}

// A ring round each landmark that was found in the picture, in its pixels.
export function showMarks(layer, head) {
  layer.setAttribute('viewBox', `0 0 ${head.width} ${head.height}`);
  layer.replaceChildren(...head.landmarks.map(([x, y, used]) => {
    const ring = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
    ring.setAttribute('cx', x + 0.5);
    ring.setAttribute('cy', y + 0.5);
    ring.setAttribute('r', head.height / 48);
    if (!used) ring.setAttribute('class', 'rejected');
    return ring;
  }));
}
