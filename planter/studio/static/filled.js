// A drawing with the numbers of a program: its record, and its picture changed in place.

const single = (numbers, source) => source.plus + (source.at < 0 ? 0 : numbers[source.at]);

const row = (numbers, source) => (i) => source.plus + source.sign * numbers[source.at + i];

/** What moves, as a page draws it. Sources of rows that differ by where they begin alone share a series. */
export function record(template, plan, numbers) {
  const found = structuredClone(template);
  const known = new Map();
  for (const [place, source] of plan.channels) {
    const owner = place.slice(0, -1).reduce((part, key) => part[key], found);
    owner[place.at(-1)] = "count" in source ? series(known, source) : single(numbers, source);
  }
  const { moments } = found;
  found.block = new Float32Array(known.size * moments);
  for (const { number, source } of known.values()) {
    const at = row(numbers, source);
    for (let i = 0; i < moments; i++) found.block[number * moments + i] = at(i);
  }
  found.largest_N = largest(found);
  return found;
}

function series(known, source) {
  const key = `${source.at} ${source.sign} ${source.plus}`;
  if (!known.has(key)) known.set(key, { number: known.size, source });
  return { series: known.get(key).number, ahead: source.ahead };
}

/** A channel of a record at a moment. */
function value(record, told, moment) {
  if (typeof told === "number") return told;
  return record.block[told.series * record.moments + ((moment + told.ahead) % record.moments)];
}

function largest(record) {
  let most = 0;
  for (const [, , x, y] of record.forces) {
    for (let i = 0; i < record.moments; i++) most = Math.max(most, Math.hypot(value(record, x, i), value(record, y, i)));
  }
  return most;
}

const path = (points, closed) => `M${points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join(" ")}${closed ? "Z" : ""}`;

/** Set outlines, labels, paths of points, the scale of forces and the view from the ground of a picture. */
export function fill(svg, plan, numbers, record) {
  const lines = svg.querySelectorAll("[data-ground] path, [data-body] path");
  for (const { number, closed, rows, corners } of plan.outlines) {
    const points = rows
      ? Array.from({ length: rows[0].count }, (_, i) => rows.map((source) => row(numbers, source)(i)))
      : corners.map((corner) => corner.map((source) => single(numbers, source)));
    lines[number].removeAttribute("transform");
    lines[number].setAttribute("d", path(points, closed));
  }
  const texts = svg.querySelectorAll("[data-machine] > text");
  for (const [number, x, y] of plan.labels) {
    texts[number].setAttribute("transform", `translate(${single(numbers, x)} ${single(numbers, y)}) scale(1 -1)`);
  }
  svg.querySelectorAll("[data-trace]").forEach((trace, k) => {
    const points = Array.from({ length: record.moments }, (_, i) => record.points[k].map((told) => value(record, told, i)));
    trace.setAttribute("d", path(points, plan.again));
  });
  const [left, top, width, height] = svg.dataset.near.split(" ").map(Number);
  svg.dataset.force = record.largest_N ? (plan.longest * width) / record.largest_N : 0;
  const ends = [0, record.moments - 1].map((moment) => value(record, record.travel, moment));
  svg.dataset.wide = [left + Math.min(...ends), top, width + Math.abs(ends[1] - ends[0]), height].join(" ");
}
