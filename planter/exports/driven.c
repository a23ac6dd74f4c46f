/* $headline, as a unit for co-simulation (FMI): see ../modelDescription.xml.
 *
 * Written by planter $version; do not edit. The drive's speed is prescribed; over a step it is constant.
 */
#include "$name.c"

#define TOKEN "TOKEN_OF_THIS"

/* The speed's place among design and data of the machine. */
enum { SPEED = $speed, NUMBERS = ${NAME}_PARAMETERS + ${NAME}_MACHINE };
/* What the drive has turned by is hidden. */
enum { STATES = 0, SET = 1 + NUMBERS, HIDDEN = 1, COMPUTED = 1 + ${NAME}_QUANTITIES, EVENTS = 0 };

/* Speed and first angle of the drive, then design and data of the machine but its speed. */
static const double starts[SET] = {$starts};
static const char *const names[SET] = {$names};

typedef ${name}_memory memory;

static const char *reason(memory *m, int status)
{
  (void)m;
  return ${name}_failure(status);
}

static int evaluate(memory *m, double time, const double *values, int part, double *outputs)
{
  const double *others = values + 2;
  double numbers[NUMBERS];
  (void)time, (void)part;
  for (int i = 0; i < NUMBERS; ++i) numbers[i] = i == SPEED ? values[0] : *others++;
  outputs[0] = values[1] + values[SET];
  return ${name}_quantities(m, numbers, numbers + ${NAME}_PARAMETERS, 1, outputs, outputs + 1);
}

static int advance(memory *m, double time, double step, double *values)
{
  (void)m, (void)time;
  values[SET] += values[0] * step;
  return 0;
}

#include "interface.c"
