// A parameter of a machine: its name, value, slider between bounds, mark of the other design, reset and lock.

import { digits, element, unitText } from "./tables.js";

const LOCK = { true: "M4 7V5a4 4 0 0 1 8 0v2M3 7h10v7H3z", false: "M4 7V5a4 4 0 0 1 7.5-2M3 7h10v7H3z" };

/** The number that a text says, in the parameter's unit: 0.5, 0,5 and −0.5, with or without the unit; NaN if none. */
export function parseValue(text, unit) {
  const plain = text.trim().replaceAll("\u2212", "-").replace(",", ".");
  const words = [unit, unitText(unit)].filter((word) => word && plain.endsWith(word));
  const bare = words.length ? plain.slice(0, -words[0].length).trim() : plain;
  return bare === "" ? NaN : Number(bare);
}

/** A row of the panel; `deeds` are what its parts do: `move`, `done`, `refuse` and `lock`. */
export class Parameter {
  constructor(control, lockable, deeds) {
    this.control = control;
    this.deeds = deeds;
    this.wrong = null;
    const { name, symbol, unit, path, meaning } = control;
    const id = `p-${path.replace(/\W/g, "-")}`;
    this.field = Object.assign(document.createElement("input"), { type: "text", className: "value", inputMode: "decimal", id, autocomplete: "off", spellcheck: false });
    this.slider = Object.assign(document.createElement("input"), { type: "range", ariaLabel: `${name}, slider` });
    const label = Object.assign(element("label", "name", name), { htmlFor: id, title: `${path}${meaning ? `: ${meaning}` : ""}` });
    if (symbol) label.append(" ", element("i", "", symbol));
    this.low = element("span", "bound");
    this.high = element("span", "bound");
    this.mark = Object.assign(element("span", "other"), { hidden: true });
    this.restore = Object.assign(element("button", "icon restore", "\u21ba"), { type: "button" });
    this.error = Object.assign(element("p", "wrong"), { id: `${id}-error`, hidden: true });
    const box = element("span", "box", this.field, element("span", "unit", unitText(unit)));
    const track = element("span", "track", this.slider, this.mark);
    this.element = element("div", "control", label, box, this.low, track, this.high, this.restore);
    this.element.dataset.path = path;
    if (lockable) this.element.append(this.#lock());
    this.element.append(this.error);
    this.#listen();
  }

  #lock() {
    const space = "http://www.w3.org/2000/svg";
    const [svg, path] = ["svg", "path"].map((name) => document.createElementNS(space, name));
    svg.setAttribute("viewBox", "0 0 16 16");
    svg.setAttribute("aria-hidden", "true");
    svg.append(path);
    this.locker = Object.assign(element("button", "icon lock", svg), { type: "button", ariaLabel: `Lock ${this.control.name} in searches` });
    this.locker.addEventListener("click", () => this.deeds.lock(this.control.path));
    return this.locker;
  }

  #listen() {
    const { path, name, value } = this.control;
    this.slider.addEventListener("input", () => this.deeds.move(path, this.#slid()));
    this.slider.addEventListener("change", () => this.deeds.done(this.#step()));
    this.field.addEventListener("change", () => this.#typed());
    this.field.addEventListener("keydown", (event) => this.#key(event));
    this.restore.addEventListener("click", () => { this.deeds.move(path, value); this.deeds.done(`${name} reset`); });
  }

  /** The slider's place as a number of few digits, unless that is beyond an end. */
  #slid() {
    const exact = Number(this.slider.value);
    const rounded = Number(exact.toPrecision(6));
    return rounded >= this.from && rounded <= this.to ? rounded : exact;
  }

  #step() {
    return `${this.control.name} ${digits(this.value)}${unitText(this.control.unit) ? ` ${unitText(this.control.unit)}` : ""}`;
  }

  #typed() {
    const { name, unit, path } = this.control;
    const value = parseValue(this.field.value, unit);
    if (Number.isNaN(value)) { this.#refuse(`${name}: \u201c${this.field.value.slice(0, 40)}\u201d is not a number; type one such as ${digits(this.value)}`); return; }
    const [low, high] = [this.control.lower, this.control.upper];
    if (value < low || value > high) { this.#refuse(`${name} = ${digits(value)}: the value must be between ${digits(low)} and ${digits(high)} ${unitText(unit)}`.trim()); return; }
    this.#refuse(null);
    if (value === this.value) { this.field.value = this.text; return; }
    this.deeds.move(path, value);
    this.deeds.done(this.#step());
    this.field.value = this.text;
  }

  /** Say what is wrong with the text, or that nothing is; what was there before stays on the page. */
  #refuse(sentence) {
    const before = this.wrong;
    this.wrong = sentence;
    this.error.hidden = sentence === null;
    this.error.textContent = sentence ?? "";
    this.field.setAttribute("aria-invalid", sentence !== null);
    if (sentence) this.field.setAttribute("aria-describedby", this.error.id);
    else this.field.removeAttribute("aria-describedby");
    if (sentence || before) this.deeds.refuse(sentence);
  }

  #key(event) {
    if (event.key === "Escape") { this.#refuse(null); this.field.value = this.text; return; }
    if (event.key === "Enter") { this.#typed(); return; }
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!way) return;
    event.preventDefault();
    const step = (way * (this.control.upper - this.control.lower)) / (event.shiftKey ? 10 : 100);
    const value = Math.min(Math.max(this.value + step, this.from), this.to);
    this.deeds.move(this.control.path, Number(value.toPrecision(6)));
    this.field.value = this.text;
    this.deeds.done(this.#step());
  }

  /** Whether the text in the box was not taken yet. */
  get isEdited() {
    return this.field.value !== this.text;
  }

  /** Show a value within its ends, that of the other design if it differs, and whether the number is locked. */
  reflect(value, ends, other, locked) {
    const { name, value: own, unit } = this.control;
    Object.assign(this, { value, from: Math.min(ends[0], value), to: Math.max(ends[1], value), text: String(value) });
    Object.assign(this.slider, { min: this.from, max: this.to, step: (this.to - this.from) / 1000 });
    this.slider.value = value;
    this.slider.setAttribute("aria-valuetext", `${digits(value)} ${unitText(unit)}`.trim());
    if (document.activeElement !== this.field && !this.wrong) this.field.value = this.text;
    this.low.textContent = digits(this.from, 4);
    this.high.textContent = digits(this.to, 4);
    this.element.classList.toggle("moved", value !== own);
    this.restore.hidden = value === own;
    this.restore.ariaLabel = this.restore.title = `Reset ${name} to ${digits(own)}`;
    this.mark.hidden = other === undefined || other === value;
    const share = (Math.min(Math.max(other, this.from), this.to) - this.from) / (this.to - this.from);
    if (!this.mark.hidden) this.mark.style.left = `calc(8px + ${share} * (100% - 16px))`;
    this.locker?.setAttribute("aria-pressed", locked);
    this.locker?.querySelector("path").setAttribute("d", LOCK[locked]);
  }

  /** Drop a text that was refused. */
  clear() {
    this.#refuse(null);
    this.field.value = this.text;
  }

  /** Whether the name, the symbol or the key has a text. */
  matches(text) {
    const { name, symbol, path } = this.control;
    return `${name} ${symbol} ${path}`.toLowerCase().includes(text.toLowerCase());
  }
}
