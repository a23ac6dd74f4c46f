/* $headline: $purpose of many designs, a thread for each design and angle.
 *
 * Written by planter $version; do not edit. SI units and radians.
 *
 *     nvcc -O3 -arch=native -shared -Xcompiler -fPIC $name.cu -o lib$name.so
 *
 * First what a design fixes, in CasADi's C, and its closed loops over a turn, a thread for each design; then a block for
 * each design, whose threads take its angles and share what they find. Mean and variance are joined in pairs: Chan,
 * Golub & LeVeque, Am. Stat. 37 (1983), 242-247.
 *
$design
 *
$machine
 *
$fields
 */
#include <math.h>
#include <stddef.h>

#ifdef __CUDACC__
#pragma nv_diag_suppress 177
#endif
#define CASADI_SYMBOL_EXPORT static __device__
$prologue
#undef casadi_int
#undef casadi_real

#define INLINED static __device__ __forceinline__
$functions
INLINED double whole_floor(double x) { return floor(x); }
INLINED int is_finite(double x) { return isfinite(x); }

#define restrict __restrict__
#define INDEPENDENT_LANES
$kernels
$loops
#undef restrict
#ifdef __CUDACC__
#pragma nv_diag_default 177
#pragma nv_diag_suppress 550
#endif

enum { PARAMETERS = $parameters, MACHINE = $constants, VALUES = $values, SHARED = $shared, SHARES = $shares };
enum { ROWS = $rows, GUARDS = $guards, NODES = $nodes, FIELDS = $field_count, COORDINATES_OR_ONE = $coordinates };
enum { COURSE_OR_ONE = $course, PREPARED = VALUES + SHARED + COURSE_OR_ONE };
enum { DESIGN_THREADS = 64, ANGLE_THREADS = 96, CHUNK = $chunk };

static __device__ const int design_places[] = {$design_places}, machine_places[] = {$machine_places};
static __device__ const int is_share[] = {$is_share}, is_size[] = {$is_size}, node_rows[] = {$node_rows};
static __device__ const int guard_kinds[] = {$guard_kinds};

typedef struct {
  double count, mean, squares, high, low;
} part;

INLINED part joined(part a, part b)
{
  const double count = a.count + b.count, apart = b.mean - a.mean;
  if (count == 0.0) return a;
  const part both = {count, a.mean + apart * (b.count / count),
                     a.squares + b.squares + apart * apart * (a.count * b.count / count),
                     fmax(a.high, b.high), fmin(a.low, b.low)};
  return both;
}

/* What all angles of a design share, (designs, PREPARED): its values, what they fix, its loops' course; not a number where
 * the design has none. */
static __global__ void prepare(long designs, const double *x, const double *c, double *prepared)
{
  const long design = blockIdx.x * (long)blockDim.x + threadIdx.x;
  if (design >= designs) return;
  double h[$hoisted], w[$w];
  long long iw[$iw];
  double *values = prepared + design * PREPARED, *own = values + VALUES;
  for (int i = 0; i < PARAMETERS; ++i) values[design_places[i]] = x[design * PARAMETERS + i];
  for (int i = 0; i < MACHINE; ++i) values[machine_places[i]] = c[i];
  const double *arg[$arg] = {values};
  double *res[$res] = {h};
  int failed = hoisting(arg, res, iw, w, 0);
$follow  before(values, h, own);
  if (failed)
    for (long i = 0; i < SHARED; ++i) own[i] = nan("");
}

/* FIELDS of each design, (designs, FIELDS). */
static __global__ void evaluate(long angles, const double *phi, const double *prepared, double *found)
{
  __shared__ double values[VALUES], own[SHARED], nodes[NODES + 1], statistics[4 * ROWS];
  __shared__ part parts[ANGLE_THREADS];
  const int thread = threadIdx.x;
  const double *given = prepared + (size_t)blockIdx.x * PREPARED;
  const long count = angles + NODES;
  for (int i = thread; i < VALUES; i += ANGLE_THREADS) values[i] = given[i];
  for (int i = thread; i < SHARED; i += ANGLE_THREADS) own[i] = given[VALUES + i];
  __syncthreads();
  part mine[ROWS];
  for (int k = 0; k < ROWS; ++k) {
    const part none = {0.0, 0.0, 0.0, -HUGE_VAL, HUGE_VAL};
    mine[k] = none;
  }
  for (long i = thread; i < count; i += ANGLE_THREADS) {
    double total[ROWS] = {0.0};
    for (int share = 0; share < SHARES; ++share) {
      double q[COORDINATES_OR_ONE] = {0.0}, rows[ROWS + GUARDS];
      int failed = 0;
$place      lane(phi[share * count + i], q, own, rows);
      for (int k = 0; k < GUARDS; ++k)
        failed |= guard_kinds[k] ? rows[ROWS + k] == 0.0 : !(rows[ROWS + k] >= $least_pivot);
      for (int k = 0; k < ROWS; ++k)
        if (share == 0 || is_share[k]) total[k] += failed ? nan("") : rows[k];
    }
    for (int k = 0; k < ROWS; ++k) {
      const double value = is_size[k] ? fabs(total[k]) : total[k];
      const part one = {1.0, value, 0.0, value, value};
      if (i < angles) mine[k] = joined(mine[k], one);
      if (i >= angles && node_rows[i - angles] == k) nodes[i - angles] = value;
    }
  }
  for (int k = 0; k < ROWS; ++k) {
    parts[thread] = mine[k];
    __syncthreads();
    for (int left = ANGLE_THREADS; left > 1;) {
      const int half = (left + 1) / 2;
      if (thread < left - half) parts[thread] = joined(parts[thread], parts[thread + half]);
      __syncthreads();
      left = half;
    }
    if (thread == 0) {
      statistics[4 * k] = parts[0].high;
      statistics[4 * k + 1] = parts[0].low;
      statistics[4 * k + 2] = parts[0].mean;
      statistics[4 * k + 3] = parts[0].squares / parts[0].count;
    }
    __syncthreads();
  }
  if (thread == 0) {
    double *result = found + (size_t)blockIdx.x * FIELDS;
$weigh    for (int k = 0; k < ROWS; ++k) {
      *result++ = statistics[4 * k] - statistics[4 * k + 1];
      *result++ = statistics[4 * k + 3];
      *result++ = statistics[4 * k + 2];
    }
  }
}

static int chunk(long designs, const double *x, double *found, const double *c, const double *phi, double *device_x,
                 double *prepared, double *device_found, long angles)
{
  const int blocks = (int)((designs + DESIGN_THREADS - 1) / DESIGN_THREADS);
  cudaError_t error = cudaMemcpy(device_x, x, designs * PARAMETERS * sizeof *x, cudaMemcpyHostToDevice);
  if (error != cudaSuccess) return error;
  prepare<<<blocks, DESIGN_THREADS>>>(designs, device_x, c, prepared);
  evaluate<<<(int)designs, ANGLE_THREADS>>>(angles, phi, prepared, device_found);
  error = cudaGetLastError();
  if (error != cudaSuccess) return error;
  return cudaMemcpy(found, device_found, designs * FIELDS * sizeof *found, cudaMemcpyDeviceToHost);
}

/* Number of devices, 0 where there is none. */
extern "C" int ${name}_devices(void)
{
  int count = 0;
  return cudaGetDeviceCount(&count) == cudaSuccess ? count : 0;
}

extern "C" const char *${name}_error(int code) { return cudaGetErrorString((cudaError_t)code); }

/* FIELDS (designs, FIELDS) of designs x (designs, PARAMETERS), with the machine's data and lanes phi, those of each share
 * its angles and then its nodes: 0, or the code of what went wrong. A design without a cycle has a NaN. */
extern "C" int ${name}_cycles(long designs, const double *x, const double *machine, long angles, const double *phi,
                              double *found)
{
  const long most = designs < CHUNK ? designs : CHUNK, lanes = SHARES * (angles + NODES);
  const size_t sizes[5] = {MACHINE, (size_t)lanes, (size_t)most * PARAMETERS, (size_t)most * PREPARED,
                           (size_t)most * FIELDS};
  double *memory = NULL, *places[5];
  size_t total = 0;
  for (int i = 0; i < 5; ++i) total += sizes[i];
  int error = cudaMalloc((void **)&memory, total * sizeof *memory);
  if (error != cudaSuccess) return error;
  places[0] = memory;
  for (int i = 1; i < 5; ++i) places[i] = places[i - 1] + sizes[i - 1];
  error = cudaMemcpy(places[0], machine, MACHINE * sizeof *machine, cudaMemcpyHostToDevice);
  if (!error) error = cudaMemcpy(places[1], phi, lanes * sizeof *phi, cudaMemcpyHostToDevice);
  for (long first = 0; !error && first < designs; first += most) {
    const long count = designs - first < most ? designs - first : most;
    error = chunk(count, x + first * PARAMETERS, found + first * FIELDS, places[0], places[1], places[2], places[3],
                  places[4], angles);
  }
  cudaFree(memory);
  return error;
}
$weighed
