/* $headline: the objective of many designs, a thread for each design and angle.
 *
 * Written by planter $version; do not edit. SI units and radians.
 *
 *     nvcc -O3 -arch=native -shared -Xcompiler -fPIC $name.cu -o lib$name.so
 *
 * First what a design fixes, in CasADi's C, a thread for each design; then a block for each design, whose threads take
 * its angles and share what they find. Mean and variance are joined in pairs: Chan, Golub & LeVeque, Am. Stat. 37
 * (1983), 242-247.
 *
$design
 *
$machine
 */
#include <math.h>
#include <stddef.h>

#ifdef __CUDACC__
#pragma nv_diag_suppress 177
#endif
#define CASADI_SYMBOL_EXPORT static __device__
$prologue
$weighed
#ifdef __CUDACC__
#pragma nv_diag_default 177
#endif
#undef casadi_int
#undef casadi_real

#define INLINED static __device__ __forceinline__
$functions
INLINED double whole_floor(double x) { return floor(x); }

$kernels
enum { PARAMETERS = $parameters, MACHINE = $constants, SHARED = $shared, SHARES = $shares };
enum { DESIGN_THREADS = 64, ANGLE_THREADS = 96, CHUNK = 65536 };

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

/* What all angles of a design share, (designs, SHARED); not a number where the design has no curves. */
static __global__ void prepare(long designs, const double *x, const double *c, double *shared)
{
  const long design = blockIdx.x * (long)blockDim.x + threadIdx.x;
  if (design >= designs) return;
  double d[PARAMETERS + MACHINE], h[$hoisted], w[$w];
  long long iw[$iw];
  for (int i = 0; i < PARAMETERS; ++i) d[i] = x[design * PARAMETERS + i];
  for (int i = 0; i < MACHINE; ++i) d[PARAMETERS + i] = c[i];
  const double *arg[$arg] = {d};
  double *res[$res] = {h}, *own = shared + design * SHARED;
  const int failed = prologue(arg, res, iw, w, 0);
  before(d, h, own);
  if (failed)
    for (long i = 0; i < SHARED; ++i) own[i] = nan("");
}

/* Objective, range, variance and mean of each design, (designs, 4). */
static __global__ void evaluate(long angles, const double *phi, const double *shared, double weight_range,
                                double weight_variance, int newton, double *found)
{
  __shared__ double own[SHARED];
  __shared__ part parts[ANGLE_THREADS];
  const int thread = threadIdx.x;
  const double *given = shared + (size_t)blockIdx.x * SHARED;
  for (int i = thread; i < SHARED; i += ANGLE_THREADS) own[i] = given[i];
  __syncthreads();
  part mine = {0.0, 0.0, 0.0, -HUGE_VAL, HUGE_VAL};
  for (long i = thread; i < angles; i += ANGLE_THREADS) {
    double force = 0.0;
    for (int share = 0; share < SHARES; ++share) force += $lane(phi[share * angles + i], own);
    const part one = {1.0, force, 0.0, force, force};
    mine = joined(mine, one);
  }
  parts[thread] = mine;
  __syncthreads();
  for (int left = ANGLE_THREADS; left > 1;) {
    const int half = (left + 1) / 2;
    if (thread < left - half) parts[thread] = joined(parts[thread], parts[thread + half]);
    __syncthreads();
    left = half;
  }
  if (thread == 0) {
    const double range = parts[0].high - parts[0].low, variance = parts[0].squares / parts[0].count;
    double *own_found = found + (size_t)blockIdx.x * 4;
    own_found[0] = weighed(weight_range, weight_variance, newton, range, variance);
    own_found[1] = range;
    own_found[2] = variance;
    own_found[3] = parts[0].mean;
  }
}

static int chunk(long designs, const double *x, double *found, const double *c, const double *phi, double *device_x,
                 double *shared, double *device_found, long angles, double weight_range, double weight_variance,
                 int newton)
{
  const int blocks = (int)((designs + DESIGN_THREADS - 1) / DESIGN_THREADS);
  cudaError_t error = cudaMemcpy(device_x, x, designs * PARAMETERS * sizeof *x, cudaMemcpyHostToDevice);
  if (error != cudaSuccess) return error;
  prepare<<<blocks, DESIGN_THREADS>>>(designs, device_x, c, shared);
  evaluate<<<(int)designs, ANGLE_THREADS>>>(angles, phi, shared, weight_range, weight_variance, newton, device_found);
  error = cudaGetLastError();
  if (error != cudaSuccess) return error;
  return cudaMemcpy(found, device_found, designs * 4 * sizeof *found, cudaMemcpyDeviceToHost);
}

/* Number of devices, 0 where there is none. */
extern "C" int ${name}_devices(void)
{
  int count = 0;
  return cudaGetDeviceCount(&count) == cudaSuccess ? count : 0;
}

extern "C" const char *${name}_error(int code) { return cudaGetErrorString((cudaError_t)code); }

/* Objective, range, variance, mean (designs, 4) of designs x (designs, PARAMETERS), with the machine's data and the
 * lanes phi (SHARES angles): 0, or the code of what went wrong. A design without a force has a NaN. */
extern "C" int ${name}_turns(long designs, const double *x, const double *machine, long angles, const double *phi,
                             double weight_range, double weight_variance, int newton, double *found)
{
  const long most = designs < CHUNK ? designs : CHUNK, lanes = SHARES * angles;
  const size_t sizes[5] = {MACHINE, (size_t)lanes, (size_t)most * PARAMETERS, (size_t)most * SHARED, (size_t)most * 4};
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
    error = chunk(count, x + first * PARAMETERS, found + first * 4, places[0], places[1], places[2], places[3], places[4],
                  angles, weight_range, weight_variance, newton);
  }
  cudaFree(memory);
  return error;
}
