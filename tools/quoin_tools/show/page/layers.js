"use strict";
// What is drawn over the blocks: crosses, joints, water, anchors, points, scales. Each layer returns what it has drawn, as rows of the table of numbers.

const STATES = {open: [1, "#c1121f"], slipping: [2, "#8e24aa"], crushing: [4, "#000000"]};
const CROSS_EVERY = 13; // [px] of the picture there is one cross at most in a square of this size
const STEEP = 0.4; // part of its length that a face goes up, from which water stands at it, and not on it
const PRESSURE_PART = 0.13; // of the size of the dam: the largest pressure, drawn

// ---- names that do not cover each other

let taken = [];
let leftOut = 0;

function isFree(box) {
  if (box[0] < 2 || box[1] > eye.width - 2 || box[2] < 2 || box[3] > eye.height - 2) return false;
  return taken.every((other) => box[1] < other[0] || box[0] > other[1] || box[3] < other[2] || box[2] > other[3]);
}

// Writes words near a place of the picture where there is room; far from it, with a line to it; else they are counted as left out.
function label(words, px, py, colour) {
  pen.font = "12px DejaVu Sans, Segoe UI, Arial, sans-serif";
  const width = pen.measureText(words).width + 6, height = 16;
  for (const far of [8, 26, 48, 80]) {
    for (const [sx, sy] of [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]]) {
      const left = px + sx * far - (sx < 0 ? width : sx === 0 ? 0.5 * width : 0), top = py + sy * far - (sy < 0 ? height : sy === 0 ? 0.5 * height : 0);
      const box = [left, left + width, top, top + height];
      if (!isFree(box)) continue;
      taken.push(box);
      if (far > 8) stroked([[px, py], [sx < 0 ? box[1] : sx > 0 ? box[0] : px, sy < 0 ? box[3] : sy > 0 ? box[2] : py]], colour, 0.7);
      pen.fillStyle = "rgba(255,255,255,0.85)";
      pen.fillRect(left, top, width, height);
      pen.fillStyle = colour;
      pen.textAlign = "left";
      pen.textBaseline = "middle";
      pen.fillText(words, left + 3, top + 0.5 * height);
      return true;
    }
  }
  leftOut++;
  return false;
}

function stroked(points, colour, width, dash = []) {
  pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.setLineDash(dash);
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.stroke();
  pen.setLineDash([]);
}

function filled(points, colour) {
  pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.closePath();
  pen.fillStyle = colour;
  pen.fill();
}

const onScreen = ([x, y]) => [screenX(x), screenY(y)];
const isSeen = ([px, py]) => px >= 0 && px <= eye.width && py >= 0 && py <= eye.height;

// ---- principal stresses

function drawCrosses(step, sight) {
  const {s1, s2, angle} = step.blocks, now = movedVertices(step), squares = new Map();
  let largest = 0, deformable = 0;
  for (const block of sight.found) {
    if (Number.isNaN(s1[block])) continue;
    const at = onScreen(centreOf(block, now));
    if (!isSeen(at)) continue;
    deformable++;
    const key = `${Math.floor(at[0] / CROSS_EVERY)} ${Math.floor(at[1] / CROSS_EVERY)}`, size = Math.max(Math.abs(s1[block]), Math.abs(s2[block]));
    const other = squares.get(key);
    if (!other || size > other.size) squares.set(key, {block, at, size});
  }
  const sizes = [...squares.values()].map((c) => c.size).sort((a, b) => a - b);
  largest = sizes.length ? sizes[Math.floor(0.98 * (sizes.length - 1))] : 0;
  for (const {block, at: [x, y]} of squares.values()) {
    for (const [value, turned] of [[s1[block], angle[block]], [s2[block], angle[block] + Math.PI / 2]]) {
      const half = Math.min(1.5, Math.abs(value) / (largest || 1)) * Math.max(CROSS_EVERY, Math.min(30, 0.45 * sight.largest)) * 0.75;
      const dx = half * Math.cos(turned), dy = -half * Math.sin(turned);
      stroked([[x - dx, y - dy], [x + dx, y + dy]], value > 0 ? TENSION : COMPRESSION, 1.3);
    }
  }
  return [["crosses", "crosses drawn", `${squares.size} of ${deformable} blocks`, squares.size]];
}

// ---- joints

function endsOfContact(step, i) {
  const {by, factor} = motionOf(step), {point, displacement} = step.contacts, out = [];
  for (const end of [0, 1]) {
    const k = 4 * i + 2 * end;
    if (by === step.displacement) out.push([point[k] + factor * displacement[k], point[k + 1] + factor * displacement[k + 1]]);
    else out.push(shiftAt(step, point[k], point[k + 1]));
  }
  return out;
}

// Colours contacts by state or by a stress or opening; returns rows and the range of colours.
function drawJoints(step) {
  const {state, sigma, opening} = step.contacts, values = UNITS[choice.joints] ? step.contacts[choice.joints] : null, count = {open: 0, slipping: 0, crushing: 0};
  const seen = [];
  let widest = 0, least = 0, most = 0;
  for (let i = 0; i < state.length / 2; i++) {
    const ends = endsOfContact(step, i).map(onScreen);
    if (!ends.some(isSeen)) continue;
    seen.push([i, ends]);
    for (const [name, [bit]] of Object.entries(STATES)) if ((state[2 * i] | state[2 * i + 1]) & bit) count[name]++;
    widest = Math.max(widest, opening[2 * i], opening[2 * i + 1]);
    least = Math.min(least, sigma[2 * i], sigma[2 * i + 1]);
    most = Math.max(most, sigma[2 * i], sigma[2 * i + 1]);
  }
  const shown = (value) => (choice.joints === "opening" ? Math.max(0, value) : choice.joints === "slip" ? Math.abs(value) : value);
  const range = values ? rangeOf(choice.joints, seen.flatMap(([i]) => [shown(values[2 * i]), shown(values[2 * i + 1])])) : null;
  for (const [i, [a, b]] of seen) {
    const middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    if (choice.joints === "none") continue;
    [[a, middle], [middle, b]].forEach((half, end) => {
      const value = values && values[2 * i + end];
      const name = Object.keys(STATES).reverse().find((word) => state[2 * i + end] & STATES[word][0]);
      const colour = values ? coloursOf(choice.joints)[binOf(shown(value), range)] : name ? STATES[name][1] : "#6b7680";
      if (values && seen.length < 4000) stroked(half, INK, 5);
      stroked(half, colour, values ? 3.6 : name ? 3 : 0.8);
    });
  }
  const rows = [["contacts", "contacts in the picture", `${seen.length}`, seen.length], ["open", "of these open", `${count.open}`, count.open],
    ["slipping", "slipping", `${count.slipping}`, count.slipping], ["crushing", "crushing", `${count.crushing}`, count.crushing],
    ["opening", "widest opening", said(widest, "m"), widest], ["sigma_min", "most compression across a joint", said(least, "Pa"), least],
    ["sigma_max", "most tension across a joint", said(most, "Pa"), most]];
  return {rows: seen.length ? rows : rows.slice(0, 1), range};
}

// ---- water

function largestPressure(step) {
  let largest = 0;
  for (const f of step.faces) for (let k = 1; k < f.ends.length; k += 2) largest = Math.max(largest, f.unit * (f.level - f.ends[k]));
  for (const u of step.uplift) for (const p of u.pressure) largest = Math.max(largest, p);
  if (step.flow) for (const p of step.flow.pressure) largest = Math.max(largest, p);
  return largest;
}

// The ends of wet face i as they are drawn, and their depths below the level; null: it is dry.
function wetFace(step, f, i) {
  const now = movedVertices(step), ends = [0, 1].map((end) => {
    const vertex = f.rows[2 * i + end], x = f.ends[4 * i + 2 * end], y = f.ends[4 * i + 2 * end + 1];
    return {drawn: vertex < 0 ? [x, y] : [now[2 * vertex], now[2 * vertex + 1]], depth: f.level - y};
  });
  if (ends[0].depth <= 0 && ends[1].depth <= 0) return null;
  const [a, b] = ends;
  for (const [dry, wet] of [[a, b], [b, a]]) {
    if (dry.depth >= 0) continue;
    const part = wet.depth / (wet.depth - dry.depth);
    dry.drawn = wet.drawn.map((v, k) => v + part * (dry.drawn[k] - v));
    dry.depth = 0;
  }
  return ends;
}

function drawFaces(step, f, reach) {
  const fill = f.water ? "rgba(90,160,220,0.55)" : "rgba(150,110,60,0.55)", edge = f.water ? "#0b5fa5" : "#7a4f1d";
  let top = null, deepest = null, side = 0, length = 0;
  for (let i = 0; i < f.rows.length / 2; i++) {
    const ends = wetFace(step, f, i);
    if (!ends) continue;
    const [a, b] = ends.map((end) => end.drawn), long = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const out = [(b[1] - a[1]) / long, (a[0] - b[0]) / long], tip = (end) => [end.drawn[0] + reach * f.unit * end.depth * out[0], end.drawn[1] + reach * f.unit * end.depth * out[1]];
    const tips = ends.map(tip);
    filled([a, b, tips[1], tips[0]].map(onScreen), fill);
    stroked(tips.map(onScreen), edge, 1.2);
    side += out[0] * long;
    length += long;
    ends.forEach((end, k) => {
      if (!top || end.depth < top.depth) top = end;
      if (isSeen(onScreen(tips[k])) && (!deepest || end.depth > deepest.depth)) deepest = {depth: end.depth, at: tips[k]};
    });
  }
  const y = screenY(f.level);
  if (top && f.water && Math.abs(side) > STEEP * length && y > 0 && y < eye.height) {
    const x = screenX(top.drawn[0]), edgeX = side < 0 ? Math.max(2, Math.min(x, screenX(scene.whole[0]))) : Math.min(eye.width - 2, Math.max(x, screenX(scene.whole[1])));
    stroked([[x, y], [edgeX, y]], edge, 1.4);
    label(`${f.name}: level ${plain(f.level + scene.origin[1])} m`, 0.5 * (x + edgeX), y, edge);
  }
  if (deepest) label(`${f.water ? "" : `${f.name} (${plain(f.density)} kg/m³): `}${said(f.unit * deepest.depth, "Pa")}`, ...onScreen(deepest.at), edge);
}

// A diagram of pressures along pieces of a joint, to the lower side of it.
function drawDiagram(step, pieces, reach, colour) {
  for (const [a, p, b, q] of pieces) {
    const from = shiftAt(step, ...a), to = shiftAt(step, ...b), long = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
    let normal = [(to[1] - from[1]) / long, (from[0] - to[0]) / long];
    if (normal[1] > 1e-9 || (Math.abs(normal[1]) <= 1e-9 && normal[0] > 0)) normal = normal.map((v) => -v);
    const tips = [[to, q], [from, p]].map(([end, value]) => [end[0] + reach * value * normal[0], end[1] + reach * value * normal[1]]);
    filled([from, to, ...tips].map(onScreen), `${colour}66`);
    stroked(tips.map(onScreen), colour, 1.1);
  }
}

function piecesOfFlow(flow) {
  const out = [];
  for (let i = 0; i < flow.joint.length; i++) {
    const p = flow.point.subarray(4 * i, 4 * i + 4);
    if (flow.pressure[2 * i] > 0 || flow.pressure[2 * i + 1] > 0) out.push([[p[0], p[1]], flow.pressure[2 * i], [p[2], p[3]], flow.pressure[2 * i + 1]]);
  }
  return out;
}

function drawLoads(step) {
  return [...drawWater(step), ...drawForces(step)];
}

function drawWater(step) {
  const largest = largestPressure(step);
  if (!largest) return [];
  const reach = (PRESSURE_PART * damSize) / largest;
  for (const f of step.faces) drawFaces(step, f, reach);
  for (const u of step.uplift) {
    const pieces = [];
    for (let k = 0; k + 1 < u.pressure.length; k++) pieces.push([[u.point[2 * k], u.point[2 * k + 1]], u.pressure[k], [u.point[2 * k + 2], u.point[2 * k + 3]], u.pressure[k + 1]]);
    drawDiagram(step, pieces, reach, "#7a3e9d");
    const most = u.pressure.indexOf(Math.max(...u.pressure));
    label(`${u.name}: ${said(u.pressure[most], "Pa")}`, ...onScreen(shiftAt(step, u.point[2 * most], u.point[2 * most + 1])), "#7a3e9d");
  }
  if (step.flow) drawDiagram(step, piecesOfFlow(step.flow), reach, "#0b5fa5");
  const levels = step.faces.map((f) => [`level ${f.name}`, `${f.name}: ${f.water ? "level of the water" : "top"}`, `${plain(f.level + scene.origin[1])} m`, f.level + scene.origin[1]]);
  return [["pressure", "largest pressure of water", said(largest, "Pa"), largest], ...levels];
}

// ---- other loads: silt, ice, waves, tractions, pressures, forces at points

function drawForces(step) {
  const colour = "#b3261e", long = 0.12 * damSize;
  return step.forces.map(({name, at, force}) => {
    const size = Math.hypot(...force), along = force.map((v) => v / (size || 1));
    const head = onScreen(shiftAt(step, ...at)), tail = onScreen(shiftAt(step, ...at).map((v, k) => v - long * along[k]));
    stroked([tail, head], colour, 2);
    const [dx, dy] = [head[0] - tail[0], head[1] - tail[1]].map((v) => (9 * v) / (Math.hypot(head[0] - tail[0], head[1] - tail[1]) || 1));
    filled([head, [head[0] - dx - 0.45 * dy, head[1] - dy + 0.45 * dx], [head[0] - dx + 0.45 * dy, head[1] - dy - 0.45 * dx]], colour);
    label(`${name}: ${said(size, "N")}`, ...tail, colour);
    return [`force ${name}`, `${name}: force`, said(size, "N"), size];
  });
}

// ---- anchors, points

function drawAnchors(step) {
  const a = step.anchors;
  if (!a) return [];
  const most = Math.max(...a.force.map(Math.abs), 1e-300);
  if (a.bars) drawBars(step, a.bars, most);
  a.names.forEach((name, i) => {
    const [head, root] = [a.head, a.root].map((ends) => onScreen(shiftAt(step, ends[2 * i], ends[2 * i + 1])));
    const gone = a.state[i] === "absent" || a.state[i] === "broken", part = Math.abs(a.force[i]) / most;
    const colour = gone ? "#777777" : mixed([220, 150, 40], [120, 10, 60], part);
    stroked([head, root], colour, 2.6, gone ? [3, 5] : []);
    pen.fillStyle = colour;
    pen.fillRect(head[0] - 3, head[1] - 3, 6, 6);
    label(gone ? `${name}: ${a.state[i]}` : `${name}: ${said(a.force[i], "N")} (${plain(a.force[i] / a.spacing[i] / 1e3)} kN/m)`, ...head, "#5a1a6b");
  });
  const largest = Math.max(...a.force);
  return [["anchor", "largest force of one anchor", said(largest, "N"), largest]];
}

// The force along bonded bars, beside their lines.
function drawBars(step, bars, most) {
  const pieces = [], reach = (0.05 * damSize) / Math.max(most, ...bars.force.map(Math.abs));
  for (let k = 0; k + 1 < bars.anchor.length; k++) {
    if (bars.anchor[k] !== bars.anchor[k + 1]) continue;
    const place = bars.place.subarray(2 * k, 2 * k + 4);
    pieces.push([[place[0], place[1]], Math.abs(bars.force[k]), [place[2], place[3]], Math.abs(bars.force[k + 1])]);
  }
  drawDiagram(step, pieces, reach, "#3b6ea5");
}

function drawPoints(step) {
  const now = movedVertices(step), drawn = scene.points.filter(([name, vertex]) => {
    const at = onScreen([now[2 * vertex], now[2 * vertex + 1]]);
    if (!isSeen(at)) return false;
    pen.beginPath();
    pen.arc(...at, 3, 0, 2 * Math.PI);
    pen.fillStyle = INK;
    pen.fill();
    const u = step.displacement.subarray(2 * vertex, 2 * vertex + 2);
    label(`${name}: ${plain(1e3 * u[0], 3)}, ${plain(1e3 * u[1], 3)} mm`, ...at, INK);
    return true;
  });
  return [["points", "named points (u_x, u_y)", `${drawn.length} of ${scene.points.length}`, drawn.length]];
}

// ---- scales

function drawScaleBar(title, unit, range, colours, px, py) {
  const [name, factor] = unitFor(unit, Math.max(...range.map(Math.abs))), high = 150, width = 16;
  pen.fillStyle = "rgba(255,255,255,0.88)";
  pen.fillRect(px - 8, py - 24, 118, high + 34);
  taken.push([px - 8, px + 110, py - 24, py + high + 10]);
  colours.forEach((colour, i) => {
    pen.fillStyle = colour;
    pen.fillRect(px, py + high - ((i + 1) * high) / colours.length, width, high / colours.length + 0.5);
  });
  pen.fillStyle = INK;
  pen.font = "12px DejaVu Sans, Segoe UI, Arial, sans-serif";
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  pen.fillText(`${title} [${name}]`, px - 4, py - 13, 108);
  for (const part of [0, 0.5, 1]) pen.fillText(plain(factor * (range[0] + part * (range[1] - range[0])), 3), px + width + 5, py + high * (1 - part));
}

function drawKey(rows, px, py) {
  pen.font = "12px DejaVu Sans, Segoe UI, Arial, sans-serif";
  const width = Math.max(...rows.map(([words]) => pen.measureText(words).width)) + 34, high = 17 * rows.length + 6;
  pen.fillStyle = "rgba(255,255,255,0.88)";
  pen.fillRect(px, py, width, high);
  taken.push([px, px + width, py, py + high]);
  rows.forEach(([words, colour], i) => {
    pen.fillStyle = colour;
    pen.fillRect(px + 6, py + 6 + 17 * i, 16, 11);
    pen.fillStyle = INK;
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    pen.fillText(words, px + 28, py + 12 + 17 * i);
  });
  return py + high + 6;
}

// Metres along the lower and left edges.
function drawAxes() {
  const every = nice(110 / eye.zoom) * (110 / eye.zoom / nice(110 / eye.zoom) > 1.5 ? 2 : 1);
  pen.fillStyle = SOFT;
  pen.font = "11px DejaVu Sans, Segoe UI, Arial, sans-serif";
  pen.textBaseline = "alphabetic";
  const ticks = (from, to, origin) => {
    const out = [];
    for (let k = Math.ceil((from + origin) / every); k * every <= to + origin; k++) out.push(k * every);
    return out;
  };
  const digits = Math.max(0, -Math.floor(Math.log10(every) + 1e-9));
  pen.textAlign = "center";
  ticks(modelX(40), modelX(eye.width - 50), scene.origin[0]).forEach((x) => {
    const px = screenX(x - scene.origin[0]);
    stroked([[px, eye.height], [px, eye.height - 5]], SOFT, 1);
    pen.fillText(x.toFixed(digits), px, eye.height - 8);
  });
  pen.textAlign = "right";
  pen.fillText("x [m]", eye.width - 4, eye.height - 8);
  pen.textAlign = "left";
  ticks(modelY(eye.height - 30), modelY(24), scene.origin[1]).forEach((y) => {
    const py = screenY(y - scene.origin[1]);
    stroked([[0, py], [5, py]], SOFT, 1);
    pen.fillText(y.toFixed(digits), 8, py + 4);
  });
  pen.fillText("y [m]", 4, 14);
  taken.push([0, eye.width, eye.height - 20, eye.height], [0, 44, 0, eye.height]);
}
