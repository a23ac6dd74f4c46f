/* Range and spread of a curve, weighed and added up, and the slope in the variance; newton: the spread is the standard
 * deviation, not the variance.
 */
#include <math.h>

static double weighed(double weight_range, double weight_variance, long newton, double range, double variance)
{
  return weight_range * range + weight_variance * (newton ? sqrt(variance) : variance);
}

static double weighed_rate(double weight_variance, long newton, double variance)
{
  return newton ? weight_variance / (2.0 * sqrt(variance)) : weight_variance;
}
