#include <math.h>

#if defined(__GNUC__)
#define INLINED static inline __attribute__((always_inline, unused))
#else
#define INLINED static inline
#endif
#if defined(__clang__)
#define INDEPENDENT_LANES _Pragma("clang loop interleave(disable)")
#elif defined(__GNUC__)
#define INDEPENDENT_LANES _Pragma("GCC ivdep")
#else
#define INDEPENDENT_LANES
#endif
#if defined(FP_FAST_FMA) || defined(__FMA__)
INLINED double half_turns(double x) { return rint(x * 0.3183098861837907); }
INLINED double within(double x, double k) { return fma(-k, 1.2246467991473532e-16, fma(-k, 3.141592653589793, x)); }
INLINED double parity(double k) { const double h = 0.5 * k; return fma(-4.0, fabs(h - rint(h)), 1.0); }
INLINED double turned_sin(double x)
{
  const double k = half_turns(x), r = within(x, k), q = r * r;
  return parity(k) * r * (fma(fma(fma(fma(fma(fma(fma(fma(fma(fma(1.9572941063391263e-20, q, -8.22063524662433e-18), q, 2.8114572543455206e-15), q, -7.647163731819816e-13), q, 1.6059043836821613e-10), q, -2.505210838544172e-08), q, 2.7557319223985893e-06), q, -0.0001984126984126984), q, 0.008333333333333333), q, -0.16666666666666666), q, 1.0));
}
INLINED double turned_cos(double x)
{
  const double k = half_turns(x), r = within(x, k), q = r * r;
  return parity(k) * (fma(fma(fma(fma(fma(fma(fma(fma(fma(fma(fma(-8.896791392450574e-22, q, 4.110317623312165e-19), q, -1.5619206968586225e-16), q, 4.779477332387385e-14), q, -1.1470745597729725e-11), q, 2.08767569878681e-09), q, -2.755731922398589e-07), q, 2.48015873015873e-05), q, -0.001388888888888889), q, 0.041666666666666664), q, -0.5), q, 1.0));
}
#else
double f_zero = 0.0;
INLINED double turned_sin(double x) { return sin(x); }
INLINED double turned_cos(double x) { return cos(x + f_zero); }
#endif
#if defined(__SSE2__) && !defined(__SSE4_1__)
INLINED double whole_floor(double x)
{
  const double near = fmin(fmax(x, -2147483647.0), 2147483647.0), whole = (double)(int)near;
  return near == x ? whole - (whole > near ? 1.0 : 0.0) : x;
}
#else
INLINED double whole_floor(double x) { return floor(x); }
#endif

void f(long lanes, const double *restrict phi, const double *restrict x, double *restrict curve, double *restrict both)
{
  const double s0 = x[0];
  const double s7 = x[1];
  const double s8 = sqrt(s7);
INDEPENDENT_LANES
  for (long i = 0; i < lanes; ++i) {
    const double t1 = phi[i];
    const double t2 = s0 < t1 ? 1.0 : 0.0;
    const double t3 = 3.5 < t1 ? 1.0 : 0.0;
    const double t4 = 1.0 - t3;
    const double t5 = t2 * t4;
    const double t6 = turned_sin(t1);
    const double t9 = t6 * s8;
    const double t10 = t5 != 0.0 ? t9 : 0.0;
    const double t11 = 1.0 - t5;
    const double t12 = turned_cos(t1);
    const double t13 = t12 - 0.5;
    const double t14 = t11 != 0.0 ? t13 : 0.0;
    const double t15 = t10 + t14;
    curve[i] = t15;
    const double t16 = t15 * t15;
    both[0 * lanes + i] = t16;
    const double t17 = whole_floor(t1);
    const double t18 = s0 * t17;
    both[1 * lanes + i] = t18;
  }
}

void total(long lanes, const double *restrict phi, const double *restrict x, double *restrict curve)
{
  const double s0 = x[0];
  const double s7 = x[1];
  const double s8 = sqrt(s7);
  double a0 = 0.0;
INDEPENDENT_LANES
  for (long i = 0; i < lanes; ++i) {
    const double t1 = phi[i];
    const double t2 = s0 < t1 ? 1.0 : 0.0;
    const double t3 = 3.5 < t1 ? 1.0 : 0.0;
    const double t4 = 1.0 - t3;
    const double t5 = t2 * t4;
    const double t6 = turned_sin(t1);
    const double t9 = t6 * s8;
    const double t10 = t5 != 0.0 ? t9 : 0.0;
    const double t11 = 1.0 - t5;
    const double t12 = turned_cos(t1);
    const double t13 = t12 - 0.5;
    const double t14 = t11 != 0.0 ? t13 : 0.0;
    const double t15 = t10 + t14;
    a0 += t15;
  }
  curve[0] = a0;
}
