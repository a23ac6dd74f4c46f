/* A unit around a model: what both versions of FMI ask for.
 *
 * Stands behind what the model brings: TOKEN; the numbers STATES of continuous states, SET of states, inputs and
 * parameters, which come first among the variables, HIDDEN of further values that steps change, COMPUTED of rates and
 * outputs, EVENTS of event indicators, which are the last outputs; `starts` and `names` (SET); for a `memory` that begins
 * as zeros, time and values
 *
 *   evaluate(memory *, time, values, part, computed)   rates (part 0) or outputs (part 1)
 *   advance(memory *, time, step, values)              values after a step with constant inputs
 *   differentiate(time, values, slopes)                derivatives (COMPUTED, SET), if DIFFERENTIABLE is defined, of
 *   find_slope(slopes, row, column)                    which this is one
 *
 * each nonzero where there is no result; `reason(int)`, why there is none. A model with HIDDEN values is for
 * co-simulation alone. The version brings the type `logger`, and `tell`, which calls one.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#pragma GCC diagnostic ignored "-Wunused-parameter"
#else
#define EXPORTED
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status;
typedef enum { MODEL_EXCHANGE, CO_SIMULATION } use;
typedef enum { INSTANTIATED, INITIALISING, EVENT, CONTINUOUS, STEPPING, TERMINATED } phase;
typedef enum { RATES, RESULTS, SLOPES, PARTS } part;

/* All that a state is: what is saved and restored. */
typedef struct {
  char token[sizeof TOKEN];
  phase phase;
  double time, values[SET + HIDDEN];
} state;

typedef struct {
  state now;
  use use;
  int known[PARTS]; /* whether computed values and slopes are those of the state */
  double computed[COMPUTED + 1], *slopes;
  memory work;
  logger log;
  void *environment;
  char *name;
} instance;

static void tell(const instance *unit, status status, const char *message);

static status complain(const void *unit, status found, const char *message)
{
  if (!unit) return ERROR;
  if (((const instance *)unit)->log) tell(unit, found, message);
  return found;
}

/* What every function of an instance begins with: nothing is written where the instance or an address is missing. */
static status check(const void *unit, int is_complete)
{
  return unit && is_complete ? OK : complain(unit, ERROR, "an address is missing");
}

#define REQUIRE(unit, is_complete) \
  if (check(unit, (is_complete)) != OK) return ERROR

/* Finite-math flags make isfinite() constant: look at the exponent. */
static int is_number(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

static void forget(instance *unit) { memset(unit->known, 0, sizeof unit->known); }

static void begin(instance *unit)
{
  memset(&unit->now, 0, sizeof unit->now);
  memcpy(unit->now.token, TOKEN, sizeof TOKEN);
  memcpy(unit->now.values, starts, sizeof starts);
  forget(unit);
}

static void end(instance *unit)
{
  if (unit) {
    free(unit->name);
    free(unit->slopes);
  }
  free(unit);
}

/* A new instance, or NULL for a use that the model does not serve, or a token that is not the description's. */
static instance *create(const char *name, const char *token, use use, logger log, void *environment)
{
  instance *unit = use == CO_SIMULATION || !HIDDEN ? calloc(1, sizeof *unit) : NULL;
  if (!unit) return NULL;
  unit->use = use;
  unit->log = log;
  unit->environment = environment;
  unit->name = calloc(name ? strlen(name) + 1 : 1, 1);
  if (unit->name && name) strcpy(unit->name, name);
  if (!unit->name || !token || strcmp(token, TOKEN) != 0) {
    complain(unit, ERROR, "this unit is another one than its description is of");
    end(unit);
    return NULL;
  }
  begin(unit);
  return unit;
}

/* --- life cycle --- */

static status enter(instance *unit, phase from, phase to)
{
  REQUIRE(unit, 1);
  if (unit->now.phase != from) return complain(unit, ERROR, "this is not its turn");
  unit->now.phase = to;
  return OK;
}

static status set_up(instance *unit, double start)
{
  REQUIRE(unit, 1);
  if (!is_number(start)) return complain(unit, ERROR, "the start of an experiment is a number");
  if (unit->now.phase != INSTANTIATED) return complain(unit, ERROR, "an experiment is set up before it begins");
  unit->now.time = start;
  return OK;
}

static status initialise(instance *unit)
{
  REQUIRE(unit, 1);
  return enter(unit, INITIALISING, unit->use == CO_SIMULATION ? STEPPING : EVENT);
}

static status terminate(instance *unit)
{
  REQUIRE(unit, 1);
  return enter(unit, unit->now.phase < EVENT ? EVENT : unit->now.phase, TERMINATED);
}

static status start_anew(instance *unit)
{
  REQUIRE(unit, 1);
  begin(unit);
  return OK;
}

/* --- values --- */

static status set_time(instance *unit, double time)
{
  REQUIRE(unit, 1);
  if (!is_number(time)) return complain(unit, DISCARD, "a time is a number");
  unit->now.time = time;
  forget(unit);
  return OK;
}

static status set_numbers(instance *unit, const uint32_t references[], size_t count, const double given[])
{
  REQUIRE(unit, !count || (references && given));
  for (size_t i = 0; i < count; ++i) {
    if (references[i] >= SET) return complain(unit, ERROR, "only states, inputs and parameters can be set");
    if (!is_number(given[i])) return complain(unit, DISCARD, names[references[i]]);
    unit->now.values[references[i]] = given[i];
  }
  forget(unit);
  return OK;
}

static status compute(instance *unit, part part)
{
  if (unit->known[part]) return OK;
  const int failed = evaluate(&unit->work, unit->now.time, unit->now.values, part, unit->computed);
  if (failed) return complain(unit, DISCARD, reason(failed));
  unit->known[part] = 1;
  return OK;
}

/* Behind what can be set, rates and outputs stands the time. */
static status get_numbers(instance *unit, const uint32_t references[], size_t count, double found[])
{
  REQUIRE(unit, !count || (references && found));
  for (size_t i = 0; i < count; ++i) {
    const int place = references[i] <= SET + COMPUTED ? (int)references[i] : -1;
    if (place < 0) return complain(unit, ERROR, "there is no variable of this reference");
    if (place >= SET && place < SET + COMPUTED && compute(unit, place < SET + STATES ? RATES : RESULTS) != OK)
      return DISCARD;
    found[i] = place < SET              ? unit->now.values[place]
               : place < SET + COMPUTED ? unit->computed[place - SET]
                                        : unit->now.time;
  }
  return OK;
}

static status set_states(instance *unit, const double x[], size_t count)
{
  REQUIRE(unit, (x || !STATES) && count == STATES);
  for (size_t i = 0; i < count; ++i) unit->now.values[i] = x[i];
  forget(unit);
  return OK;
}

static status get_states(const instance *unit, double x[], size_t count)
{
  REQUIRE(unit, (x || !STATES) && count == STATES);
  for (size_t i = 0; i < count; ++i) x[i] = unit->now.values[i];
  return OK;
}

static status get_computed(instance *unit, part part, int first, int wanted, double found[], size_t count)
{
  REQUIRE(unit, (found || !wanted) && count == (size_t)wanted);
  if (wanted && compute(unit, part) != OK) return DISCARD;
  for (size_t i = 0; i < count; ++i) found[i] = unit->computed[first + (int)i];
  return OK;
}

static status get_rates(instance *unit, double found[], size_t count)
{
  return get_computed(unit, RATES, 0, STATES, found, count);
}

static status get_events(instance *unit, double found[], size_t count)
{
  return get_computed(unit, RESULTS, COMPUTED - EVENTS, EVENTS, found, count);
}

static status get_nominals(const instance *unit, double found[], size_t count)
{
  REQUIRE(unit, (found || !STATES) && count == STATES);
  for (size_t i = 0; i < count; ++i) found[i] = 1.0;
  return OK;
}

/* Changes of rates and outputs with states, inputs and parameters that change along a direction. */
static status get_slopes(instance *unit, const uint32_t unknown[], size_t unknowns, const uint32_t known[], size_t knowns,
                         const double along[], double found[])
{
  REQUIRE(unit, (!unknowns || (unknown && found)) && (!knowns || (known && along)));
#ifdef DIFFERENTIABLE
  for (size_t i = 0; i < unknowns; ++i)
    if (unknown[i] < SET || unknown[i] >= SET + COMPUTED) return complain(unit, ERROR, "there is no such derivative");
  for (size_t j = 0; j < knowns; ++j)
    if (known[j] >= SET) return complain(unit, ERROR, "there is no such derivative");
  if (!unit->slopes) unit->slopes = malloc(COMPUTED * SET * sizeof *unit->slopes);
  if (!unit->slopes) return complain(unit, ERROR, "there is no memory for derivatives");
  if (!unit->known[SLOPES]) {
    const int failed = differentiate(unit->now.time, unit->now.values, unit->slopes);
    if (failed) return complain(unit, DISCARD, reason(failed));
    unit->known[SLOPES] = 1;
  }
  for (size_t i = 0; i < unknowns; ++i) {
    found[i] = 0.0;
    for (size_t j = 0; j < knowns; ++j)
      found[i] += find_slope(unit->slopes, (int)unknown[i] - SET, (int)known[j]) * along[j];
  }
  return OK;
#else
  return complain(unit, ERROR, "there are no derivatives");
#endif
}

/* --- steps --- */

/* A communication point is the end of the step before, but for the rounding of an importer that counts steps. */
static int follows(double time, double before, double step)
{
  const double gap = time > before ? time - before : before - time, size = time > 0.0 ? time : -time;
  return gap <= 1e-9 * (size + step);
}

static status step_on(instance *unit, double time, double step)
{
  REQUIRE(unit, 1);
  if (unit->now.phase != STEPPING) return complain(unit, ERROR, "a step comes after the initialisation");
  if (!is_number(time) || !is_number(step) || step < 0.0) return complain(unit, ERROR, "time does not go backwards");
  if (!follows(time, unit->now.time, step)) return complain(unit, ERROR, "a step begins where the one before ended");
  const int failed = advance(&unit->work, time, step, unit->now.values);
  if (failed) return complain(unit, DISCARD, reason(failed));
  unit->now.time = time + step;
  forget(unit);
  return OK;
}

/* --- saved states: they hold no addresses, so that in memory and as bytes they are the same --- */

static status measure(const instance *unit, size_t *size)
{
  REQUIRE(unit, size != NULL);
  *size = sizeof(state);
  return OK;
}

static status store(const instance *unit, const void *from, void **saved)
{
  REQUIRE(unit, from && saved);
  if (!*saved) *saved = malloc(sizeof(state));
  if (!*saved) return complain(unit, ERROR, "there is no memory for a state");
  memcpy(*saved, from, sizeof(state));
  return OK;
}

static status save(const instance *unit, void **saved) { return store(unit, unit ? &unit->now : NULL, saved); }

static int is_state(const void *saved) { return saved && memcmp(saved, TOKEN, sizeof TOKEN) == 0; }

static status restore(instance *unit, const void *saved)
{
  REQUIRE(unit, 1);
  if (!is_state(saved)) return complain(unit, ERROR, "this is no state of this unit");
  memcpy(&unit->now, saved, sizeof(state));
  forget(unit);
  return OK;
}

static status release(const instance *unit, void **saved)
{
  REQUIRE(unit, 1);
  if (saved) {
    free(*saved);
    *saved = NULL;
  }
  return OK;
}

static status to_bytes(const instance *unit, const void *saved, void *bytes, size_t size)
{
  REQUIRE(unit, bytes != NULL);
  if (!is_state(saved) || size < sizeof(state)) return complain(unit, ERROR, "there is no room for a state");
  memcpy(bytes, saved, sizeof(state));
  return OK;
}

static status from_bytes(const instance *unit, const void *bytes, size_t size, void **saved)
{
  REQUIRE(unit, 1);
  if (size != sizeof(state) || !is_state(bytes)) return complain(unit, ERROR, "these bytes are no state of this unit");
  return store(unit, bytes, saved);
}
