/* Evaluates the machine file's own design: see $name.h.
 *
 *     ./$name          objective and gradient
 *     ./$name turn     all quantities over a turn, as CSV
 */
#include <stdio.h>
#include <string.h>

#include "$name.h"

static ${name}_memory memory;

static int objective(void)
{
  static const char *const names[] = {$names};
  ${name}_found found;
  double gradient[${NAME}_PARAMETERS];
  if (${name}_gradient(&memory, ${name}_design, ${name}_machine, &found, gradient)) {
    fputs("the support force is not finite\n", stderr);
    return 1;
  }
  printf("objective %.17g\nrange_N %.17g\nvariance_N2 %.17g\nmean_N %.17g\n", found.objective, found.range,
         found.variance, found.mean);
  for (int i = 0; i < ${NAME}_PARAMETERS; ++i) printf("gradient.%s %.17g\n", names[i], gradient[i]);
  return 0;
}

static int quantities(void)
{
  static double phi[${NAME}_SAMPLES], q[${NAME}_QUANTITIES * ${NAME}_SAMPLES];
  for (int i = 0; i < ${NAME}_SAMPLES; ++i) phi[i] = 6.283185307179586 * i / ${NAME}_SAMPLES;
  if (${name}_quantities(&memory, ${name}_design, ${name}_machine, ${NAME}_SAMPLES, phi, q)) {
    fputs("a quantity is not finite\n", stderr);
    return 1;
  }
  printf("phi");
  for (int k = 0; k < ${NAME}_QUANTITIES; ++k) printf(",%s", ${name}_quantity[k]);
  for (int i = 0; i < ${NAME}_SAMPLES; ++i) {
    printf("\n%.17g", phi[i]);
    for (int k = 0; k < ${NAME}_QUANTITIES; ++k) printf(",%.17g", q[k * ${NAME}_SAMPLES + i]);
  }
  printf("\n");
  return 0;
}

int main(int count, char **arguments)
{
  ${name}_prepare(&memory);
  if (count == 1) return objective();
  if (count == 2 && strcmp(arguments[1], "turn") == 0) return quantities();
  fputs("usage: $name [turn]\n", stderr);
  return 2;
}
