/* The objective: statistics of each row over the samples, and what `weigh` makes of them and of values at single angles. */
enum { ROWS = $rows, SHARES = $shares, NODES = $nodes, COUNT = ${NAME}_ANGLES + NODES, LANES = SHARES * COUNT };
static const int shared[ROWS] = {$shared}, absolute[ROWS] = {$absolute}, node_rows[NODES + 1] = {$node_rows};
static const double offsets[SHARES] = {$offsets}, node_angles[NODES + 1] = {$node_angles};

/* A row's lanes as its samples and nodes; weights become the sign of what a size is of. */
static void fold(double *row, double *weights, int k)
{
  for (long share = 1; shared[k] && share < SHARES; ++share)
    for (long i = 0; i < COUNT; ++i) row[i] += row[share * COUNT + i];
  for (long i = 0; i < COUNT; ++i) {
    weights[i] = absolute[k] && row[i] < 0.0 ? -1.0 : 1.0;
    row[i] *= weights[i];
  }
}

/* Greatest, least, mean and variance of a row's samples, and where it is greatest and least. */
static void summarise(const double *row, double *statistics, long *highest, long *lowest)
{
  double sum = 0.0, squares = 0.0;
  long high = 0, low = 0;
  for (long i = 0; i < ${NAME}_ANGLES; ++i) sum += row[i];
  const double mean = sum / ${NAME}_ANGLES;
  for (long i = 0; i < ${NAME}_ANGLES; ++i) squares += (row[i] - mean) * (row[i] - mean);
  for (long i = 1; i < ${NAME}_ANGLES; ++i) {
    if (row[i] > row[high]) high = i;
    if (row[i] < row[low]) low = i;
  }
  statistics[0] = row[high];
  statistics[1] = row[low];
  statistics[2] = mean;
  statistics[3] = squares / ${NAME}_ANGLES;
  *highest = high;
  *lowest = low;
}

/* Everything but the rows at all lanes. */
static int prepare_lanes(${name}_memory *m, const double *x, const double *machine, int tangent)
{
  const int status = set_values(m, x, machine, tangent);
  if (status) return status;
$place$guard  return 0;
}

/* The objective and what it is made of; its gradient, of samples that stay where they are, unless that is null. */
static int evaluate(${name}_memory *m, const double *x, const double *machine, ${name}_found *result, double *gradient)
{
  double statistics[4 * ROWS], nodes[NODES + 1] = {0.0}, slope[4 * ROWS], node_slope[NODES + 1];
  double moved_slope[${NAME}_PARAMETERS + 1], objective;
  long high[ROWS], low[ROWS];
  const int status = prepare_lanes(m, x, machine, gradient != NULL);
  if (status) return status;
  if (gradient)
    slopes(LANES, m->phi, m->d, m->h, $coordinates, m->dh, m->samples, m->g);
  else
    rows(LANES, m->phi, m->d, m->h, $coordinates, m->samples);
  for (int k = 0; k < ROWS; ++k) {
    fold(m->samples + k * LANES, m->weights + k * LANES, k);
    summarise(m->samples + k * LANES, statistics + 4 * k, high + k, low + k);
  }
  for (int n = 0; n < NODES; ++n) nodes[n] = m->samples[node_rows[n] * LANES + ${NAME}_ANGLES + n];
  weigh(1, m->d, statistics, nodes, &objective, slope, node_slope, moved_slope);
  const ${name}_found found = {$found};
  *result = found;
  int failed = !is_finite(objective);
  for (int k = 0; k < ROWS; ++k) failed |= !is_finite(statistics[4 * k + 2]);
  if (!gradient || failed) return failed ? ${NAME}_NOT_FINITE : 0;
  for (int k = 0; k < ROWS; ++k) {
    const double *s = statistics + 4 * k, *along = slope + 4 * k, *row = m->samples + k * LANES;
    const double rate = along[2] / ${NAME}_ANGLES, bend = 2.0 * along[3] / ${NAME}_ANGLES;
    double *weights = m->weights + k * LANES;
    for (long i = 0; i < ${NAME}_ANGLES; ++i)
      weights[i] *= rate + bend * (row[i] - s[2]) + (i == high[k] ? along[0] : 0.0) + (i == low[k] ? along[1] : 0.0);
    for (int n = 0; n < NODES; ++n) weights[${NAME}_ANGLES + n] *= node_rows[n] == k ? node_slope[n] : 0.0;
    for (long share = 1; share < SHARES; ++share)
      for (long i = 0; i < COUNT; ++i) weights[share * COUNT + i] = shared[k] ? weights[i] : 0.0;
  }
  for (int j = 0; j < ${NAME}_PARAMETERS; ++j) {
    double sum = moved_slope[j];
    for (int k = 0; k < ROWS; ++k) {
      const double *g = m->g + (k * (1 + ${NAME}_PARAMETERS) + 1 + j) * (long)LANES, *weights = m->weights + k * LANES;
      for (long i = 0; i < LANES; ++i) sum += weights[i] * g[i];
    }
    gradient[j] = sum;
    failed |= !is_finite(sum);
  }
  return failed ? ${NAME}_NOT_FINITE : 0;
}

void ${name}_prepare(${name}_memory *m)
{
$reset  for (long share = 0; share < SHARES; ++share) {
    double *phi = m->phi + share * COUNT;
    for (long i = 0; i < ${NAME}_ANGLES; ++i) phi[i] = offsets[share] + $turn * (double)i / $count.0;
    for (int n = 0; n < NODES; ++n) phi[${NAME}_ANGLES + n] = offsets[share] + node_angles[n];
  }
}

int ${name}_value(${name}_memory *m, const double *x, const double *machine, ${name}_found *result)
{
  return evaluate(m, x, machine, result, NULL);
}

int ${name}_gradient(${name}_memory *m, const double *x, const double *machine, ${name}_found *result, double *gradient)
{
  return evaluate(m, x, machine, result, gradient);
}
