// The studio's page. All that it knows stands here: a server that was started anew is told again.

import { chosen, exported, exporting, offer } from "./exports.js";
import { Parameter } from "./fields.js";
import { connect } from "./line.js";
import { changeText, detailTable, digits, element, named, requirementRows, row, unsampled, verdict } from "./tables.js";
import { Drawing } from "./view.js";

const $ = (id) => document.getElementById(id);
const state = {
  machine: null, values: {}, model: "", id: 0, shown: 0, steps: [], at: 0, locked: new Set(), b: null, beside: [], checks: null,
  sources: [], opens: 0, pending: null, opening: null, loaded: null, searching: false,
  sought: null, stopped: false, awaited: null,
};
const STORED = `planter studio ${location.pathname}`; // of this tab and this studio
const THEME = "planter studio theme";
const MOST_STEPS = 100;
const MODELS = { exact: "Exact", printed: "As printed" };
const parameters = new Map();
const loading = $("loading");

function say(text, wrong = false) {
  $("said").textContent = text;
  $("said").className = wrong ? "error" : "";
  $("said").setAttribute("role", wrong ? "alert" : "status");
}

function take(message) {
  if (message.sources) sources(message.sources);
  if (message.opened && current(message)) opened(message.opened);
  if (message.scenes && message.id > state.shown) seen(message);
  if (message.readings && !message.scenes && message.id === state.id) refined(message);
  if (message.finished && message.id === state.id) finished(message.finished);
  if (message.details && message.id === state.id) details(message);
  if (message.ends && message.id === state.id) ends(message.ends);
  if (message.checks && message.id === state.id) checks(message.checks);
  if (message.wished) open({ text: message.wished, file: `${state.machine.name}.toml` });
  if (message.file) download(message.file);
  if (message.plan) plan(message.plan);
  if (message.searching) searching(message.searching);
  if (message.best) best(message.best);
  if (message.design && current(message) && message.title === state.awaited) beside({ ...message.design, title: message.title });
  if (message.progress && message.work === "search") progress(message.progress);
  else if (message.progress) say(message.progress);
  if (message.optimum) optimum(message);
  if (message.exporting !== undefined || message.exported) exported(message);
  if (message.error && current(message) && (message.id === undefined || message.id === state.id)) {
    if (message.opening !== undefined) { state.pending = null; loading.textContent = ""; choices(); }
    say(message.error, true);
    if (message.work === "search") search(null);
    if (message.work === "export") exported({ exporting: null });
  }
}

/** The line broke: what ran for this page has ended. A studio that was started anew has another address. */
function lost(anew) {
  search(null);
  exported({ exporting: null });
  const moved = (state.machine?.controls ?? []).filter((one) => state.values[one.path] !== one.value);
  const numbers = moved.map((one) => `${one.name} = ${state.values[one.path]}`).join(", ");
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
  loading.textContent = `Loading ${what.name ?? what.file ?? ""} \u2026`;
  state.opens += 1;
  send({ ask: "open", opening: state.opens, ...what });
}

const own = (machine) => Object.fromEntries(machine.controls.map((one) => [one.path, one.value]));
const alike = (one, two) => JSON.stringify(Object.entries(one).sort()) === JSON.stringify(Object.entries(two).sort());

/** What a page has to set again where its line broke, or it was loaded anew. */
function keepable() {
  const { opening, values, model, steps, at, b } = state;
  const beside = b && b.scene.record.data !== undefined ? b : null; // a page without a server computes its pictures by functions
  return state.machine && { opening, own: own(state.machine), values, model, steps, at, locked: [...state.locked], b: beside };
}

/** What this tab had before it was loaded anew; null where there is nothing, or the browser keeps nothing. */
function stored() {
  try { return JSON.parse(sessionStorage.getItem(STORED)); } catch { return null; }
}

function opened(machine) {
  const { what, kept } = state.pending ?? { what: state.opening, kept: null };
  const again = kept !== null && alike(kept.own, own(machine));
  const here = again && state.machine !== null;
  Object.assign(state, { machine, opening: what, pending: null, shown: state.id, checks: null });
  if (what.name === undefined) state.loaded = what;
  choices();
  if (again) Object.assign(state, { values: kept.values, steps: kept.steps, at: kept.at, model: kept.model, locked: new Set(kept.locked) });
  else Object.assign(state, { values: own(machine), steps: [{ label: "As in the file", values: own(machine) }], at: 0, model: machine.models[0], locked: new Set() });
  if (!here) {
    Object.assign(state, { b: again ? kept.b : null, beside: [] });
    $("drawings").replaceChildren(loading);
    $("curve").replaceChildren();
    drawings.length = 0;
  }
  $("model").replaceChildren(...machine.models.map((name) => new Option(MODELS[name] ?? name, name, false, name === state.model)));
  $("equations").hidden = machine.models.length < 2;
  offer(machine.exports);
  $("optimise").hidden = !machine.search;
  search(null);
  $("wish").hidden = !machine.wishes;
  fields();
  history();
  designs();
  ask();
  if (kept && !again) say(`${machine.name} has other numbers than before: what was moved here is gone.`, true);
}

/** The parameters in their groups. */
function fields() {
  parameters.clear();
  const groups = new Map();
  const lockable = new Set(state.machine.lockable ?? []);
  const deeds = { move: set, done: commit, refuse: (sentence) => say(sentence ?? "", sentence !== null), lock };
  for (const one of state.machine.controls) {
    if (!groups.has(one.group)) groups.set(one.group, group(one.group));
    const parameter = new Parameter(one, lockable.has(one.path), deeds);
    parameters.set(one.path, parameter);
    groups.get(one.group).append(parameter.element);
  }
  $("groups").replaceChildren(...groups.values());
  for (const found of groups.values()) found.querySelector("summary small").textContent = found.querySelectorAll(".control").length;
  find();
  reflect();
}

function group(name) {
  const title = element("summary", "", element("h2", "", name), " ", element("small"));
  return Object.assign(element("details", "group", title), { open: true });
}

/** Show the parameters that have the text that is looked for. */
function find() {
  const text = $("find").value.trim();
  for (const parameter of parameters.values()) parameter.element.hidden = !parameter.matches(text);
  for (const found of document.querySelectorAll(".group")) {
    found.hidden = !found.querySelector(".control:not([hidden])");
    if (text) found.open = true;
  }
}

/** Lock a number in searches, or unlock it. */
function lock(path) {
  if (!state.locked.delete(path)) state.locked.add(path);
  reflect();
}

/** How far the numbers can be moved from where they are. */
function ends(found) {
  for (const one of state.machine.controls) [one.from, one.to] = found[one.path] ?? [one.lower, one.upper];
  reflect();
  document.body.dataset.ended = state.id;
}

/** Record a step of the history, unless nothing was changed. */
function commit(label) {
  if (alike(state.values, state.steps[state.at].values)) return;
  state.steps = [...state.steps.slice(0, state.at + 1), { label, values: { ...state.values } }].slice(-MOST_STEPS);
  state.at = state.steps.length - 1;
  history();
}

/** Go to a step of the history. */
function go(at) {
  if (at < 0 || at >= state.steps.length) return;
  state.at = at;
  state.values = { ...state.steps[at].values };
  reflect();
  for (const parameter of parameters.values()) parameter.clear();
  history();
  ask();
}

/** Undo a change that was not recorded yet, or the latest step. */
function undo() {
  go(alike(state.values, state.steps[state.at].values) ? state.at - 1 : state.at);
}

function history() {
  const [back, on] = [state.steps[state.at], state.steps[state.at + 1]];
  $("undo").disabled = state.at === 0;
  $("undo").title = state.at ? `Undo: ${back.label}` : "Nothing to undo";
  $("redo").disabled = !on;
  $("redo").title = on ? `Redo: ${on.label}` : "Nothing to redo";
  $("steps").replaceChildren(...state.steps.map(({ label }, k) => {
    const button = Object.assign(element("button", "link", label), { type: "button" });
    if (k === state.at) button.setAttribute("aria-current", "step");
    button.addEventListener("click", () => go(k));
    return element("li", "", button);
  }));
}

function set(path, value) {
  state.values[path] = value;
  reflect();
  ask();
}

function reflect() {
  for (const [path, parameter] of parameters) {
    const { from, to, lower, upper } = parameter.control;
    parameter.reflect(state.values[path], [from ?? lower, to ?? upper], state.b?.values[path], state.locked.has(path));
  }
}

function ask() {
  state.id += 1;
  for (const name of ["checks", "readings", "details"]) busy(name, true);
  if (![...parameters.values()].some((parameter) => parameter.wrong)) say("");
  send({ id: state.id, values: state.values, model: state.model });
}

function busy(name, is) {
  $(name).classList.toggle("stale", is);
  $(name).setAttribute("aria-busy", is);
}

const drawings = [];

function draw(place, index, scene) {
  const known = drawings[index];
  if (known && known.element.parentElement === place) known.load(scene.record, scene.fill ?? scene.picture);
  else {
    drawings[index] = drawn(place, scene, index === 0 ? $("curve") : null);
    if (index === 0 && state.b) drawings[0].keep(state.b.scene);
  }
}

/** A drawing of a scene, whose picture may be one that is to be filled. */
function drawn(place, scene, curves) {
  const found = document.createElement("div");
  Object.assign(found, { className: "planter-view", tabIndex: 0, innerHTML: scene.picture });
  found.setAttribute("role", "group");
  found.setAttribute("aria-label", "Drawing: Space plays, arrows move, Page Up and Page Down go to events");
  scene.fill?.(found.querySelector("svg.mechanism"));
  place.append(found);
  return new Drawing(found, scene.record, curves);
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
  const end = () => {
    removeEventListener("pointermove", move);
    removeEventListener("pointerup", end);
    commit("A point dragged");
  };
  addEventListener("pointermove", move);
  addEventListener("pointerup", end);
}

function seen(message) {
  state.shown = message.id;
  state.latest = message;
  draw_all(message.scenes);
  readings();
  judge();
  document.body.dataset.shown = message.id;
}

/** True extremes take the place of those of samples when the hand rests; the last ones are all of them. */
function refined(message) {
  if (state.latest.refined) return;
  Object.assign(state.latest, { readings: message.readings, refined: message.refined });
  readings();
  judge();
  document.body.dataset.refined = `${state.id} ${message.refined ? "all" : "first"}`;
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
  $("curve").hidden = !$("curve").childElementCount;
  handles();
}

/** The design's results, those of its other models, and those of the design that was kept with the change. */
function readings() {
  busy("readings", !state.latest.refined);
  const values = (found) => new Map(found.map((one) => [unsampled(one.name), one.value]));
  const columns = [{ head: "A", of: values(state.latest.readings), kind: "a" }];
  for (const one of state.beside) columns.push({ head: `A, ${MODELS[one.model]?.toLowerCase() ?? one.model}`, of: values(one.readings), kind: "beside" });
  if (state.b) columns.push({ head: "B", of: values(state.b.readings), kind: "b" });
  const heads = columns.map(({ head }) => head);
  const numbers = [...heads, ...(state.b ? ["change"] : [])].map((_, k) => k + 1);
  const made = (cells, head) => {
    const found = row(cells, numbers, head);
    columns.forEach(({ kind }, k) => found.children[k + 1].classList.add(kind));
    return found;
  };
  $("readings").tHead.replaceChildren(made(["Quantity", ...heads, ...(state.b ? ["Change"] : [])], true));
  $("readings").tBodies[0].replaceChildren(...state.latest.readings.map((one) => {
    const cells = columns.map(({ of }) => digits(of.get(unsampled(one.name))));
    const change = state.b ? [changeText(one.value, columns.at(-1).of.get(unsampled(one.name)))] : [];
    return made([named(one.name, one.unit), ...cells, ...change], false);
  }));
}

/** What takes longest: the other models, and what the machine is sized by. */
function details(message) {
  state.beside = message.beside;
  readings();
  drawings[0]?.beside(message.beside);
  $("details").hidden = message.details.length === 0;
  busy("details", false);
  $("details").querySelector("div").replaceChildren(...message.details.map(detailTable));
  document.body.dataset.detailed = state.id;
}

const jump = (angle) => { drawings[0]?.go(angle); $("drawings").scrollIntoView({ block: "nearest" }); };

function checks(found) {
  state.checks = found;
  judge();
  document.body.dataset.checked = state.id;
}

/** Requirements of both designs, and what follows. */
function judge() {
  const { checks: found, b } = state;
  if (found) {
    $("checks").parentElement.hidden = found.length === 0;
    busy("checks", false);
    const { head, rows } = requirementRows(found, b?.checks ?? null, jump);
    $("checks").tHead.replaceChildren(head);
    $("checks").tBodies[0].replaceChildren(...rows);
  }
  const title = b ? "Which design is better?" : "Which requirements are met?";
  $("verdict").querySelector("h2").textContent = title;
  $("verdict").querySelector("div").replaceChildren(...verdict({ checks: found, readings: state.latest?.readings, b, jump }));
}

/** What this page has of the design in edit. */
function snapshot() {
  const { latest, checks: found, values, model } = state;
  return { scene: latest.scenes[0], readings: latest.readings, checks: found, values: { ...values }, model, title: `kept at ${time()}` };
}

const time = () => new Date().toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });

function keep() {
  if (!state.latest) return;
  beside(snapshot());
  if (!state.checks || !state.latest.refined) complete(state.b);
}

/** Ask for all that belongs to a design that is to be B: a later answer about another one counts no more. */
function complete({ values, model, title }) {
  send({ ask: "design", values, model, title, opening: state.opens });
  state.awaited = title;
}

function beside(b) {
  Object.assign(state, { b, awaited: null });
  drawings[0]?.keep(b?.scene ?? null);
  designs();
  reflect();
  readings();
  judge();
}

/** Edit the design that was kept, and keep the one in edit. */
function exchange() {
  if (!state.b || !state.latest) return;
  const other = state.b;
  beside(snapshot());
  state.values = { ...other.values };
  state.model = $("model").value = other.model;
  commit("A and B exchanged");
  reflect();
  ask();
}

function designs() {
  const { b } = state;
  $("exchange").disabled = $("discard").disabled = !b;
  $("kept").replaceChildren(...(b ? [element("b", "b", "B"), `: ${b.title}.`] : ["No design is kept as B."]));
}

/** Numbers as the file has them. */
function reset() {
  state.values = own(state.machine);
  reflect();
  for (const parameter of parameters.values()) parameter.clear();
  commit("All parameters reset");
  ask();
}

/** Show no search, the question that comes before one ("plan"), or the one that is running. */
function search(stage) {
  state.searching = stage === "running";
  $("optimise").textContent = state.machine?.search ?? "";
  $("optimise").disabled = state.searching;
  $("search").hidden = stage === null;
  $("plan").hidden = stage !== "plan";
  $("running").hidden = stage !== "running";
}

const locked = () => [...state.locked].map((path) => parameters.get(path).control.name).join(", ");

/** Ask which goal, and how many starts; a machine that leaves nothing to ask is searched at once. */
function plan({ goal, quantities, aims, starts }) {
  const stated = goal ? [new Option(`as the file states: ${goal}`, "")] : [];
  $("quantity").replaceChildren(...stated, ...quantities.map(({ name, label }) => new Option(label, name)));
  $("aim").replaceChildren(...aims.map((words) => new Option(words, words)));
  $("starts").value = starts;
  $("counted").hidden = starts === 1;
  $("bound").textContent = locked() && `Locked: ${locked()}`;
  aim();
  if (starts === 1 && !quantities.length) { begin(); return; }
  search("plan");
  $("quantity").focus();
}

/** The file's own goal needs no word more. */
function aim() {
  $("aims").hidden = $("quantity").value === "";
}

function begin() {
  const goal = $("quantity").value ? { quantity: $("quantity").value, aim: $("aim").value } : {};
  searching({ goal: "", starts: 1 });
  send({ ask: "optimise", values: state.values, model: state.model, locked: [...state.locked], goal, starts: Number($("starts").value) });
}

/** What the search that runs makes small, from how many starts, and what it leaves as it is. */
function searching({ goal, starts }) {
  state.sought = { values: { ...state.values }, model: state.model, best: null };
  const from = starts === 1 ? "from this design" : `from ${starts} starts, this design and others within its bounds`;
  const fixed = locked() && `. Locked: ${locked()}`;
  $("goal").replaceChildren(...(goal ? [element("b", "", "Minimised: "), `${goal}; ${from}${fixed}.`] : []));
  state.stopped = $("stop").disabled = false;
  progress("");
  best(null);
  search("running");
}

/** The best design that a search has so far, none at first. */
function best(found) {
  state.sought.best = found;
  $("best").textContent = found?.sentence ?? "No design has been evaluated yet.";
  $("use").disabled = !found;
}

/** Put a design of the search beside the one in edit, which stays: as soon as it was computed it is B. */
function use(found, title) {
  const { values, model } = state.sought;
  complete({ values: { ...values, ...found.values }, model, title: `${title}, ${time()}` });
}

/** How far a stage of the search is, where its text counts steps. */
function progress(text) {
  if (state.stopped) return;
  const [, done, total] = text.match(/ (\d+) of (\d+)/) ?? [];
  const bar = $("search").querySelector("progress");
  if (total) Object.assign(bar, { value: Number(done), max: Number(total) });
  else bar.removeAttribute("value");
  $("progress").textContent = text;
}

const title = ({ met }, reason) => (met ? (reason ? "Best so far" : "Optimum") : "Closest design");

/** The search has ended: with a result, or else with a `reason` and the best design that it had. */
function optimum({ optimum: found, reason }) {
  search(null);
  use(found, title(found, reason));
  const outcome = reason ? [`${reason.replace(/\.$/, "")}.`] : [found.sentence, $("goal").textContent];
  if (state.stopped && found.met) outcome.push(found.sentence);
  say([...outcome, `${found.met ? "It" : "The closest design"} is B; your design stays A.`].join(" "), Boolean(reason) && !state.stopped);
  document.body.dataset.optimum = found.objective ?? found.sentence;
}

function stop() {
  state.stopped = true;
  $("stop").disabled = true;
  $("progress").textContent = "Stopping; the best design so far is kept.";
  send({ ask: "stop" });
}

function download(text) {
  const link = document.createElement("a");
  link.href = `data:application/toml;charset=utf-8,${encodeURIComponent(text)}`;
  link.download = `${state.machine.name}.toml`;
  link.click();
  say(`${link.download} was handed to the browser.`);
}

/** Set the theme, "light", "dark" or "" for the system's, and keep it for all of this browser's studios. */
function theme(name) {
  if (name) document.documentElement.dataset.theme = name;
  else delete document.documentElement.dataset.theme;
  $("theme").value = name;
  try { localStorage.setItem(THEME, name); } catch { return; } // a browser that keeps nothing
}

function storedTheme() {
  try { return localStorage.getItem(THEME) ?? ""; } catch { return ""; }
}

/** Choose what a narrow screen shows below the drawing. */
function panel(name) {
  document.body.dataset.panel = name;
  for (const button of document.querySelectorAll("#tabs button")) button.setAttribute("aria-pressed", button.dataset.to === name);
}

/** Keys that work wherever nothing is typed. */
function key(event) {
  const typing = event.target.matches("input:not([type=range]):not([type=checkbox]), select, textarea");
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z") {
    if ([...parameters.values()].some((parameter) => parameter.field === event.target && parameter.isEdited)) return;
    event.preventDefault();
    if (event.shiftKey) go(state.at + 1);
    else undo();
    return;
  }
  if (typing || event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
  const deeds = { k: keep, x: exchange, s: () => $("save").click(), "/": () => $("find").focus(), "?": () => $("keys").showModal() };
  const deed = deeds[event.key.toLowerCase()];
  if (deed) { event.preventDefault(); deed(); return; }
  if (event.target === document.body) drawings[0]?.key(event);
}

$("export").addEventListener("click", () => {
  if (exporting()) { send({ ask: "cancel" }); exported({ exporting: null }); say("The export was given up."); }
  else send({ ask: "export", values: state.values, model: state.model, ...chosen() });
});
$("source").addEventListener("change", () => {
  const name = $("source").value;
  if (name) open({ name });
  else if (state.loaded) open(state.loaded);
});
$("model").addEventListener("change", () => { Object.assign(state, { model: $("model").value, beside: [] }); ask(); });
for (const [name, deed] of Object.entries({ undo, redo: () => go(state.at + 1), reset, keep, exchange, discard: () => beside(null), stop, help: () => $("keys").showModal() })) {
  $(name).addEventListener("click", deed);
}
$("optimise").addEventListener("click", () => send({ ask: "plan", values: state.values, model: state.model }));
$("plan").addEventListener("submit", (event) => { event.preventDefault(); begin(); });
$("unplan").addEventListener("click", () => search(null));
$("quantity").addEventListener("change", aim);
$("use").addEventListener("click", () => { use(state.sought.best, title(state.sought.best, "so far")); say("The best design so far is B; the search goes on."); });
$("theme").addEventListener("change", () => theme($("theme").value));
theme(storedTheme());
$("find").addEventListener("input", find);
$("tabs").addEventListener("click", (event) => event.target.dataset.to && panel(event.target.dataset.to));
$("wish").addEventListener("click", () => send({ ask: "wish", values: state.values }));
$("save").addEventListener("click", () => send({ ask: "file", values: state.values }));
$("load").addEventListener("change", async () => {
  const [file] = $("load").files;
  if (file) open({ text: await file.text(), file: file.name });
  $("load").value = "";
});
addEventListener("keydown", key);
panel("controls");
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
  const kept = keepable();
  try { sessionStorage.setItem(STORED, JSON.stringify(kept)); } catch {
    try { sessionStorage.setItem(STORED, JSON.stringify({ ...kept, b: null })); } catch { return; } // a browser that keeps nothing
  }
});
