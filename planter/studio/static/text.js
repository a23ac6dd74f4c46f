// A machine's file with numbers that a hand moved, line by line as `planter` writes it.

const number = (value) => (Number.isInteger(value) ? value.toFixed(1) : String(value));

/** The file: its own lines, and for each path those that stand in the place of some where its number was moved.
 *  What goes in at one place stands there in the order of the numbers' own lines. */
export function text({ lines, edits }, controls, values) {
  const found = [...lines];
  const moved = controls.filter(({ path, value }) => values[path] !== value);
  moved.sort((a, b) => edits[b.path][0].from - edits[a.path][0].from);
  const all = moved.flatMap(({ path }) => edits[path].map((edit) => ({ ...edit, value: number(values[path]) })));
  all.sort((a, b) => b.from - a.from);
  for (const { from, to, lines: own, value } of all) found.splice(from, to - from, ...own.map((line) => line.replace("{}", value)));
  return `${found.join("\n")}\n`;
}
