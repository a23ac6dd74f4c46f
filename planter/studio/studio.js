// The studio's page. All that it knows stands here: a server that was started anew is told again.

import { chosen, exported, exporting, offer } from "./exports.js";
import { connect } from "./line.js";
import { Drawing } from "./view.js";

const $ = (id) => document.getElementById(id);
const state = { machine: null, values: {}, model: "", id: 0, shown: 0, past: [], b: null, beside: [], sources: [], opens: 0, pending: null, opening: null, loaded: null, searching: false };
const STORED = `planter studio ${location.pathname}`; // of this tab and this studio
const LONGEST_PAST = 50; // steps back that a reload keeps

function say(text, wrong = false) {
  $("said").textContent = text;
  $("said").className = wrong ? "error" : "";
}

function take(message) {
  if (message.sources) sources(message.sources);
  if (message.opened && current(message)) opened(message.opened);
  if (message.scenes && message.id > state.shown) seen(message);
  if (message.finished && message.id === state.id) finished(message.finished);
  if (message.details && message.id === state.id) details(message);
  if (message.ends && message.id === state.id) ends(message.ends);
  if (message.checks && message.id === state.id) checks(message.checks);
  if (message.wished) open({ text: message.wished, file: `${state.machine.name}.toml` });
  if (message.file) download(message.file);
  if (message.progress) say(message.progress);
  if (message.optimum) optimum(message);
  if (message.exporting !== undefined || message.exported) exported(message);
  if (message.error && current(message) && (message.id === undefined || message.id === state.id)) {
    if (message.opening !== undefined) { state.pending = null; choices(); }
    say(message.error, true);
    if (message.work === "search") search(false);
    if (message.work === "export") exported({ exporting: null });
  }
}

/** The line broke: what ran for this page has ended. A studio that was started anew has another address. */
function lost(anew) {
  search(false);
  exported({ exporting: null });
  const moved = (state.machine?.controls ?? []).filter((one) => state.values[one.path] !== one.value);
  const numbers = moved.map((one) => `${one.path} = ${state.values[one.path]}`).join(", ");
  const kept = numbers && ` What was moved here: ${numbers}.`;
  say(anew ? `The studio was started anew: open the address that it prints.${kept}` : "The studio does not answer; trying again.", true);
}

/** Whether a message is not about a machine that something newer has taken the place of. */
const current = (message) => message.opening === undefined || message.opening === state.opens;

function sources(names) {
  state.sources = names;
  const kept = stored();
  if (!state.opening && !state.pending) open(kept?.opening ?? { name: decodeURIComponent(location.hash.slice(1)) || names[0] }, kept);
  choices();
}

/** The machines to choose from; the one that is open is chosen. */
function choices() {
  const open = state.pending?.what ?? state.opening ?? {};
  const loaded = state.loaded ? [new Option(`${state.loaded.file ?? "loaded file"} (loaded)`, "", false, open.name === undefined)] : [];
  if (!loaded.length && open.name === undefined) loaded.push(new Option("", ""));
  $("source").replaceChildren(...loaded, ...state.sources.map((name) => new Option(name, name, false, name === open.name)));
}

/** Open a machine; what was `kept` of it is set again, where its own numbers are the same as then. */
function open(what, kept = null) {
  state.pending = { what, kept };
  state.opens += 1;
  send({ ask: "open", opening: state.opens, ...what });
}

const own = (machine) => Object.fromEntries(machine.controls.map((one) => [one.path, one.value]));
const alike = (one, two) => JSON.stringify(Object.entries(one).sort()) === JSON.stringify(Object.entries(two).sort());

/** What a page has to set again where its line broke, or it was loaded anew. */
function keepable() {
  const { opening, values, model, past } = state;
  return state.machine && { opening, own: own(state.machine), values, model, past: past.slice(-LONGEST_PAST) };
}

/** What this tab had before it was loaded anew; null where there is nothing, or the browser keeps nothing. */
function stored() {
  try { return JSON.parse(sessionStorage.getItem(STORED)); } catch { return null; }
}

function opened(machine) {
  const { what, kept } = state.pending ?? { what: state.opening, kept: null };
  const again = kept !== null && alike(kept.own, own(machine));
  const here = again && state.machine !== null;
  Object.assign(state, { machine, opening: what, pending: null, shown: state.id });
  if (what.name === undefined) state.loaded = what;
  choices();
  if (again) Object.assign(state, { values: kept.values, past: kept.past, model: kept.model });
  else Object.assign(state, { values: own(machine), past: [], model: machine.models[0] });
  remember(null);
  if (!here) {
    Object.assign(state, { b: null, beside: [] });
    $("drawings").replaceChildren();
    $("drawings").className = "";
    drawings.length = 0;
  }
  $("model").replaceChildren(...machine.models.map((name) => new Option(name, name, false, name === state.model)));
  offer(machine.exports);
  $("optimise").hidden = !machine.search;
  search(false);
  $("wish").hidden = !machine.wishes;
  controls();
  ask();
  if (kept && !again) say(`${machine.name} has other numbers than before: what was moved here is gone.`, true);
}

function controls() {
  const groups = new Map();
  for (const one of state.machine.controls) {
    if (!groups.has(one.group)) groups.set(one.group, group(one.group));
    groups.get(one.group).append(control(one));
  }
  $("controls").replaceChildren(...groups.values());
}

function group(name) {
  const found = document.createElement("fieldset");
  const title = document.createElement("legend");
  title.textContent = name.replaceAll("_", " ");
  found.append(title);
  return found;
}

function control(one) {
  const [box, name, slider, field] = ["div", "span", "input", "input"].map((tag) => document.createElement(tag));
  box.className = "control";
  box.dataset.path = one.path;
  name.className = "name";
  name.textContent = `${one.path.split(".").slice(1).join(".")}${one.meaning ? `: ${one.meaning}` : ""}`;
  const step = (one.upper - one.lower) / 1000;
  Object.assign(slider, { type: "range", min: one.lower, max: one.upper, step, value: state.values[one.path], ariaLabel: one.path });
  Object.assign(field, { type: "number", min: one.lower, max: one.upper, step: "any", value: state.values[one.path], ariaLabel: `${one.path}, value` });
  let before = null;
  slider.addEventListener("pointerdown", () => (before = { ...state.values }));
  slider.addEventListener("input", () => { before ??= { ...state.values }; set(one.path, Number(slider.value)); });
  slider.addEventListener("change", () => { remember(before); before = null; });
  field.addEventListener("change", () => { remember({ ...state.values }); set(one.path, Number(field.value)); });
  box.append(name, slider, field);
  return box;
}

/** How far the numbers can be moved from where they are. */
function ends(found) {
  for (const one of state.machine.controls) [one.from, one.to] = found[one.path] ?? [one.lower, one.upper];
  reflect();
  document.body.dataset.ended = state.id;
}

function remember(values) {
  if (values) state.past.push(values);
  $("undo").disabled = state.past.length === 0;
}

function set(path, value) {
  state.values[path] = value;
  reflect();
  ask();
}

function reflect() {
  for (const box of document.querySelectorAll(".control")) {
    const one = state.machine.controls.find((known) => known.path === box.dataset.path);
    const value = state.values[one.path];
    const [slider, field] = box.querySelectorAll("input");
    for (const input of [slider, field]) Object.assign(input, { min: Math.min(one.from ?? one.lower, value), max: Math.max(one.to ?? one.upper, value) });
    if (document.activeElement !== slider) slider.value = value;
    if (document.activeElement !== field) field.value = value;
    box.classList.toggle("moved", value !== one.value);
  }
}

function ask() {
  state.id += 1;
  for (const name of ["checks", "readings", "details"]) $(name).classList.add("stale");
  say("");
  send({ id: state.id, values: state.values, model: state.model });
}

const drawings = [];

function draw(place, index, scene) {
  const known = drawings[index];
  if (known && known.element.parentElement === place) known.load(scene.record, scene.fill ?? scene.picture);
  else drawings[index] = drawn(place, scene);
}

/** A drawing of a scene, whose picture may be one that is to be filled. */
function drawn(place, scene) {
  const element = document.createElement("div");
  Object.assign(element, { className: "planter-view", tabIndex: 0, innerHTML: scene.picture });
  scene.fill?.(element.querySelector("svg.mechanism"));
  place.append(element);
  return new Drawing(element, scene.record);
}

/** Points of the first drawing that a hand takes hold of; the machine follows, within the ends of its numbers. */
function handles() {
  const svg = $("drawings").querySelector("svg.mechanism");
  if (!svg || !state.machine.handles.length) return;
  const machine = svg.querySelector("[data-machine]");
  const size = svg.viewBox.baseVal.width / 60;
  for (const [x, y] of state.machine.handles) {
    const handle = document.createElementNS("http://www.w3.org/2000/svg", "circle");
    for (const [key, value] of Object.entries({ class: "handle", r: size, cx: state.values[x], cy: state.values[y] })) handle.setAttribute(key, value);
    handle.dataset.handle = x;
    handle.addEventListener("pointerdown", (event) => take_hold(event, machine, x, y));
    machine.append(handle);
  }
}

function take_hold(event, machine, x, y) {
  event.preventDefault();
  remember({ ...state.values });
  const matrix = machine.getScreenCTM().inverse();
  const within = (path, value) => {
    const one = state.machine.controls.find((known) => known.path === path);
    return Math.min(Math.max(value, one.from ?? one.lower), one.to ?? one.upper);
  };
  const move = (now) => {
    const at = new DOMPoint(now.clientX, now.clientY).matrixTransform(matrix);
    Object.assign(state.values, { [x]: within(x, at.x), [y]: within(y, at.y) });
    reflect();
    ask();
  };
  const end = () => { removeEventListener("pointermove", move); removeEventListener("pointerup", end); };
  addEventListener("pointermove", move);
  addEventListener("pointerup", end);
}

function seen(message) {
  state.shown = message.id;
  state.latest = message;
  draw_all(message.scenes);
  readings();
  document.body.dataset.shown = message.id;
}

/** What takes longer to find is drawn when the hand rests. */
function finished(scenes) {
  state.latest.scenes = scenes;
  draw_all(scenes);
  document.body.dataset.finished = state.id;
}

function draw_all(scenes) {
  scenes.forEach((scene, index) => draw($("drawings"), index, scene));
  for (const gone of drawings.splice(scenes.length)) gone.element.remove();
  handles();
}

const digits = (value) => (value === null ? "\u2013" : Number(value.toPrecision(6)).toString().replace("-", "\u2212"));

function row(cells, numbers) {
  const found = document.createElement("tr");
  cells.forEach((text, k) => {
    const cell = document.createElement("td");
    cell.textContent = text;
    if (numbers.includes(k)) cell.className = "number";
    found.append(cell);
  });
  return found;
}

/** The design's readings, those of its other models, and those of the design that was kept. */
function readings() {
  const values = (found) => new Map(found.map((one) => [one.name, digits(one.value)]));
  const several = state.machine.models.length > 1;
  const columns = [{ head: several ? `A ${state.model}` : "A", of: values(state.latest.readings) }];
  for (const one of state.beside) columns.push({ head: `A ${one.model}`, of: values(one.readings), kind: "beside" });
  if (state.b) columns.push({ head: "B", of: values(state.b.readings), kind: "b" });
  const numbers = columns.map((_, k) => k + 1);
  const made = (name, cells, unit) => {
    const found = row([name, ...cells, unit], numbers);
    columns.forEach(({ kind }, k) => kind && found.children[k + 1].classList.add(kind));
    return found;
  };
  $("readings").tHead.replaceChildren(made("quantity", columns.map(({ head }) => head), "unit"));
  $("readings").tBodies[0].replaceChildren(...state.latest.readings.map((one) => made(one.name, columns.map(({ of }) => of.get(one.name) ?? ""), one.unit)));
}

/** What takes longest: the other models, and what the machine is sized by. */
function details(message) {
  state.beside = message.beside;
  $("readings").classList.remove("stale");
  readings();
  drawings[0]?.beside(message.beside);
  $("details").hidden = message.details.length === 0;
  $("details").classList.remove("stale");
  $("details").querySelector("div").replaceChildren(...message.details.map(table));
  document.body.dataset.detailed = state.id;
}

function table({ title, head, rows }) {
  const [found, caption] = ["table", "caption"].map((tag) => document.createElement(tag));
  caption.textContent = title;
  found.append(caption, document.createElement("thead"), document.createElement("tbody"));
  found.tHead.append(row(head, []));
  const cell = (value) => (typeof value === "string" ? value : digits(value));
  const numbers = (cells) => cells.flatMap((value, k) => (typeof value === "string" ? [] : [k]));
  found.tBodies[0].append(...rows.map((cells) => row(cells.map(cell), numbers(cells))));
  return found;
}

function checks(found) {
  $("checks").hidden = found.length === 0;
  $("checks").classList.remove("stale");
  const rows = found.map((one) => {
    const made = row([one.name, digits(one.value), digits(one.margin), one.unit], [1, 2]);
    made.children[2].classList.add(one.met ? "met" : "missed");
    return made;
  });
  $("checks").tBodies[0].replaceChildren(...rows);
  document.body.dataset.checked = state.id;
}

function keep() {
  if (!state.latest) return;
  state.b = { readings: state.latest.readings };
  document.querySelector("#kept")?.remove();
  const place = document.createElement("div");
  place.id = "kept";
  $("drawings").classList.add("two");
  $("drawings").append(place);
  drawn(place, state.latest.scenes[0]);
  readings();
}

function undo() {
  const values = state.past.pop();
  $("undo").disabled = state.past.length === 0;
  if (!values) return;
  state.values = values;
  reflect();
  ask();
}

/** Numbers as the file has them. */
function reset() {
  remember({ ...state.values });
  for (const one of state.machine.controls) state.values[one.path] = one.value;
  reflect();
  ask();
}

function search(running) {
  state.searching = running;
  $("optimise").textContent = running ? "Cancel" : (state.machine?.search ?? "");
}

function optimise() {
  if (state.searching) { send({ ask: "cancel" }); say("The search was cancelled."); search(false); return; }
  search(true);
  say("Searching.");
  send({ ask: "optimise", values: state.values, model: state.model });
}

function optimum(message) {
  search(false);
  keep();
  remember({ ...state.values });
  Object.assign(state.values, message.optimum);
  reflect();
  ask();
  const sentence = message.sentence ?? `Improved: objective ${digits(message.start_objective)} to ${digits(message.objective)}.`;
  say(`${sentence} Your previous design is kept as B.`);
  document.body.dataset.optimum = message.objective ?? message.sentence;
}

function download(text) {
  const link = document.createElement("a");
  link.href = `data:application/toml;charset=utf-8,${encodeURIComponent(text)}`;
  link.download = `${state.machine.name}.toml`;
  link.click();
  say(`${link.download} was handed to the browser.`);
}

$("export").addEventListener("click", () => {
  if (exporting()) { send({ ask: "cancel", work: "export" }); exported({ exporting: null }); say("The export was given up."); }
  else send({ ask: "export", values: state.values, model: state.model, ...chosen() });
});
$("source").addEventListener("change", () => {
  const name = $("source").value;
  if (name) open({ name });
  else if (state.loaded) open(state.loaded);
});
$("model").addEventListener("change", () => { Object.assign(state, { model: $("model").value, beside: [] }); ask(); });
$("undo").addEventListener("click", undo);
$("reset").addEventListener("click", reset);
$("keep").addEventListener("click", keep);
$("optimise").addEventListener("click", optimise);
$("wish").addEventListener("click", () => send({ ask: "wish", values: state.values }));
$("save").addEventListener("click", () => send({ ask: "file", values: state.values }));
$("load").addEventListener("change", async () => {
  const [file] = $("load").files;
  if (file) open({ text: await file.text(), file: file.name });
  $("load").value = "";
});
const send = connect({
  heard: take,
  back: () => {
    say("");
    if (state.pending) open(state.pending.what, state.pending.kept);
    else if (state.opening) open(state.opening, keepable());
  },
  lost,
});
addEventListener("pagehide", () => {
  try { sessionStorage.setItem(STORED, JSON.stringify(keepable())); } catch { return; } // a browser that keeps nothing
});
