"use strict";
// The section: where the eye is, blocks as they have moved, their colours. Lengths are in m, `px` are pixels of the style sheet.

const canvas = document.getElementById("section");
const pen = canvas.getContext("2d");
const eye = {x: 0, y: 0, zoom: 1, width: 1, height: 1}; // middle of the picture [m], px a metre, size [px]
const choice = {step: scene.steps.length - 1, scale: 0, shape: "", fill: "groups", joints: "state", crosses: false, water: true, anchors: true, points: true, picked: null};
const INK = "#1b1f24", SOFT = "#5b6570", TENSION = "#d55e00", COMPRESSION = "#0072b2";
const SHAPE_PART = 0.06; // of the size of the dam: how far a motion without a size is drawn

const screenX = (x) => (x - eye.x) * eye.zoom + 0.5 * eye.width;
const screenY = (y) => 0.5 * eye.height - (y - eye.y) * eye.zoom;
const modelX = (px) => (px - 0.5 * eye.width) / eye.zoom + eye.x;
const modelY = (px) => (0.5 * eye.height - px) / eye.zoom + eye.y;
const damSize = Math.max(scene.box[1] - scene.box[0], scene.box[3] - scene.box[2]);

// Fits a box, x_min, x_max, y_min, y_max, into the picture.
function look(box) {
  eye.x = 0.5 * (box[0] + box[1]);
  eye.y = 0.5 * (box[2] + box[3]);
  eye.zoom = Math.min(eye.width / (box[1] - box[0]), eye.height / (box[3] - box[2]));
}

// Zooms about a place of the picture [px], which stays where it is.
function zoomAt(px, py, factor) {
  const x = modelX(px), y = modelY(py);
  eye.zoom = Math.min(1e6, Math.max(1e-4, eye.zoom * factor));
  eye.x = x - (px - 0.5 * eye.width) / eye.zoom;
  eye.y = y + (py - 0.5 * eye.height) / eye.zoom;
}

// Gives a canvas as many dots as the screen has behind it; returns its size [px].
function sized(drawn) {
  const dots = window.devicePixelRatio || 1, width = drawn.clientWidth, height = drawn.clientHeight;
  if (drawn.width !== Math.round(width * dots) || drawn.height !== Math.round(height * dots)) {
    drawn.width = Math.round(width * dots);
    drawn.height = Math.round(height * dots);
  }
  drawn.getContext("2d").setTransform(dots, 0, 0, dots, 0, 0);
  return [width, height];
}

// ---- what moves

// What vertices do, and how much of it is drawn.
function motionOf(step) {
  const shape = step.shapes.find((s) => s.name === choice.shape);
  return shape ? {by: shape.motion, factor: SHAPE_PART * damSize} : {by: step.displacement, factor: choice.scale};
}

let movedOf = {};
function movedVertices(step) {
  const {by, factor} = motionOf(step);
  if (movedOf.by !== by || movedOf.factor !== factor) {
    const out = new Float32Array(mesh.vertices.length);
    for (let i = 0; i < out.length; i++) out[i] = mesh.vertices[i] + (factor && Number.isFinite(by[i]) ? factor * by[i] : 0);
    movedOf = {by, factor, out};
  }
  return movedOf.out;
}

// By how much a place of the mesh is drawn away from it: as its nearest vertex moves.
const nearestKnown = new Map();
function shiftAt(step, x, y) {
  const key = `${x} ${y}`;
  if (!nearestKnown.has(key)) {
    let best = 0, least = Infinity;
    for (let v = 0; v < mesh.vertices.length / 2; v++) {
      const far = (mesh.vertices[2 * v] - x) ** 2 + (mesh.vertices[2 * v + 1] - y) ** 2;
      if (far < least) [best, least] = [v, far];
    }
    nearestKnown.set(key, best);
  }
  const vertex = nearestKnown.get(key), now = movedVertices(step);
  return [x + now[2 * vertex] - mesh.vertices[2 * vertex], y + now[2 * vertex + 1] - mesh.vertices[2 * vertex + 1]];
}

// The vertices of a block.
function cornersOf(block) {
  const row = mesh.blocks.subarray(4 * block, 4 * block + 4);
  return row[3] < 0 ? row.subarray(0, 3) : row;
}

function isBuilt(step, block) {
  return !step.blocks.built || step.blocks.built[block] !== 0;
}

// Blocks that are there and in the picture, and the size of the largest of them [px].
function blocksInSight(step) {
  const now = movedVertices(step), found = [];
  let largest = 0;
  for (let block = 0; block < blockCount; block++) {
    if (!isBuilt(step, block)) continue;
    let left = Infinity, right = -Infinity, low = Infinity, high = -Infinity;
    for (const v of cornersOf(block)) {
      left = Math.min(left, now[2 * v]); right = Math.max(right, now[2 * v]);
      low = Math.min(low, now[2 * v + 1]); high = Math.max(high, now[2 * v + 1]);
    }
    if (screenX(right) < 0 || screenX(left) > eye.width || screenY(low) < 0 || screenY(high) > eye.height) continue;
    found.push(block);
    largest = Math.max(largest, (right - left) * eye.zoom, (high - low) * eye.zoom);
  }
  return {found, largest};
}

function centreOf(block, places) {
  const corners = cornersOf(block);
  let x = 0, y = 0;
  for (const v of corners) { x += places[2 * v]; y += places[2 * v + 1]; }
  return [x / corners.length, y / corners.length];
}

// ---- colours

const SIGNED = new Set(["s1", "s2", "temperature", "sigma", "tau"]); // colours run from below nought to above
const STEPS = 32;

function mixed(from, to, part) {
  return `rgb(${from.map((c, i) => Math.round(c + part * (to[i] - c))).join(",")})`;
}

const BLUE = [0, 90, 160], WHITE = [247, 247, 247], ORANGE = [205, 80, 0], PALE = [238, 232, 245], VIOLET = [75, 20, 120];
const signedColours = Array.from({length: STEPS}, (_, i) => {
  const part = (2 * i) / (STEPS - 1) - 1;
  return part < 0 ? mixed(WHITE, BLUE, -part) : mixed(WHITE, ORANGE, part);
});
const risingColours = Array.from({length: STEPS}, (_, i) => mixed(PALE, VIOLET, i / (STEPS - 1)));

// Between which values colours change: all but the outer 2 % of those in the picture; local failure factors from 1 to 5.
function rangeOf(name, values) {
  if (name === "safety_factor") return [1, 5];
  const known = values.filter(Number.isFinite).sort((a, b) => a - b);
  if (!known.length) return [0, 1];
  const low = known[Math.floor(0.02 * (known.length - 1))], high = known[Math.ceil(0.98 * (known.length - 1))];
  if (!SIGNED.has(name)) return [0, high > 0 ? high : 1];
  const size = Math.max(Math.abs(low), Math.abs(high)) || 1;
  return [-size, size];
}

function binOf(value, range) {
  const part = (value - range[0]) / (range[1] - range[0]);
  return Math.min(STEPS - 1, Math.max(0, Math.floor(part * STEPS)));
}

function coloursOf(name) {
  return SIGNED.has(name) ? signedColours : name === "safety_factor" ? [...risingColours].reverse() : risingColours;
}

// ---- blocks

function traceBlock(block, places) {
  const corners = cornersOf(block);
  pen.moveTo(screenX(places[2 * corners[0]]), screenY(places[2 * corners[0] + 1]));
  for (let i = 1; i < corners.length; i++) pen.lineTo(screenX(places[2 * corners[i]]), screenY(places[2 * corners[i] + 1]));
  pen.closePath();
}

// Fills blocks by group or by a field; returns the range of colours, null for groups.
function drawBlocks(step, sight) {
  const values = step.blocks[choice.fill], now = movedVertices(step), byColour = new Map();
  const range = values ? rangeOf(choice.fill, sight.found.map((block) => values[block])) : null;
  const colours = coloursOf(choice.fill);
  for (const block of sight.found) {
    const group = mesh.group[block];
    const colour = !values ? scene.fills[group % scene.fills.length] : Number.isNaN(values[block]) ? "#e3e3e3" : colours[binOf(values[block], range)];
    if (!byColour.has(colour)) byColour.set(colour, []);
    byColour.get(colour).push(block);
  }
  const edges = sight.largest > 14 && sight.found.length < 8000;
  for (const [colour, blocks] of byColour) {
    pen.beginPath();
    for (const block of blocks) traceBlock(block, now);
    pen.fillStyle = colour;
    pen.fill();
    pen.lineWidth = edges ? 0.5 : 0.6;
    pen.strokeStyle = edges ? "#8a8a8a" : colour;
    pen.stroke();
  }
  return range;
}

function drawOutline(places, colour, width, dash) {
  pen.beginPath();
  for (let i = 0; i < mesh.outline.length; i += 2) {
    const a = mesh.outline[i], b = mesh.outline[i + 1];
    pen.moveTo(screenX(places[2 * a]), screenY(places[2 * a + 1]));
    pen.lineTo(screenX(places[2 * b]), screenY(places[2 * b + 1]));
  }
  pen.setLineDash(dash);
  pen.lineWidth = width;
  pen.strokeStyle = colour;
  pen.stroke();
  pen.setLineDash([]);
}

// The block under a place of the picture [px]; null: none.
function blockAt(step, px, py) {
  const now = movedVertices(step), x = modelX(px), y = modelY(py);
  for (let block = blockCount - 1; block >= 0; block--) {
    if (!isBuilt(step, block)) continue;
    const corners = cornersOf(block);
    let inside = true;
    for (let i = 0; i < corners.length && inside; i++) {
      const a = corners[i], b = corners[(i + 1) % corners.length];
      inside = (now[2 * b] - now[2 * a]) * (y - now[2 * a + 1]) - (now[2 * b + 1] - now[2 * a + 1]) * (x - now[2 * a]) >= 0;
    }
    if (inside) return block;
  }
  return null;
}
