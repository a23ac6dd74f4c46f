/* Measures over cycles of rows of values, and their slopes in the moved values: for each row what no angle changes, the
 * quantities in all lanes, and what the measures make of these, as `planter.numerics.statistics` has them.
 *
 * A lane is a step of a side. Of a shared quantity the sides are added up, and the steps of one side are its samples; of
 * another quantity every stride-th step is a sample.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef long long casadi_int;
typedef int fixed(const double **arg, double **res, casadi_int *iw, double *w, int mem);
typedef void sampled(long lanes, const double *phi, const double *d, const double *h, const double *q, double *rows);
typedef void sloped(long lanes, const double *phi, const double *d, const double *h, const double *q, const double *dh,
                    double *rows, double *slopes);

enum { MAX, MIN, RANGE, MEAN, VARIANCE, STD, RMS };

typedef struct {
  long output, place, kind;
  double scale;
} term; /* sorted by output and place */

typedef struct {
  double high, low, mean, variance, square;
} statistics;

typedef struct {
  long values, hoisted, coordinates, lanes, sides, stride, places, guards, terms, outputs, sloped, parameters;
  double least_pivot;
  fixed *fix;                                /* d -> h and, with slopes, dh */
  sampled *sample;                           /* without slopes */
  sloped *slope;                             /* with slopes */
  const long *shared, *states;               /* (places) and (guards): 1 if it is, or 0 */
  const term *term;                          /* (terms) */
  const double *phi;                         /* (lanes) */
  statistics *statistics;                    /* (places) */
  double *q, *h, *dh;                        /* (coordinates, lanes) q */
  double *rows, *slopes, *weights;           /* (places + guards, lanes) rows, (.., parameters, lanes) slopes */
  const double **arg;
  double **res;
  casadi_int *iw;
  double *w;
} cycle;

/* Finite-math flags make isfinite() constant: look at the exponent. */
static int is_finite(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

static long count(const cycle *c, long place) { return c->lanes / (c->shared[place] ? c->sides : c->stride); }

/* Put the samples of a quantity at the begin of its row. */
static void fold(const cycle *c, long place, double *row)
{
  const long n = count(c, place);
  if (c->shared[place])
    for (long side = 1; side < c->sides; ++side)
      for (long i = 0; i < n; ++i) row[i] += row[side * n + i];
  else if (c->stride > 1)
    for (long i = 1; i < n; ++i) row[i] = row[i * c->stride];
}

/* Statistics of samples (n); nothing more than the mean if that is not finite. */
static statistics summarise(long n, const double *x)
{
  statistics s = {x[0], x[0], 0.0, 0.0, 0.0};
  double sum = 0.0, squares = 0.0;
  for (long i = 0; i < n; ++i) sum += x[i];
  s.mean = sum / n;
  if (!is_finite(s.mean)) return s;
  for (long i = 0; i < n; ++i) squares += (x[i] - s.mean) * (x[i] - s.mean);
  s.variance = squares / n;
  s.square = s.variance + s.mean * s.mean;
  for (long i = 1; i < n; ++i) {
    s.high = x[i] > s.high ? x[i] : s.high;
    s.low = x[i] < s.low ? x[i] : s.low;
  }
  return s;
}

static double measure(long kind, const statistics *s)
{
  switch (kind) {
    case MAX: return s->high;
    case MIN: return s->low;
    case RANGE: return s->high - s->low;
    case MEAN: return s->mean;
    case VARIANCE: return s->variance;
    default: return sqrt(kind == STD ? s->variance : s->square);
  }
}

static long find(long n, const double *x, double value)
{
  long i = 0;
  while (i < n - 1 && x[i] != value) ++i;
  return i;
}

/* Add scale times the derivatives of a measure in its samples (n) to weights (n). */
static void differentiate(long kind, double scale, long n, const double *x, const statistics *s, double *weights)
{
  if (kind == MAX || kind == RANGE) weights[find(n, x, s->high)] += scale;
  if (kind == MIN || kind == RANGE) weights[find(n, x, s->low)] += kind == MIN ? scale : -scale;
  if (kind <= RANGE) return;
  const double origin = kind == RMS ? 0.0 : s->mean, size = n * measure(kind, s);
  const double rate = kind == VARIANCE ? 2.0 * scale / n : size > 0.0 ? scale / size : 0.0, step = scale / n;
  if (kind == MEAN)
    for (long i = 0; i < n; ++i) weights[i] += step;
  else
    for (long i = 0; i < n; ++i) weights[i] += rate * (x[i] - origin);
}

/* Add to a gradient (parameters) what weights (n) of a quantity's samples make of its slopes. */
static void weigh(const cycle *c, long place, double *gradient)
{
  const long n = count(c, place), sides = c->shared[place] ? c->sides : 1, stride = c->shared[place] ? 1 : c->stride;
  for (long j = 0; j < c->parameters; ++j) {
    double sum = 0.0;
    for (long side = 0; side < sides; ++side) {
      const double *slope = c->slopes + (place * c->parameters + j) * c->lanes + side * n;
      if (stride == 1)
        for (long i = 0; i < n; ++i) sum += c->weights[i] * slope[i];
      else
        for (long i = 0; i < n; ++i) sum += c->weights[i] * slope[i * stride];
    }
    gradient[j] += sum;
  }
}

static int are_finite(long n, const double *x)
{
  double sum = 0.0;
  for (long i = 0; i < n; ++i) sum += x[i];
  return is_finite(sum);
}

/* Whether a guard of forces has the sign of determined ones in all lanes. */
static int is_guarded(const cycle *c, long guard, const double *row)
{
  if (!are_finite(c->lanes, row)) return 0;
  for (long i = 0; i < c->lanes; ++i)
    if (c->states[guard] ? row[i] == 0.0 : row[i] < c->least_pivot) return 0;
  return 1;
}

/* Whether the quantities of a row have numbers in all lanes, and its forces are determined. */
static int evaluate(const cycle *c, const double *d)
{
  c->arg[0] = d;
  c->res[0] = c->h;
  c->res[1] = c->dh;
  if (c->fix(c->arg, c->res, c->iw, c->w, 0)) return 0;
  if (!are_finite(c->hoisted, c->h)) return 0;
  if (c->slope) c->slope(c->lanes, c->phi, d, c->h, c->q, c->dh, c->rows, c->slopes);
  else c->sample(c->lanes, c->phi, d, c->h, c->q, c->rows);
  for (long guard = 0; guard < c->guards; ++guard)
    if (!is_guarded(c, guard, c->rows + (c->places + guard) * c->lanes)) return 0;
  for (long place = 0; place < c->places; ++place) {
    double *row = c->rows + place * c->lanes;
    fold(c, place, row);
    c->statistics[place] = summarise(count(c, place), row);
    if (!is_finite(c->statistics[place].mean)) return 0;
  }
  return 1;
}

/* What the terms make of the samples of a row and of their slopes. */
static void reduce(const cycle *c, double *outputs, double *gradients)
{
  memset(outputs, 0, c->outputs * sizeof *outputs);
  memset(gradients, 0, c->sloped * c->parameters * sizeof *gradients);
  for (const term *t = c->term, *end = t + c->terms; t < end; ++t) {
    const statistics *s = c->statistics + t->place;
    const long n = count(c, t->place);
    outputs[t->output] += t->scale * measure(t->kind, s);
    if (t->output >= c->sloped) continue;
    if (t == c->term || t[-1].output != t->output || t[-1].place != t->place) memset(c->weights, 0, n * sizeof *c->weights);
    differentiate(t->kind, t->scale, n, c->rows + t->place * c->lanes, s, c->weights);
    if (t + 1 == end || t[1].output != t->output || t[1].place != t->place)
      weigh(c, t->place, gradients + t->output * c->parameters);
  }
}

/* Outputs (rows, outputs) and gradients (rows, sloped, parameters) of the first of them, of the machines at `index` among
 * values d (width, values) with coordinates (coordinates, lanes, width). A row has `failed` by 1 if it has no cycle, by 2
 * if a slope is not finite. Returns how many rows have failed.
 */
long cycles(const cycle *c, long rows, const long *index, long width, const double *d, const double *coordinates,
            double *outputs, double *gradients, unsigned char *failed)
{
  const long size = c->sloped * c->parameters;
  long failures = 0;
  for (long row = 0; row < rows; ++row) {
    for (long i = 0; i < c->coordinates * c->lanes; ++i) c->q[i] = coordinates[i * width + index[row]];
    failed[row] = !evaluate(c, d + index[row] * c->values);
    if (!failed[row]) reduce(c, outputs, gradients);
    for (long i = 0; i < size && !failed[row]; ++i)
      if (!is_finite(gradients[i])) failed[row] = 2;
    failures += failed[row] != 0;
    outputs += c->outputs;
    gradients += size;
  }
  return failures;
}
