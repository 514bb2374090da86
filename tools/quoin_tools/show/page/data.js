"use strict";
// What the page holds: its description, the numbers behind it, and how numbers are said.

const scene = JSON.parse(document.getElementById("described").textContent);

const numbers = (() => {
  const code = atob(document.getElementById("base64").textContent);
  const bytes = new Uint8Array(code.length);
  for (let i = 0; i < code.length; i++) bytes[i] = code.charCodeAt(i);
  return bytes.buffer;
})();

// The array of a place in the numbers, [kind, start, count].
function at(place) {
  return place[0] === "f" ? new Float32Array(numbers, 4 * place[1], place[2]) : new Int32Array(numbers, 4 * place[1], place[2]);
}

const mesh = Object.fromEntries(Object.entries(scene.mesh).map(([name, place]) => [name, at(place)]));
const blockCount = mesh.blocks.length / 4;

// A step with its arrays; made when it is asked for.
const madeSteps = new Map();
function stepOf(index) {
  if (!madeSteps.has(index)) {
    const s = scene.steps[index];
    const made = {...s, index, displacement: at(s.displacement), blocks: arrays(s.blocks), contacts: arrays(s.contacts), flow: s.flow && arrays(s.flow)};
    made.shapes = s.shapes.map(([name, place]) => ({name, motion: at(place)}));
    made.faces = s.faces.map((f) => ({...f, ends: at(f.ends), rows: at(f.rows)}));
    made.uplift = s.uplift.map((u) => ({...u, point: at(u.point), pressure: at(u.pressure)}));
    made.anchors = s.anchors && {...s.anchors, head: at(s.anchors.head), root: at(s.anchors.root), force: at(s.anchors.force), spacing: at(s.anchors.spacing),
      bars: s.anchors.bars && arrays(s.anchors.bars)};
    madeSteps.set(index, made);
  }
  return madeSteps.get(index);
}

function arrays(places) {
  return Object.fromEntries(Object.entries(places).map(([name, place]) => [name, at(place)]));
}

// Words of a step, for people.
function wordsOf(step) {
  return step.time === null ? step.stage : `${step.stage}, t = ${step.time.toFixed(3)} s`;
}

// A number with four figures; thousands apart.
function plain(value, figures = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (!Number.isFinite(value)) return value > 0 ? "infinite" : "-infinite";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-4) return value.toExponential(figures - 1);
  const digits = Math.max(0, figures - 1 - Math.floor(Math.log10(size)));
  const [whole, part] = value.toFixed(Math.min(digits, 8)).split(".");
  return whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") + (part ? `.${part}` : "");
}

// A number that is a whole one, or one of a row of ticks so far apart.
function round(value, every = 1) {
  return plain(value, Math.max(1, Math.ceil(Math.log10(Math.abs(value) / every + 1e-9)) + 1)).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
}

// Unit in which values of this size are said, and its factor.
function unitFor(unit, largest) {
  if (unit === "Pa") return largest >= 1e6 ? ["MPa", 1e-6] : largest >= 1e3 || largest === 0 ? ["kPa", 1e-3] : ["Pa", 1];
  if (unit === "m") return ["mm", 1e3];
  if (unit === "N") return ["kN", 1e-3];
  return [unit, 1];
}

function said(value, unit, largest = Math.abs(value)) {
  const [name, factor] = unitFor(unit, Number.isFinite(largest) ? largest : 0);
  return `${plain(value * factor)} ${name}`;
}

// The largest of 1, 2, 5, 10, ... not above a value.
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([5, 2, 1].find((step) => step * power <= value * (1 + 1e-9)) || 1);
}
