/* What a core can do at most: fused multiply-adds in vectors, and the length of a clock cycle.
 *
 * `cycles` is a chain of additions of which each takes one cycle; `fused` has enough independent sums to fill all
 * pipes.
 */
#if defined(__AVX512F__)
#define BYTES 64
#elif defined(__AVX__)
#define BYTES 32
#else
#define BYTES 16
#endif
#define SUMS 12
#define LANES (BYTES / (long)sizeof(double))

typedef double vector __attribute__((vector_size(BYTES)));

long lanes(void) { return LANES; }

/* 16 n cycles. */
long cycles(long n, long step)
{
  long sum = 0;
#define ADD sum += step; __asm__ volatile("" : "+r"(sum));
#define ADD4 ADD ADD ADD ADD
  for (long i = 0; i < n; ++i) { ADD4 ADD4 ADD4 ADD4 }
  return sum;
}

/* SUMS n vectors of multiply-adds. */
double fused(long n, double factor, double term)
{
  vector sums[SUMS], m, a;
  for (int lane = 0; lane < LANES; ++lane) {
    m[lane] = factor;
    a[lane] = term;
    for (int k = 0; k < SUMS; ++k) sums[k][lane] = k;
  }
#define FUSE(k) s##k = s##k * m + a;
  vector s0 = sums[0], s1 = sums[1], s2 = sums[2], s3 = sums[3], s4 = sums[4], s5 = sums[5], s6 = sums[6],
         s7 = sums[7], s8 = sums[8], s9 = sums[9], s10 = sums[10], s11 = sums[11];
  for (long i = 0; i < n; ++i) {
    FUSE(0) FUSE(1) FUSE(2) FUSE(3) FUSE(4) FUSE(5) FUSE(6) FUSE(7) FUSE(8) FUSE(9) FUSE(10) FUSE(11)
  }
  vector all = s0 + s1 + s2 + s3 + s4 + s5 + s6 + s7 + s8 + s9 + s10 + s11;
  double sum = 0.0;
  for (int lane = 0; lane < LANES; ++lane) sum += all[lane];
  return sum;
}
