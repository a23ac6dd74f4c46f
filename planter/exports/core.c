/* A unit around a model: what both versions of FMI ask for.
 *
 * Stands behind what the model brings: TOKEN; the numbers STATES of continuous states, SET of states, inputs and
 * parameters, which come first among the variables, HIDDEN of further values that steps change, COMPUTED of rates and
 * outputs, EVENTS of event indicators, which are the last outputs; `starts` and `names` (SET); for a `memory` that begins
 * as zeros, time and values
 *
 *   evaluate(memory *, time, values, part, computed)   rates (part 0) or outputs (part 1)
 *   advance(memory *, time, step, values)              values after a step with constant inputs
 *   differentiate(memory *, time, values, slopes)      derivatives (COMPUTED, SET), if DIFFERENTIABLE is defined, of
 *   find_slope(slopes, row, column)                    which this is one
 *
 * each positive where there is no result, negative where the result deserves a warning; `reason(memory *, int)`, why. A
 * model with HIDDEN values is for co-simulation alone. The version brings FMI(name), the name of a function of the
 * interface, the type `logger`, and `tell`, which calls one. What both versions have alike stands at the end.
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
  int warned;       /* of what lasts, so that it is told once */
  double computed[COMPUTED + 1], *slopes;
  memory work;
  logger log;
  void *environment;
  char *name;
} instance;

static void tell(const instance *unit, status status, const char *message);

#define CATEGORY(status) ((status) == WARNING ? "logStatusWarning" : "logStatusError")

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

/* What becomes of a computation; a warning is told where what it is about begins. */
static status judge(instance *unit, int outcome)
{
  const int begins = outcome < 0 && !unit->warned;
  if (outcome <= 0) unit->warned = outcome < 0;
  if (outcome <= 0 && !begins) return OK;
  return complain(unit, outcome > 0 ? DISCARD : WARNING, reason(&unit->work, outcome));
}

static status find_worse(status one, status other) { return one > other ? one : other; }

static void forget(instance *unit) { memset(unit->known, 0, sizeof unit->known); }

static void begin(instance *unit)
{
  memset(&unit->now, 0, sizeof unit->now);
  memcpy(unit->now.token, TOKEN, sizeof TOKEN);
  memcpy(unit->now.values, starts, sizeof starts);
  unit->warned = 0;
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
  const int outcome = evaluate(&unit->work, unit->now.time, unit->now.values, part, unit->computed);
  unit->known[part] = outcome <= 0;
  return judge(unit, outcome);
}

/* Behind what can be set, rates and outputs stands the time. */
static status get_numbers(instance *unit, const uint32_t references[], size_t count, double found[])
{
  status worst = OK;
  REQUIRE(unit, !count || (references && found));
  for (size_t i = 0; i < count; ++i) {
    const int place = references[i] <= SET + COMPUTED ? (int)references[i] : -1;
    if (place < 0) return complain(unit, ERROR, "there is no variable of this reference");
    if (place >= SET && place < SET + COMPUTED)
      worst = find_worse(worst, compute(unit, place < SET + STATES ? RATES : RESULTS));
    if (worst > WARNING) return worst;
    found[i] = place < SET              ? unit->now.values[place]
               : place < SET + COMPUTED ? unit->computed[place - SET]
                                        : unit->now.time;
  }
  return worst;
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
  const status outcome = wanted ? compute(unit, part) : OK;
  if (outcome > WARNING) return outcome;
  for (size_t i = 0; i < count; ++i) found[i] = unit->computed[first + (int)i];
  return outcome;
}

static status get_rates(instance *unit, double found[], size_t count)
{
  return get_computed(unit, RATES, 0, STATES, found, count);
}

static status get_nominals(const instance *unit, double found[], size_t count)
{
  REQUIRE(unit, (found || !STATES) && count == STATES);
  for (size_t i = 0; i < count; ++i) found[i] = 1.0;
  return OK;
}

/* Changes of states, rates and outputs with states, inputs and parameters that change along a direction. */
static status get_slopes(instance *unit, const uint32_t unknown[], size_t unknowns, const uint32_t known[], size_t knowns,
                         const double along[], double found[])
{
  REQUIRE(unit, (!unknowns || (unknown && found)) && (!knowns || (known && along)));
#ifdef DIFFERENTIABLE
  for (size_t i = 0; i < unknowns; ++i)
    if ((unknown[i] >= STATES && unknown[i] < SET) || unknown[i] >= SET + COMPUTED)
      return complain(unit, ERROR, "there is no such derivative");
  for (size_t j = 0; j < knowns; ++j)
    if (known[j] >= SET) return complain(unit, ERROR, "there is no such derivative");
  if (!unit->slopes) unit->slopes = malloc(COMPUTED * SET * sizeof *unit->slopes);
  if (!unit->slopes) return complain(unit, ERROR, "there is no memory for derivatives");
  if (!unit->known[SLOPES]) {
    const int failed = differentiate(&unit->work, unit->now.time, unit->now.values, unit->slopes);
    if (failed) return judge(unit, failed);
    unit->known[SLOPES] = 1;
  }
  for (size_t i = 0; i < unknowns; ++i) {
    found[i] = 0.0;
    for (size_t j = 0; j < knowns; ++j) {
      const int row = (int)unknown[i] - SET;
      const double slope = row < 0 ? unknown[i] == known[j] : find_slope(unit->slopes, row, (int)known[j]);
      found[i] += slope * along[j];
    }
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
  const status outcome = judge(unit, advance(&unit->work, time, step, unit->now.values));
  if (outcome > WARNING) return outcome;
  unit->now.time = time + step;
  forget(unit);
  return outcome;
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
  unit->warned = 0;
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

/* --- what both versions have alike --- */

EXPORTED void FMI(FreeInstance)(void *unit) { end(unit); }
EXPORTED status FMI(ExitInitializationMode)(void *unit) { return initialise(unit); }
EXPORTED status FMI(Terminate)(void *unit) { return terminate(unit); }
EXPORTED status FMI(Reset)(void *unit) { return start_anew(unit); }

EXPORTED status FMI(EnterContinuousTimeMode)(void *unit) { return enter(unit, EVENT, CONTINUOUS); }
EXPORTED status FMI(EnterEventMode)(void *unit) { return enter(unit, CONTINUOUS, EVENT); }
EXPORTED status FMI(SetTime)(void *unit, double time) { return set_time(unit, time); }
EXPORTED status FMI(SetContinuousStates)(void *unit, const double x[], size_t count) { return set_states(unit, x, count); }
EXPORTED status FMI(GetContinuousStates)(void *unit, double x[], size_t count) { return get_states(unit, x, count); }
EXPORTED status FMI(GetEventIndicators)(void *unit, double found[], size_t count)
{
  return get_computed(unit, RESULTS, COMPUTED - EVENTS, EVENTS, found, count);
}
EXPORTED status FMI(GetNominalsOfContinuousStates)(void *unit, double found[], size_t count)
{
  return get_nominals(unit, found, count);
}
