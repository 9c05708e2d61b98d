'use strict';
// Plots on canvases: one plot per title, one line per name. A plot shows the last 600 values over time, or a profile over a coordinate at
// the current time. Theory and experiments are dashed.
const Plots = (() => {
  const kept = 600;
  const colours = ['#d9822b', '#2f8fd0', '#3fa45b', '#b565c9', '#d14c4c', '#7b8a97', '#c2a516', '#26a59a'];
  const plots = new Map();
  // Only visible plots are drawn, at most twice a second.
  const seen = new IntersectionObserver(changes => {
    for (const change of changes) for (const plot of plots.values()) if (plot.canvas === change.target) plot.seen = change.isIntersecting;
    drawSoon();
  });
  let waits = 0;
  function drawSoon() {
    if (!waits) waits = setTimeout(() => { waits = 0; draw(); }, 500);
  }

  function short(v) {
    if (v === null || v === undefined || !isFinite(v)) return '–';
    const a = Math.abs(v);
    if (a !== 0 && (a >= 1e5 || a < 1e-3)) return v.toExponential(2);
    return String(Number(v.toPrecision(3)));
  }

  function make(parent, title, along = 'time') {
    const figure = document.createElement('figure');
    figure.className = 'plot';
    const caption = document.createElement('figcaption');
    caption.textContent = title;
    const canvas = document.createElement('canvas');
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', title + ' over ' + along);
    const legend = document.createElement('div');
    legend.className = 'legend';
    figure.append(caption, canvas, legend);
    parent.append(figure);
    const plot = {canvas, legend, times: [], unit: 's', lines: new Map(), seen: false};
    seen.observe(canvas);
    return plot;
  }

  const colour = k => colours[k % colours.length];
  const number = v => typeof v === 'number' && isFinite(v) ? v : null;

  // Adds values at a time, and drops the oldest above 600.
  function add(parent, title, time, values, dashed = []) {
    if (!plots.has(title)) plots.set(title, make(parent, title));
    const plot = plots.get(title);
    plot.times.push(time);
    for (const [name, value] of Object.entries(values)) {
      if (!plot.lines.has(name)) plot.lines.set(name, {colour: colour(plot.lines.size), dashed: dashed.includes(name), points: new Array(plot.times.length - 1).fill(null)});
      plot.lines.get(name).points.push(number(value));
    }
    for (const line of plot.lines.values()) while (line.points.length < plot.times.length) line.points.push(null);
    if (plot.times.length > kept) {
      plot.times.shift();
      for (const line of plot.lines.values()) line.points.shift();
    }
  }

  // Replaces a profile by values at these positions.
  function profile(parent, title, {along, along_unit}, places, values, dashed) {
    if (!plots.has(title)) plots.set(title, make(parent, title, along));
    const plot = plots.get(title);
    plot.times = places, plot.unit = along_unit;
    plot.lines = new Map(Object.entries(values).map(([name, points], k) => [name, {colour: colour(k), dashed: dashed.includes(name), points: points.map(number)}]));
  }

  function draw() {
    for (const plot of plots.values()) {
      if (!plot.seen) continue;
      const {canvas, times, lines} = plot;
      const scale = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
      if (w === 0) continue;
      if (canvas.width !== Math.round(w * scale)) canvas.width = Math.round(w * scale), canvas.height = Math.round(h * scale);
      const g = canvas.getContext('2d');
      g.setTransform(scale, 0, 0, scale, 0, 0);
      g.clearRect(0, 0, w, h);
      let low = Infinity, high = -Infinity;
      for (const line of lines.values()) for (const p of line.points) if (p !== null) low = Math.min(low, p), high = Math.max(high, p);
      const ink = getComputedStyle(canvas).getPropertyValue('--soft'), grid = getComputedStyle(canvas).getPropertyValue('--line');
      if (!isFinite(low)) {
        g.fillStyle = ink, g.font = '12px system-ui', g.fillText('nothing measured yet', 8, h / 2);
        continue;
      }
      if (low > 0 && low < 0.5 * high) low = 0;
      if (high === low) high = low + (Math.abs(low) || 1);
      const left = 56, right = w - 4, top = 6, bottom = h - 16;
      const x = k => left + (right - left) * (times.length > 1 ? k / (times.length - 1) : 1), y = v => bottom - (bottom - top) * (v - low) / (high - low);
      g.font = '11px system-ui', g.fillStyle = ink, g.strokeStyle = grid, g.lineWidth = 1;
      for (const part of [0, 0.5, 1]) {
        const v = low + part * (high - low);
        g.beginPath(), g.moveTo(left, y(v)), g.lineTo(right, y(v)), g.stroke();
        g.textAlign = 'right', g.fillText(short(v), left - 5, y(v) + 4);
      }
      g.textAlign = 'left', g.fillText(short(times[0]) + ' ' + plot.unit, left, h - 3);
      g.textAlign = 'right', g.fillText(short(times[times.length - 1]) + ' ' + plot.unit, right, h - 3);
      g.lineWidth = 1.8;
      for (const line of lines.values()) {
        g.strokeStyle = line.colour;
        g.setLineDash(line.dashed ? [5, 4] : []);
        g.beginPath();
        let open = false;
        line.points.forEach((p, k) => {
          if (p === null) { open = false; return; }
          if (open) g.lineTo(x(k), y(p)); else g.moveTo(x(k), y(p));
          open = true;
        });
        g.stroke();
      }
      g.setLineDash([]);
      if (plot.legend.children.length !== lines.size) plot.legend.replaceChildren(...[...lines.values()].map(line => {
        const entry = document.createElement('span'), mark = document.createElement('i');
        mark.style.color = line.colour;
        mark.className = line.dashed ? 'dashed' : '';
        entry.append(mark, '');
        return entry;
      }));
      [...lines].forEach(([name, line], i) => { plot.legend.children[i].lastChild.data = name + ' ' + short(line.points[line.points.length - 1]); });
    }
  }

  function clear() {
    for (const plot of plots.values()) seen.unobserve(plot.canvas), plot.canvas.parentElement.remove();
    plots.clear();
  }
  const points = title => plots.has(title) ? plots.get(title).times.length : 0;
  return {add, profile, draw, drawSoon, clear, short, points};
})();
