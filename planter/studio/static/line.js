// A page without a server: what it asks is computed here. The machine stands in the page as JSON.

import { fill, record } from "./filled.js";
import { improve } from "./improve.js";
import { programs } from "./programs.js";
import { text } from "./text.js";

const digits = (value) => Number(value.toPrecision(6));

/** As the line to a server: `heard` takes what is said, `back` is called when it stands. */
export function connect({ heard, back }) {
  const machine = JSON.parse(document.getElementById("machine").textContent);
  const local = new Local(machine);
  local.begin().then(() => { back(); heard({ sources: [machine.name] }); }, (error) => heard({ error: `This browser does not run the page's functions: ${error.message}` }));
  let newest = null;
  const answered = (message) => {
    const found = local.answer(message);
    heard(found);
    newest = found.scenes ? message : null;
    if (newest) setTimeout(() => newest === message && heard(local.details(message)));
  };
  return (message) => queueMicrotask(() => answered(message));
}

/** A machine in one of its models. */
class Model {
  constructor(told, found) {
    this.told = told;
    this.seen = found[told.seen.name];
    this.descent = told.descent && found[told.descent.name];
  }

  given(program, values) {
    return program.inputs.filter(({ path }) => path in values).map(({ path, at, factor }) => [at, values[path] * factor]);
  }

  /** Scene and readings with other numbers; null where there are none. */
  shown(values) {
    if (!this.seen.run(this.given(this.told.seen, values))) return null;
    const numbers = this.seen.numbers.slice();
    const { plan, template, picture, readings } = this.told;
    const told = record(template, plan, numbers);
    const scene = { record: told, picture, fill: (svg) => fill(svg, plan, numbers, told) };
    return { scenes: [scene], refined: true, readings: readings.map((one) => ({ ...one, value: one.at === null ? null : numbers[one.at] })) };
  }

  /** The objective and its gradient per shown unit; null where there are none. */
  sloped(values) {
    const { objective, gradient, factors } = this.told.descent;
    if (!this.descent.run(this.given(this.told.descent, values))) return null;
    const slopes = factors.map((factor, k) => this.descent.numbers[gradient + k] * factor);
    return { value: this.descent.numbers[objective], gradient: slopes };
  }
}

class Local {
  constructor(machine) {
    this.machine = machine;
    this.own = Object.fromEntries(machine.controls.map((one) => [one.path, one.value]));
  }

  async begin() {
    const found = await programs(this.machine.module, this.machine.programs);
    this.models = Object.fromEntries(Object.entries(this.machine.models).map(([name, told]) => [name, new Model(told, found)]));
  }

  answer({ ask, id, values, model, title }) {
    const { name, controls, search, file } = this.machine;
    if (ask === "open") return { opened: { name, models: Object.keys(this.models), handles: [], exports: [], controls, search } };
    if (ask === "plan") return { plan: { goal: this.machine.goal, quantities: [], aims: [], starts: 1 } };
    if (ask === "file") return { file: text(file, controls, values) };
    const wrong = controls.find(({ path, lower, upper }) => !(values[path] >= lower && values[path] <= upper));
    if (wrong) return { id, error: `${wrong.name} = ${values[wrong.path]}: the value must be between ${digits(wrong.lower)} and ${digits(wrong.upper)}` };
    if (ask === "optimise") return this.#improved(this.models[model], values);
    const found = this.models[model].shown(values);
    if (found === null) return { id, error: "with these numbers there is no such machine: what is computed is not finite" };
    if (ask === "design") return { title, design: { scene: found.scenes[0], readings: found.readings, checks: null, values, model } };
    return { id, ...found };
  }

  /** What the other models say: it comes after the picture. */
  details({ id, values, model }) {
    const others = Object.entries(this.models).filter(([name]) => name !== model);
    const found = others.map(([name, other]) => ({ model: name, told: other.shown(values) })).filter(({ told }) => told);
    const beside = found.map(({ model: name, told }) => ({ model: name, readings: told.readings, course: told.scenes[0].record }));
    return { id, details: [], beside };
  }

  #improved(model, values) {
    const paths = model.told.descent.paths;
    const known = new Map(this.machine.controls.map((one) => [one.path, one]));
    const at = (design) => ({ ...values, ...Object.fromEntries(paths.map((path, k) => [path, design[k]])) });
    const ends = (key) => paths.map((path) => known.get(path)[key]);
    const found = improve((design) => model.sloped(at(design)), paths.map((path) => values[path]), ends("lower"), ends("upper"));
    if (found === null) return { work: "search", error: "from here there is no descent: what is computed is not finite" };
    const sentence = `Improved: objective ${digits(found.first)} to ${digits(found.value)}.`;
    return { searching: { goal: this.machine.goal, starts: 1 }, optimum: { values: at(found.values), sentence, met: true, objective: found.value } };
  }
}
