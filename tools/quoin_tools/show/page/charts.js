"use strict";
// Charts: histories of points and joints, and what a joint carries along its line.

const DASHES = [[], [6, 3], [2, 3], [8, 3, 2, 3]];

function lineOf(number) {
  return {colour: scene.lines[number % scene.lines.length], dash: DASHES[Math.floor(number / scene.lines.length) % DASHES.length]};
}

// Places of the ticks of an axis.
function ticksOf(low, high, wanted) {
  const every = nice((high - low) / wanted) || 1, out = [];
  for (let k = Math.ceil(low / every - 1e-9); k * every <= high + 1e-9 * every; k++) out.push(Math.abs(k * every) < 1e-12 * Math.abs(high) ? 0 : k * every);
  return out;
}

function rangeOfAll(arrays, log) {
  let low = Infinity, high = -Infinity;
  for (const values of arrays) for (const v of values) {
    if (!Number.isFinite(v) || (log && v <= 0)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (low > high) return log ? [1e-3, 1] : [-1, 1];
  if (log) return [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high) + 1e-9)];
  const room = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
  return [low - room, high + room];
}

// Where stages end on an axis over cycles: as long as they ran, but none so short that it cannot be seen.
const NAME_ROWS = 2; // of names of stages above a chart
const SHORTEST = 0.35; // of an even share

function stretched(spans) {
  const from = [spans[0][1], ...spans.map(([, , to]) => to)], whole = from[from.length - 1] - from[0] || 1;
  const parts = spans.map((_, i) => Math.max((from[i + 1] - from[i]) / whole, SHORTEST / spans.length)), sum = parts.reduce((a, b) => a + b, 0);
  const at = [0];
  parts.forEach((part) => at.push(at[at.length - 1] + part / sum));
  return {from, at};
}

// The value at which a row of corners, rising, is at a place; and the other way round with the rows changed.
function along(value, froms, tos) {
  let k = 0;
  while (k < froms.length - 2 && value > froms[k + 1]) k++;
  return tos[k] + ((value - froms[k]) / (froms[k + 1] - froms[k] || 1)) * (tos[k + 1] - tos[k]);
}

// Panel of a chart: box of its axes, how values become px and px values. spans: stages along x.
function panelOf(box, xs, ys, log, spans = []) {
  const y = log ? Math.log10 : (v) => v, [low, high] = [y(ys[0]), y(ys[1])];
  const {from, at: ends} = spans.length > 1 ? stretched(spans) : {from: xs[1] > xs[0] ? xs : [xs[0], xs[0] + 1], at: [0, 1]}, wide = box[1] - box[0];
  return {box, xs, ys, log, from, px: (v) => box[0] + along(v, from, ends) * wide, valueAt: (px) => along((px - box[0]) / wide, ends, from), py: (v) => box[3] - ((y(v) - low) / (high - low || 1)) * (box[3] - box[2])};
}

function drawPanel(ink, panel, xLabel, yLabel) {
  const [left, right, top, bottom] = panel.box;
  ink.font = "11px DejaVu Sans, Segoe UI, Arial, sans-serif";
  ink.strokeStyle = "#dfe4e8";
  ink.fillStyle = SOFT;
  ink.lineWidth = 1;
  ink.setLineDash([]);
  const line = (a, b, c, d) => { ink.beginPath(); ink.moveTo(a, b); ink.lineTo(c, d); ink.stroke(); };
  ink.textAlign = "center";
  ink.textBaseline = "top";
  const ends = panel.from.length > 2, across = ends ? panel.from : ticksOf(...panel.xs, Math.max(2, (right - left) / 110)), every = ends || across.length < 2 ? 1 : across[1] - across[0];
  let free = -Infinity;
  for (const x of xLabel ? across : []) {
    const isLast = x === across[across.length - 1];
    if (ends && (panel.px(x) < free || (!isLast && panel.px(x) > right - 60))) continue;
    free = panel.px(x) + 60;
    line(panel.px(x), top, panel.px(x), bottom);
    ink.textAlign = isLast && panel.px(x) > right - 20 ? "right" : "center";
    ink.fillText(round(x, every), Math.min(panel.px(x), right + 8), bottom + 4);
  }
  ink.textAlign = "right";
  ink.textBaseline = "middle";
  const decades = Math.log10(panel.ys[1] / panel.ys[0]), rows = panel.log
    ? Array.from({length: Math.round(decades) + 1}, (_, k) => panel.ys[0] * 10 ** k).filter((_, k) => k % Math.ceil(decades / 6) === 0) : ticksOf(...panel.ys, Math.max(2, (bottom - top) / 36));
  for (const y of rows) {
    line(left, panel.py(y), right, panel.py(y));
    ink.fillText(panel.log ? y.toExponential(0) : round(y, rows[1] - rows[0] || 1), left - 4, panel.py(y));
  }
  ink.strokeStyle = SOFT;
  ink.strokeRect(left, top, right - left, bottom - top);
  if (!panel.log && panel.ys[0] < 0 && panel.ys[1] > 0) line(left, panel.py(0), right, panel.py(0));
  ink.fillStyle = INK;
  ink.textAlign = "center";
  ink.textBaseline = "bottom";
  if (xLabel) ink.fillText(xLabel, 0.5 * (left + right), bottom + 32);
  ink.save();
  ink.translate(12, 0.5 * (top + bottom));
  ink.rotate(-Math.PI / 2);
  ink.textBaseline = "middle";
  ink.fillText(yLabel, 0, 0);
  ink.restore();
}

function drawCourse(ink, panel, x, y, {colour, dash}, width = 1.5) {
  ink.save();
  ink.beginPath();
  ink.rect(panel.box[0], panel.box[2], panel.box[1] - panel.box[0], panel.box[3] - panel.box[2]);
  ink.clip();
  ink.beginPath();
  let down = false;
  for (let i = 0; i < x.length; i++) {
    const known = Number.isFinite(y[i]) && !(panel.log && y[i] <= 0);
    if (known) down ? ink.lineTo(panel.px(x[i]), panel.py(y[i])) : ink.moveTo(panel.px(x[i]), panel.py(y[i]));
    down = known;
  }
  ink.setLineDash(dash);
  ink.strokeStyle = colour;
  ink.lineWidth = width;
  ink.stroke();
  ink.restore();
}

// Names of lines in rows above a chart; returns where the chart can begin [px].
function drawNames(ink, names, width) {
  let x = 6, y = 10;
  ink.font = "11px DejaVu Sans, Segoe UI, Arial, sans-serif";
  ink.textAlign = "left";
  ink.textBaseline = "middle";
  names.forEach((name, i) => {
    const wide = ink.measureText(name).width + 36, {colour, dash} = lineOf(i);
    if (x + wide > width && x > 6) [x, y] = [6, y + 15];
    ink.setLineDash(dash);
    ink.strokeStyle = colour;
    ink.lineWidth = 2;
    ink.beginPath();
    ink.moveTo(x, y);
    ink.lineTo(x + 20, y);
    ink.stroke();
    ink.fillStyle = INK;
    ink.fillText(name, x + 24, y);
    x += wide;
  });
  return y + 12;
}

// ---- histories

const MOST_LINES = 12; // of one chart; more would not be told apart

// Lines of a chart: those that move most.
function linesOf(chart) {
  const all = chart.series.map(([name, place]) => [name, at(place)]);
  if (all.length <= MOST_LINES) return all;
  const reach = all.map(([, y]) => { const [low, high] = rangeOfAll([y]); return high - low; });
  const kept = new Set(reach.map((_, i) => i).sort((a, b) => reach[b] - reach[a]).slice(0, MOST_LINES));
  return all.filter((_, i) => kept.has(i));
}

// The place of a step on the axis of a chart; null: it is not on it.
function placeOf(chart, step) {
  if (chart.over === "cycle") {
    const span = chart.spans.find(([name]) => name === step.stage);
    if (!span) return null;
    const times = scene.steps.filter((s) => s.stage === step.stage && s.time !== null).map((s) => s.time), end = Math.max(...times);
    return step.time === null || !(end > 0) ? span[2] : span[1] + (step.time / end) * (span[2] - span[1]);
  }
  return chart.over === step.stage ? step.time : null;
}

function drawChart(drawn, chart, step) {
  const [width, height] = sized(drawn), ink = drawn.getContext("2d"), x = at(chart.x), lines = linesOf(chart);
  ink.clearRect(0, 0, width, height);
  const top = drawNames(ink, lines.map(([name]) => name), width) + (chart.spans.length > 1 ? 13 * NAME_ROWS : 0);
  const ends = rangeOfAll([x]), panel = panelOf([64, width - 10, top, height - 38], [x[0], Math.max(x[x.length - 1], x[0] + 1e-12)], rangeOfAll(lines.map(([, y]) => y), chart.log), chart.log, chart.spans);
  drawPanel(ink, panel, chart.label, `${chart.title.split(",")[0]} [${chart.unit}]`);
  lines.forEach(([, y], i) => drawCourse(ink, panel, x, y, lineOf(i)));
  drawSpans(ink, panel, chart.spans);
  const here = placeOf(chart, step);
  if (here !== null) {
    ink.strokeStyle = "#c1121f";
    ink.lineWidth = 1.4;
    ink.setLineDash([]);
    ink.beginPath();
    ink.moveTo(panel.px(here), top);
    ink.lineTo(panel.px(here), height - 38);
    ink.stroke();
  }
  Object.assign(drawn.dataset, {lines: lines.length, rows: x.length, here: here === null ? "" : here, from: ends[0], to: ends[1]});
  drawn.valueAt = panel.valueAt;
}

// Where stages end, and their names as far as there is room.
function drawSpans(ink, panel, spans) {
  if (spans.length < 2) return;
  ink.font = "11px DejaVu Sans, Segoe UI, Arial, sans-serif";
  ink.fillStyle = SOFT;
  ink.strokeStyle = SOFT;
  ink.lineWidth = 0.8;
  ink.textAlign = "center";
  ink.textBaseline = "bottom";
  const free = Array(NAME_ROWS).fill(-Infinity);
  spans.forEach(([name, from, to], i) => {
    const start = i ? spans[i - 1][2] : from, middle = 0.5 * (panel.px(start) + panel.px(to)), half = 0.5 * ink.measureText(name).width + 3;
    if (i) {
      ink.setLineDash([2, 3]);
      ink.beginPath();
      ink.moveTo(panel.px(start), panel.box[2]);
      ink.lineTo(panel.px(start), panel.box[3]);
      ink.stroke();
    }
    const row = free.findIndex((end) => middle - half > end);
    if (row >= 0 && middle + half < panel.box[1] + 10) {
      ink.fillText(name, middle, panel.box[2] - 1 - 13 * row);
      free[row] = middle + half;
    }
  });
}

// ---- along a joint

// Distance [m], and values at both ends, of the contacts of a joint that is a line, in order.
function profileOf(step, name, ends) {
  const {joint, point, sigma, tau, opening} = step.contacts, number = scene.joints.indexOf(name), out = [];
  const [from, to] = ends.map(([x, y]) => [x - scene.origin[0], y - scene.origin[1]]), long = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const along = (k) => ((point[k] - from[0]) * (to[0] - from[0]) + (point[k + 1] - from[1]) * (to[1] - from[1])) / long;
  for (let i = 0; i < joint.length; i++) {
    if (joint[i] !== number) continue;
    const s = [along(4 * i), along(4 * i + 2)], order = s[0] <= s[1] ? [0, 1] : [1, 0];
    out.push({s: order.map((e) => s[e]), sigma: order.map((e) => sigma[2 * i + e]), tau: order.map((e) => -tau[2 * i + e]), opening: order.map((e) => Math.max(0, opening[2 * i + e]))});
  }
  return out.sort((a, b) => a.s[0] + a.s[1] - b.s[0] - b.s[1]);
}

// Stresses and opening along a joint; values of contacts side by side are joined only where they belong to one contact.
function drawProfile(drawn, step, name, ends) {
  const [width, height] = sized(drawn), ink = drawn.getContext("2d");
  ink.clearRect(0, 0, width, height);
  const profile = ends ? profileOf(step, name, ends) : [];
  drawn.dataset.contacts = profile.length;
  drawn.hidden = !profile.length;
  if (!profile.length) return ends ? "no contacts of it are in this step" : "it is no line: see the colours of the section";
  const spread = (key, factor) => profile.flatMap((c) => [factor * c[key][0], factor * c[key][1], NaN]), s = spread("s", 1);
  const sigma = spread("sigma", 1e-3), tau = spread("tau", 1e-3), opening = spread("opening", 1e3), length = Math.max(...s.filter(Number.isFinite));
  const isOpen = opening.some((v) => v > 0), split = isOpen ? Math.round(0.62 * height) : height - 38;
  const top = drawNames(ink, ["normal stress σ (tension positive)", "shear stress τ (positive: the upper side pushes to the end)", ...(isOpen ? ["opening"] : [])], width);
  const upper = panelOf([64, width - 10, top, split], [0, length], rangeOfAll([sigma, tau, [0]]), false);
  drawPanel(ink, upper, isOpen ? "" : `distance along ${name} [m]`, "stress [kPa]");
  [sigma, tau].forEach((y, i) => drawCourse(ink, upper, s, y, lineOf(i), 2));
  if (isOpen) {
    const lower = panelOf([64, width - 10, split + 12, height - 38], [0, length], rangeOfAll([opening, [0]]), false);
    drawPanel(ink, lower, `distance along ${name} [m]`, "opening [mm]");
    drawCourse(ink, lower, s, opening, lineOf(2), 2);
  }
  const widest = Math.max(...opening.filter(Number.isFinite));
  Object.assign(drawn.dataset, {least: Math.min(...sigma.filter(Number.isFinite)), widest});
  return `${profile.length} contacts, ${plain(length)} m; most compression ${plain(-Math.min(0, ...sigma.filter(Number.isFinite)))} kPa, widest opening ${plain(widest)} mm`;
}
