/* $headline
 *
 * x' = f(t, x, u, p) and y = g(t, x, u, p) with their derivatives, in SI units and radians.
 * Written by planter $version; do not edit. C99, without a heap and without a library but libm:
 *
 *     cc -std=c99 -O3 $name.c ${name}_main.c -lm -o $name && ./$name 1 0.001 > motion.csv
 *
 * Define ${NAME}_REAL as float for single precision.
 *
$variables
 *
$operations
 *
$constraints
 */
#ifndef ${NAME}_H
#define ${NAME}_H

#ifndef ${NAME}_REAL
#define ${NAME}_REAL double
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef ${NAME}_REAL ${name}_real;

enum { ${NAME}_STATES = $states, ${NAME}_INPUTS = $inputs, ${NAME}_PARAMETERS = $parameters, ${NAME}_OUTPUTS = $outputs };

/* What functions return: 0, or why there is no result. */
enum { ${NAME}_OK, ${NAME}_MISSING, ${NAME}_NOT_FINITE };

extern const char *const ${name}_states[];
extern const char *const ${name}_inputs[];
extern const char *const ${name}_parameters[];
extern const char *const ${name}_outputs[];
extern const ${name}_real ${name}_start[];  /* state at the start */
extern const ${name}_real ${name}_u[];      /* inputs at the start */
extern const ${name}_real ${name}_p[];      /* parameters of the file */
extern const ${name}_real ${name}_least_pivot; /* below it a motion may be lost */

/* ${name}_MISSING: a pointer that must not be null is null; u may be null without inputs, p without parameters. Results
 * may be null where they are not wanted. Matrices are row by row. */

/* xdot (STATES), and the least pivot of the constraints over the largest (1), to be watched: below least_pivot digits are
 * lost, and a motion may leave its branch */
int ${name}_rates(${name}_real t, const ${name}_real *x, const ${name}_real *u, const ${name}_real *p, ${name}_real *xdot,
    ${name}_real *pivot);
/* A (STATES, STATES), B (STATES, INPUTS), F (STATES, PARAMETERS): derivatives of xdot by x, u, p */
int ${name}_rates_jacobian(${name}_real t, const ${name}_real *x, const ${name}_real *u, const ${name}_real *p,
    ${name}_real *A, ${name}_real *B, ${name}_real *F);
/* y (OUTPUTS) */
int ${name}_outputs_at(${name}_real t, const ${name}_real *x, const ${name}_real *u, const ${name}_real *p, ${name}_real *y);
/* C (OUTPUTS, STATES), D (OUTPUTS, INPUTS), G (OUTPUTS, PARAMETERS): derivatives of y by x, u, p */
int ${name}_outputs_jacobian(${name}_real t, const ${name}_real *x, const ${name}_real *u, const ${name}_real *p,
    ${name}_real *C, ${name}_real *D, ${name}_real *G);

#ifdef __cplusplus
}
#endif

#endif
