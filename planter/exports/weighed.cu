
/* The same with other weights of range and spread, of variance or, newton, standard deviation: objective, range, variance,
 * mean (designs, 4). */
extern "C" int ${name}_turns(long designs, const double *x, const double *machine, long angles, const double *phi,
                             double weight_range, double weight_variance, int newton, double *found)
{
  const int error = ${name}_cycles(designs, x, machine, angles, phi, found);
  for (long i = 0; !error && i < designs; ++i) {
    const double spread = newton ? sqrt(found[4 * i + 2]) : found[4 * i + 2];
    found[4 * i] = weight_range * found[4 * i + 1] + weight_variance * spread;
  }
  return error;
}
