/* $headline
 *
 * Support force over a turn of the carrier, objective and gradient; all motions and forces at any carrier angle.
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
enum { ${NAME}_SIDE = $side, ${NAME}_TOTALS = $totals, ${NAME}_QUANTITIES = 2 * ${NAME}_SIDE + ${NAME}_TOTALS };

/* A turn: objective $objective; range [N], variance [N2] and mean [N] of the support force. */
typedef struct {
  double objective, range, variance, mean;
} ${name}_found;

/* What a call works on; one for each thread, prepared once. After a call `force` holds the support force [N] at the
 * first ${NAME}_ANGLES of `phi`$half. */
typedef struct {
  double phi[$lanes], force[$lanes], weights[$lanes], g[$slopes], d[$values], h[$hoisted], dh[$tangent], w[$w];
  const double *arg[$arg];
  double *res[$res];
  long long iw[$iw];
} ${name}_memory;

extern const double ${name}_design[${NAME}_PARAMETERS];  /* the machine file's own design */
extern const double ${name}_lower[${NAME}_PARAMETERS];   /* its bounds */
extern const double ${name}_upper[${NAME}_PARAMETERS];
extern const double ${name}_machine[${NAME}_MACHINE];    /* its data */
extern const char *const ${name}_quantity[${NAME}_QUANTITIES];  /* names of q */

void ${name}_prepare(${name}_memory *m);

/* The turn of a design x; nonzero where a result is not finite. */
int ${name}_value(${name}_memory *m, const double *x, const double *machine, ${name}_found *found);

/* The same, and the gradient of the objective: that of the samples where the extremes stand. */
int ${name}_gradient(${name}_memory *m, const double *x, const double *machine, ${name}_found *found, double *gradient);

/* All quantities q (${NAME}_QUANTITIES, angles), row after row, of a design x at carrier angles phi [rad]; nonzero where
 * one is not finite. Side 1 comes first, then side 2, half a turn behind, then what both do together. */
int ${name}_quantities(${name}_memory *m, const double *x, const double *machine, long angles, const double *phi,
                double *q);

#ifdef __cplusplus
}
#endif

#endif
