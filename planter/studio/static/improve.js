// A descent inside a box: quasi-Newton steps by the gradient (BFGS), cut off at the bounds. What is made small may have
// corners, where it ends early: what it finds is better than the start, and no optimum is claimed.

const MOST = 400; // steps
const LEAST = 1e-12; // a step of this length, in parts of the box, goes nowhere
const ENOUGH = 1e-4; // share of the promised descent that a step must bring

const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
const identity = (n) => Array.from({ length: n }, (_, i) => Array.from({ length: n }, (_, j) => Number(i === j)));

/** From `start` to something better, both within `lower` and `upper`; `evaluate` gives a value and its gradient, or null. */
export function improve(evaluate, start, lower, upper) {
  const width = start.map((_, k) => upper[k] - lower[k] || 1);
  const at = (u) => {
    const found = evaluate(u.map((share, k) => lower[k] + share * width[k]));
    return found && { u, value: found.value, slope: found.gradient.map((rate, k) => rate * width[k]) };
  };
  let here = at(start.map((value, k) => (value - lower[k]) / width[k]));
  const first = here?.value;
  let inverse = null;
  for (let step = 0; here && step < MOST; step++) {
    const fresh = inverse === null;
    inverse ??= identity(start.length);
    const next = line(at, here, direction(here, inverse), fresh);
    if (next === null && fresh) break;
    if (next === null) { inverse = null; continue; }
    inverse = updated(inverse, here, next);
    here = next;
  }
  return here && { values: here.u.map((share, k) => lower[k] + share * width[k]), first, value: here.value };
}

/** Downhill, and along no bound's outside. */
function direction({ u, slope }, inverse) {
  const free = u.map((share, k) => !((share <= 0 && slope[k] > 0) || (share >= 1 && slope[k] < 0)));
  const felt = slope.map((rate, k) => (free[k] ? rate : 0));
  const way = inverse.map((row, k) => (free[k] ? -dot(row, felt) : 0));
  return dot(way, felt) < 0 ? way : felt.map((rate) => -rate);
}

/** The first of ever shorter steps that goes down enough; null where none does. */
function line(at, here, way, fresh) {
  const length = Math.hypot(...way);
  for (let share = fresh ? Math.min(1, 0.1 / length) : 1; share * length > LEAST; share /= 2) {
    const next = at(here.u.map((value, k) => Math.min(1, Math.max(0, value + share * way[k]))));
    const moved = next && next.u.map((value, k) => value - here.u[k]);
    if (next && next.value <= here.value + ENOUGH * Math.min(0, dot(moved, here.slope)) && next.value < here.value) return next;
  }
  return null;
}

/** The inverse Hessian after a step, by Broyden, Fletcher, Goldfarb and Shanno; as it was where that would lose its sign. */
function updated(inverse, here, next) {
  const s = next.u.map((value, k) => value - here.u[k]);
  const y = next.slope.map((rate, k) => rate - here.slope[k]);
  const bent = dot(s, y);
  if (bent <= 1e-12 * Math.hypot(...s) * Math.hypot(...y)) return inverse;
  const moved = inverse.map((row) => dot(row, y));
  const scale = (1 + dot(y, moved) / bent) / bent;
  return inverse.map((row, i) => row.map((value, j) => value + scale * s[i] * s[j] - (moved[i] * s[j] + s[i] * moved[j]) / bent));
}
