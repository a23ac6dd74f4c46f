// The drawing of a mechanism in motion. `picture` is an SVG that stands still; what moves in it carries data-body,
// data-point, data-arrow; `record` says where it is at every moment. One file for reports, notebooks and the studio.

const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2];
const LETTER = 12.5, TALLEST = 544; // size of names, and height of a drawing, in pixels
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
  constructor(svg, motion) {
    this.svg = svg;
    this.motion = motion;
    this.overGround = false;
    const all = (name) => Array.from(svg.querySelectorAll(`[data-${name}]`)).sort((a, b) => a.dataset[name] - b.dataset[name]);
    this.bodies = all("body");
    this.points = all("point");
    this.arrows = all("arrow");
    this.chains = all("chain");
    this.traces = all("trace");
    this.near = this.traces.map((trace) => trace.getAttribute("d"));
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
      if (!name || seen.has(name) || name.startsWith("ground at ") || name.startsWith("teeth of ") || this.named.length === MOST_NAMES) return;
      seen.add(name);
      this.named.push({ name, at });
    };
    const { bodies, chains, points } = this.motion;
    this.bodies.forEach((body) => add(body, (i) => {
      let [x, y] = [0, 0];
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
    const pixels = this.svg.getBoundingClientRect().width || 640;
    this.size = LETTER / Math.min(pixels / (1.3 * width), TALLEST / height);
    const longest = Math.max(0, ...this.named.map(({ name }) => name.length));
    this.right = left + width + 1.5 * this.size;
    this.near_box = [left, top, width + (this.named.length ? (0.56 * longest + 3) * this.size : 0), height];
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

  /** A bar of a round length, so that sizes can be read off. */
  #bar() {
    const [left, top, width, height] = this.svg.dataset.near.split(" ").map(Number);
    const power = 10 ** Math.floor(Math.log10(0.3 * width));
    const length = power * [5, 2, 1].find((factor) => factor * power <= 0.3 * width);
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
      const level = Math.min(Math.max(-y, before), top + height - this.size - rest);
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
    const near = this.named_shown === false ? this.svg.dataset.near : this.near_box.join(" ");
    this.svg.setAttribute("viewBox", this.overGround ? this.svg.dataset.wide : near);
  }

  /** Look from the ground, over which the machine travels, or from the machine. */
  look(overGround) {
    this.overGround = overGround;
    this.#box();
    this.names.style.display = overGround || this.named_shown === false ? "none" : "";
    if (this.ground) this.ground.style.display = overGround ? "" : "none";
    this.traces.forEach((trace, k) => trace.setAttribute("d", overGround ? this.#path(k) : this.near[k]));
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

  #path(k) {
    const [x, y] = this.motion.points[k];
    const steps = [];
    for (let i = 0; i < this.motion.moments; i++) steps.push(`${(x(i) + this.motion.travel(i)).toFixed(2)} ${y(i).toFixed(2)}`);
    return `M${steps.join(" ")}`;
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

/** Round numbers between two ends, about `count` of them: steps of 1, 2 or 5 times a power of ten. */
function ticks(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * (1 - 1e-9));
  const first = Math.ceil(low / step - 1e-9);
  const found = [];
  for (let k = first; k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

const LEFT = 58, RIGHT = 64, TOP = 20, HEIGHT = 210, FLOOR = 172; // of a curve's drawing, in pixels
const NARROW = 420; // width below which an axis of angles has a tick every 90 deg

/** A curve over the cycle with its axes, and a mark that moves along it; others of the same name are dashed. */
class Curve {
  constructor(motion) {
    this.motion = motion;
    this.others = [];
    this.width = 480;
    this.axes = make("g", { class: "axes" });
    this.ends = make("g", { class: "ends" });
    this.line = make("path", { class: "course" });
    this.other = make("path", { class: "course other" });
    this.zero = make("path", { class: "reference" });
    this.mark = make("circle", { r: 4, class: "mark" });
    this.svg = make("svg", { class: "curve", role: "img" }, this.axes, this.zero, this.other, this.line, this.mark, this.ends);
    if (typeof ResizeObserver !== "undefined") new ResizeObserver(() => this.#fit()).observe(this.svg);
  }

  /** Choose a curve; from its reference if it has one and that is wanted; beside it those of that name of `others`. */
  choose(index, deviation, beside) {
    this.chosen = [index, deviation, beside];
    const curve = this.motion.curves[index];
    const from = deviation && curve.reference !== null ? curve.reference : 0;
    this.value = (i) => curve.at(i) - from;
    const sampled = (value) => Array.from({ length: this.motion.moments }, (_, i) => value(i));
    const values = sampled(this.value);
    const wanted = this.others.filter((one) => beside || one.always);
    const others = wanted.map((one) => ({ model: one.model, at: one.at(curve.name) })).filter((one) => one.at);
    const drawn = others.map(({ at }) => sampled((i) => at(i) - from));
    const all = [...values, ...drawn.flat()];
    const [least, most] = [Math.min(...all), Math.max(...all)];
    const room = 0.07 * (most - least) || Math.abs(most) / 10 || 1;
    const [low, high] = [least - room, most + room];
    const span = high - low;
    const right = this.width - RIGHT;
    const end = this.motion.share(this.motion.moments - 1);
    this.x = (i) => LEFT + ((right - LEFT) * this.motion.share(i)) / end;
    this.y = (value) => FLOOR - ((FLOOR - TOP) * (value - low)) / span;
    const path = (course) => `M${course.map((value, i) => `${this.x(i).toFixed(1)} ${this.y(value).toFixed(2)}`).join(" ")}`;
    this.line.setAttribute("d", path(values));
    this.other.setAttribute("d", drawn.map(path).join(""));
    const level = deviation || curve.reference === null ? 0 : curve.reference;
    const seen = level >= low && level <= high;
    this.zero.setAttribute("d", seen ? `M${LEFT} ${this.y(level)} ${right} ${this.y(level)}` : "");
    const unit = curve.unit ? ` ${curve.unit}` : "";
    this.exact = (value) => (Math.abs(value) < 1e-9 * span ? 0 : value);
    const told = (value) => digits(this.exact(value)) + unit;
    const also = (i) => others.map(({ model, at }) => `, ${model} ${told(at(i) - from)}`).join("");
    this.told = (i) => `${curve.name}${from ? " less its reference" : ""} ${told(this.value(i))}${also(i)}`;
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${HEIGHT}`);
    this.svg.setAttribute("aria-label", `${curve.name} over the cycle, from ${told(least)} to ${told(most)}`);
    this.#axes(curve, low, high, right);
    const last = this.motion.moments - 1;
    const ends = others.map(({ model, at }) => ({ name: model, y: this.y(at(last) - from), kind: "other" }));
    if (others.length) ends.push({ name: "A", y: this.y(values[last]), kind: "own" });
    if (seen && curve.reference !== null && !deviation) ends.push({ name: `${digits(level)}`, y: this.y(level), kind: "level" });
    this.#label(ends, right);
  }

  /** Ticks, their lines and the names of both axes. */
  #axes(curve, low, high, right) {
    const { record } = this.motion;
    const parts = [];
    for (const value of ticks(low, high, 4)) {
      const y = this.y(value).toFixed(1);
      parts.push(make("path", { class: "grid", d: `M${LEFT} ${y} ${right} ${y}` }));
      parts.push(make("text", { x: LEFT - 6, y: Number(y) + 4, "text-anchor": "end" }, digits(this.exact(value))));
    }
    const [first, last] = [this.motion.place(0), this.motion.place(this.motion.moments - 1)];
    const round = record.unit === "deg" && last - first > 300;
    const step = this.width < NARROW ? 90 : 60;
    const places = round ? Array.from({ length: Math.floor(360 / step) + 1 }, (_, k) => k * step) : ticks(first, last, this.width < NARROW ? 4 : 6);
    for (const place of places) {
      const x = place > last ? right : this.x(this.motion.nearest(place));
      parts.push(make("path", { class: "grid", d: `M${x.toFixed(1)} ${TOP} ${x.toFixed(1)} ${FLOOR}` }));
      parts.push(make("text", { x, y: FLOOR + 15, "text-anchor": "middle" }, digits(place) + (record.unit === "deg" ? "\u00b0" : "")));
    }
    parts.push(make("text", { x: LEFT, y: 12, class: "axis" }, curve.unit ? `${curve.name} / ${curve.unit}` : curve.name));
    const under = record.unit === "deg" || !record.unit ? record.place : `${record.place} / ${record.unit}`;
    parts.push(make("text", { x: (LEFT + right) / 2, y: HEIGHT - 6, "text-anchor": "middle" }, under));
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
  }
}

/** A mechanism with its controls, in an element that holds its picture. */
export class Drawing {
  constructor(element, record) {
    this.element = element;
    this.moment = 0;
    this.playing = false;
    this.controls = make("div", { class: "controls" });
    element.append(this.controls);
    this.load(record);
    element.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Take another record, and with it another picture, or what changes the one in place; the moment stays. */
  load(record, picture = null) {
    if (typeof picture === "function") picture(this.element.querySelector("svg.mechanism"));
    else if (picture !== null) this.element.querySelector("svg.mechanism").outerHTML = picture;
    this.motion = new Motion(record);
    this.mechanism = new Mechanism(this.element.querySelector("svg.mechanism"), this.motion);
    if (picture === null || this.motion.curves.length !== this.count) this.#build();
    else this.#settle();
    this.show(this.moment % this.motion.moments);
  }

  show(moment) {
    this.moment = moment;
    this.mechanism.show(moment);
    if (this.curve) this.curve.show(moment);
    this.scrub.value = moment;
    const { record } = this.motion;
    const place = `${record.place} ${digits(this.motion.place(moment))} ${record.unit}`;
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
    this.curve.choose(Number(this.which.value), this.apart.checked, this.over.checked);
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
      row.append(make("button", { type: "button", onclick: () => this.event(-1) }, "\u2190 event"));
      row.append(make("button", { type: "button", onclick: () => this.event(1) }, "event \u2192"));
    }
    this.controls.append(row, this.told, this.#choices());
    if (motion.curves.length) this.controls.append(this.#curves());
    else this.curve = null;
  }

  /** After a change of design: what was chosen goes for the new picture too. */
  #settle() {
    for (const choice of this.chosen) choice.apply();
    if (this.curve) {
      Object.assign(this.curve, { motion: this.motion, others: [] });
      this.curve.choose(Number(this.which.value), this.apart.checked, false);
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
    const apart = make("label", {}, this.apart, " as deviation from the reference");
    const over = make("label", { hidden: true }, this.over, " also show other models");
    apart.hidden = this.motion.curves.every((curve) => curve.reference === null);
    this.curve.choose(0, false, false);
    return make("div", { class: "curves" }, make("div", { class: "row" }, this.which, apart, over), this.curve.svg);
  }

  #key(event) {
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
