/* $headline: see $name.h. Written by planter $version; do not edit. */
#include "$name.h"

#include <math.h>
#include <stddef.h>

typedef ${name}_real real;

const char *const ${name}_states[] = { $state_names };
const char *const ${name}_inputs[] = { $input_names };
const char *const ${name}_parameters[] = { $parameter_names };
const char *const ${name}_outputs[] = { $output_names };
const real ${name}_start[] = { $start };
const real ${name}_u[] = { $u };
const real ${name}_p[] = { $p };
const real ${name}_least_pivot = (real)$least_pivot;

$helpers

$graphs

static int check_inputs(const real *x, const real *u, const real *p) {
  return !x || (${NAME}_INPUTS && !u) || (${NAME}_PARAMETERS && !p) ? ${NAME}_MISSING : ${NAME}_OK;
}

static int check_results(const real *values, int count) {
  int k;
  if (values)
    for (k = 0; k < count; ++k)
      if (!isfinite(values[k])) return ${NAME}_NOT_FINITE;
  return ${NAME}_OK;
}

$functions
