// The drawing of a mechanism in motion. `picture` is an SVG that stands still; what moves in it carries data-body,
// data-point, data-arrow; `record` says where it is at every moment. One file for reports, notebooks and the studio.

const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2];
const LETTER = 12.5, TALLEST = 544; // size of names, and height of a drawing, in pixels
const LONGEST_BAR = 160; // of the scale, in pixels
const MOST_NAMES = 12; // bodies that are named in a drawing
const SHORTEST = 2; // seconds that a cycle is shown for at first

/** Series of float32, one after another, each of `moments` numbers; or what stands still or goes on evenly. */
function series(record) {
  const all = record.block ?? decoded(record.data);
  const part = (k) => all.subarray(k * record.moments, (k + 1) * record.moments);
  const moving = (values, ahead) => (i) => values[(i + ahead) % record.moments];
  return (told) => {
    if (typeof told === "number") return () => told;
    return "step" in told ? (i) => told.from + told.step * i : moving(part(told.series), told.ahead);
  };
}

/** Numbers in base64. */
function decoded(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

/** An element with attributes and children. */
function make(name, attributes = {}, ...children) {
  const svg = ["svg", "path", "line", "circle", "text", "g"].includes(name);
  const found = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) found.addEventListener(key.slice(2), value);
    else if (value !== false) found.setAttribute(key, value === true ? "" : value);
  }
  found.append(...children);
  return found;
}

const digits = (value) => Number(value.toPrecision(5)).toString().replace("-", "\u2212");

/** What a record holds, as functions of the moment. */
class Motion {
  constructor(record) {
    const at = series(record);
    this.record = record;
    this.moments = record.moments;
    this.place = at(record.places);
    this.share = at(record.shares);
    this.travel = at(record.travel);
    this.bodies = record.bodies.map((pose) => pose.map(at));
    this.points = record.points.map((place) => place.map(at));
    this.chains = record.chains;
    this.forces = record.forces.map((force) => force.map(at));
    this.curves = record.curves.map((curve) => ({ ...curve, at: at(curve.values) }));
  }

  /** The latest moment at which no more than a share of the cycle's time is over. */
  reached(share) {
    let found = 0;
    while (found + 1 < this.moments && this.share(found + 1) <= share) found++;
    return found;
  }

  /** The moment that is nearest to a place of the cycle. */
  nearest(place) {
    let best = 0;
    for (let i = 1; i < this.moments; i++) {
      if (Math.abs(this.place(i) - place) < Math.abs(this.place(best) - place)) best = i;
    }
    return best;
  }
}

/** The mechanism itself: an SVG whose parts are set to a moment. */
class Mechanism {
  /** `room` is the largest width and height of the drawing in pixels. */
  constructor(svg, motion, room) {
    this.svg = svg;
    this.room = room;
    this.motion = motion;
    this.overGround = false;
    const all = (name) => Array.from(svg.querySelectorAll(`[data-${name}]`)).sort((a, b) => a.dataset[name] - b.dataset[name]);
    this.bodies = all("body");
    this.points = all("point");
    this.arrows = all("arrow");
    this.chains = all("chain");
    this.traces = all("trace");
    this.near = this.traces.map((trace, k) => trace.getAttribute("d") ?? this.#path(k, () => 0));
    this.traces.forEach((trace, k) => trace.setAttribute("d", this.near[k]));
    this.machine = svg.querySelector("[data-machine]");
    this.cut = svg.querySelector(".teeth") !== null;
    this.ground = svg.querySelector("[data-ground]");
    this.scale = Number(svg.dataset.force);
    if (motion.record.travel && this.ground) this.ground.style.display = "none";
    this.#name();
    this.#bar();
  }

  /** Names of the bodies beside the drawing, each with a line to its body. */
  #name() {
    this.named = [];
    const seen = new Set();
    const add = (element, at) => {
      const name = element.querySelector(":scope > title")?.textContent;
      if (!name || seen.has(name) || name.startsWith("ground at ") || this.named.length === MOST_NAMES) return;
      seen.add(name);
      this.named.push({ name, at });
    };
    const { bodies, chains, points } = this.motion;
    this.bodies.filter((body) => body.dataset.middle).forEach((body) => add(body, (i) => {
      let [x, y] = body.dataset.middle.split(" ").map(Number);
      for (let part = body; part; part = part.parentElement.closest("[data-body]")) {
        const [px, py, turn] = bodies[part.dataset.body].map((channel) => channel(i));
        const [cos, sin] = [Math.cos((turn * Math.PI) / 180), Math.sin((turn * Math.PI) / 180)];
        [x, y] = [px + cos * x - sin * y, py + sin * x + cos * y];
      }
      return [x, y];
    }));
    this.chains.forEach((chain, k) => add(chain, (i) => {
      const corners = chains[k].points.slice(0, 2).map((index) => points[index].map((channel) => channel(i)));
      return [0, 1].map((axis) => (corners[0][axis] + corners.at(-1)[axis]) / 2);
    }));
    const [left, top, width, height] = this.svg.dataset.near.split(" ").map(Number);
    this.size = LETTER / Math.min(this.room.width / (1.3 * width), (this.room.height - 2 * LETTER) / height);
    const longest = Math.max(0, ...this.named.map(({ name }) => name.length));
    this.right = left + width + 1.5 * this.size;
    this.near_box = [left, top, width + (this.named.length ? (0.56 * longest + 3) * this.size : 0), height + 2 * this.size];
    this.labels = this.named.map(({ name }) => {
      const line = make("path", { class: "leader" });
      const text = make("text", { "font-size": this.size, class: "name" }, name);
      return { line, text };
    });
    this.names = make("g", { class: "names" }, ...this.labels.flatMap(({ line, text }) => [line, text]));
    this.svg.querySelector(":scope > .names")?.remove();
    this.svg.append(this.names);
    this.svg.setAttribute("viewBox", this.near_box.join(" "));
  }

  /** A bar of a round length below the drawing, so that sizes can be read off. */
  #bar() {
    const [left, top, width, height] = this.near_box;
    const longest = Math.min(LONGEST_BAR * (this.size / LETTER), width - this.size);
    const power = 10 ** Math.floor(Math.log10(longest));
    const length = power * [5, 2, 1].find((factor) => factor * power <= longest);
    const [x, y, notch] = [left + this.size / 2, top + height - this.size / 2, this.size / 3];
    const bar = make("path", { class: "scale", d: `M${x} ${y - notch}V${y}H${x + length}V${y - notch}` });
    const text = make("text", { x: x + length / 2, y: y - notch, "font-size": this.size, "text-anchor": "middle" }, `${digits(length)} mm`);
    this.svg.querySelector(":scope > .bar")?.remove();
    this.svg.append(make("g", { class: "bar" }, bar, text));
  }

  /** The names at a moment: in the order of the heights of their bodies, apart from each other. */
  #place(moment) {
    const [, top, , height] = this.near_box;
    const gap = 1.5 * this.size;
    const places = this.named.map(({ at }, k) => ({ k, at: at(moment) })).sort((one, two) => two.at[1] - one.at[1]);
    let before = top;
    places.forEach(({ k, at: [x, y] }, order) => {
      const rest = (places.length - 1 - order) * gap;
      const level = Math.min(Math.max(-y, before), top + height - 3 * this.size - rest);
      before = level + gap;
      const { line, text } = this.labels[k];
      line.setAttribute("d", `M${x.toFixed(2)} ${(-y).toFixed(2)} ${(this.right - this.size / 2).toFixed(2)} ${level.toFixed(2)}`);
      text.setAttribute("x", this.right);
      text.setAttribute("y", level + this.size / 3);
    });
  }

  /** Show or hide the names; they are relative to the machine. */
  label(wanted) {
    this.named_shown = wanted;
    this.names.style.display = wanted && !this.overGround ? "" : "none";
    this.#box();
  }

  #box() {
    const [left, top, named, height] = this.near_box;
    const width = this.named_shown === false ? this.svg.dataset.near.split(" ")[2] : named;
    this.svg.setAttribute("viewBox", this.overGround ? this.svg.dataset.wide : [left, top, width, height].join(" "));
  }

  /** Look from the ground, over which the machine travels, or from the machine. */
  look(overGround) {
    this.overGround = overGround;
    this.#box();
    this.names.style.display = overGround || this.named_shown === false ? "none" : "";
    if (this.ground) this.ground.style.display = overGround ? "" : "none";
    this.traces.forEach((trace, k) => trace.setAttribute("d", overGround ? this.#path(k, this.motion.travel) : this.near[k]));
  }

  show(moment) {
    const { bodies, chains, points, forces, travel } = this.motion;
    this.bodies.forEach((body, k) => {
      const [x, y, turn] = bodies[k].map((channel) => channel(moment));
      body.setAttribute("transform", `translate(${x.toFixed(3)} ${y.toFixed(3)}) rotate(${turn.toFixed(3)})`);
    });
    this.chains.forEach((chain, k) => {
      const { points: corners, closed } = chains[k];
      const steps = corners.map((index) => points[index].map((channel) => channel(moment).toFixed(3)).join(" "));
      chain.setAttribute("d", `M${steps.join(" ")}${closed ? "Z" : ""}`);
    });
    this.points.forEach((point, k) => {
      point.setAttribute("cx", points[k][0](moment));
      point.setAttribute("cy", points[k][1](moment));
    });
    this.arrows.forEach((arrow, k) => arrow.setAttribute("d", this.#arrow(forces[k].map((channel) => channel(moment)))));
    this.#place(moment);
    const moved = this.overGround ? travel(moment) : 0;
    this.machine.setAttribute("transform", `translate(${moved} 0)`);
    this.traces.forEach((trace) => trace.setAttribute("transform", `translate(${-moved} 0)`));
  }

  /** The path of a point, closed where the cycle repeats relative to what it is drawn on. */
  #path(k, travel) {
    const [x, y] = this.motion.points[k];
    const steps = [];
    for (let i = 0; i < this.motion.moments; i++) steps.push(`${(x(i) + travel(i)).toFixed(2)} ${y(i).toFixed(2)}`);
    const last = this.motion.moments - 1;
    return `M${steps.join(" ")}${this.motion.share(last) < 1 && travel(last) === travel(0) ? "Z" : ""}`;
  }

  #arrow([x, y, fx, fy]) {
    const [along, up] = [this.scale * fx, this.scale * fy];
    const length = Math.hypot(along, up);
    if (length === 0) return `M${x} ${y}`;
    const [ex, ey, bx, by] = [x + along, y + up, x + 0.82 * along, y + 0.82 * up];
    const [sx, sy] = [-0.072 * up, 0.072 * along];
    return `M${x} ${y} ${ex} ${ey}M${bx + sx} ${by + sy} ${ex} ${ey} ${bx - sx} ${by - sy}`;
  }
}

/** Round numbers between two ends, about `count` of them and at least three: steps of 1, 2 or 5 times a power of ten. */
function ticks(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const steps = [10, 5, 2, 1, 0.5, 0.2, 0.1].map((factor) => factor * power);
  let found = [];
  for (const step of steps.slice(steps.findLastIndex((step) => step >= rough * (1 - 1e-9)))) {
    found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
    if (found.length >= 3) break;
  }
  return found;
}

const LEFT = 58, RIGHT = 64, TOP = 20, HEIGHT = 210, FLOOR = 172; // of a curve's drawing, in pixels
const PANE = 100, HEAD = 22; // height of the differences above the axis of angles, and of their title
const FLOAT = 1e-6; // rounding of numbers of 32 bits, relative to the largest
const LETTER_WIDTH = 6.5; // width of a letter of an axis, at most on average
const NARROW = 420; // width below which an axis of angles has a tick every 90 deg

/** A curve over the cycle with its axes, and a mark that moves along it; others of the same name are dashed. */
class Curve {
  constructor(motion) {
    this.motion = motion;
    this.others = [];
    this.kept = null;
    this.width = 480;
    this.axes = make("g", { class: "axes" });
    this.ends = make("g", { class: "ends" });
    this.line = make("path", { class: "course" });
    this.other = make("path", { class: "course other" });
    this.second = make("path", { class: "course kept" });
    this.change = make("path", { class: "course change" });
    this.zero = make("path", { class: "reference" });
    this.mark = make("circle", { r: 4, class: "mark" });
    this.mark2 = make("circle", { r: 4, class: "mark change" });
    const lines = [this.zero, this.other, this.second, this.line, this.change, this.mark, this.mark2];
    this.svg = make("svg", { class: "curve", role: "img" }, this.axes, ...lines, this.ends);
    if (typeof ResizeObserver !== "undefined") new ResizeObserver(() => this.#fit()).observe(this.svg);
  }

  // Choose a curve; from its reference if it has one and that is wanted; beside it those of that name of `others`.
  // The curve of a design that was kept is always beside it, and the difference from it below if that is wanted.
  choose(index, deviation, beside, difference) {
    this.chosen = [index, deviation, beside, difference];
    const curve = this.motion.curves[index];
    const from = deviation && curve.reference !== null ? curve.reference : 0;
    this.value = (i) => curve.at(i) - from;
    const sampled = (value) => Array.from({ length: this.motion.moments }, (_, i) => value(i));
    const values = sampled(this.value);
    const wanted = [...(this.kept ? [this.kept] : []), ...(beside ? this.others : [])];
    const others = wanted.map((one) => ({ model: one.model, at: one.at(curve.name), kind: one === this.kept ? "kept" : "other" })).filter((one) => one.at);
    const drawn = others.map(({ at }) => sampled((i) => at(i) - from));
    const kept = others.findIndex(({ kind }) => kind === "kept");
    const apart = difference && kept >= 0;
    const height = apart ? HEIGHT + PANE + HEAD + 14 : HEIGHT;
    const all = [...values, ...drawn.flat()];
    const [least, most] = [Math.min(...all), Math.max(...all)];
    const room = 0.07 * (most - least) || Math.abs(most) / 10 || 1;
    const [low, high] = [least - room, most + room];
    const span = high - low;
    const right = this.width - RIGHT;
    const end = this.motion.share(this.motion.moments - 1);
    this.x = (i) => LEFT + ((right - LEFT) * this.motion.share(i)) / end;
    this.y = (value) => FLOOR - ((FLOOR - TOP) * (value - low)) / span;
    const path = (course, y = this.y) => `M${course.map((value, i) => `${this.x(i).toFixed(1)} ${y(value).toFixed(2)}`).join(" ")}`;
    this.line.setAttribute("d", path(values));
    this.other.setAttribute("d", drawn.filter((_, k) => k !== kept).map((course) => path(course)).join(""));
    this.second.setAttribute("d", kept < 0 ? "" : path(drawn[kept]));
    const level = deviation || curve.reference === null ? 0 : curve.reference;
    const seen = level >= low && level <= high;
    this.zero.setAttribute("d", seen ? `M${LEFT} ${this.y(level)} ${right} ${this.y(level)}` : "");
    const unit = !curve.unit || curve.unit === "\u00b0" ? curve.unit : ` ${curve.unit}`;
    this.exact = (value) => (Math.abs(value) < 1e-9 * span ? 0 : value);
    const told = (value) => digits(this.exact(value)) + unit;
    const also = (i) => others.map(({ model, at }) => `, ${model} ${told(at(i) - from)}`).join("");
    this.told = (i) => `${curve.name}${from ? " less its reference" : ""} ${told(this.value(i))}${also(i)}`;
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${height}`);
    this.svg.setAttribute("aria-label", `${curve.name} over the cycle, from ${told(least)} to ${told(most)}`);
    const pane = apart ? this.#pane(values.map((value, i) => drawn[kept][i] - value), span, Math.max(...all.map(Math.abs))) : null;
    this.change.setAttribute("d", pane ? path(pane.values, pane.y) : "");
    this.mark2.style.display = pane ? "" : "none";
    this.#axes(curve, low, high, right, pane, height);
    const last = this.motion.moments - 1;
    const ends = others.map(({ model, at, kind }) => ({ name: model, y: this.y(at(last) - from), kind }));
    if (others.length) ends.push({ name: "A", y: this.y(values[last]), kind: "own" });
    if (seen && curve.reference !== null && !deviation) ends.push({ name: `${digits(level)}`, y: this.y(level), kind: "level" });
    this.#label(ends, right);
  }

  /** Differences below the curves, on a scale of their own; those below rounding are zero. */
  #pane(differences, span, size) {
    const values = differences.map((value) => (Math.abs(value) < FLOAT * Math.max(span, size) ? 0 : value));
    const [least, most] = [Math.min(0, ...values), Math.max(0, ...values)];
    const room = 0.07 * (most - least) || 1;
    const [low, high] = [least - room, most + room];
    const top = FLOOR + HEAD + 14;
    const y = (value) => top + PANE - (PANE * (value - low)) / (high - low);
    this.differs = (i) => y(values[i]);
    return { values, low, high, y, top };
  }

  /** Ticks, their lines and the names of both axes. */
  #axes(curve, low, high, right, pane, height) {
    const { record } = this.motion;
    const parts = [];
    const level = (value, y) => {
      parts.push(make("path", { class: "grid", d: `M${LEFT} ${y} ${right} ${y}` }));
      parts.push(make("text", { x: LEFT - 6, y: Number(y) + 4, "text-anchor": "end" }, digits(this.exact(value))));
    };
    for (const value of ticks(low, high, 4)) level(value, this.y(value).toFixed(1));
    const bottom = pane ? pane.top + PANE : FLOOR;
    if (pane) {
      for (const value of ticks(pane.low, pane.high, 3)) level(value, pane.y(value).toFixed(1));
      const title = `${this.kept.model} \u2212 A${curve.unit ? ` / ${curve.unit}` : ""}`;
      parts.push(make("text", { x: LEFT, y: pane.top - 6, class: "axis" }, title));
    }
    const [first, last] = [this.motion.place(0), this.motion.place(this.motion.moments - 1)];
    const round = record.unit === "deg" && last - first > 300;
    const step = this.width < NARROW ? 90 : 60;
    const places = round ? Array.from({ length: Math.floor(360 / step) + 1 }, (_, k) => k * step) : ticks(first, last, this.width < NARROW ? 4 : 6);
    for (const place of places) {
      const x = place > last ? right : this.x(this.motion.nearest(place));
      for (const [from, to] of pane ? [[TOP, FLOOR], [pane.top, bottom]] : [[TOP, FLOOR]]) {
        parts.push(make("path", { class: "grid", d: `M${x.toFixed(1)} ${from} ${x.toFixed(1)} ${to}` }));
      }
      parts.push(make("text", { x, y: bottom + 15, "text-anchor": "middle" }, digits(place) + (record.unit === "deg" ? "\u00b0" : "")));
    }
    const unit = curve.unit ? ` / ${curve.unit}` : "";
    const room = Math.floor((this.width - LEFT) / LETTER_WIDTH) - unit.length;
    const name = curve.name.length > room ? `${curve.name.slice(0, room - 1).trimEnd()}\u2026` : curve.name;
    parts.push(make("text", { x: LEFT, y: 12, class: "axis" }, name + unit));
    const under = record.unit === "deg" || !record.unit ? record.place : `${record.place} / ${record.unit}`;
    parts.push(make("text", { x: (LEFT + right) / 2, y: height - 6, "text-anchor": "middle" }, under));
    this.axes.replaceChildren(...parts);
  }

  /** Names of curves at their right ends, 13 px apart at least. */
  #label(ends, right) {
    let before = -Infinity;
    this.ends.replaceChildren(...ends.sort((one, two) => one.y - two.y).map(({ name, y, kind }) => {
      before = Math.max(y, before + 13);
      return make("text", { x: right + 5, y: before + 4, class: kind }, name);
    }));
  }

  /** The drawing has as many units as its place has pixels, so that texts keep their size. */
  #fit() {
    const width = Math.round(this.svg.getBoundingClientRect().width);
    if (!width || Math.abs(width - this.width) < 2 || !this.chosen) return;
    this.width = width;
    this.choose(...this.chosen);
    this.show(this.moment ?? 0);
  }

  show(moment) {
    this.moment = moment;
    this.mark.setAttribute("cx", this.x(moment));
    this.mark.setAttribute("cy", this.y(this.value(moment)));
    if (this.mark2.style.display === "none") return;
    this.mark2.setAttribute("cx", this.x(moment));
    this.mark2.setAttribute("cy", this.differs(moment));
  }
}

/** Another design beneath a drawing: its machine without teeth, forces and texts, at the same share of the cycle. */
class Ghost {
  constructor({ picture, record, fill }) {
    const holder = document.createElement("template");
    holder.innerHTML = picture;
    const svg = holder.content.querySelector("svg.mechanism");
    fill?.(svg);
    this.motion = new Motion(record);
    this.mechanism = new Mechanism(svg, this.motion, { width: 640, height: TALLEST });
    this.element = this.mechanism.machine;
    this.element.classList.add("ghost");
    for (const part of this.element.querySelectorAll(".teeth, .force, .before, text")) part.remove();
  }

  show(share) {
    this.mechanism.show(this.motion.reached(share));
  }

  /** A curve of this design, if it has one of that name, at the moments of another. */
  curve(name, motion) {
    const found = this.motion.curves.find((curve) => curve.name === name);
    return found && ((i) => found.at(this.motion.reached(motion.share(i))));
  }
}

const REACH = 12; // of a click, in pixels

/** A mechanism with its controls, in an element that holds its picture; curves are in it too, or in a `place`. */
export class Drawing {
  constructor(element, record, place = null) {
    this.element = element;
    this.place = place;
    this.ghost = null;
    this.moment = 0;
    this.playing = false;
    this.controls = make("div", { class: "controls" });
    element.append(this.controls);
    this.load(record);
    element.addEventListener("keydown", (event) => this.key(event));
    element.addEventListener("click", (event) => this.#pick(event));
    if (typeof ResizeObserver !== "undefined") new ResizeObserver(() => this.#resize()).observe(element);
  }

  /** Names keep the size of their letters where the drawing has another width. */
  #resize() {
    const svg = this.element.querySelector("svg.mechanism");
    const width = svg.getBoundingClientRect().width;
    if (!width || Math.abs(width - this.room.width) < 0.05 * this.room.width) return;
    this.room = null;
    this.ghost?.element.remove();
    this.#mechanism(svg);
    this.#settle();
    this.#haunt();
    if (this.curve) this.choose();
    this.show(this.moment);
  }

  #mechanism(svg) {
    this.room ??= { width: svg.getBoundingClientRect().width || 640, height: parseFloat(getComputedStyle(svg).maxHeight) || TALLEST };
    this.mechanism = new Mechanism(svg, this.motion, this.room);
  }

  /** Keep another design beneath this one, named; none without a scene. */
  keep(scene, model = "B") {
    this.ghost?.element.remove();
    this.ghost = scene && new Ghost(scene);
    this.kept_name = model;
    this.#haunt();
    if (this.curve) this.choose();
    this.show(this.moment);
  }

  /** Put the other design into the picture, and its curves beside those of this one. */
  #haunt() {
    if (this.ghost) this.mechanism.machine.before(this.ghost.element);
    if (!this.curve) return;
    const { ghost, motion } = this;
    this.curve.kept = ghost && { model: this.kept_name, at: (name) => ghost.curve(name, motion) };
    this.minus.parentElement.hidden = !ghost;
  }

  /** Go to a place of the cycle, and stay there. */
  go(place) {
    this.play(false);
    this.show(this.motion.nearest(place));
  }

  /** Take another record, and with it another picture, or what changes the one in place; the moment stays. */
  load(record, picture = null) {
    this.ghost?.element.remove();
    if (typeof picture === "function") picture(this.element.querySelector("svg.mechanism"));
    else if (picture !== null) this.element.querySelector("svg.mechanism").outerHTML = picture;
    this.motion = new Motion(record);
    this.#mechanism(this.element.querySelector("svg.mechanism"));
    if (picture === null || this.motion.curves.length !== this.count) this.#build();
    else this.#settle();
    this.#haunt();
    if (this.ghost && this.curve) this.choose();
    this.show(this.moment % this.motion.moments);
  }

  show(moment) {
    this.moment = moment;
    this.mechanism.show(moment);
    this.ghost?.show(this.motion.share(moment));
    if (this.curve) this.curve.show(moment);
    this.scrub.value = moment;
    const { record } = this.motion;
    const place = `${record.place} ${digits(this.motion.place(moment))}${record.unit === "deg" ? "\u00b0" : ` ${record.unit}`}`;
    this.scrub.setAttribute("aria-valuetext", place);
    this.told.textContent = this.curve ? `${place}, ${this.curve.told(moment)}` : place;
  }

  play(playing = !this.playing) {
    this.playing = playing;
    this.button.textContent = playing ? "Pause" : "Play";
    this.button.setAttribute("aria-pressed", playing);
    if (!playing) return;
    let before = null;
    let exact = this.motion.share(this.moment);
    const step = (now) => {
      if (!this.playing || !this.element.isConnected) return;
      if (before !== null && this.moment === this.motion.reached(exact)) {
        exact = (exact + ((now - before) / 1000 / this.motion.record.seconds) * this.speed) % 1;
      } else exact = this.motion.share(this.moment);
      before = now;
      this.show(this.motion.reached(exact));
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /** Curves of other models, to be drawn over these until another design is loaded: records by model. */
  beside(records) {
    if (!this.curve) return;
    this.curve.others = records.map(({ model, course }) => {
      const at = series(course);
      const known = new Map(course.curves.map((curve) => [curve.name, at(curve.values)]));
      return { model, at: (name) => known.get(name) };
    });
    this.over.parentElement.hidden = !records.length;
    this.over.nextSibling.textContent = ` also show ${records.map(({ model }) => model).join(", ")}`;
    this.choose();
  }

  /** Draw the curve as it is chosen. */
  choose() {
    this.curve.choose(Number(this.which.value), this.apart.checked, this.over.checked, this.minus.checked);
    this.show(this.moment);
  }

  /** Go to the next event, or to the one before. */
  event(way) {
    const moments = this.motion.record.events.map(([, place]) => this.motion.nearest(place));
    const ahead = way > 0 ? moments.find((m) => m > this.moment) : moments.findLast((m) => m < this.moment);
    const found = ahead ?? (way > 0 ? moments[0] : moments.at(-1));
    if (found === undefined) return;
    this.show(found);
    this.told.textContent += `: ${this.motion.record.events[moments.indexOf(found)][0]}`;
  }

  #build() {
    const { motion } = this;
    this.count = motion.curves.length;
    this.controls.replaceChildren();
    this.button = make("button", { type: "button", onclick: () => this.play() }, "Play");
    this.scrub = make("input", { type: "range", min: 0, max: motion.moments - 1, "aria-label": motion.record.place, oninput: () => this.show(Number(this.scrub.value)) });
    this.speed = SPEEDS.findLast((speed) => speed <= 1 && motion.record.seconds / speed >= SHORTEST) ?? SPEEDS[0];
    const speeds = SPEEDS.map((speed) => make("option", { value: speed, selected: speed === this.speed }, `${speed} \u00d7`));
    this.pace = make("select", { "aria-label": "speed", onchange: () => (this.speed = Number(this.pace.value)) }, ...speeds);
    this.told = make("output", { class: "told" });
    const row = make("div", { class: "row" }, this.button, this.scrub, this.pace);
    if (motion.record.events.length) {
      row.append(make("button", { type: "button", "aria-label": "to the event before", title: "to the event before", onclick: () => this.event(-1) }, "\u21e4"));
      row.append(make("button", { type: "button", "aria-label": "to the next event", title: "to the next event", onclick: () => this.event(1) }, "\u21e5"));
    }
    this.controls.append(row, this.told, this.#choices());
    const place = this.place ?? this.controls;
    if (this.place) this.place.replaceChildren();
    if (motion.curves.length) place.append(this.#curves());
    else this.curve = null;
  }

  /** After a change of design: what was chosen goes for the new picture too. */
  #settle() {
    for (const choice of this.chosen) choice.apply();
    if (this.curve) {
      Object.assign(this.curve, { motion: this.motion, others: [], kept: null });
      this.curve.choose(Number(this.which.value), this.apart.checked, false, false);
    }
  }

  #choices() {
    this.chosen = [];
    const row = make("fieldset", { class: "row choices" }, make("legend", {}, "Show"));
    const add = (name, checked, apply) => {
      const box = make("input", { type: "checkbox", checked });
      const choice = { apply: () => apply(box.checked) };
      box.addEventListener("change", () => { choice.apply(); this.show(this.moment); });
      this.chosen.push(choice);
      const label = make("label", {}, box, ` ${name}`);
      row.append(label);
      return label;
    };
    const title = (part) => part.querySelector("title").textContent;
    this.mechanism.points.forEach((point, k) => {
      const visible = this.mechanism.traces[k].getAttribute("visibility") !== "hidden";
      add(`path of ${title(point)}`, visible, (on) => this.mechanism.traces[k].setAttribute("visibility", on ? "visible" : "hidden"));
    });
    if (this.mechanism.arrows.length) {
      add(`forces, the longest ${digits(this.motion.record.largest_N)} N`, false, (on) => this.mechanism.arrows.forEach((arrow) => arrow.setAttribute("visibility", on ? "visible" : "hidden")));
      this.chosen.at(-1).apply();
    }
    const teeth = add("teeth", true, (on) => {
      this.mechanism.svg.classList.toggle("toothed", this.mechanism.cut && on);
      if (this.mechanism.cut) teeth.hidden = false;
    });
    teeth.hidden = !this.mechanism.cut;
    if (this.mechanism.named.length) add("names", true, (on) => this.mechanism.label(on));
    if (this.motion.record.travel) add("over the ground", false, (on) => this.mechanism.look(on));
    row.hidden = this.chosen.length === 1 && teeth.hidden;
    return row;
  }

  #curves() {
    this.curve = new Curve(this.motion);
    const options = this.motion.curves.map((curve, k) => make("option", { value: k }, curve.name));
    const choose = () => this.choose();
    this.which = make("select", { "aria-label": "curve", onchange: choose }, ...options);
    this.apart = make("input", { type: "checkbox", onchange: choose });
    this.over = make("input", { type: "checkbox", onchange: choose });
    this.minus = make("input", { type: "checkbox", checked: true, onchange: choose });
    const minus = make("label", { hidden: true }, this.minus, " difference");
    const apart = make("label", {}, this.apart, " as deviation from the reference");
    const over = make("label", { hidden: true }, this.over, " also show other models");
    apart.hidden = this.motion.curves.every((curve) => curve.reference === null);
    this.curve.choose(0, false, false, false);
    return make("div", { class: "curves" }, make("div", { class: "row" }, this.which, minus, apart, over), this.curve.svg);
  }

  /** Show the path of a point that is clicked, or hide it; show the force of a spring, then its length. */
  #pick(event) {
    if (!event.target.closest("svg.mechanism") || event.target.closest(".handle")) return;
    const [x, y] = [event.clientX, event.clientY];
    const distance = (point) => {
      const box = point.getBoundingClientRect();
      return Math.hypot(x - (box.left + box.right) / 2, y - (box.top + box.bottom) / 2);
    };
    const title = (part) => part.querySelector(":scope > title")?.textContent ?? "";
    const points = this.mechanism.points.filter((point) => distance(point) <= REACH && title(point));
    const nearest = points.sort((one, two) => distance(one) - distance(two)).map(title);
    const labels = Array.from(this.controls.querySelectorAll(".choices label"));
    const found = nearest.map((name) => labels.find((label) => label.textContent.trim() === `path of ${name}`)).find(Boolean);
    if (found) { found.control.click(); return; }
    if (!this.curve) return;
    const around = [[0, 0], [REACH, 0], [-REACH, 0], [0, REACH], [0, -REACH]];
    const parts = around.map(([dx, dy]) => document.elementFromPoint(x + dx / 2, y + dy / 2)?.closest("[data-body], [data-chain]"));
    const curves = parts.filter(Boolean).map((part) => this.#curves_of(title(part))).find((numbers) => numbers.length);
    if (!curves) return;
    this.which.value = curves[(curves.indexOf(Number(this.which.value)) + 1) % curves.length];
    this.choose();
  }

  /** The numbers of the curves of a spring's or strut's force and length. */
  #curves_of(name) {
    const symbols = ["F", "l"].map((letter) => `(${letter}_${name.replaceAll(" ", "_")})`);
    const { curves } = this.motion;
    return symbols.map((symbol) => curves.findIndex((curve) => curve.name.endsWith(symbol))).filter((k) => k >= 0);
  }

  /** Play, go on, back and to events by keys. */
  key(event) {
    if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName) || event.altKey || event.ctrlKey || event.metaKey) return;
    const count = this.motion.moments;
    const deeds = {
      " ": () => this.play(), ArrowRight: () => this.show((this.moment + 1) % count), ArrowLeft: () => this.show((this.moment + count - 1) % count),
      PageDown: () => this.event(1), PageUp: () => this.event(-1), Home: () => this.show(0), End: () => this.show(count - 1),
    };
    if (!(event.key in deeds)) return;
    event.preventDefault();
    deeds[event.key]();
  }
}

/** A widget of a notebook: the model holds `picture` and `record`. */
function render({ model, el }) {
  const element = make("div", { class: "planter-view", tabindex: 0 });
  element.innerHTML = model.get("picture");
  el.append(element);
  const drawing = new Drawing(element, model.get("record"));
  model.on("change:record", () => drawing.load(model.get("record"), model.get("picture")));
}

export default { render };

if (typeof document !== "undefined") {
  for (const element of document.querySelectorAll("[data-view]")) {
    const drawing = new Drawing(element, JSON.parse(element.querySelector("script").textContent));
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (element.dataset.view === "play" && !still) drawing.play(true);
  }
}
