/* Many designs (designs, parameters) with their gradients, one after another; stands behind turn.c.
 * The number of the first that fails, from 1, or 0. */
long turn_gradients(const turn *t, long designs, const double *x, found *f, double *gradients)
{
  for (long d = 0; d < designs; ++d)
    if (turn_gradient(t, x + d * t->parameters, f + d, gradients + d * t->parameters)) return d + 1;
  return 0;
}
