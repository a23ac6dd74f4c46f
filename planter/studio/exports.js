// What the commands write of a machine: what there is to choose from, and the files that were written.

const $ = (id) => document.getElementById(id);
const state = { exporting: null };

/** Whether anything is being written. */
export const exporting = () => state.exporting !== null;

/** What a machine offers to be written. */
export function offer(exports) {
  const boxes = exports.flatMap((one) => [choice(one), ...one.asks.map((asked) => number(one, asked))]);
  $("offered").replaceChildren(...boxes);
}

function choice(one) {
  const box = Object.assign(document.createElement("input"), { type: "checkbox", name: one.name });
  return label(box, ` ${one.name}: ${one.meaning}`);
}

function number(one, asked) {
  const field = Object.assign(document.createElement("input"), { type: "number", name: asked.option, step: "any", value: asked.value });
  field.dataset.of = one.name;
  const found = label(field, ` ${asked.meaning}`);
  found.className = "asked";
  return found;
}

function label(field, text) {
  const found = document.createElement("label");
  found.append(field, text);
  return found;
}

/** The exports that are ticked, and the numbers that they ask for. */
export function chosen() {
  const names = Array.from(document.querySelectorAll("#offered input:checked"), (box) => box.name);
  const fields = Array.from(document.querySelectorAll('#offered input[type="number"]'));
  const asked = fields.filter((field) => names.includes(field.dataset.of));
  return { names, numbers: Object.fromEntries(asked.map((field) => [field.name, field.valueAsNumber])) };
}

/** What is being written, or has been. */
export function exported(message) {
  if (message.exporting !== undefined) {
    state.exporting = message.exporting;
    $("export").textContent = message.exporting === null ? "Write" : `Cancel ${message.exporting}`;
    if (message.exporting === "") $("written").replaceChildren();
  }
  if (!message.exported) return;
  $("place").textContent = `Written to ${message.folder}`;
  $("written").append(...message.files.map(line));
}

function line({ path, bytes }) {
  const [found, link] = [document.createElement("li"), document.createElement("a")];
  Object.assign(link, { href: `exports/${path.split("/").map(encodeURIComponent).join("/")}`, target: "_blank", rel: "noopener", textContent: path });
  found.append(link, ` ${size(bytes)}`);
  return found;
}

const size = (bytes) => (bytes < 1000 ? `${bytes} B` : `${Number((bytes / 1000).toPrecision(3))} kB`);
