// The lookdev page: one live render, its graph as a drawing and as sliders, and its picture.
'use strict';

const $ = (id) => document.getElementById(id);
const make = (name, attributes = {}, ...children) => {
  const e = document.createElement(name);
  for (const [k, v] of Object.entries(attributes)) k in e ? (e[k] = v) : e.setAttribute(k, v);
  e.append(...children);
  return e;
};
const LAYERS = ['beauty', 'direct_diffuse', 'indirect_diffuse', 'direct_specular', 'indirect_specular', 'refraction', 'sss', 'emission', 'background',
  'light_group_default', 'light_group_1', 'light_group_2', 'light_group_3', 'N', 'Z', 'uv', 'denoise_albedo', 'sample_count', 'error'];

let graph = null, live = null, nodes = {}, selected = null, events = null, sent = new Map(), edits = 0;
let zoom = 1, pan = [0, 0], groups = {};

function tell(text) { $('fault').textContent = text || ''; }

async function ask(method, path, body, headers = {}) {
  const answer = await fetch(path, { method, headers: { 'Content-Type': 'application/json', ...headers }, body: body === undefined ? undefined : JSON.stringify(body) });
  const text = await answer.text();
  const json = text ? JSON.parse(text) : null;
  if (!answer.ok) {
    const first = json && json.errors && json.errors[0];
    throw new Error(first ? `${first.pointer}: ${first.found}; expected ${first.expected}` : (json && (json.detail || json.title)) || answer.statusText);
  }
  return json;
}

// One edit is on its way at a time; what changes meanwhile goes out together with the next.
let waiting = null, busy = false;
function send(kind, value) {
  waiting = waiting || {};
  if (kind === 'graph') waiting.graph = true;
  else waiting[kind] = value;
  flush();
}
async function flush() {
  if (busy || !waiting || !live) return;
  const now = waiting;
  waiting = null;
  busy = true;
  const token = `e${++edits}`;
  sent.set(token, performance.now());
  if (sent.size > 50) sent.delete(sent.keys().next().value);
  try {
    if (now.graph) await ask('PUT', live.links.graph, graph, { 'If-Match': '*', 'Alder-Edit-Id': token });
    const rest = { ...now };
    delete rest.graph;
    if (Object.keys(rest).length) await ask('PATCH', `/v1/renders/${live.id}`, rest, now.graph ? {} : { 'Alder-Edit-Id': token });
    tell('');
  } catch (e) {
    tell(e.message);
  }
  busy = false;
  flush();
}

async function begin() {
  if (live) fetch(`/v1/renders/${live.id}`, { method: 'DELETE', keepalive: true });
  if (events) events.close();
  live = null;
  try {
    live = await ask('POST', '/v1/renders', { mode: 'live', graph, stage: $('stage').value, resolution: [512, 512], max_samples: 512, aovs: wantedLayers() });
  } catch (e) {
    return tell(e.message);
  }
  tell('');
  events = new EventSource(live.links.events);
  const say = (d) => { $('state').textContent = `${d.samples} samples${d.divisor > 1 ? `, 1/${d.divisor} size` : ''}`; };
  events.addEventListener('image', (e) => {
    const d = JSON.parse(e.data);
    say(d);
    for (const token of d.edits) if (sent.has(token)) {
      $('latency').textContent = `edit to picture ${Math.round(performance.now() - sent.get(token))} ms`;
      sent.delete(token);
    }
  });
  events.addEventListener('state', (e) => { const d = JSON.parse(e.data); $('pause').textContent = d.reason === 'asked' ? 'Resume' : 'Pause'; showGroups(d.light_groups); });
  showPicture();
}

function wantedLayers() {
  const layer = $('layer').value;
  return ['id_object', 'id_material', ...(layer === 'beauty' || layer.startsWith('light_group') ? [] : [layer])];
}
function pictureQuery() { return `aov=${encodeURIComponent($('layer').value)}&exposure=${$('exposure').value}`; }
function showPicture() {
  if (!live) return;
  $('picture').src = `${live.links.preview}?${pictureQuery()}&quality=92`;
  $('exr').href = live.links.snapshot;
}

// ---- the network ----------------------------------------------------------------------------------------------------
function links(node) {
  const found = [];
  const look = (v) => {
    if (Array.isArray(v)) v.forEach(look);
    else if (v && typeof v === 'object') {
      if (typeof v.node === 'string') found.push(v.node);
      else Object.values(v).forEach(look);
    }
  };
  look(node.params || {});
  return found;
}
function drawNetwork() {
  const depth = {}, names = Object.keys(graph.nodes || {});
  const walk = (name, d, path) => {
    if (!graph.nodes[name] || path.includes(name) || d > names.length) return;
    depth[name] = Math.max(depth[name] || 0, d);
    for (const from of links(graph.nodes[name])) walk(from, d + 1, [...path, name]);
  };
  const roots = Object.values(graph.outputs || {}).flatMap((o) => (o.node ? [o.node] : Object.values(o).map((v) => v.node)));
  roots.forEach((r) => walk(r, 0, []));
  names.forEach((n) => { if (!(n in depth)) depth[n] = 0; });
  const most = Math.max(0, ...Object.values(depth)), column = {}, at = {}, w = 132, h = 36;
  for (const n of names) {
    const row = (column[depth[n]] = (column[depth[n]] || 0) + 1) - 1;
    at[n] = [8 + (most - depth[n]) * (w + 34), 8 + row * (h + 12)];
  }
  const rows = Math.max(1, ...Object.values(column));
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const add = (parent, name, attributes, text) => {
    const e = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
    if (text !== undefined) e.textContent = text;
    parent.append(e);
    return e;
  };
  svg.setAttribute('width', (most + 1) * (w + 34) - 18);
  svg.setAttribute('height', rows * (h + 12) + 8);
  for (const n of names)
    for (const from of new Set(links(graph.nodes[n])))
      if (at[from]) {
        const [x0, y0] = [at[from][0] + w, at[from][1] + h / 2], [x1, y1] = [at[n][0], at[n][1] + h / 2];
        add(svg, 'path', { d: `M${x0} ${y0}C${x0 + 17} ${y0} ${x1 - 17} ${y1} ${x1} ${y1}` });
      }
  for (const n of names) {
    const g = add(svg, 'g', { transform: `translate(${at[n]})`, tabindex: 0, role: 'option', 'aria-selected': n === selected, 'aria-label': n });
    add(g, 'rect', { width: w, height: h, rx: 5 });
    add(g, 'text', { x: 8, y: 15 }, n.slice(0, 20));
    add(g, 'text', { x: 8, y: 28, class: 'type' }, graph.nodes[n].type.replace(/^ShaderNode/, '').slice(0, 22));
    g.addEventListener('click', () => select(n));
    g.addEventListener('keydown', (e) => { if (e.key === 'Enter' || e.key === ' ') { e.preventDefault(); select(n); } });
  }
  $('network').replaceChildren(svg);
}
function select(name) {
  selected = name;
  drawNetwork();
  showParameters();
}

// ---- parameters, from the schema ------------------------------------------------------------------------------------
const toHex = (c) => '#' + c.slice(0, 3).map((x) => Math.round(255 * Math.min(1, Math.max(0, x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055))).toString(16).padStart(2, '0')).join('');
const fromHex = (s) => [1, 3, 5].map((i) => parseInt(s.slice(i, i + 2), 16) / 255).map((x) => +(x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4).toFixed(4));

async function showParameters() {
  const node = graph.nodes[selected];
  $('node-title').textContent = node ? `${selected}: ${node.type}` : 'Parameters';
  if (!node) return $('parameters').replaceChildren();
  try {
    nodes[node.type] = nodes[node.type] || await ask('GET', `/v1/nodes/${encodeURIComponent(node.type)}`);
  } catch (e) {
    return $('parameters').replaceChildren(e.message);
  }
  const rows = [];
  let group = '';
  for (const p of nodes[node.type].params) {
    const row = parameterRow(node, p);
    if (!row) continue;
    if ((p.group || '') !== group) rows.push(make('div', { className: 'group', textContent: group = p.group || '' }));
    rows.push(row);
  }
  $('parameters').replaceChildren(...rows);
}
function parameterRow(node, p) {
  node.params = node.params || {};
  const given = node.params[p.name], value = given === undefined ? p.default : given;
  const label = make('span', { textContent: p.label || p.name, title: `${p.name}\n${p.help || ''}` });
  const row = make('label', { className: given === undefined ? 'row' : 'row changed' }, label);
  const set = (v) => {
    node.params[p.name] = v;
    row.classList.add('changed');
    send('graph');
  };
  if (given && typeof given === 'object' && !Array.isArray(given)) {
    row.append(make('em', { textContent: given.node ? `from ${given.node}` : 'value' }));
  } else if (p.type === 'float' || p.type === 'int') {
    if (typeof value !== 'number') return null;
    const low = p.soft_min ?? p.min ?? 0, high = p.soft_max ?? p.max ?? Math.max(1, 2 * value);
    const step = p.type === 'int' ? 1 : (high - low) / 500 || 0.01;
    const slider = make('input', { type: 'range', min: low, max: Math.max(high, value), step, value });
    const number = make('input', { type: 'number', step: 'any', value: +value.toPrecision(5) });
    slider.addEventListener('input', () => { number.value = +(+slider.value).toPrecision(5); set(+slider.value); });
    number.addEventListener('change', () => { if (number.value !== '') { slider.value = number.value; set(+number.value); } });
    row.append(slider, number);
  } else if (p.type === 'color' && Array.isArray(value)) {
    const picker = make('input', { type: 'color', value: toHex(value) });
    picker.addEventListener('input', () => set(value.length === 4 ? [...fromHex(picker.value), value[3]] : fromHex(picker.value)));
    row.append(picker);
  } else if (p.type === 'enum') {
    const choice = make('select', {}, ...p.enum.map((e) => make('option', { value: e.name, textContent: e.label || e.name, selected: e.name === value })));
    choice.addEventListener('change', () => set(choice.value));
    row.append(choice);
  } else if (p.type === 'bool') {
    const box = make('input', { type: 'checkbox', checked: !!value });
    box.addEventListener('change', () => set(box.checked));
    row.append(box);
  } else {
    return null;
  }
  return row;
}

// ---- light groups: mixed from what is rendered ----------------------------------------------------------------------
function showGroups(list) {
  const names = JSON.stringify(Object.keys(list));
  if ($('lights').dataset.names === names) return;
  $('lights').dataset.names = names;
  groups = {};
  $('lights').replaceChildren(...Object.entries(list).map(([name, g]) => {
    groups[name] = { intensity: 1, color: [1, 1, 1] };
    const slider = make('input', { type: 'range', min: 0, max: 4, step: 0.02, value: 1 });
    const picker = make('input', { type: 'color', value: '#ffffff' });
    const change = () => {
      groups[name] = { intensity: +slider.value, color: fromHex(picker.value) };
      send('mix', groups);
    };
    slider.addEventListener('input', change);
    picker.addEventListener('input', change);
    slider.addEventListener('dblclick', () => { slider.value = 1; change(); });
    return make('label', { className: 'row' }, make('span', { textContent: g.lights.join(', ') || (name === 'default' ? 'world' : name) }), slider, picker);
  }));
}

// ---- the picture: zoom, values, A/B ---------------------------------------------------------------------------------
function place() {
  $('pictures').style.transform = `translate(${pan[0]}px, ${pan[1]}px) scale(${zoom})`;
  $('pictures').classList.toggle('close', zoom > 2);
  const edge = $('edge').value;
  $('kept').style.clipPath = `inset(0 ${100 - edge}% 0 0)`;
}
function zoomAt(x, y, factor) {
  const next = Math.min(64, Math.max(1, zoom * factor));
  pan = next === 1 ? [0, 0] : [x - (x - pan[0]) * next / zoom, y - (y - pan[1]) * next / zoom];
  zoom = next;
  place();
}
function pixelAt(e) {
  const box = $('view').getBoundingClientRect(), size = live ? live.resolution : [512, 512];
  const x = (e.clientX - box.left - pan[0]) / zoom, y = (e.clientY - box.top - pan[1]) / zoom;
  const scale = Math.min(box.width / size[0], box.height / size[1]);
  const px = Math.floor((x - (box.width - size[0] * scale) / 2) / scale), py = Math.floor((y - (box.height - size[1] * scale) / 2) / scale);
  return px >= 0 && py >= 0 && px < size[0] && py < size[1] ? [px, py] : null;
}
let asking = false;
async function inspect(e) {
  const at = live && pixelAt(e);
  if (!at || asking) return;
  asking = true;
  try {
    const p = await ask('GET', `/v1/renders/${live.id}/pixel?x=${at[0]}&y=${at[1]}`);
    const text = (v) => (Array.isArray(v) ? v : [v]).map((x) => (typeof x === 'number' ? x.toPrecision(4) : x)).join('  ');
    const layer = $('layer').value === 'beauty' ? 'rgba' : $('layer').value;
    $('pixel').textContent = `${p.x}, ${p.y}  ${p.object || 'background'}${p.material ? ` (${p.material})` : ''}\n${layer}  ${layer in p.layers ? text(p.layers[layer]) : ''}`;
  } catch (error) {
    $('pixel').textContent = error.message;
  }
  asking = false;
}
async function keep() {
  if (!live) return;
  const answer = await fetch(`/v1/renders/${live.id}/snapshot.png?${pictureQuery()}`);
  if (!answer.ok) return tell('no picture to keep');
  URL.revokeObjectURL($('kept').src);
  $('kept').src = URL.createObjectURL(await answer.blob());
  compare(true);
}
function compare(on) {
  if (on && !$('kept').src) return keep();
  $('kept').hidden = $('edge').hidden = !on;
  $('wipe').setAttribute('aria-pressed', on);
  place();
}
function pause() {
  if (live) ask('POST', `/v1/renders/${live.id}/${$('pause').textContent === 'Pause' ? 'pause' : 'resume'}`).then((d) => { $('pause').textContent = d.reason === 'asked' ? 'Resume' : 'Pause'; }, (e) => tell(e.message));
}
function step(select, by) {
  const n = select.options.length;
  select.selectedIndex = (select.selectedIndex + by + n) % n;
  select.dispatchEvent(new Event('change'));
}
function download() {
  const url = URL.createObjectURL(new Blob([JSON.stringify(graph, null, 2)], { type: 'application/json' }));
  make('a', { href: url, download: 'graph.json' }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
function use(next) {
  graph = JSON.parse(JSON.stringify(next));
  selected = Object.keys(graph.nodes || {}).slice(-1)[0];
  drawNetwork();
  showParameters();
  if (live) send('graph');
  else begin();
}

const view = $('view');
view.addEventListener('wheel', (e) => {
  e.preventDefault();
  const box = view.getBoundingClientRect();
  zoomAt(e.clientX - box.left, e.clientY - box.top, e.deltaY < 0 ? 1.25 : 0.8);
}, { passive: false });
let dragged = null;
view.addEventListener('pointerdown', (e) => { if (e.target !== $('edge')) { dragged = [e.clientX - pan[0], e.clientY - pan[1]]; view.setPointerCapture(e.pointerId); } });
view.addEventListener('pointerup', () => { dragged = null; });
view.addEventListener('pointermove', (e) => {
  if (dragged && zoom > 1) { pan = [e.clientX - dragged[0], e.clientY - dragged[1]]; place(); }
  inspect(e);
});
view.addEventListener('pointerleave', () => { $('pixel').textContent = ''; });
view.addEventListener('dblclick', () => zoomAt(0, 0, 1 / zoom));
document.addEventListener('keydown', (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(e.target.tagName)) return;
  const exposure = (by) => { $('exposure').value = +$('exposure').value + by; showPicture(); };
  const box = view.getBoundingClientRect();
  const action = { a: keep, w: () => compare($('kept').hidden), f: () => zoomAt(0, 0, 1 / zoom), z: () => zoomAt(box.width / 2, box.height / 2, 2), p: pause,
    '[': () => step($('layer'), -1), ']': () => step($('layer'), 1), e: () => exposure(-0.5), E: () => exposure(0.5),
    ArrowLeft: () => { pan[0] += 40; place(); }, ArrowRight: () => { pan[0] -= 40; place(); } }[e.key];
  if (action) { e.preventDefault(); action(); }
});
$('edge').addEventListener('input', place);
$('keep').addEventListener('click', keep);
$('wipe').addEventListener('click', () => compare($('kept').hidden));
$('fit').addEventListener('click', () => zoomAt(0, 0, 1 / zoom));
$('pause').addEventListener('click', pause);
$('json').addEventListener('click', download);
$('curl').addEventListener('click', () => {
  const body = JSON.stringify({ graph, stage: $('stage').value, size: 512, samples: 64 }).replaceAll("'", "'\\''");
  navigator.clipboard.writeText(`curl -sS ${location.origin}/v1/preview -H 'Accept: image/png' -o alder.png --json '${body}'`).then(() => tell('copied'), () => tell('the browser refused the clipboard'));
});
$('open').addEventListener('change', async () => { try { use(JSON.parse(await $('open').files[0].text())); } catch (e) { tell(`not a graph: ${e.message}`); } });
document.addEventListener('dragover', (e) => e.preventDefault());
document.addEventListener('drop', async (e) => {
  e.preventDefault();
  if (e.dataTransfer.files.length) try { use(JSON.parse(await e.dataTransfer.files[0].text())); } catch (error) { tell(`not a graph: ${error.message}`); }
});
$('stage').addEventListener('change', () => (live ? send('stage', $('stage').value) : begin()));
$('example').addEventListener('change', () => use(EXAMPLES[$('example').value]));
$('layer').addEventListener('change', () => { send('aovs', wantedLayers()); showPicture(); });
$('exposure').addEventListener('input', showPicture);
$('exposure').addEventListener('dblclick', () => { $('exposure').value = 0; showPicture(); });
addEventListener('pagehide', () => { if (live) fetch(`/v1/renders/${live.id}`, { method: 'DELETE', keepalive: true }); });

$('stage').append(...['shaderball', 'sphere', 'plane'].map((n) => make('option', { textContent: n })));
$('example').append(...Object.keys(EXAMPLES).map((n) => make('option', { textContent: n })));
$('layer').append(...LAYERS.map((n) => make('option', { textContent: n })));
use(EXAMPLES[$('example').value]);
