/* $headline, as a unit for co-simulation (FMI): see ../modelDescription.xml.
 *
 * Written by planter $version; do not edit. The drive's speed is prescribed; over a step it is constant.
 */
#include "$name.c"

#define TOKEN "TOKEN_OF_THIS"

/* The speed's place among design and data of the machine. */
enum { SPEED = $speed, NUMBERS = ${NAME}_PARAMETERS + ${NAME}_MACHINE };
enum { SET = 1 + NUMBERS, OUTPUTS = 1 + ${NAME}_QUANTITIES };

/* Speed and first angle of the drive, then design and data of the machine but its speed. */
static const double starts[SET] = {$starts};
static const char *const names[SET] = {$names};

typedef ${name}_memory memory;

static double rate(const double *values) { return values[0]; }

static const char *reason(int status) { return ${name}_failure(status); }

static int evaluate(memory *m, const double *values, double turned, double *outputs)
{
  const double *others = values + 2;
  double numbers[NUMBERS];
  for (int i = 0; i < NUMBERS; ++i) numbers[i] = i == SPEED ? values[0] : *others++;
  outputs[0] = values[1] + turned;
  return ${name}_quantities(m, numbers, numbers + ${NAME}_PARAMETERS, 1, outputs, outputs + 1);
}

#include "interface.c"
