/* $headline
 *
 * All motions and forces at any angle of the drive$scope
 * SI units and radians throughout.
 * Written by planter $version; do not edit. Needs a C99 compiler and nothing else:
 *
 *     cc -std=c99 -O3 -march=native -ffast-math -c $name.c && cc ${name}_main.c $name.o -lm -o $name && ./$name
 *
 * Compile with -ffast-math or without; never link with it: that would change the arithmetic of the whole program.
 *
$design
 *
$machine
 *
$quantities
 *
$equations
 */
#ifndef ${NAME}_H
#define ${NAME}_H

#ifdef __cplusplus
extern "C" {
#endif

enum { ${NAME}_PARAMETERS = $parameters, ${NAME}_MACHINE = $constants, ${NAME}_SAMPLES = $samples, ${NAME}_ANGLES = $angles };
enum { ${NAME}_SIDE = $side, ${NAME}_TOTALS = $totals, ${NAME}_QUANTITIES = $sides * ${NAME}_SIDE + ${NAME}_TOTALS };

/* What functions return: 0, or why there is no result; ${name}_failure says it in words. */
enum { $statuses };

$found/* What a call works on; one for each thread, prepared once.$after */
typedef struct {
  $fields;
  const double *arg[$arg];
  double *res[$res];
  long long iw[$iw];
} ${name}_memory;

extern const double ${name}_design[$design_size];  /* the machine file's own design */
extern const double ${name}_lower[$design_size];   /* its bounds */
extern const double ${name}_upper[$design_size];
extern const double ${name}_machine[$machine_size];    /* its data */
extern const char *const ${name}_quantity[${NAME}_QUANTITIES];  /* names of q */

void ${name}_prepare(${name}_memory *m);
const char *${name}_failure(int status);
$objective
/* All quantities q (${NAME}_QUANTITIES, angles), row after row, of a design x at angles phi [rad] of the drive, in any
 * order.$sides_order$loops_note */
int ${name}_quantities(${name}_memory *m, const double *x, const double *machine, long angles, const double *phi,
                double *q);

#ifdef __cplusplus
}
#endif

#endif
