/* Turns of many devices in one call: what design and data fix, quantities in every lane, statistics of each quantity.
 *
 * A lane is an angle and a share. Folded quantities are the sum of their shares, so that at angle i they stand in lanes
 * i, i + angles, ...; of the others every lane is a sample.
 */
#include <stdint.h>
#include <string.h>

typedef long long casadi_int;

int hoisting(const double **arg, double **res, casadi_int *iw, double *w, int mem);
void stated(long lanes, const double *phi, const double *x, const double *c, const double *h, double *rows);

typedef struct {
  long parameters, constants, angles, shares, quantities;
  const long *folded;     /* (quantities) */
  const double *phi;      /* (lanes) */
  double *h, *rows;       /* rows: (quantities, lanes) */
  const double **arg;
  double **res;
  casadi_int *iw;
  double *w;
} turns;

typedef struct {
  double max, min, mean, variance;
} found;

/* Finite-math flags make isfinite() constant: look at the exponent. */
static int is_finite(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

static found summary(const double *values, long count)
{
  double sum = 0.0, squares = 0.0, high = values[0], low = values[0];
  for (long i = 0; i < count; ++i) {
    sum += values[i];
    high = values[i] > high ? values[i] : high;
    low = values[i] < low ? values[i] : low;
  }
  const double mean = sum / count;
  for (long i = 0; i < count; ++i) squares += (values[i] - mean) * (values[i] - mean);
  const found f = {high, low, mean, squares / count};
  return f;
}

/* One turn; nonzero where a result is not finite. */
static int turned(const turns *t, const double *x, const double *c, found *f)
{
  const long lanes = t->angles * t->shares;
  int failed = 0;
  t->arg[0] = x;
  t->arg[1] = c;
  t->res[0] = t->h;
  if (hoisting(t->arg, t->res, t->iw, t->w, 0)) return 1;
  stated(lanes, t->phi, x, c, t->h, t->rows);
  for (long q = 0; q < t->quantities; ++q) {
    double *row = t->rows + q * lanes;
    for (long share = 1; t->folded[q] && share < t->shares; ++share)
      for (long i = 0; i < t->angles; ++i) row[i] += row[share * t->angles + i];
    f[q] = summary(row, t->folded[q] ? t->angles : lanes);
    failed |= !is_finite(f[q].variance) || !is_finite(f[q].max) || !is_finite(f[q].min);
  }
  return failed;
}

/* Devices (count, parameters) and (count, constants) to statistics (count, quantities); which of them failed. */
void turned_many(const turns *t, long count, const double *x, const double *c, found *f, unsigned char *failed)
{
  for (long d = 0; d < count; ++d)
    failed[d] = 0 != turned(t, x + d * t->parameters, c + d * t->constants, f + d * t->quantities);
}
