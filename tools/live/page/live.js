'use strict';
// Page of a live run. It shows data of /keys, /events, /history and /stream; it changes the run through /set and /control.
const $ = id => document.getElementById(id);
const token = new URLSearchParams(location.search).get('token');
const address = path => token ? path + (path.includes('?') ? '&' : '?') + 'token=' + encodeURIComponent(token) : path;
let state = null, keys = null, plotted = -1, noticed = null, events = null, watching = new AbortController();
const knobs = new Map();

// --- requests --------------------------------------------------------------------------------------------------------------------------
async function post(path, body) {
  try {
    const reply = await fetch(address(path), {method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(body)});
    return await reply.json();
  } catch (error) {
    return {ok: false, error: 'no connection to whorl: ' + error.message};
  }
}

async function control(order) {
  const reply = await post('/control', order);
  answered(reply);
  return reply;
}

// Sends changes, one request at a time. Changes made during a request are sent together in the next one, with the last value of each key.
let waiting = {}, sending = null;
function set(changes) {
  Object.assign(waiting, changes);
  if (!sending) sending = send().finally(() => { sending = null; });
}
async function send() {
  while (Object.keys(waiting).length > 0) {
    const changes = waiting;
    waiting = {};
    const reply = await post('/set', changes);
    for (const path of Object.keys(changes)) {
      const knob = knobs.get(path);
      if (knob && !reply.ok && state) knob.show(state.values[path], true);
      if (knob) knob.wrong.textContent = reply.ok ? '' : reply.error, knob.refused = reply.ok ? 0 : Date.now();
    }
    answered(reply);
  }
}

// Shows the error of a reply; a reply without an error hides the previous error.
function answered(reply) {
  if (!reply.ok) say(reply.error, true);
  else if ($('notice').className === 'bad') say('');
}

function say(text, bad) {
  $('notice').hidden = !text;
  $('notice').textContent = text || '';
  $('notice').className = bad ? 'bad' : '';
}

// --- the image -------------------------------------------------------------------------------------------------------------------------
// Reads the stream with fetch. An <img> would show each image only when the header of the next one arrives, and would not give its time.
async function watch() {
  watching.abort();
  watching = new AbortController();
  const ours = watching.signal, text = new TextDecoder('latin1');
  try {
    const reader = (await fetch(address('/stream?once=1'), {signal: ours})).body.getReader();
    for (let data = new Uint8Array(0);;) {
      const {done, value} = await reader.read();
      if (done) return;
      const more = new Uint8Array(data.length + value.length);
      more.set(data), more.set(value, data.length);
      data = more;
      let newest = null;
      for (;;) {
        const head = text.decode(data.subarray(0, 400)), end = head.indexOf('\r\n\r\n') + 4, size = Number(/Content-Length: (\d+)/.exec(head)?.[1]);
        if (end < 4 || data.length < end + size + 2) break;
        newest = {jpeg: data.slice(end, end + size), time: Number(/X-Time: (\S+)/.exec(head)[1]), frame: /X-Frame: (\d+)/.exec(head)[1]};
        data = data.slice(end + size + 2);
      }
      if (newest) await paint(newest, ours);
    }
  } catch (error) { /* the stream ended, or there is no connection, which the pill shows */ }
}
async function paint(picture, ours) {
  const image = await createImageBitmap(new Blob([picture.jpeg], {type: 'image/jpeg'})), canvas = $('picture');
  if (ours.aborted) return;
  if (canvas.width !== image.width || canvas.height !== image.height) canvas.width = image.width, canvas.height = image.height;
  canvas.getContext('2d', {alpha: false}).drawImage(image, 0, 0);
  image.close();
  $('clock').textContent = fixed(picture.time, 2) + ' s of ' + (state ? Plots.short(state.end) : '–') + ' s · frame ' + picture.frame;
}

// --- the state -------------------------------------------------------------------------------------------------------------------------
function connect() {
  if (events) events.close();
  events = new EventSource(address('/events'));
  events.onopen = () => { keys = null, watch(), loadHistory(), answered({ok: true}); };
  events.onerror = () => { $('pill').textContent = 'no connection, trying again'; $('pill').className = 'pill bad'; };
  events.onmessage = message => show(JSON.parse(message.data));
}
document.addEventListener('visibilitychange', () => {
  // A hidden page closes its connections, because browsers allow only six per address.
  if (document.hidden) { events.close(); watching.abort(); } else connect();
});

// Sets a text only if it differs, so that an unchanged text costs nothing.
const write = (element, text) => { if (element.textContent !== String(text)) element.textContent = text; };
const fixed = (v, digits) => v === null || v === undefined ? '–' : Number(v).toFixed(digits);
const grouped = v => v === null || v === undefined ? '–' : Number(v).toLocaleString('en');

function show(now) {
  const before = state;
  state = now;
  if (keys === null || structure(now) !== structure(before)) loadKeys();
  if (before && (now.frame < before.frame || now.scene !== before.scene)) Plots.clear(), plotted = -1;
  const playing = now.playing && now.state === 'running';
  $('pill').textContent = now.state !== 'running' ? now.state : now.playing ? 'playing' : 'paused';
  $('pill').className = 'pill ' + (now.state === 'diverged' ? 'bad' : playing ? 'running' : '');
  $('play').textContent = playing ? 'Pause' : now.state === 'running' ? 'Play' : 'Again';
  $('step').disabled = now.state !== 'running';
  $('undo').disabled = !now.can_undo;
  write($('pace'), now.state === 'ended' ? 'The scene ends at ' + Plots.short(now.end) + ' s: Again restarts it, a larger end (search for end) continues it.' :
    playing && now.pace ? now.pace + '.' : '');
  // A problem is shown as long as the state contains it, a notice once.
  $('problem').hidden = !now.problem;
  write($('problem'), now.problem);
  const number = now.notice ? now.notice.number : 0;
  if (noticed !== null && number !== noticed) say(now.problem.includes(now.notice.text) ? '' : now.notice.text, now.notice.error);
  noticed = number;
  facts(now);
  for (const [path, knob] of knobs) if (path in now.values) knob.show(now.values[path], false);
  if (now.frame !== plotted) plot(now, now.probe_plots), Plots.drawSoon(), plotted = now.frame;
}
// Text that differs if the set of keys differs (another scene, kind of camera or look).
const structure = s => s && [s.scene, s.quality, ...Object.keys(s.values)].join();

function facts(s) {
  const list = [
    ['particles', grouped(s.particles)], ['real time', s.simulated_per_wall_second > 0 ? fixed(100 * s.simulated_per_wall_second, 0) + ' %' : '–'],
    ['frames per second', fixed(s.frames_per_second, 1)], ['frame', fixed(s.frame_ms, 0) + ' ms'], ['steps per frame', s.steps],
    ['iterations per step', fixed(s.iterations, 1)], ['maximum speed', Plots.short(s.max_speed) + ' m/s'], ['memory', grouped(Math.round(s.memory_bytes / 1e6)) + ' MB'],
    ['viewers', s.viewers], ['drawn by', (s.device || '').split(/[,(]/)[0]]];
  if ($('facts').children.length === 0) $('facts').replaceChildren(...list.map(([name]) => {
    const box = document.createElement('div'), dt = document.createElement('dt'), dd = document.createElement('dd');
    dt.textContent = name;
    box.append(dt, dd);
    return box;
  }));
  list.forEach(([, value], i) => write($('facts').children[i].lastChild, value));
}

function plot(s, described) {
  const where = $('plots');
  for (const [name, probe] of Object.entries(described))
    for (const {title, curves} of probe.plots) {
      const named = name + ': ' + title, dashed = curves.filter(c => c.dashed).map(c => c.label);
      const values = row => Object.fromEntries(curves.map(c => [c.label, row[c.column]]));
      if (!probe.profile) Plots.add(where, named, s.time, values(s.probes[name]), dashed);
      else if (s.profiles) Plots.profile(where, named, probe, s.profiles[name][probe.along], values(s.profiles[name]), dashed);
    }
  Plots.add(where, 'ms per frame by stage', s.time, s.ms);
  Plots.add(where, 'frames per second', s.time, {frames: s.frames_per_second || null});
  Plots.add(where, 'iterations per step', s.time, {iterations: s.iterations, steps: s.steps});
  const energy = {kinetic: s.energy.kinetic};
  if (s.energy.spin) energy.spin = s.energy.spin;
  Plots.add(where, 'kinetic energy [J]', s.time, energy);
  Plots.add(where, 'potential energy [J]', s.time, {potential: s.energy.potential});
}
// Loads the last 600 frames, so that a page that is opened late shows the earlier curves.
async function loadHistory() {
  try {
    const [frames, now] = await Promise.all(['/history', '/state'].map(async path => (await fetch(address(path))).json()));
    if (frames.length === 0) return;
    Plots.clear();
    frames.forEach(frame => plot(frame, now.probe_plots));
    plotted = frames[frames.length - 1].frame;
    Plots.draw();
  } catch (error) { /* no history: the curves begin with the next frame */ }
}
window.addEventListener('resize', () => Plots.draw());

// --- knobs, made from the descriptions in /keys ----------------------------------------------------------------------------------------
async function loadKeys() {
  keys = keys || {revision: 0};  // a request is under way
  try {
    const now = await (await fetch(address('/keys'))).json();
    if (now.revision >= keys.revision) showKeys(now);
  } catch (error) {
    keys = null;  // try again with the next state
  }
}
function showKeys(now) {
  keys = now;
  const options = (select, names, chosen) => select.replaceChildren(...names.map(name => new Option(name, name, name === chosen, name === chosen)));
  const names = keys.scenes.includes(keys.scene) ? keys.scenes : [keys.scene, ...keys.scenes];
  options($('scene'), names, keys.scene);
  $('quality').value = keys.quality;
  if (document.body.dataset.scene !== keys.scene) home = view = null, document.body.dataset.scene = keys.scene;
  document.title = keys.scene + ' · Whorl live';
  const open = new Map([...document.querySelectorAll('#knobs details')].map(d => [d.dataset.group, d.open]));
  knobs.clear();
  const groups = new Map();
  $('fixed').replaceChildren();
  for (const key of keys.keys) {
    const knob = makeKnob(key);
    if (!key.live) { $('fixed').append(knob.row); continue; }
    knobs.set(key.path, knob);
    const group = key.path.includes('.') ? key.path.slice(0, key.path.lastIndexOf('.')) : 'scene';
    if (!groups.has(group)) groups.set(group, []);
    groups.get(group).push(knob);
  }
  const order = ['fluid', 'emitter[0]', 'solid[0]', 'domain', 'look', 'camera'];
  const rank = name => (order.indexOf(name) + order.length + 1) % (order.length + 1) + (order.includes(name) ? 0 : order.length);
  $('knobs').replaceChildren(...[...groups].sort((a, b) => rank(a[0]) - rank(b[0])).map(([name, list]) => {
    const box = document.createElement('details'), summary = document.createElement('summary');
    box.dataset.group = name;
    box.setAttribute('aria-label', name);
    box.open = open.get(name) ?? ['fluid', 'emitter[0]'].includes(name);
    summary.textContent = name.replace('[', ' ').replace(']', '');
    box.append(summary, ...list.map(k => k.row));
    return box;
  }));
  $('models').replaceChildren(...keys.models.flatMap(m => {
    const dt = document.createElement('dt'), dd = document.createElement('dd');
    dt.textContent = m.key + ' = ' + m.value + (m.automatic ? ' (auto)' : '');
    dd.textContent = m.reason;
    return [dt, dd];
  }), ...keys.warnings.map(w => { const dd = document.createElement('dd'); dd.textContent = 'Note: ' + w; return dd; }));
  tries();
  filter();
}

// Typical magnitudes by unit, for the range of a slider whose value is 0.
const typical = {'N/m': 0.1, 'm^2/s': 1e-4, 'Pa s': 10, 'm/s': 10, Pa: 1000, s: 2, m: 0.05};
// Returns the scale of a slider: logarithmic if the values are positive and may span decades.
function scaleOf(key, value) {
  let low = key.least, high = key.most;
  const positive = low !== null && low >= 0;
  const size = Math.abs(value) || (typical[key.unit] ?? 1);
  if (low === null) low = -2 * size;
  if (high === null) high = positive ? (value === 0 ? 1 : 30) * size : 2 * size;
  if (positive && value > 0 && (key.most === null || key.most > 200 * value || (key.least > 0 && key.most / key.least > 200))) {
    const from = Math.max(low, value / 30) || value / 30, to = Math.min(key.most ?? Infinity, 30 * value), span = Math.log(to / from);
    return {at: v => v <= 0 ? 0 : Math.log(v / from) / span, value: p => from * Math.exp(p * span)};
  }
  return {at: v => (v - low) / (high - low), value: p => low + p * (high - low)};
}
const rounded = v => Number(v.toPrecision(3));

function makeKnob(key) {
  const row = document.createElement('div'), name = document.createElement('label'), unit = document.createElement('span');
  const fields = document.createElement('div'), why = document.createElement('p'), wrong = document.createElement('p');
  row.className = 'knob', name.className = 'name', fields.className = 'fields', why.className = 'why', wrong.className = 'wrong';
  row.dataset.path = key.path;
  name.textContent = key.path.slice(key.path.lastIndexOf('.') + 1).replace(/_/g, ' ');
  unit.textContent = key.unit;
  name.append(unit);
  why.textContent = key.meaning + (key.variables ? ' (a number, or an expression of ' + key.variables + ')' : '');
  const id = 'k_' + key.path.replace(/[^a-z0-9]+/gi, '_');
  name.htmlFor = id;
  row.append(name, fields, wrong, why);
  let shown = null, held = 0;
  const change = value => {
    held = Date.now();
    shown = JSON.stringify(value);
    row.dataset.changed = '1', row.dataset.value = shown;
    if (key.live) set({[key.path]: value});
  };
  const knob = {row, wrong, key, refused: 0, put: () => {}, show(value, force) {
    const text = JSON.stringify(value);
    // Hide the error when the value changes, unless the value was refused less than a second ago: that state may be older than the refusal.
    if (text !== shown && !force && Date.now() - this.refused > 1000) wrong.textContent = '';
    // Do not overwrite a control that the user is moving or typing into.
    if (!force && (text === shown || Date.now() - held < 700 || (fields.contains(document.activeElement) && document.activeElement.type === 'text'))) return;
    shown = text;
    this.put(value);
  }};
  row.onkeydown = event => {
    if (event.key !== 'Escape' || event.target.type !== 'text') return;
    wrong.textContent = row.dataset.changed = '';
    knob.show(key.live && state ? state.values[key.path] : key.value, true);
  };
  const field = (value, cls) => {
    const input = document.createElement('input');
    input.type = 'text', input.className = cls, input.spellcheck = false, input.autocomplete = 'off';
    input.value = value;
    return input;
  };
  // Converts "0.2" to a number; keeps other texts (an expression, "auto").
  const typed = text => text.trim() !== '' && isFinite(Number(text)) ? Number(text) : text;
  const list = key.type.endsWith('s'), entry = text => ({true: true, false: false})[text.trim()] ?? typed(text.trim());

  if (key.type === 'flag') {
    const box = document.createElement('input');
    box.type = 'checkbox', box.id = id;
    box.onchange = () => change(box.checked);
    knob.put = v => { box.checked = v; };
    fields.append(box);
  } else if (key.choices.length > 0 && ['choice', 'text'].includes(key.type)) {
    const select = document.createElement('select');
    select.id = id;
    for (const c of [...(key.auto ? ['auto'] : []), ...key.choices]) select.append(new Option(c, c));
    select.onchange = () => change(select.value);
    knob.put = v => { select.value = v; };
    fields.append(select);
  } else if (['numbers', 'integers', 'expressions'].includes(key.type) && Array.isArray(key.value) && !key.auto) {
    fields.classList.add('three');
    const inputs = key.value.map((v, i) => {
      const input = field(v, '');
      if (i === 0) input.id = id;
      input.setAttribute('aria-label', key.path + ' ' + ('xyz'[i] || i));
      input.onchange = () => change(inputs.map(each => typed(each.value)));
      return input;
    });
    knob.put = v => v.forEach((one, i) => { if (inputs[i]) inputs[i].value = one; });
    fields.append(...inputs);
  } else if (['number', 'integer', 'expression'].includes(key.type) && typeof key.value === 'number') {
    const slider = document.createElement('input'), input = field(key.value, '');
    slider.type = 'range', slider.min = 0, slider.max = 1000, slider.step = 1, slider.setAttribute('aria-label', key.path + ' slider');
    input.id = id, input.inputMode = 'decimal';
    let scale = scaleOf(key, key.value);
    const announce = () => slider.setAttribute('aria-valuetext', input.value + ' ' + key.unit);
    slider.oninput = () => {
      const v = key.type === 'integer' ? Math.round(scale.value(slider.value / 1000)) : rounded(scale.value(slider.value / 1000));
      input.value = v, announce();
      change(v);
    };
    input.onchange = () => { change(typed(input.value)); if (isFinite(Number(input.value))) scale = scaleOf(key, Number(input.value)), slider.value = 1000 * scale.at(Number(input.value)); };
    knob.put = v => { input.value = v, announce(); slider.disabled = typeof v !== 'number'; if (typeof v === 'number') slider.value = 1000 * Math.min(1, Math.max(0, scale.at(v))); };
    fields.append(slider, input);
  } else {
    const input = field(key.value, 'wide');
    input.id = id;
    input.onchange = () => change(list && input.value.includes(',') ? input.value.replace(/[[\]]/g, '').split(',').map(entry) : typed(input.value));
    knob.put = v => { input.value = Array.isArray(v) ? v.join(', ') : v; };
    fields.append(input);
  }
  knob.show(key.value, true);
  row.dataset.changed = '';
  return knob;
}

// Hides the knobs that lack a word of the search text in their path, name or meaning.
function filter() {
  const words = $('find').value.toLowerCase().replace(/color/g, 'colour').split(/\s+/).filter(word => word);
  for (const knob of document.querySelectorAll('.knob')) {
    const text = (knob.dataset.path + ' ' + knob.textContent).toLowerCase();
    knob.hidden = !words.every(word => text.includes(word));
  }
  for (const box of document.querySelectorAll('#knobs details, #restarting')) {
    box.hidden = words.length > 0 && !box.querySelector('.knob:not([hidden])');
    if (words.length > 0 && !box.hidden) box.open = true;
  }
  const found = document.querySelectorAll('.knob:not([hidden])').length;
  write($('found'), words.length === 0 ? '' : found === 0 ? 'No key has "' + words.join(' ') + '" in its name or meaning.' : found + (found === 1 ? ' key' : ' keys'));
}
$('find').oninput = filter;

// Fills the list of suggested changes with those whose keys the scene has.
function tries() {
  const v = path => state ? state.values[path] : undefined;
  const scaled = (path, factor) => () => typeof v(path) === 'number' ? {[path]: rounded(v(path) * factor)} : null;
  const list = [
    ['three times thicker', 'fluid.viscosity', scaled('fluid.viscosity', 3)], ['three times thinner', 'fluid.viscosity', scaled('fluid.viscosity', 1 / 3)],
    ['pour half as fast again', 'emitter[0].speed', scaled('emitter[0].speed', 1.5)], ['pour in pulses', 'emitter[0].speed', () => ({'emitter[0].speed': rounded(Number(v('emitter[0].speed')) || 0.2) + '*(1+0.8*sin(12*t))'})],
    ['turn the solid', 'solid[0].rotation', () => ({'solid[0].rotation': [0, 6, 0]})],
    ['swing the solid', 'solid[0].position', () => ({'solid[0].position': ['0.015*sin(8*t)', 0, 0]})],
    ['gravity of the moon', 'domain.gravity', () => ({'domain.gravity': [0, -1.62, 0]})], ['tilt the world', 'domain.gravity', () => ({'domain.gravity': [3, -9.3, 0]})],
    ['chocolate', 'look.material', () => ({'look.style': 'opaque', 'look.material': 'chocolate'})], ['honey', 'look.material', () => ({'look.style': 'liquid', 'look.material': 'honey'})],
    ['lava', 'look.material', () => ({'look.style': 'opaque', 'look.material': 'lava'})], ['show the speed', 'look.style', () => ({'look.style': 'particles', 'look.field': 'speed', 'look.legend': true})]];
  $('try').replaceChildren(new Option('choose', ''), ...list.filter(([, path]) => knobs.has(path)).map(([name]) => new Option(name, name)));
  $('try').onchange = () => {
    const chosen = list.find(([name]) => name === $('try').value);
    const changes = chosen && chosen[2]();
    if (changes) set(changes);
    $('try').value = '';
  };
}

// --- buttons and keys ------------------------------------------------------------------------------------------------------------------
const actions = {
  play: () => control({do: !state || state.state === 'running' ? (state && state.playing ? 'pause' : 'play') : 'restart'}),
  step: () => control({do: 'step'}),
  restart: () => control({do: 'restart'}).then(reply => reply.ok && say('')),
  undo: async () => { await sending; control({do: 'undo'}); },  // first send a change that is still waiting, so that it is undone
};
for (const [name, act] of Object.entries(actions)) $(name).onclick = act;
const restart = more => control({do: 'restart', ...more}).then(loadKeys);
$('apply').onclick = () => {
  const changes = {};
  for (const row of $('fixed').children) if (row.dataset.changed === '1') changes[row.dataset.path] = JSON.parse(row.dataset.value);
  control({do: 'restart', set: changes}).then(reply => reply.ok && loadKeys());  // if refused, the fields keep the values
};
$('forget').onclick = () => restart({forget: true});
$('scene').onchange = () => restart({scene: $('scene').value});
$('quality').onchange = () => restart({quality: $('quality').value});
for (const link of ['save', 'recording']) $(link).href = address($(link).getAttribute('href'));

document.addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  // A focused text field or list keeps all keys, a focused button or check box keeps Space; a slider leaves these keys to the page.
  const tag = event.target.tagName, kind = event.target.type;
  const types = tag === 'TEXTAREA' || tag === 'SELECT' || tag === 'INPUT' && kind !== 'range' && kind !== 'checkbox';
  const presses = event.key === ' ' && (['BUTTON', 'A', 'SUMMARY'].includes(tag) || kind === 'checkbox');
  const busy = types || presses;
  const name = {' ': 'play', '.': 'step', 'r': 'restart', 'u': 'undo'}[event.key];
  if (name && !busy) { event.preventDefault(); actions[name](); }
});

// --- the camera, which turns about its target ------------------------------------------------------------------------------------------
const add = (a, b) => a.map((v, i) => v + b[i]), scale = (a, s) => a.map(v => v * s), minus = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0), length = a => Math.sqrt(dot(a, a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => scale(a, 1 / (length(a) || 1));
const turned = (a, axis, angle) => add(add(scale(a, Math.cos(angle)), scale(cross(axis, a), Math.sin(angle))), scale(axis, dot(axis, a) * (1 - Math.cos(angle))));
let view = null, viewed = 0, home = null;

function camera() {
  // Within 1.5 s of a movement, use the page's own view, because the view of the state lags behind.
  if (!view || Date.now() - viewed > 1500) view = state && state.view ? JSON.parse(JSON.stringify(state.view)) : null;
  if (view && !home) home = Object.fromEntries(Object.entries(state.values).filter(([k]) => k.startsWith('camera.')));
  return view;
}
function moved() {
  viewed = Date.now();
  const round = a => a.map(v => Number(v.toFixed(5)));
  set({'camera.kind': 'fixed', 'camera.position': round(view.position), 'camera.target': round(view.target), 'camera.up': view.up, 'camera.fov': view.fov});
}
function orbit(dx, dy) {
  if (!camera()) return;
  const up = unit(view.up);
  let offset = turned(minus(view.position, view.target), up, -dx);
  const side = unit(cross(up, offset)), tilted = turned(offset, side, -dy);
  if (Math.abs(dot(unit(tilted), up)) < 0.985) offset = tilted;
  view.position = add(view.target, offset);
  moved();
}
function pan(dx, dy) {
  if (!camera()) return;
  const offset = minus(view.position, view.target), side = unit(cross(view.up, offset)), above = unit(cross(offset, side));
  const size = 2 * length(offset) * Math.tan(view.fov * Math.PI / 360), by = add(scale(side, -dx * size), scale(above, dy * size));
  view.position = add(view.position, by), view.target = add(view.target, by);
  moved();
}
function zoom(factor) {
  if (!camera()) return;
  view.position = add(view.target, scale(minus(view.position, view.target), factor));
  moved();
}
function goHome() {
  if (home) set(home), view = null;
}

const frame = $('frame'), pointers = new Map();
frame.addEventListener('contextmenu', event => event.preventDefault());
frame.addEventListener('pointerdown', event => { frame.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]); });
for (const end of ['pointerup', 'pointercancel']) frame.addEventListener(end, event => pointers.delete(event.pointerId));
frame.addEventListener('pointermove', event => {
  const last = pointers.get(event.pointerId);
  if (!last) return;
  const dx = event.clientX - last[0], dy = event.clientY - last[1];
  if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    const before = Math.hypot(last[0] - other[0], last[1] - other[1]), after = Math.hypot(event.clientX - other[0], event.clientY - other[1]);
    if (before > 0 && after > 0) zoom(before / after);
    pan(dx / 2 / frame.clientHeight, dy / 2 / frame.clientHeight);
  } else if (event.shiftKey || event.buttons & 2) pan(dx / frame.clientHeight, dy / frame.clientHeight);
  else orbit(dx * 0.008, dy * 0.008);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
});
frame.addEventListener('wheel', event => { event.preventDefault(); zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY / 100)) * 0.12)); }, {passive: false});
frame.addEventListener('keydown', event => {
  const by = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
  if (by) { event.preventDefault(); if (event.shiftKey) pan(0.05 * by[0], 0.05 * by[1]); else orbit(0.1 * by[0], 0.1 * by[1]); }
  else if (event.key === '+' || event.key === '=') zoom(0.9);
  else if (event.key === '-') zoom(1 / 0.9);
  else if (event.key === '0') goHome();
});

connect();
