/* $headline, as a unit (FMI): see ../modelDescription.xml.
 *
 * Written by planter $version; do not edit. Inputs are constant over a step of co-simulation.
 */
#include "$name.c"

#include <stdio.h>
#include <string.h>

#define TOKEN "TOKEN_OF_THIS"

enum { N = ${NAME}_STATES, M = ${NAME}_INPUTS, Q = ${NAME}_PARAMETERS };
enum { STATES = N, SET = N + M + Q, HIDDEN = 0, COMPUTED = N + ${NAME}_OUTPUTS, EVENTS = $events };

/* States, inputs, parameters. */
static const double starts[SET] = {$starts};
static const char *const names[SET] = {$names};

/* What an outcome is of. */
typedef struct {
  double time, pivot;
  char text[160];
} memory;

enum { WEAK = -1, TOO_SHORT = 100 };

static const char *reason(memory *m, int outcome)
{
  const char *what = outcome == ${NAME}_NOT_FINITE ? "a rate or an output is not finite" : "steps become too short";
  if (outcome == WEAK)
    snprintf(m->text, sizeof m->text, "at %.9g s: constraints or friction determine no motion: pivot %.3g is below %.3g",
             m->time, m->pivot, (double)${name}_least_pivot);
  else
    snprintf(m->text, sizeof m->text, "at %.9g s: %s", m->time, what);
  return m->text;
}

static int evaluate(memory *m, double time, const double *values, int part, double *computed)
{
  const double *u = values + N, *p = values + N + M;
  double pivot;
  int failed = ${name}_rates(time, values, u, p, part == 0 ? computed : NULL, &pivot);
  if (!failed && part != 0) failed = ${name}_outputs_at(time, values, u, p, computed + N);
  m->time = time;
  m->pivot = pivot;
  return failed ? failed : pivot < ${name}_least_pivot ? WEAK : 0;
}

/* Derivatives by states, by inputs, by parameters: a block each, row by row. */
#define DIFFERENTIABLE

static int differentiate(memory *m, double time, const double *values, double *slopes)
{
  const double *u = values + N, *p = values + N + M;
  double *by_u = slopes + COMPUTED * N, *by_p = by_u + COMPUTED * M;
  const int failed = ${name}_rates_jacobian(time, values, u, p, slopes, by_u, by_p);
  m->time = time;
  if (failed) return failed;
  return ${name}_outputs_jacobian(time, values, u, p, slopes + N * N, by_u + N * M, by_p + N * Q);
}

static double find_slope(const double *slopes, int row, int column)
{
  if (column < N) return slopes[row * N + column];
  if (column < N + M) return slopes[COMPUTED * N + row * M + column - N];
  return slopes[COMPUTED * (N + M) + row * Q + column - N - M];
}

/* --- steps of co-simulation: Dormand and Prince, Journal of Computational and Applied Mathematics 6, 1980 --- */

enum { STAGES = 7 };
static const double TOLERANCE = 1e-9, SHORTEST = 1e-12;
static const double places[STAGES] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
static const double weights[STAGES][STAGES - 1] = {
  {0.0},
  {0.2},
  {3.0 / 40.0, 9.0 / 40.0},
  {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
  {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
  {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
  {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
};
/* By which the method of order 5 differs from that of order 4. */
static const double differences[STAGES] = {71.0 / 57600.0,      0.0,         -71.0 / 16695.0, 71.0 / 1920.0,
                                           -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};

/* The error of a trial over what is allowed, with the states `next` at its end and the least pivot; negative where it
 * has none. */
static double try_step(double time, double step, const double *values, double *next, memory *least)
{
  double slopes[STAGES][N], worst = 0.0;
  least->pivot = HUGE_VAL;
  for (int stage = 0; stage < STAGES; ++stage) {
    for (int i = 0; i < N; ++i) {
      next[i] = values[i];
      for (int k = 0; k < stage; ++k) next[i] += step * weights[stage][k] * slopes[k][i];
    }
    const double at = time + places[stage] * step;
    double pivot;
    if (${name}_rates(at, next, values + N, values + N + M, slopes[stage], &pivot)) return -1.0;
    if (pivot < least->pivot) least->pivot = pivot, least->time = at;
  }
  for (int i = 0; i < N; ++i) {
    double error = 0.0;
    for (int stage = 0; stage < STAGES; ++stage) error += step * differences[stage] * slopes[stage][i];
    worst = fmax(worst, fabs(error) / (TOLERANCE * (1.0 + fmax(fabs(values[i]), fabs(next[i])))));
  }
  return worst;
}

static int advance(memory *m, double time, double step, double *values)
{
  double moved[SET], next[N], size = step, done = 0.0;
  memory least;
  m->pivot = HUGE_VAL;
  memcpy(moved, values, sizeof moved);
  while (done < step) {
    const double trial = fmin(size, step - done), error = try_step(time + done, trial, moved, next, &least);
    const double growth = error < 0.0 ? 0.1 : error == 0.0 ? 5.0 : 0.9 * pow(error, -0.2);
    if (error >= 0.0 && error <= 1.0) {
      memcpy(moved, next, sizeof next);
      if (least.pivot < m->pivot) m->pivot = least.pivot, m->time = least.time;
      done = trial < step - done ? done + trial : step;
    } else if (trial < SHORTEST * step) {
      m->time = time + done;
      return error < 0.0 ? ${NAME}_NOT_FINITE : TOO_SHORT;
    }
    size = trial * fmin(5.0, fmax(0.1, growth));
  }
  memcpy(values, moved, N * sizeof *values);
  return m->pivot < ${name}_least_pivot ? WEAK : 0;
}

#include "interface.c"
