
/* The turn of a design x: a status. */
int ${name}_value(${name}_memory *m, const double *x, const double *machine, ${name}_found *found);

/* The same, and the gradient of the objective: that of the samples where the extremes stand. */
int ${name}_gradient(${name}_memory *m, const double *x, const double *machine, ${name}_found *found, double *gradient);
