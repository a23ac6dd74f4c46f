/* A whole turn of a device in one call: what a design fixes, the force in every lane, what the objective makes of it:
 * the same sums as `planter.optimise.spread`. Stands behind weighed.c.
 *
 * A lane is an angle and a share: the force at angle i is the sum of the shares' forces in lanes i, i + angles, ...
 * Values d are the design, then the constants.
 */
#include <stdint.h>
#include <string.h>

typedef long long casadi_int;

int prologue(const double **arg, double **res, casadi_int *iw, double *w, int mem);
int tangent(const double **arg, double **res, casadi_int *iw, double *w, int mem);
void rows(long lanes, const double *phi, const double *d, const double *h, double *force);
void slopes(long lanes, const double *phi, const double *d, const double *h, const double *dh, double *force,
            double *g);

typedef struct {
  long parameters, constants, angles, shares;
  double weight_range, weight_variance;
  long newton;
  const double *phi, *c;                     /* (lanes), (constants) */
  double *d, *h, *dh, *force, *g, *weights;  /* (lanes) force and weights, (1 + parameters, lanes) g */
  const double **arg;
  double **res;
  casadi_int *iw;
  double *w;
} turn;

typedef struct {
  double objective, range, variance, mean;
} found;

/* Finite-math flags make isfinite() constant: look at the exponent. */
static int is_finite(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

/* All values d of a design, and what the angles do not change of it: h, and `along` the design its derivative. */
static int designed(const turn *t, const double *x, int along)
{
  memcpy(t->d, x, t->parameters * sizeof *x);
  memcpy(t->d + t->parameters, t->c, t->constants * sizeof *x);
  t->arg[0] = t->d;
  t->res[0] = t->h;
  t->res[1] = t->dh;
  return (along ? tangent : prologue)(t->arg, t->res, t->iw, t->w, 0);
}

static void folded(const turn *t)
{
  for (long share = 1; share < t->shares; ++share)
    for (long i = 0; i < t->angles; ++i) t->force[i] += t->force[share * t->angles + i];
}

static found summary(const turn *t, long *highest, long *lowest)
{
  const double *force = t->force;
  double sum = 0.0, squares = 0.0;
  long high = 0, low = 0;
  for (long i = 0; i < t->angles; ++i) sum += force[i];
  const double mean = sum / t->angles;
  for (long i = 0; i < t->angles; ++i) squares += (force[i] - mean) * (force[i] - mean);
  for (long i = 1; i < t->angles; ++i) {
    if (force[i] > force[high]) high = i;
    if (force[i] < force[low]) low = i;
  }
  found f = {0.0, force[high] - force[low], squares / t->angles, mean};
  f.objective = weighed(t->weight_range, t->weight_variance, t->newton, f.range, f.variance);
  *highest = high;
  *lowest = low;
  return f;
}

/* The objective and what it is made of; nonzero where a result is not finite. */
int turn_value(const turn *t, const double *x, found *f)
{
  long high, low;
  if (designed(t, x, 0)) return 1;
  rows(t->angles * t->shares, t->phi, t->d, t->h, t->force);
  folded(t);
  *f = summary(t, &high, &low);
  return !is_finite(f->objective) || !is_finite(f->mean);
}

/* The same, and the gradient (parameters) of the objective: that of the samples where the extremes stand. */
int turn_gradient(const turn *t, const double *x, found *f, double *gradient)
{
  const long lanes = t->angles * t->shares;
  long high, low;
  if (designed(t, x, 1)) return 1;
  slopes(lanes, t->phi, t->d, t->h, t->dh, t->force, t->g);
  folded(t);
  *f = summary(t, &high, &low);
  const double rate = 2.0 * weighed_rate(t->weight_variance, t->newton, f->variance) / t->angles;
  for (long i = 0; i < t->angles; ++i) t->weights[i] = rate * (t->force[i] - f->mean);
  t->weights[high] += t->weight_range;
  t->weights[low] -= t->weight_range;
  for (long share = 1; share < t->shares; ++share)
    memcpy(t->weights + share * t->angles, t->weights, t->angles * sizeof *t->weights);
  int failed = !is_finite(f->objective) || !is_finite(f->mean);
  for (long j = 0; j < t->parameters; ++j) {
    const double *row = t->g + (1 + j) * lanes;
    double sum = 0.0;
    for (long i = 0; i < lanes; ++i) sum += t->weights[i] * row[i];
    gradient[j] = sum;
    failed |= !is_finite(sum);
  }
  return failed;
}

/* Many designs (designs, parameters); the number of the first that fails, from 1, or 0. */
long turn_values(const turn *t, long designs, const double *x, found *f)
{
  for (long d = 0; d < designs; ++d)
    if (turn_value(t, x + d * t->parameters, f + d)) return d + 1;
  return 0;
}
