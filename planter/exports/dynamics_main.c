/* The motion of $name from its start, with constant inputs, by the method of Runge and Kutta in equal steps:
 *
 *     ./$name SECONDS STEP > motion.csv
 */
#include "$name.h"

#include <stdio.h>
#include <stdlib.h>

enum { N = ${NAME}_STATES };

static int advance(${name}_real t, ${name}_real step, ${name}_real *x, ${name}_real *pivot) {
  static const double shares[] = { 0.0, 0.5, 0.5, 1.0 }, weights[] = { 1.0, 2.0, 2.0, 1.0 };
  ${name}_real slope[N] = { 0 }, at[N], sum[N] = { 0 };
  int i, stage, status;
  for (stage = 0; stage < 4; ++stage) {
    ${name}_real shift = (${name}_real)shares[stage] * step;
    for (i = 0; i < N; ++i) at[i] = x[i] + shift * slope[i];
    status = ${name}_rates(t + shift, at, ${name}_u, ${name}_p, slope, pivot);
    if (status) return status;
    for (i = 0; i < N; ++i) sum[i] += (${name}_real)weights[stage] * slope[i];
  }
  for (i = 0; i < N; ++i) x[i] += step * sum[i] / 6;
  return 0;
}

int main(int argc, char **argv) {
  double seconds = argc > 1 ? atof(argv[1]) : 1.0, step = argc > 2 ? atof(argv[2]) : 1e-3;
  long count, n;
  int i, status, is_weak = 0;
  ${name}_real x[N], pivot;
  if (!(seconds > 0.0) || !(step > 0.0)) {
    fprintf(stderr, "usage: %s SECONDS STEP\n", argv[0]);
    return 2;
  }
  count = (long)(seconds / step + 0.5);
  printf("t");
  for (i = 0; i < N; ++i) {
    x[i] = ${name}_start[i];
    printf(",%s", ${name}_states[i]);
  }
  for (n = 0;; ++n) {
    printf("\n%.9g", (double)n * step);
    for (i = 0; i < N; ++i) printf(",%.9g", (double)x[i]);
    if (n == count) break;
    status = advance((${name}_real)((double)n * step), (${name}_real)step, x, &pivot);
    if (status) {
      fprintf(stderr, "\nno motion after %g s: status %d\n", (double)n * step, status);
      return 1;
    }
    if (pivot < ${name}_least_pivot && !is_weak)
      fprintf(stderr, "at %.9g s: constraints or friction determine no motion: pivot %.3g\n", (double)n * step, (double)pivot);
    is_weak = pivot < ${name}_least_pivot;
  }
  printf("\n");
  return 0;
}
