/* $headline: see $name.h.
 *
 * First what a design fixes, in CasADi's C; then all quantities, and rows of the objective with their slopes, as loops
 * over angles, each line an operation of the derived equations; then what joins them.
 */
#include "$name.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define CASADI_SYMBOL_EXPORT static
$prologue
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#undef casadi_int
#undef casadi_real

$kernels
const double ${name}_design[$design_size] = {$own};
const double ${name}_lower[$design_size] = {$lower};
const double ${name}_upper[$design_size] = {$upper};
const double ${name}_machine[$machine_size] = {$data};
const char *const ${name}_quantity[${NAME}_QUANTITIES] = {$quantity};

/* Where the design and the machine's data stand among all values. */
static const int design_places[$design_size] = {$design_places}, machine_places[$machine_size] = {$machine_places};

/* Finite-math flags make isfinite() constant: look at the exponent. */
static int is_finite(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

const char *${name}_failure(int status)
{
  static const char *const texts[] = {$failures};
  return texts[status >= 0 && status <= ${NAME}_STUCK ? status : 0];
}

$loops
$guards
/* All values, what the angles do not change of them, and with $tangent_word its derivative along the design. */
static int set_values(${name}_memory *m, const double *x, const double *machine, int tangent)
{
  double d[$values];
  for (int i = 0; i < ${NAME}_PARAMETERS; ++i) d[design_places[i]] = x[i];
  for (int i = 0; i < ${NAME}_MACHINE; ++i) d[machine_places[i]] = machine[i];
  for (int i = 0; i < $values; ++i)
    if (!is_finite(d[i])) return ${NAME}_NOT_FINITE;
$follow  memcpy(m->d, d, sizeof d);
  m->arg[0] = m->d;
  m->res[0] = m->h;
$tangent}

$evaluation
int ${name}_quantities(${name}_memory *m, const double *x, const double *machine, long angles, const double *phi,
                       double *q)
{
  ${status} = set_values(m, x, machine, 0);
  if (status) return status;
$cycle
  for (long i = 0; i < ${NAME}_QUANTITIES * angles; ++i)
    if (!is_finite(q[i])) return ${NAME}_NOT_FINITE;
  return 0;
}
