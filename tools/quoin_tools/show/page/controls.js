"use strict";
// What can be touched: sliders, lists, keys, the section itself; and the tables that follow.

const byId = (id) => document.getElementById(id);
const SCALES = [0, ...Array.from({length: 22}, (_, k) => [1, 2, 5][k % 3] * 10 ** Math.floor(k / 3))];
const KINDS = {none: "not drawn", state: "state", sigma: "normal stress", tau: "shear stress", opening: "opening", slip: "slip"};
const UNITS = {sigma: "Pa", tau: "Pa", opening: "m", slip: "m"};
let asked = false;
let playing = null;

// ---- drawing

function redraw() {
  if (!asked) {
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  }
}

function draw() {
  const step = stepOf(choice.step), whole = [];
  [eye.width, eye.height] = sized(canvas);
  pen.clearRect(0, 0, eye.width, eye.height);
  taken = [];
  leftOut = 0;
  const sight = blocksInSight(step), range = drawBlocks(step, sight);
  if (motionOf(step).factor) drawOutline(mesh.vertices, SOFT, 0.8, [5, 4]);
  drawOutline(movedVertices(step), INK, sight.found.length < 3000 ? 1 : 0.5, []);
  whole.push(["drawn", "blocks in the picture", `${sight.found.length} of ${blockCount}`, sight.found.length], ...extremesOf(step, sight));
  if (choice.crosses) whole.push(...drawCrosses(step, sight));
  const joints = drawJoints(step);
  whole.push(...joints.rows);
  drawScales(step, range, joints.range);
  drawAxes();
  if (choice.water) {
    whole.push(...drawLoads(step));
    drawScales(step, range, joints.range); // once more: over the loads, which left their places free of names only
  }
  if (choice.anchors) whole.push(...drawAnchors(step));
  if (choice.points && scene.points.length) whole.push(...drawPoints(step));
  drawPicked(step);
  if (leftOut) whole.push(["left_out", "names without room", `${leftOut}`, leftOut]);
  fillTable(byId("numbers"), whole);
  tell(step);
  drawLower(step);
}

function extremesOf(step, sight) {
  const {s1, s2} = step.blocks, by = step.displacement, most = {u: 0, s1: -Infinity, s2: Infinity};
  for (const block of sight.found) {
    for (const v of cornersOf(block)) most.u = Math.max(most.u, Math.hypot(by[2 * v], by[2 * v + 1]) || 0);
    if (s1[block] > most.s1) most.s1 = s1[block];
    if (s2[block] < most.s2) most.s2 = s2[block];
  }
  const rows = [["u_max", "largest displacement", said(most.u, "m"), most.u]];
  if (most.s2 < Infinity) rows.push(["s1_max", "largest s1 (tension positive)", said(most.s1, "Pa"), most.s1], ["s2_min", "least s2", said(most.s2, "Pa"), most.s2]);
  const values = choice.fill !== "s1" && choice.fill !== "s2" && step.blocks[choice.fill];
  if (values) {
    const known = sight.found.map((block) => values[block]).filter(Number.isFinite), [name, unit] = scene.fields[choice.fill];
    if (known.length) rows.push(["field", name, `${said(Math.min(...known), unit)} to ${said(Math.max(...known), unit)}`, Math.max(...known)]);
  }
  return rows;
}

function drawScales(step, range, jointRange) {
  let y = 12;
  if (!range) {
    const groups = scene.groups.map((name, i) => [name + (scene.rigid[i] ? " (rigid)" : ""), scene.fills[i % scene.fills.length]]);
    y = drawKey(groups.slice(0, 14), 56, y);
  }
  if (choice.joints === "state") y = drawKey([["joint closed", "#6b7680"], ...Object.entries(STATES).map(([name, [, colour]]) => [`joint ${name}`, colour])], 56, y);
  let px = eye.width - 118;
  if (range) {
    const [name, unit] = scene.fields[choice.fill];
    drawScaleBar(name, unit, range, coloursOf(choice.fill), px, 34);
    px -= 128;
  }
  if (jointRange) drawScaleBar(KINDS[choice.joints], UNITS[choice.joints], jointRange, coloursOf(choice.joints), px, 34);
}

function fillTable(table, rows) {
  const body = table.tBodies[0];
  body.replaceChildren(...rows.map(([key, words, text, value]) => {
    const row = document.createElement("tr"), head = document.createElement("th"), cell = document.createElement("td");
    row.dataset.key = key;
    head.textContent = words;
    cell.textContent = text;
    if (value !== undefined) cell.dataset.value = value;
    row.append(head, cell);
    return row;
  }));
  table.hidden = !rows.length;
}

function tell(step) {
  const shape = step.shapes.some((s) => s.name === choice.shape);
  byId("state").textContent = `Stage ${wordsOf(step)}: ${step.verdict}${step.evidence ? ` (${step.evidence})` : ""}`;
  byId("scaled").textContent = shape ? "not to scale: a motion has no size" : choice.scale ? `× ${round(choice.scale)}` : "not drawn (× 0)";
  byId("said").textContent = `${shape ? `The ${choice.shape}` : `Displacements × ${round(choice.scale)}`}; dashed: the mesh before. Tension is positive.${choice.fill === "groups" && !UNITS[choice.joints] ? "" : " Colours leave out the outer 2 % of values."}`;
}

function drawLower(step) {
  const tabled = scene.steps.find((s) => s.stage === step.stage && s.table.length), row = tabled && tabled.table.find((r) => r.name === byId("joint").value);
  byId("jointsaid").textContent = byId("joint").value ? drawProfile(byId("profile"), step, byId("joint").value, row && row.ends) : "";
  showInCharts.forEach((show) => show(step));
  drawJointTable(step, tabled);
}

function drawJointTable(step, tabled) {
  const box = byId("tables");
  if (box.dataset.stage === step.stage) return;
  box.dataset.stage = step.stage;
  box.replaceChildren();
  if (!tabled) return;
  const table = document.createElement("table"), head = table.createTHead().insertRow();
  table.createCaption().textContent = `Joints at the end of stage ${step.stage}`;
  for (const words of ["joint", "length [m]", "N [kN] (compression)", "T [kN]", "sliding factor [-]", "open [m]", "slipping [m]"]) {
    const cell = document.createElement("th");
    cell.textContent = words;
    head.append(cell);
  }
  const body = table.createTBody();
  for (const r of tabled.table) {
    const row = body.insertRow();
    for (const text of [r.name, plain(r.length), r.N === null ? "-" : plain(1e-3 * r.N), r.T === null ? "-" : plain(1e-3 * r.T), plain(r.factor), plain(r.open), plain(r.slipping)]) row.insertCell().textContent = text;
  }
  box.append(table);
}

// ---- a chosen place

function drawPicked(step) {
  const p = choice.picked;
  if (!p || (p.block !== null && !isBuilt(step, p.block))) return fillTable(byId("picked"), []);
  const now = movedVertices(step), rows = [];
  if (p.block !== null) {
    pen.beginPath();
    traceBlock(p.block, now);
    pen.lineWidth = 2.5;
    pen.strokeStyle = "#c1121f";
    pen.stroke();
    rows.push(...rowsOfBlock(step, p.block));
  }
  if (p.contact !== null && p.contact < step.contacts.joint.length) rows.push(...rowsOfContact(step, p.contact, p.end));
  return fillTable(byId("picked"), rows);
}

function rowsOfBlock(step, block) {
  const [x, y] = centreOf(block, mesh.vertices), [ux, uy] = centreOf(block, step.displacement), {s1, s2, angle} = step.blocks;
  const rows = [["block", "block", `${mesh.number[block]}, group ${scene.groups[mesh.group[block]]}`, mesh.number[block]],
    ["centre", "centre x, y", `${plain(x + scene.origin[0])}, ${plain(y + scene.origin[1])} m`], ["u", "u_x, u_y there", `${plain(1e3 * ux)}, ${plain(1e3 * uy)} mm`]];
  if (!Number.isNaN(s1[block])) rows.push(["s1", "s1", said(s1[block], "Pa"), s1[block]], ["s2", "s2", said(s2[block], "Pa"), s2[block]], ["angle", "s1 from x", `${plain((180 / Math.PI) * angle[block])}°`]);
  for (const [name, [words, unit]] of Object.entries(scene.fields)) if (name !== "s1" && name !== "s2" && step.blocks[name] && !Number.isNaN(step.blocks[name][block])) rows.push([name, words, said(step.blocks[name][block], unit)]);
  return rows;
}

function rowsOfContact(step, i, end) {
  const c = step.contacts, k = 2 * i + end, states = Object.keys(STATES).filter((name) => c.state[k] & STATES[name][0]);
  return [["joint", "contact beside it, joint", scene.joints[c.joint[i]] || "-"], ["sigma", "normal stress σ", said(c.sigma[k], "Pa"), c.sigma[k]], ["tau", "shear stress τ", said(c.tau[k], "Pa"), c.tau[k]],
    ["opening_here", "opening", said(c.opening[k], "m"), c.opening[k]], ["slip", "slip", said(c.slip[k], "m"), c.slip[k]], ["joint_state", "state", states.join(", ") || "closed"]];
}

function pick(px, py) {
  const step = stepOf(choice.step), found = {block: blockAt(step, px, py), contact: null, end: 0};
  let least = 14 ** 2;
  for (let i = 0; i < step.contacts.joint.length; i++) {
    endsOfContact(step, i).map(onScreen).forEach(([x, y], end) => {
      const far = (x - px) ** 2 + (y - py) ** 2;
      if (far < least) [least, found.contact, found.end] = [far, i, end];
    });
  }
  choice.picked = found.block === null && found.contact === null ? null : found;
  redraw();
}

// ---- steps

function goTo(index) {
  const before = stepOf(choice.step);
  choice.step = Math.min(scene.steps.length - 1, Math.max(0, index));
  const step = stepOf(choice.step);
  if (choice.picked && step.contacts.joint.length !== before.contacts.joint.length) choice.picked.contact = null;
  byId("step").value = choice.step;
  byId("stage").value = step.stage;
  if (before.stage !== step.stage || byId("shape").options.length === 0) listFields(step);
  if (before.stage !== step.stage && !choice.ownScale) rescale(fittingScale(step), false);
  else redraw();
}

function option(value, words) {
  const made = document.createElement("option");
  made.value = value;
  made.textContent = words;
  return made;
}

// Fills the lists that depend on what a step has, and keeps what is chosen where it is there.
function listFields(step) {
  const shapes = [...new Set(scene.steps.filter((s) => s.stage === step.stage).flatMap((s) => s.shapes.map(([name]) => name)))];
  byId("shape").replaceChildren(option("", "displacements"), ...shapes.map((name) => option(name, name)));
  byId("fill").replaceChildren(option("groups", "groups"), ...Object.entries(scene.fields).filter(([name]) => step.blocks[name]).map(([name, [words]]) => option(name, words))); // the scale has the unit
  for (const [id, key] of [["shape", "shape"], ["fill", "fill"]]) {
    byId(id).value = choice[key];
    if (byId(id).selectedIndex < 0) byId(id).selectedIndex = 0;
    choice[key] = byId(id).value;
  }
}

function play() {
  if (playing !== null) {
    clearInterval(playing);
    playing = null;
  } else {
    if (choice.step === scene.steps.length - 1) goTo(0);
    playing = setInterval(() => (choice.step < scene.steps.length - 1 ? goTo(choice.step + 1) : play()), scene.steps.length > 20 ? 80 : 900);
  }
  byId("play").textContent = playing === null ? "play" : "stop";
}

// ---- the scale of displacements

function rescale(index, byHand = true) {
  choice.ownScale = choice.ownScale || byHand; // once chosen it stays; else each stage has the scale that fits it
  const kept = Math.min(SCALES.length - 1, Math.max(0, index));
  byId("scale").value = kept;
  choice.scale = SCALES[kept];
  redraw();
}

// The largest displacement in the box of the dam becomes about a twentieth of it; motion in time, and what moves farther, is drawn as it is.
function fittingScale(step) {
  let largest = 0;
  const inside = (v) => mesh.vertices[v] > scene.box[0] && mesh.vertices[v] < scene.box[1] && mesh.vertices[v + 1] > scene.box[2] && mesh.vertices[v + 1] < scene.box[3];
  for (let v = 0; v < step.displacement.length; v += 2) if (inside(v)) largest = Math.max(largest, Math.hypot(step.displacement[v], step.displacement[v + 1]) || 0);
  if (!largest) return 1;
  const wanted = nice((SHAPE_PART * damSize) / largest);
  return Math.max(1, SCALES.findIndex((s) => s >= wanted * (1 - 1e-9)));
}

// ---- hands

const down = new Map(); // fingers or the mouse on the section: where they are, and were at first
let moved = false;

function onDown(event) {
  canvas.setPointerCapture(event.pointerId);
  if (!down.size) moved = false;
  down.set(event.pointerId, {x: event.offsetX, y: event.offsetY, x0: event.offsetX, y0: event.offsetY});
  if (down.size > 1) moved = true;
}

function onMove(event) {
  const finger = down.get(event.pointerId);
  if (!finger) return;
  const before = {...finger}, others = [...down].filter(([id]) => id !== event.pointerId).map(([, f]) => f);
  Object.assign(finger, {x: event.offsetX, y: event.offsetY});
  if (Math.hypot(finger.x - finger.x0, finger.y - finger.y0) > 5) moved = true;
  if (!moved) return;
  if (others.length) {
    const other = others[0], far = (f) => Math.max(1, Math.hypot(f.x - other.x, f.y - other.y));
    zoomAt(0.5 * (before.x + other.x), 0.5 * (before.y + other.y), far(finger) / far(before));
  }
  const part = others.length ? 0.5 : 1; // two fingers: the picture follows the middle between them
  eye.x -= (part * (finger.x - before.x)) / eye.zoom;
  eye.y += (part * (finger.y - before.y)) / eye.zoom;
  redraw();
}

function onUp(event) {
  if (!down.delete(event.pointerId)) return;
  if (!down.size && !moved && event.type === "pointerup") pick(event.offsetX, event.offsetY);
}

function zoomMiddle(factor) {
  zoomAt(0.5 * eye.width, 0.5 * eye.height, factor);
  redraw();
}

const KEYS = {
  ArrowLeft: () => goTo(choice.step - 1), ArrowRight: () => goTo(choice.step + 1), ArrowUp: () => rescale(Number(byId("scale").value) + 1),
  ArrowDown: () => rescale(Number(byId("scale").value) - 1), "+": () => zoomMiddle(1.25), "=": () => zoomMiddle(1.25), "-": () => zoomMiddle(0.8), " ": play,
  d: () => { look(scene.box); redraw(); }, a: () => { look(scene.whole); redraw(); }, u: () => rescale(0),
};

function onKey(event) {
  const {tagName, type} = event.target, key = KEYS[event.key]; // lists take all keys themselves, sliders the arrows, buttons and boxes the space
  const isTaken = tagName === "SELECT" || (type === "range" && event.key.startsWith("Arrow")) || ((tagName === "BUTTON" || type === "checkbox") && event.key === " ");
  if (!key || isTaken || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  key();
}

function listen() {
  byId("step").max = scene.steps.length - 1;
  byId("step").addEventListener("input", () => goTo(Number(byId("step").value)));
  byId("before").addEventListener("click", () => goTo(choice.step - 1));
  byId("after").addEventListener("click", () => goTo(choice.step + 1));
  byId("play").addEventListener("click", play);
  byId("stage").append(...[...new Set(scene.steps.map((s) => s.stage))].map((name) => option(name, name)));
  byId("stage").addEventListener("change", () => goTo(scene.steps.findLastIndex((s) => s.stage === byId("stage").value)));
  byId("scale").max = SCALES.length - 1;
  byId("scale").addEventListener("input", () => rescale(Number(byId("scale").value)));
  byId("joints").append(...Object.entries(KINDS).map(([value, words]) => option(value, words)));
  byId("joints").value = choice.joints;
  for (const id of ["shape", "fill", "joints"]) byId(id).addEventListener("change", () => { choice[id] = byId(id).value; redraw(); });
  for (const id of ["crosses", "water", "anchors", "points"]) byId(id).addEventListener("change", () => { choice[id] = byId(id).checked; redraw(); });
  byId("dam").addEventListener("click", KEYS.d);
  byId("all").addEventListener("click", KEYS.a);
  byId("larger").addEventListener("click", KEYS["+"]);
  byId("smaller").addEventListener("click", KEYS["-"]);
  canvas.addEventListener("pointerdown", onDown);
  canvas.addEventListener("pointermove", onMove);
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, onUp);
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoomAt(event.offsetX, event.offsetY, Math.exp(-0.0015 * event.deltaY)); redraw(); }, {passive: false});
  document.addEventListener("keydown", onKey);
  window.addEventListener("resize", redraw);
}

// ---- the page

function listJoints() {
  const lines = new Map();
  for (const s of scene.steps) for (const row of s.table) lines.set(row.name, row.ends !== null || lines.get(row.name));
  const names = [...lines.keys()].sort((a, b) => Number(lines.get(b)) - Number(lines.get(a)));
  byId("joint").append(...names.map((name) => option(name, name)));
  byId("joint").addEventListener("change", redraw);
  byId("joint").closest("figure").hidden = !names.length;
}

const showInCharts = []; // one function for each chart, which marks a step in it

function listCharts() {
  scene.charts.forEach((chart) => {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption"), drawn = document.createElement("div");
    const all = chart.series.length;
    caption.textContent = `${chart.title} [${chart.unit}]${all > MOST_LINES ? `: ${MOST_LINES} of ${all} lines, those that move most` : ""}`;
    drawn.setAttribute("role", "img");
    drawn.setAttribute("aria-label", caption.textContent);
    figure.append(caption, drawn);
    byId("charts").append(figure);
    showInCharts.push(plotChart(drawn, chart, (value) => goTo(nearestStep(chart, value))));
  });
}

// The step whose place on the axis of a chart is nearest.
function nearestStep(chart, value) {
  let best = choice.step, least = Infinity;
  scene.steps.forEach((step, i) => {
    const here = placeOf(chart, step);
    if (here !== null && Math.abs(here - value) < least) [best, least] = [i, Math.abs(here - value)];
  });
  return best;
}

byId("notes").append(...scene.notes.map((text) => {
  const item = document.createElement("li");
  item.textContent = text;
  return item;
}));
listen();
listJoints();
listCharts();
[eye.width, eye.height] = sized(canvas);
look(scene.box);
rescale(fittingScale(stepOf(choice.step)), false);
goTo(choice.step);
