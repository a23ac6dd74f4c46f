/* Whether numbers are finite: their bits are looked at, since a compiler may be told that all are. */
#include <stdint.h>
#include <string.h>

#define EXPONENT 0x7ff0000000000000u

/* The first of some arrays that holds a number which is not finite, from 1; 0 where there is none. */
long not_finite(long arrays, const double *const *at, const long *sizes)
{
  for (long k = 0; k < arrays; ++k) {
    uint64_t found = 0;
    for (long i = 0; i < sizes[k]; ++i) {
      uint64_t bits;
      memcpy(&bits, at[k] + i, sizeof bits);
      found |= (bits & EXPONENT) == EXPONENT;
    }
    if (found) return k + 1;
  }
  return 0;
}
