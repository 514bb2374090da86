"use strict";
// Charts, drawn by uPlot: histories of points and joints, and what a joint carries along its line.

const DASHES = [[], [6, 3], [2, 3], [8, 3, 2, 3]];
const BORDERS = ["solid", "dashed", "dotted", "double"]; // of the marks in the legend, by dash
const FONT = "11px DejaVu Sans, Segoe UI, Arial, sans-serif";
const GRID = {stroke: "#dfe4e8", width: 1};

// Lines that share a colour differ in their dash.
const dashOf = (i) => Math.floor(i / scene.lines.length) % DASHES.length;

// The look of line i of a chart.
function lineOf(i, label, scale = "y") {
  return {label, scale, stroke: scene.lines[i % scene.lines.length], dash: DASHES[dashOf(i)], width: 1.6, points: {show: false}, value: (_, v) => plain(v)};
}

function axisOf(label, scale, more = {}) {
  return {scale, label, font: FONT, labelFont: FONT, labelSize: 18, stroke: INK, grid: GRID, ticks: GRID, values: (_, places, axis, space, every) => places.map((v) => (v === null ? "" : round(v, every / 10))), ...more};
}

// Draws series (columns of numbers; not finite: a gap) over rising x in a box.
function plotIn(box, x, columns, options) {
  const log = options.scales.y.distr === 3, known = (v) => Number.isFinite(v) && !(log && v <= 0);
  const data = [Array.from(x), ...columns.map((values) => Array.from(values, (v) => (known(v) ? v : null)))];
  const plot = new uPlot({...sizeIn(box), legend: {live: true, markers: {dash: (_, row) => BORDERS[dashOf(row - 1)]}}, cursor: {y: false, drag: {x: true, y: false}}, ...options}, data, box);
  new ResizeObserver(() => box.clientWidth && plot.setSize(sizeIn(box))).observe(box);
  return plot;
}

function sizeIn(box) {
  return {width: box.clientWidth || 460, height: 240};
}

function reachOf(values) {
  let low = Infinity, high = -Infinity;
  for (const v of values) {
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return [low, high];
}

// ---- histories

const MOST_LINES = 12; // of one chart; more would not be told apart
const NAME_ROWS = 2; // of names of stages above a chart
const SHORTEST = 0.35; // of an even share of the axis: a stage is as long as it ran, but none so short that it cannot be seen

// Lines of a chart: those that move most.
function linesOf(chart) {
  const all = chart.series.map(([name, place]) => [name, at(place)]);
  if (all.length <= MOST_LINES) return all;
  const reach = all.map(([, y]) => { const [low, high] = reachOf(y); return high - low; });
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

// The value at which a row of corners, rising, is at a place; and the other way round with the rows changed.
function along(value, froms, tos) {
  let k = 0;
  while (k < froms.length - 2 && value > froms[k + 1]) k++;
  return tos[k] + ((value - froms[k]) / (froms[k + 1] - froms[k] || 1)) * (tos[k + 1] - tos[k]);
}

// Scale and axis over the cycles of several stages: ticks stand where stages end.
function stretched(spans, label) {
  const ends = [spans[0][1], ...spans.map(([, , to]) => to)], whole = ends[ends.length - 1] - ends[0] || 1;
  const parts = spans.map((_, i) => Math.max((ends[i + 1] - ends[i]) / whole, SHORTEST / spans.length)), sum = parts.reduce((a, b) => a + b, 0);
  const places = [0];
  parts.forEach((part) => places.push(places[places.length - 1] + part / sum));
  const inside = (plot) => {
    let free = -Infinity;
    return ends.filter((end) => {
      const px = plot.valToPos(end, "x"), fits = end >= plot.scales.x.min && end <= plot.scales.x.max && px > free;
      if (fits) free = px + 60;
      return fits;
    });
  };
  return {scale: {time: false, distr: 100, fwd: (v) => along(v, ends, places), bwd: (v) => along(v, places, ends)}, axis: axisOf(label, "x", {size: 28, splits: inside, filter: (_, places) => places, values: (_, places) => places.map((v) => plain(v))})};
}

// Writes the names of stages above a plot, as far as there is room, and a line where each begins.
function drawSpans(plot, spans) {
  const ink = plot.ctx, dots = uPlot.pxRatio, free = Array(NAME_ROWS).fill(-Infinity), {left, top, width, height} = plot.bbox;
  ink.save();
  ink.font = FONT.replace("11", 11 * dots);
  ink.fillStyle = ink.strokeStyle = SOFT;
  ink.textAlign = "center";
  ink.textBaseline = "bottom";
  ink.setLineDash([2 * dots, 3 * dots]);
  spans.forEach(([name, from, to], i) => {
    const [start, end] = [i ? spans[i - 1][2] : from, to].map((v) => plot.valToPos(v, "x", true)), middle = 0.5 * (start + end), half = 0.5 * ink.measureText(name).width + 3 * dots;
    if (i && start > left && start < left + width) strokeUp(ink, start, top, height);
    const row = free.findIndex((taken) => middle - half > taken);
    if (row < 0 || middle < left || middle + half > left + width + 10 * dots) return;
    ink.fillText(name, middle, top - (1 + 13 * row) * dots);
    free[row] = middle + half;
  });
  ink.restore();
}

function strokeUp(ink, x, top, height) {
  ink.beginPath();
  ink.moveTo(x, top);
  ink.lineTo(x, top + height);
  ink.stroke();
}

// A red line at the present step.
function drawHere(plot, here) {
  if (here === null || here < plot.scales.x.min || here > plot.scales.x.max) return;
  const ink = plot.ctx;
  ink.save();
  ink.strokeStyle = "#c1121f";
  ink.setLineDash([]);
  ink.lineWidth = 1.4 * uPlot.pxRatio;
  strokeUp(ink, plot.valToPos(here, "x", true), plot.bbox.top, plot.bbox.height);
  ink.restore();
}

// Makes the plot of a chart; show(step) marks the step, onChoice(value) is called with the place that is clicked.
function plotChart(box, chart, onChoice) {
  const x = at(chart.x), lines = linesOf(chart), several = chart.spans.length > 1, whole = several ? stretched(chart.spans, chart.label) : {scale: {time: false}, axis: axisOf(chart.label, "x", {size: 28})};
  const decades = {distr: 3, range: (_, low, high) => [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high) + 1e-9)]};
  let here = null;
  const y = axisOf(`${chart.title.split(",")[0]} [${chart.unit}]`, "y", {size: 62});
  if (chart.log) {
    y.values = (_, places) => places.map((v) => (v === null ? "" : v.toExponential(0)));
    y.grid = {...GRID, filter: (_, places) => places.map((v) => (Math.abs(Math.log10(v) % 1) < 1e-6 ? v : null))};
  }
  const plot = plotIn(box, x, lines.map(([, values]) => values), {
    padding: [several ? 13 * NAME_ROWS + 4 : 8, 24, 0, 0],
    scales: {x: whole.scale, y: chart.log ? decades : {}},
    axes: [whole.axis, y],
    series: [{label: chart.label, value: (_, v) => plain(v)}, ...lines.map(([name], i) => lineOf(i, name))],
    hooks: {draw: [(drawn) => { if (several) drawSpans(drawn, chart.spans); drawHere(drawn, here); }]},
  });
  plot.over.addEventListener("click", () => onChoice(plot.posToVal(plot.cursor.left, "x")));
  return (step) => {
    here = placeOf(chart, step);
    Object.assign(plot.ctx.canvas.dataset, {lines: lines.length, rows: x.length, here: here === null ? "" : here});
    plot.redraw(false);
  };
}

// ---- along a joint

// Distance [m], and values at both ends, of the contacts of a joint that is a line, in order.
function profileOf(step, name, ends) {
  const {joint, point, sigma, tau, opening} = step.contacts, number = scene.joints.indexOf(name), out = [];
  const [from, to] = ends.map(([x, y]) => [x - scene.origin[0], y - scene.origin[1]]), long = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const distance = (k) => ((point[k] - from[0]) * (to[0] - from[0]) + (point[k + 1] - from[1]) * (to[1] - from[1])) / long;
  for (let i = 0; i < joint.length; i++) {
    if (joint[i] !== number) continue;
    const s = [distance(4 * i), distance(4 * i + 2)], order = s[0] <= s[1] ? [0, 1] : [1, 0];
    out.push({s: order.map((e) => s[e]), sigma: order.map((e) => 1e-3 * sigma[2 * i + e]), tau: order.map((e) => -1e-3 * tau[2 * i + e]), opening: order.map((e) => 1e3 * Math.max(0, opening[2 * i + e]))});
  }
  return out.sort((a, b) => a.s[0] + a.s[1] - b.s[0] - b.s[1]);
}

// Draws stresses and opening along a joint; returns them in words. Lines break between contacts.
function drawProfile(box, step, name, ends) {
  box.replaceChildren();
  const profile = ends ? profileOf(step, name, ends) : [];
  box.dataset.contacts = profile.length;
  box.hidden = !profile.length;
  if (!profile.length) return ends ? "no contacts of it are in this step" : "it is no line: see the colours of the section";
  const column = (key) => profile.flatMap((c) => [...c[key], NaN]), sigma = column("sigma"), tau = column("tau"), opening = column("opening");
  const least = Math.min(...profile.flatMap((c) => c.sigma)), widest = Math.max(...profile.flatMap((c) => c.opening)), length = Math.max(...profile.flatMap((c) => c.s)), isOpen = widest > 0;
  const zero = (_, low, high) => uPlot.rangeNum(Math.min(low, 0), Math.max(high, 0), 0.1, true);
  plotIn(box, profile.flatMap((c) => [...c.s, c.s[1]]), [sigma, tau, ...(isOpen ? [opening] : [])], {
    scales: {x: {time: false}, y: {range: zero}, opening: {range: zero}},
    axes: [axisOf(`distance along ${name} [m]`, "x", {size: 28}), axisOf("stress [kPa]", "y", {size: 62}), ...(isOpen ? [axisOf("opening [mm]", "opening", {side: 1, grid: {show: false}, size: 54})] : [])],
    series: [{label: "distance [m]", value: (_, v) => plain(v)}, lineOf(0, "normal stress σ, tension + [kPa]"), lineOf(1, "shear stress τ, upper side to the end + [kPa]"), ...(isOpen ? [lineOf(2, "opening [mm]", "opening")] : [])],
  });
  Object.assign(box.dataset, {least, widest});
  return `${profile.length} contacts, ${plain(length)} m; most compression ${plain(-Math.min(0, least))} kPa, widest opening ${plain(widest)} mm`;
}
