/* Evaluates the machine file's own design: see $name.h. */
#include <stdio.h>

#include "$name.h"

static ${name}_memory memory;

int main(void)
{
  static const char *const names[] = {$names};
  ${name}_found found;
  double gradient[${NAME}_PARAMETERS];
  ${name}_prepare(&memory);
  if (${name}_gradient(&memory, ${name}_design, ${name}_machine, &found, gradient)) {
    fputs("the support force is not finite\n", stderr);
    return 1;
  }
  printf("objective %.17g\nrange_N %.17g\nvariance_N2 %.17g\nmean_N %.17g\n", found.objective, found.range,
         found.variance, found.mean);
  for (int i = 0; i < ${NAME}_PARAMETERS; ++i) printf("gradient.%s %.17g\n", names[i], gradient[i]);
  return 0;
}
