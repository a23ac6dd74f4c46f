// Numbers, units and tables of the studio's page.

export const digits = (value, count = 6) => (value === null || value === undefined ? "\u2013" : Number(value.toPrecision(count)).toString().replace("-", "\u2212"));

/** The name of a result without the words that it is of samples. */
export const unsampled = (name) => name.replace(/, \d+ samples$/, "");

/** A unit as it is written: exponents raised, degrees by their sign, nothing for a number without a unit. */
export function unitText(unit) {
  if (unit === "deg") return "\u00b0";
  return unit === "1" ? "" : unit.replace(/([A-Za-z])([23])/g, (_, letter, power) => letter + (power === "2" ? "\u00b2" : "\u00b3"));
}

/** A value with its unit. */
export function valueText(value, unit, count = 4) {
  const text = unitText(unit);
  return digits(value, count) + (text === "\u00b0" || text === "" ? text : ` ${text}`);
}

/** The words for limits: at least, at most, or between; empty without any. */
export function limitText({ lower, upper, unit }) {
  if (lower === null && upper === null) return "";
  if (upper === null) return `at least ${valueText(lower, unit)}`;
  return lower === null ? `at most ${valueText(upper, unit)}` : `${digits(lower, 4)} to ${valueText(upper, unit)}`;
}

/** An element with a text or children. */
export function element(name, className = "", ...children) {
  const found = document.createElement(name);
  if (className) found.className = className;
  found.append(...children);
  return found;
}

/** A row of a table: the first cell is its heading; cells are texts or elements, those of `numbers` are aligned right. */
export function row(cells, numbers = [], head = false) {
  const found = document.createElement("tr");
  cells.forEach((content, k) => {
    const heads = head ? content !== "" : k === 0;
    const cell = document.createElement(heads ? "th" : "td");
    if (heads) cell.scope = head ? "col" : "row";
    cell.append(content);
    if (numbers.includes(k)) cell.className = "number";
    found.append(cell);
  });
  return found;
}

/** A name with its unit, in smaller letters. */
export function named(name, unit) {
  const text = unitText(unit);
  const found = document.createDocumentFragment();
  found.append(name);
  if (text) found.append(" ", element("small", "", text));
  return found;
}

/** The change from A to B in percent of A. */
export function changeText(a, b) {
  if (typeof a !== "number" || typeof b !== "number" || a === 0) return "\u2013";
  const share = (100 * (b - a)) / Math.abs(a);
  if (Math.abs(share) < 0.05) return "0 %";
  return `${share > 0 ? "+" : ""}${digits(share, 2)} %`;
}

/** A table with a title, as a machine's details have it. */
export function detailTable({ title, head, rows }) {
  const found = document.createElement("table");
  found.append(element("caption", "", title), document.createElement("thead"), document.createElement("tbody"));
  const text = (value) => (typeof value === "string" ? value : digits(value));
  const numbers = (cells) => cells.flatMap((value, k) => (typeof value === "string" ? [] : [k]));
  if (head.some((name) => name)) found.tHead.append(row(head, [], true));
  found.tBodies[0].append(...rows.map((cells) => row(cells.map(text), numbers(cells))));
  return found;
}

const mark = (met) => element("span", met ? "met" : "missed", met ? "\u2713" : "\u2715", element("span", "hidden", met ? " met" : " not met"));

/** What is required of A, and of B if there is one; `jump` goes to the angle at which a requirement is tightest. */
export function requirementRows(checks, others, jump) {
  const other = new Map((others ?? []).map((one) => [one.name, one]));
  const cell = (one) => {
    if (!one) return "\u2013";
    const found = document.createDocumentFragment();
    found.append(one.value === null ? "" : `${digits(one.value, 4)} `, mark(one.met));
    return found;
  };
  const head = ["Requirement", "A", ...(others ? ["B"] : []), "Limit", "Margin of A"];
  const numbers = others ? [1, 2, 4] : [1, 3];
  const rows = checks.map((one) => {
    const title = named(one.label || one.name, one.unit);
    if (one.phi_deg === null || one.phi_deg === undefined) return [title, one];
    const button = element("button", "link", title);
    Object.assign(button, { type: "button", title: `Show at ${digits(one.phi_deg, 4)}\u00b0` });
    button.addEventListener("click", () => jump(one.phi_deg));
    return [button, one];
  });
  return {
    head: row(head, numbers, true),
    rows: rows.map(([title, one]) => row([title, cell(one), ...(others ? [cell(other.get(one.name))] : []), limitText(one) || "\u2013", digits(one.margin, 4)], numbers)),
  };
}

/** What a design fails, in sentences; the two worst ones with both numbers. */
function failures(letter, checks, jump) {
  const missed = checks.filter((one) => !one.met);
  const badge = element("span", missed.length ? "badge bad" : "badge good", `${missed.length ? "\u2715" : "\u2713"} ${letter}`);
  if (!missed.length) return element("p", "", badge, ` meets all ${checks.length} requirements.`);
  const found = element("p", "", badge, ` fails ${missed.length} of ${checks.length}: `);
  missed.slice(0, 2).forEach((one, k) => {
    const limit = limitText(one);
    const margin = `misses its limit by ${valueText(Math.abs(one.margin), one.unit, 3)}`;
    const words = one.value === null ? margin : `${valueText(one.value, one.unit, 3)}${limit ? `, required ${limit}` : ""}`;
    found.append(`${k ? "; " : ""}${one.label || one.name}: `, element("b", "", words));
    if (typeof one.phi_deg === "number") {
      const button = element("button", "link", `show at ${digits(one.phi_deg, 3)}\u00b0`);
      button.type = "button";
      button.addEventListener("click", () => jump(one.phi_deg));
      found.append(" (", button, ")");
    }
  });
  found.append(missed.length > 2 ? `; and ${missed.length - 2} more.` : ".");
  return found;
}

/** Which design is better: what each fails, and the first result of both. */
export function verdict({ checks, readings, b, jump }) {
  const found = [];
  if (checks?.length) found.push(failures("A", checks, jump));
  if (b?.checks?.length) found.push(failures("B", b.checks, jump));
  if (b && readings) {
    const other = new Map(b.readings.map((one) => [unsampled(one.name), one.value]));
    const parts = readings.slice(0, 2).filter((one) => other.has(unsampled(one.name)));
    const change = (one, value) => `${unsampled(one.name)} ${valueText(value, one.unit)} instead of ${valueText(one.value, one.unit)} (${changeText(one.value, value)})`;
    const words = parts.map((one) => change(one, other.get(unsampled(one.name))));
    if (words.length) found.push(element("p", "", element("span", "badge", "B"), ` has ${words.join("; ")}.`));
  }
  if (!found.length) found.push(element("p", "soft", checks ? "The file of this machine states no requirements." : "Being computed."));
  return found;
}
