/* $headline: see $name.h.
 *
 * First what a design fixes, in CasADi's C; then the force of a side, its slopes and all quantities as loops over angles,
 * each line an operation of the derived equations; then the turn, which joins them.
 */
#include "$name.h"

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
$renamed
$turn
const double ${name}_design[${NAME}_PARAMETERS] = {$own};
const double ${name}_lower[${NAME}_PARAMETERS] = {$lower};
const double ${name}_upper[${NAME}_PARAMETERS] = {$upper};
const double ${name}_machine[${NAME}_MACHINE] = {$data};
const char *const ${name}_quantity[${NAME}_QUANTITIES] = {$quantity};

void ${name}_prepare(${name}_memory *m)
{
  static const double offsets[] = {$offsets};
  for (long share = 0; share < $shares; ++share)
    for (long i = 0; i < $angles; ++i)
      m->phi[share * $angles + i] = offsets[share] + 6.283185307179586 * (double)i / $samples.0;
}

static turn turn_of(${name}_memory *m, const double *machine)
{
  turn t = {$parameters, $constants, $angles, $shares, $weight_range, $weight_variance, $newton,
            0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  t.phi = m->phi;
  t.c = machine;
  t.d = m->d;
  t.h = m->h;
  t.dh = m->dh;
  t.force = m->force;
  t.g = m->g;
  t.weights = m->weights;
  t.arg = m->arg;
  t.res = m->res;
  t.iw = m->iw;
  t.w = m->w;
  return t;
}

static ${name}_found copied(const found *f)
{
  const ${name}_found result = {f->objective, f->range, f->variance, f->mean};
  return result;
}

int ${name}_value(${name}_memory *m, const double *x, const double *machine, ${name}_found *result)
{
  const turn t = turn_of(m, machine);
  found f = {0.0, 0.0, 0.0, 0.0};
  const int failed = turn_value(&t, x, &f);
  *result = copied(&f);
  return failed;
}

int ${name}_gradient(${name}_memory *m, const double *x, const double *machine, ${name}_found *result, double *gradient)
{
  const turn t = turn_of(m, machine);
  found f = {0.0, 0.0, 0.0, 0.0};
  const int failed = turn_gradient(&t, x, &f, gradient);
  *result = copied(&f);
  return failed;
}

int ${name}_quantities(${name}_memory *m, const double *x, const double *machine, long angles, const double *phi,
                       double *q)
{
  const turn t = turn_of(m, machine);
  if (designed(&t, x, 0)) return 1;
  cycle(angles, phi, x, machine, m->h, q, q + ${NAME}_SIDE * angles, q + 2 * ${NAME}_SIDE * angles);
  for (long i = 0; i < ${NAME}_QUANTITIES * angles; ++i)
    if (!is_finite(q[i])) return 1;
  return 0;
}
