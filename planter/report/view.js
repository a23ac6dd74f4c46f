// The drawing of a mechanism in motion. `picture` is an SVG that stands still; what moves in it carries data-body,
// data-point, data-arrow; `record` says where it is at every moment. One file for reports, notebooks and the studio.

const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2];
const LETTER = 12.5, TALLEST = 544; // size of names, and height of a drawing, in pixels
const LONGEST_BAR = 160; // of the scale, in pixels
const MOST_NAMES = 20; // bodies that are named in a drawing
const GAP = 22; // distance of names from each other, in pixels
const LETTER_SHARE = 0.62; // width of a letter over its size, on average
const MOST_CORNERS = 32, MOST_ANCHORS = 12; // of a line: corners that are looked at, and ends of leaders
const CROSSING = 1000; // what a leader costs that crosses a line, in pixels of its length
const SLANT = 0.2; // sine of the angle below which a leader runs along its own body
const FIXED = 0.1; // weight of crossing what does not move
const ELBOWS = [0, 0.15, 0.3, 0.5, 0.7, 0.85]; // where a leader bends that is not free straight on, as shares of its width
const ATTEMPTS = 4; // orders in which leaders are chosen
const SPARE = 3; // rows of a column of names beyond their number
const BEND = 40; // what a bend costs, in pixels of a leader's length
const PATIENCE = 4; // moments for which leaders that cross something stay, where there were no better ones
const ENCLOSED = 0.02; // weight of leaving an outline that encloses the beginning of a leader
const SIDES = [[1, -1], [-1, -1], [1, 1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]]; // of a point, where its name can be
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

/** Corners of a path of straight lines, in its body: absolute numbers, or steps of the size that its transform says. */
function corners(path) {
  const text = path.getAttribute("d");
  const numbers = text.match(/-?\d+(\.\d+)?/g)?.map(Number) ?? [];
  const points = [];
  for (let k = 0; k + 1 < numbers.length; k += 2) points.push([numbers[k], numbers[k + 1]]);
  if (text[0] === "m") {
    const step = Number(path.getAttribute("transform").match(/scale\((.+)\)/)[1]);
    let [x, y] = [0, 0];
    for (const point of points) {
      [x, y] = [x + point[0], y + point[1]];
      [point[0], point[1]] = [x * step, y * step];
    }
  }
  const stride = Math.ceil(points.length / MOST_CORNERS);
  const thinned = points.filter((_, k) => k % stride === 0 || k === points.length - 1);
  return /z$/i.test(text) && points.length ? [...thinned, points[0]] : thinned;
}

/** Where two segments cross, as shares of both; null if they are parallel or do not. */
function crossing([ax, ay, bx, by], [cx, cy, dx, dy]) {
  const [ux, uy, vx, vy] = [bx - ax, by - ay, dx - cx, dy - cy];
  const area = ux * vy - uy * vx;
  if (area === 0) return null;
  const first = ((cx - ax) * vy - (cy - ay) * vx) / area;
  const second = ((cx - ax) * uy - (cy - ay) * ux) / area;
  return first >= 0 && first <= 1 && second >= 0 && second <= 1 ? first : null;
}

/** A line where it is drawn, downwards as a picture, with the box around it. */
function outline(owner, weight, places) {
  const points = places.map(([x, y]) => [x, -y]);
  const [xs, ys] = [0, 1].map((axis) => points.map((point) => point[axis]));
  const [start, end] = [points[0], points.at(-1)];
  const closed = points.length > 2 && start[0] === end[0] && start[1] === end[1];
  return { owner, weight, points, closed, left: Math.min(...xs), right: Math.max(...xs), top: Math.min(...ys), bottom: Math.max(...ys) };
}

/** How often a piece from one point to another crosses a line; where it `begins` on it, that counts only along the line. */
function crossings([ax, ay], [bx, by], line, begins) {
  if (line.right < ax || line.left > bx || line.bottom < Math.min(ay, by) || line.top > Math.max(ay, by)) return 0;
  const [ux, uy] = [bx - ax, by - ay];
  let count = 0;
  for (let k = 1; k < line.points.length; k++) {
    const [cx, cy] = line.points[k - 1];
    const [vx, vy] = [line.points[k][0] - cx, line.points[k][1] - cy];
    const area = ux * vy - uy * vx;
    const first = ((cx - ax) * vy - (cy - ay) * vx) / area;
    const second = ((cx - ax) * uy - (cy - ay) * ux) / area;
    if (!(first > (begins ? -1e-9 : -1e-3) && first <= 1 && second >= 0 && second < 1)) continue;
    if (!begins || first > 1e-3 || Math.abs(area) < SLANT * Math.hypot(ux, uy) * Math.hypot(vx, vy)) count++;
  }
  return count;
}

/** The straight pieces of a line. */
const pieces = (points) => points.slice(1).map(([x, y], k) => [...points[k], x, y]);

/** Whether two lines cross. */
const meet = (one, two) => pieces(one).some((piece) => pieces(two).some((other) => crossing(piece, other) !== null));

/** The corners of the frame of a text of a drawing. */
function frame(text) {
  const [x, y] = text.getAttribute("transform").match(/-?\d+(\.\d+)?/g).map(Number);
  const size = Number(text.getAttribute("font-size"));
  const width = LETTER_SHARE * size * text.textContent.length;
  const left = x - { start: 0, middle: 0.5, end: 1 }[text.getAttribute("text-anchor")] * width;
  return [[left, y], [left + width, y], [left + width, y + size], [left, y + size], [left, y]];
}

/** One choice of each row of a table, in an order: first each beside those before it, then in turn as long as that is better. */
function arranged(table, given, order) {
  const chosen = [...given];
  const cost = (k, choice) => chosen.reduce((sum, other, m) => {
    if (other === null || m === k) return sum;
    return sum + (other.slot === choice.slot ? Infinity : 0) + (meet(choice.leader, other.leader) ? CROSSING : 0);
  }, choice.cost);
  const settle = (k) => {
    const before = chosen[k];
    for (const choice of table[k]) if (chosen[k] === null || cost(k, choice) < cost(k, chosen[k])) chosen[k] = choice;
    return chosen[k] !== before;
  };
  const exchange = (k, m) => {
    const [mine, other] = [chosen[k], chosen[m]];
    const before = cost(k, mine) + cost(m, other);
    [chosen[k], chosen[m]] = [table[k][other.slot], table[m][mine.slot]];
    if (cost(k, chosen[k]) + cost(m, chosen[m]) < before - 1e-9) return true;
    [chosen[k], chosen[m]] = [mine, other];
    return false;
  };
  order.forEach(settle);
  for (let round = 0, better = true; better && round < order.length; round++) {
    better = order.map(settle).some(Boolean);
    for (const k of order) for (const m of order) if (m < k && exchange(k, m)) better = true;
  }
  return chosen;
}

/** Names of bodies in a column beside a drawing, each with a leader, and of points next to them. */
class Labels {
  constructor({ motion, bodies, chains, points, machine }) {
    this.motion = motion;
    this.kept = null;
    this.lines = []; // of what is drawn: which name it belongs to, its corners, and where they are at a moment
    this.bodies = [];
    const title = (element) => element.querySelector(":scope > title")?.textContent;
    const number = (name) => {
      const known = this.bodies.findIndex((body) => body.name === name);
      if (known >= 0 || this.bodies.length === MOST_NAMES) return known;
      return this.bodies.push({ name }) - 1;
    };
    bodies.forEach((body) => {
      const paths = Array.from(body.querySelectorAll(":scope > path:not(.teeth, .before, .mark, .soil)"));
      const owner = paths.length && title(body) ? number(title(body)) : -1;
      const pose = [];
      for (let part = body; part; part = part.parentElement.closest("[data-body]")) pose.push(motion.bodies[part.dataset.body]);
      paths.forEach((path) => {
        const own = corners(path);
        const weight = path.classList.contains("ground") ? FIXED : 1;
        this.lines.push({ owner, weight, at: (i) => own.map((point) => pose.reduce((place, channels) => moved(place, channels, i), point)) });
      });
    });
    chains.forEach((chain, k) => {
      const { points: joints, closed } = motion.chains[k];
      const owner = title(chain) ? number(title(chain)) : -1;
      const numbers = closed ? [...joints, joints[0]] : joints;
      this.lines.push({ owner, weight: 1, at: (i) => numbers.map((joint) => motion.points[joint].map((channel) => channel(i))) });
    });
    for (const text of machine.querySelectorAll(":scope > text")) {
      this.lines.push({ owner: -1, weight: 1, at: () => frame(text) });
    }
    this.points = [];
    points.forEach((point, k) => {
      const [x, y] = motion.points[k];
      const size = Number(point.getAttribute("r"));
      const around = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]];
      this.lines.push({ owner: -1, weight: FIXED, at: (i) => around.map(([right, up]) => [x(i) + right * size, y(i) + up * size]) });
      const place = JSON.stringify(motion.record.points[k]);
      const known = this.points.find((other) => other.place === place);
      if (known) known.name += `, ${title(point)}`;
      else if (title(point)) this.points.push({ name: title(point), number: k, place, at: motion.points[k] });
    });
  }

  /** Begin with the leaders of a drawing of the same machine. */
  keep(before) {
    const names = ({ bodies }) => bodies.map(({ name }) => name).join("\n");
    if (before && names(before) === names(this)) Object.assign(this, { kept: before.kept, accepted: before.accepted, tried: before.tried });
  }

  get any() {
    return this.bodies.length + this.points.length > 0;
  }

  /** The texts and leaders, where letters have a `size`; names are in a column that begins at `right`. */
  build(size, left, right, top, height) {
    Object.assign(this, { size, right });
    const gap = (GAP / LETTER) * size;
    this.levels = Array.from({ length: Math.floor(height / gap + 1e-9) }, (_, k) => top + (k + 0.5) * gap);
    this.bounds = [left, top, top + height];
    const text = ({ name }) => make("text", { "font-size": size, class: "name" }, name);
    this.texts = this.bodies.map(text);
    this.leaders = this.bodies.map(() => make("path", { class: "leader" }));
    this.point_texts = this.points.map(text);
    this.sides = this.points.map(() => 0);
    return make("g", { class: "names" }, ...this.leaders, ...this.texts, ...this.point_texts);
  }

  /** Put everything where it belongs at a moment; what need not move stays. */
  place(moment) {
    this.drawn = this.lines.map(({ owner, weight, at }) => outline(owner, weight, at(moment)));
    this.anchors = this.bodies.map((_, owner) => this.drawn.filter((line) => line.owner === owner).flatMap(({ points }) => spread(points)));
    this.kept = this.#settled(moment);
    const leaders = this.kept.map(({ leader }) => leader);
    leaders.forEach((points, k) => {
      this.leaders[k].setAttribute("d", `M${points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join(" ")}`);
      this.texts[k].setAttribute("x", this.right);
      this.texts[k].setAttribute("y", points.at(-1)[1] + this.size / 3);
    });
    this.#place_points(moment, leaders.flatMap(pieces));
  }

  /** The leaders as they were if they still are free; else others where they are not; else all of them anew. */
  #settled(moment) {
    if (this.kept) {
      const kept = this.kept.map((choice, k) => this.#choice(k, choice.anchor, choice.slot, choice.elbow));
      const clashes = this.#clashes(kept);
      const recent = Math.abs(moment - this.tried) < PATIENCE;
      const good = (flags) => flags.filter(Boolean).length <= (recent ? this.accepted : 0);
      if (good(clashes)) return kept;
      const mended = this.#choose(kept.map((choice, k) => (clashes[k] ? null : choice)));
      if (good(this.#clashes(mended))) return mended;
    }
    const chosen = this.#choose(this.bodies.map(() => null));
    this.tried = moment;
    this.accepted = this.#clashes(chosen).filter(Boolean).length;
    return chosen;
  }

  /** Which leaders cross something, or each other. */
  #clashes(choices) {
    return choices.map((choice, k) => choice.count >= 1 || choices.some((other, m) => m !== k && meet(choice.leader, other.leader)));
  }

  /** A leader with what it costs: from a body, straight or by an elbow at the height of the name, to the column. */
  #choice(k, anchor, slot, elbow, limit = Infinity) {
    const [start, end] = [this.anchors[k][anchor], [this.right - this.size / 2, this.levels[slot]]];
    const leader = elbow === null ? [start, end] : [start, [start[0] + elbow * (end[0] - start[0]), end[1]], end];
    let cost = elbow === null ? 0 : BEND;
    for (let m = 1; m < leader.length; m++) cost += (LETTER / this.size) * Math.hypot(leader[m][0] - leader[m - 1][0], leader[m][1] - leader[m - 1][1]);
    const count = cost < limit ? this.#count(k, leader, (limit - cost) / CROSSING) : Infinity;
    return { cost: cost + CROSSING * count, count, anchor, slot, elbow, leader };
  }

  /** How many lines a leader crosses, by their weights; leaving what encloses its beginning hardly counts. */
  #count(k, leader, limit) {
    let total = 0;
    for (const line of this.drawn) {
      let count = 0;
      for (let m = 1; m < leader.length; m++) count += crossings(leader[m - 1], leader[m], line, m === 1 && line.owner === k);
      if (line.closed && line.owner !== k && count % 2) total += ENCLOSED + (count - 1) * line.weight;
      else total += count * line.weight;
      if (total > limit) return Infinity;
    }
    return total;
  }

  /** Choices of all leaders: those that are given, and the others, the most constrained ones first. */
  #choose(given) {
    const best = (k, slot) => {
      let found = { cost: Infinity };
      const attempt = (elbow) => this.anchors[k].forEach((_, anchor) => {
        const choice = this.#choice(k, anchor, slot, elbow, found.cost);
        if (choice.cost < found.cost) found = choice;
      });
      attempt(null);
      for (const elbow of ELBOWS) if (found.cost > CROSSING) attempt(elbow);
      return found;
    };
    const table = given.map((choice, k) => (choice ? [choice] : this.levels.map((_, slot) => best(k, slot))));
    const free = table.map((row) => row.filter(({ cost }) => cost < CROSSING).length);
    const order = table.map((_, k) => k).filter((k) => given[k] === null).sort((one, two) => free[one] - free[two]);
    let best_found = null;
    for (let round = 0; round < ATTEMPTS; round++) {
      const chosen = arranged(table, given, order);
      const clashes = this.#clashes(chosen);
      const count = clashes.filter(Boolean).length;
      if (best_found === null || count < best_found.count) best_found = { chosen, count };
      if (count === 0 || !order.some((k) => clashes[k])) break;
      order.sort((one, two) => clashes[two] - clashes[one]); // those that found no free way go first
    }
    return best_found.chosen;
  }

  /** Names of points on that side of them where they cover least. */
  #place_points(moment, leaders) {
    const { size } = this;
    const placed = [];
    const marks = this.points.map(({ at }) => [at[0](moment), -at[1](moment)]);
    this.points.forEach(({ name }, k) => {
      const [width, [x, y]] = [LETTER_SHARE * name.length * size, marks[k]];
      const box = ([right, down]) => {
        const [cx, cy] = [x + right * (width / 2 + 0.6 * size), y + down * (right ? 0.7 : 1.1) * size];
        return [cx - width / 2, cy - size / 2, cx + width / 2, cy + size / 2];
      };
      const cost = (side) => {
        const [left, top, right, bottom] = box(SIDES[side]);
        const inside = (px, py) => px > left && px < right && py > top && py < bottom;
        const covers = (line) => inside(line[0], line[1]) || crossing(line, [left, top, right, bottom]) !== null || crossing(line, [left, bottom, right, top]) !== null;
        const texts = placed.filter((other) => other[0] < right && other[2] > left && other[1] < bottom && other[3] > top).length;
        const outside = left < this.bounds[0] || top < this.bounds[1] || bottom > this.bounds[2] || right > this.right ? 10 : 0;
        return this.drawn.filter(({ points }) => pieces(points).some(covers)).length + 3 * leaders.filter(covers).length + 20 * texts + 2 * marks.filter(([px, py]) => inside(px, py)).length + outside;
      };
      const costs = SIDES.map((_, side) => cost(side));
      const best = costs.indexOf(Math.min(...costs));
      if (costs[this.sides[k]] > costs[best]) this.sides[k] = best;
      const found = box(SIDES[this.sides[k]]);
      placed.push(found);
      this.point_texts[k].setAttribute("x", found[0].toFixed(2));
      this.point_texts[k].setAttribute("y", (found[3] - size / 6).toFixed(2));
    });
  }
}

/** A point of a body where its parent, or the machine, has it at a moment. */
function moved([x, y], channels, moment) {
  const [px, py, turn, along, up] = channels.map((channel) => channel(moment));
  const [cos, sin] = [Math.cos((turn * Math.PI) / 180), Math.sin((turn * Math.PI) / 180)];
  return [px + cos * along * x - sin * up * y, py + sin * along * x + cos * up * y];
}

/** Places on a line where leaders can end: shares of its pieces, or its corners if it has many. */
function spread(points) {
  const pieces = points.slice(1).map((end, k) => [points[k], end]);
  if (pieces.length > MOST_ANCHORS) return points.filter((_, k) => k % Math.ceil(points.length / MOST_ANCHORS) === 0);
  const shares = [0.5, 0.25, 0.75].slice(0, Math.max(1, Math.floor(MOST_ANCHORS / pieces.length)));
  return pieces.flatMap(([[ax, ay], [bx, by]]) => shares.map((share) => [ax + share * (bx - ax), ay + share * (by - ay)]));
}

/** The mechanism itself: an SVG whose parts are set to a moment. */
class Mechanism {
  /** `room` is the largest width and height of the drawing in pixels; without it, nothing is named. `before` is the drawing that this one follows. */
  constructor(svg, motion, room, before = null) {
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
    if (!room) return;
    this.#name(before);
    this.#bar();
  }

  /** Names of bodies beside the drawing and of points in it; the letters have the same size in every drawing. */
  #name(before) {
    const [left, top, width, height] = this.svg.dataset.near.split(" ").map(Number);
    this.labels = new Labels(this);
    this.labels.keep(before?.labels);
    const longest = Math.max(0, ...this.labels.bodies.map(({ name }) => name.length));
    const column = longest ? (LETTER_SHARE * longest + 3) * LETTER : 0;
    const scale = Math.min(Math.max(this.room.width - column, 0.4 * this.room.width) / width, (this.room.height - 3.6 * GAP - 2 * LETTER) / height);
    this.size = LETTER / scale;
    for (const text of this.machine.querySelectorAll(":scope > text")) {
      text.setAttribute("font-size", this.size);
      const [[start, bottom], [end]] = frame(text);
      const x = Math.max(start, left) + { start: 0, middle: 0.5, end: 1 }[text.getAttribute("text-anchor")] * (end - start);
      text.setAttribute("transform", `translate(${x.toFixed(3)} ${bottom.toFixed(3)}) scale(1 -1)`);
    }
    const above = this.labels.bodies.length ? GAP / scale : 0; // for leaders over all bodies, and below them
    const tall = Math.max(height + 3.6 * above, ((this.labels.bodies.length + SPARE) * above) || 0);
    this.near_box = [left, top - above, width + column / scale, tall + 2 * this.size];
    this.names = this.labels.build(this.size, left, left + width + 1.5 * this.size, top - above, tall);
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
    this.svg.append(make("g", { class: "bar" }, bar, text, ...this.#travel(x + longest + 2 * this.size, y)));
  }

  /** An arrow in the direction of travel with its speed, if there is one, beside the scale. */
  #travel(x, y) {
    const { travel, share, record } = this.motion;
    const last = this.motion.moments - 1;
    const speed = (travel(last) - travel(0)) / (1000 * record.seconds * (share(last) - share(0)));
    if (!speed) return [];
    const size = this.size;
    const [start, end] = speed > 0 ? [x, x + 3 * size] : [x + 3 * size, x];
    const back = end - 0.6 * size * Math.sign(speed);
    const d = `M${start} ${y}H${end}M${back} ${y - 0.3 * size} ${end} ${y} ${back} ${y + 0.3 * size}`;
    const text = make("text", { x: x + 3.6 * size, y: y + size / 3, "font-size": size }, `travel ${Number(Math.abs(speed).toPrecision(4))} m/s`);
    return [make("path", { class: "scale", d }), text];
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
    this.svg.classList.toggle("over-ground", overGround);
    this.#box();
    this.names.style.display = overGround || this.named_shown === false ? "none" : "";
    if (this.ground) this.ground.style.display = overGround ? "" : "none";
    this.traces.forEach((trace, k) => trace.setAttribute("d", overGround ? this.#path(k, this.motion.travel) : this.near[k]));
  }

  show(moment) {
    const { bodies, chains, points, forces, travel } = this.motion;
    this.bodies.forEach((body, k) => {
      const [x, y, turn, ...scale] = bodies[k].map((channel) => channel(moment));
      body.setAttribute("transform", `translate(${x.toFixed(3)} ${y.toFixed(3)}) rotate(${turn.toFixed(3)}) scale(${scale.map((factor) => factor.toPrecision(6)).join(" ")})`);
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
    this.labels?.place(moment);
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
    this.mechanism = new Mechanism(svg, this.motion, null);
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
    this.mechanism = new Mechanism(svg, this.motion, this.room, this.mechanism);
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
    for (const { name, number } of this.#traceable()) {
      const trace = this.mechanism.traces[number];
      add(`path of ${name}`, trace.getAttribute("visibility") !== "hidden", (on) => this.mechanism.traces[number].setAttribute("visibility", on ? "visible" : "hidden"));
    }
    if (this.mechanism.arrows.length) {
      add(`forces, the longest ${digits(this.motion.record.largest_N)} N`, false, (on) => this.mechanism.arrows.forEach((arrow) => arrow.setAttribute("visibility", on ? "visible" : "hidden")));
      this.chosen.at(-1).apply();
    }
    const teeth = add("teeth", true, (on) => {
      this.mechanism.svg.classList.toggle("toothed", this.mechanism.cut && on);
      if (this.mechanism.cut) teeth.hidden = false;
    });
    teeth.hidden = !this.mechanism.cut;
    if (this.mechanism.labels.any) add("names", true, (on) => this.mechanism.label(on));
    if (this.motion.record.travel) add("over the ground", false, (on) => this.mechanism.look(on));
    row.hidden = this.chosen.length === 1 && teeth.hidden;
    return row;
  }

  /** The points that move, those of bodies without a point of the ground first: the others run on simple curves. */
  #traceable() {
    const { points, chains, moments } = this.motion;
    const rests = (number) => points[number].every((channel) => {
      for (let i = 1; i < moments; i++) if (channel(i) !== channel(0)) return false;
      return true;
    });
    const guided = ({ number }) => chains.some((chain) => chain.points.includes(number) && chain.points.some(rests));
    const moving = this.mechanism.labels.points.filter(({ number }) => !rests(number));
    return [...moving.filter((point) => !guided(point)), ...moving.filter(guided)];
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
