/* Programs: functions in CasADi's C, loops over lanes, and what calls them one after another on the program's numbers. */
#include <stdint.h>
#include <string.h>

#define CASADI_SYMBOL_EXPORT static __attribute__((unused))
$functions
$prototypes

static const double *arg[$arg];
static double *res[$res], w[$w];
static casadi_int iw[$iw];

static int any_not_finite(const double *numbers, long count)
{
  uint64_t found = 0;
  for (long i = 0; i < count; ++i) {
    uint64_t bits;
    memcpy(&bits, numbers + i, sizeof bits);
    found |= (bits & 0x7ff0000000000000u) == 0x7ff0000000000000u;
  }
  return found != 0;
}
