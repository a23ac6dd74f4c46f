/* $headline, as a unit for co-simulation (FMI): see ../modelDescription.xml.
 *
 * Written by planter $version; do not edit. The carrier's speed is prescribed; over a step it is constant.
 */
#include "$name.c"

#define TOKEN "TOKEN_OF_THIS"

enum { SPEED = $speed, OTHERS = ${NAME}_MACHINE - 1 };
enum { SET = 2 + ${NAME}_PARAMETERS + OTHERS, OUTPUTS = 1 + ${NAME}_QUANTITIES };

/* Speed and first angle of the carrier, design, data of the machine but its speed. */
static const double starts[SET] = {$starts};
static const char *const names[SET] = {$names};

typedef ${name}_memory memory;

static double rate(const double *values) { return values[0]; }

static int evaluate(memory *m, const double *values, double turned, double *outputs)
{
  const double *design = values + 2, *others = design + ${NAME}_PARAMETERS;
  double machine[${NAME}_MACHINE];
  for (int i = 0; i < ${NAME}_MACHINE; ++i) machine[i] = i == SPEED ? values[0] : others[i - (i > SPEED)];
  outputs[0] = values[1] + turned;
  return ${name}_quantities(m, design, machine, 1, outputs, outputs + 1);
}

#include "interface.c"
