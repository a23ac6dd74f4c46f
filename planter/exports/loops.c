/* Closed loops: coordinates followed from the assembly at 0 over a turn, by a secant predictor and Newton's method; a step
 * that does not close is halved, and where the least step does not close either there is a dead point. Anywhere else
 * they are closed from the places that were found.
 *
 * A course holds the sense of each loop that closes alone, what coordinates gain in a turn, and PLACES places. */
enum { COORDINATES = $coordinates, LOOP_COUNT = $loops, PLACES = $places };
enum { COURSE = LOOP_COUNT + (1 + PLACES) * COORDINATES };
static const double FULL_TURN = $turn, LARGEST_STEP = $largest_step, LEAST_STEP = $least_step;
static const int is_angle[COORDINATES] = {$angular};

/* Coordinates at an angle from near ones; 0 where the loops do not close, or a Jacobian on the way is singular. */
static int close_loops(double phi, const double *d, double *q, double *senses)
{
  for (int i = 0; i < $most_iterations; ++i) {
    double next[COORDINATES], step, pivot;
    newton(1, &phi, d, q, next, &step, senses, &pivot);
    if (!is_finite(step) || !is_finite(pivot) || !(pivot > $singular)) return 0;
    memcpy(q, next, sizeof next);
    if (step <= $closed) return 1;
  }
  return 0;
}

/* Whether senses are those of a course: no loop has come into another assembly. */
static int is_same_assembly(const double *senses, const double *course)
{
  for (int k = 0; k < LOOP_COUNT; ++k)
    if (!(senses[k] * course[k] > 0.0)) return 0;
  return 1;
}

/* The course of a turn; a status where there is none. */
static int follow_loops(const double *d, double *course)
{
  double *gained = course + LOOP_COUNT, *places = gained + COORDINATES, q[COORDINATES], before[COORDINATES];
  double at = 0.0, at_before = 0.0, step = LARGEST_STEP;
  assemble(1, d, q);
  if (!close_loops(0.0, d, q, course)) return $not_closed;
  memcpy(places, q, sizeof q);
  memcpy(before, q, sizeof q);
  for (int i = 1; i < PLACES; ++i) {
    const double angle = FULL_TURN * i / (PLACES - 1);
    while (at < angle) {
      const double target = at + step > angle - LEAST_STEP ? angle : at + step;
      double next[COORDINATES], senses[LOOP_COUNT];
      for (int k = 0; k < COORDINATES; ++k)
        next[k] = at > at_before ? q[k] + (q[k] - before[k]) / (at - at_before) * (target - at) : q[k];
      if (close_loops(target, d, next, senses) && is_same_assembly(senses, course)) {
        memcpy(before, q, sizeof q);
        memcpy(q, next, sizeof q);
        at_before = at;
        at = target;
        step = 2.0 * step < LARGEST_STEP ? 2.0 * step : LARGEST_STEP;
      } else if ((step /= 2.0) <= LEAST_STEP) {
        return $not_closed;
      }
    }
    memcpy(places + i * COORDINATES, q, sizeof q);
  }
  for (int k = 0; k < COORDINATES; ++k) {
    const double gain = q[k] - places[k];
    gained[k] = is_angle[k] ? FULL_TURN * rint(gain / FULL_TURN) : 0.0;
    if (!(fabs(gain - gained[k]) <= $returned)) return $not_returned;
  }
  return 0;
}

/* Coordinates at any angle. */
static int place_loops(const double *d, const double *course, double phi, double *q)
{
  const double *gained = course + LOOP_COUNT, *places = gained + COORDINATES;
  const double turns = floor(phi / FULL_TURN), within = phi - FULL_TURN * turns;
  const double scaled = within / (FULL_TURN / (PLACES - 1));
  const int first = scaled < PLACES - 2 ? (int)scaled : PLACES - 2;
  double senses[LOOP_COUNT];
  for (int k = 0; k < COORDINATES; ++k) {
    const double low = places[first * COORDINATES + k], high = places[(first + 1) * COORDINATES + k];
    q[k] = low + (high - low) * (scaled - first);
  }
  if (!close_loops(within, d, q, senses) || !is_same_assembly(senses, course)) return $not_closed;
  for (int k = 0; k < COORDINATES; ++k) q[k] += gained[k] * turns;
  return 0;
}
