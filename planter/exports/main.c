/* Evaluates the machine file's own values: see $name.h.
 *
$usage
 */
#include <stdio.h>
#include <string.h>

#include "$name.h"

static ${name}_memory memory;

static int fail(int status)
{
  fprintf(stderr, "%s\n", ${name}_failure(status));
  return 1;
}

$objective
static int quantities(void)
{
  static double phi[${NAME}_SAMPLES], q[${NAME}_QUANTITIES * ${NAME}_SAMPLES];
  for (int i = 0; i < ${NAME}_SAMPLES; ++i) phi[i] = $turn * i / ${NAME}_SAMPLES;
  const int status = ${name}_quantities(&memory, ${name}_design, ${name}_machine, ${NAME}_SAMPLES, phi, q);
  if (status) return fail(status);
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
  if (count == 1) return $first();
  if (count == 2 && strcmp(arguments[1], "turn") == 0) return quantities();
  fputs("usage: $name [turn]\n", stderr);
  return 2;
}
