/* Evaluates the machine file's own design: see wang2017.h.
 *
 *     ./wang2017          objective and gradient
 *     ./wang2017 turn     all quantities over a turn, as CSV
 */
#include <stdio.h>
#include <string.h>

#include "wang2017.h"

static wang2017_memory memory;

static int objective(void)
{
  static const char *const names[] = {"theta_deg", "gamma_deg", "alpha3_deg", "beta6_deg", "R3_mm", "e3_mm", "m31", "A6_mm", "k6", "m61"};
  wang2017_found found;
  double gradient[WANG2017_PARAMETERS];
  if (wang2017_gradient(&memory, wang2017_design, wang2017_machine, &found, gradient)) {
    fputs("the support force is not finite\n", stderr);
    return 1;
  }
  printf("objective %.17g\nrange_N %.17g\nvariance_N2 %.17g\nmean_N %.17g\n", found.objective, found.range,
         found.variance, found.mean);
  for (int i = 0; i < WANG2017_PARAMETERS; ++i) printf("gradient.%s %.17g\n", names[i], gradient[i]);
  return 0;
}

static int quantities(void)
{
  static double phi[WANG2017_SAMPLES], q[WANG2017_QUANTITIES * WANG2017_SAMPLES];
  for (int i = 0; i < WANG2017_SAMPLES; ++i) phi[i] = 6.283185307179586 * i / WANG2017_SAMPLES;
  if (wang2017_quantities(&memory, wang2017_design, wang2017_machine, WANG2017_SAMPLES, phi, q)) {
    fputs("a quantity is not finite\n", stderr);
    return 1;
  }
  printf("phi");
  for (int k = 0; k < WANG2017_QUANTITIES; ++k) printf(",%s", wang2017_quantity[k]);
  for (int i = 0; i < WANG2017_SAMPLES; ++i) {
    printf("\n%.17g", phi[i]);
    for (int k = 0; k < WANG2017_QUANTITIES; ++k) printf(",%.17g", q[k * WANG2017_SAMPLES + i]);
  }
  printf("\n");
  return 0;
}

int main(int count, char **arguments)
{
  wang2017_prepare(&memory);
  if (count == 1) return objective();
  if (count == 2 && strcmp(arguments[1], "turn") == 0) return quantities();
  fputs("usage: wang2017 [turn]\n", stderr);
  return 2;
}
