/* A unit for co-simulation around a model that has no states but how far its input has turned it: what both versions of
 * FMI ask for.
 *
 * Stands behind what the model brings: TOKEN, the number SET of inputs and parameters, which come first, and OUTPUTS;
 * `starts` and `names` (SET); `evaluate(memory *, values, turned, outputs)`, nonzero where there is no result, which
 * works on a `memory` that begins as zeros; `reason(int)`, why there is none; `rate(values)`, by which `turned` grows with
 * time. The version brings the type `logger`, and `tell`, which calls one.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status;
typedef enum { INSTANTIATED, INITIALISING, STEPPING, TERMINATED } phase;

/* All that a state is: what is saved and restored. */
typedef struct {
  char token[sizeof TOKEN];
  phase phase;
  double time, turned, values[SET];
} state;

typedef struct {
  state now;
  int known; /* whether the outputs are those of the state */
  double outputs[OUTPUTS];
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

static int is_number(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

static void begin(instance *unit)
{
  memset(&unit->now, 0, sizeof unit->now);
  memcpy(unit->now.token, TOKEN, sizeof TOKEN);
  memcpy(unit->now.values, starts, sizeof starts);
  unit->known = 0;
}

static void end(instance *unit)
{
  if (unit) free(unit->name);
  free(unit);
}

/* A new instance, or NULL for a token that is not the description's. */
static instance *made(const char *name, const char *token, logger log, void *environment)
{
  instance *unit = calloc(1, sizeof *unit);
  if (!unit) return NULL;
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

static status enter(instance *unit, phase from, phase to)
{
  REQUIRE(unit, 1);
  if (unit->now.phase != from) return complain(unit, ERROR, "this is not its turn");
  unit->now.phase = to;
  return OK;
}

static status set_numbers(instance *unit, const uint32_t references[], size_t count, const double given[])
{
  REQUIRE(unit, !count || (references && given));
  for (size_t i = 0; i < count; ++i) {
    if (references[i] >= SET) return complain(unit, ERROR, "only inputs and parameters can be set");
    if (!is_number(given[i])) return complain(unit, DISCARD, names[references[i]]);
    unit->now.values[references[i]] = given[i];
  }
  unit->known = 0;
  return OK;
}

/* Behind inputs, parameters and outputs stands the time. */
static status get_numbers(instance *unit, const uint32_t references[], size_t count, double found[])
{
  REQUIRE(unit, !count || (references && found));
  for (size_t i = 0; i < count; ++i) {
    const uint32_t place = references[i];
    if (place > SET + OUTPUTS) return complain(unit, ERROR, "there is no variable of this reference");
    const int failed = place >= SET && !unit->known
                           ? evaluate(&unit->work, unit->now.values, unit->now.turned, unit->outputs)
                           : 0;
    if (failed) return complain(unit, DISCARD, reason(failed));
    unit->known |= place >= SET;
    found[i] = place < SET             ? unit->now.values[place]
               : place < SET + OUTPUTS ? unit->outputs[place - SET]
                                       : unit->now.time;
  }
  return OK;
}

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
  unit->now.turned += rate(unit->now.values) * step;
  unit->now.time = time + step;
  unit->known = 0;
  return OK;
}

static const void *current(const instance *unit) { return unit ? &unit->now : NULL; }

static status start_anew(instance *unit)
{
  REQUIRE(unit, 1);
  begin(unit);
  return OK;
}

static status measure(const instance *unit, size_t *size)
{
  REQUIRE(unit, size != NULL);
  *size = sizeof(state);
  return OK;
}

/* States hold no addresses: saved in memory and as bytes they are the same. */

static status save(const instance *unit, const void *from, void **saved)
{
  REQUIRE(unit, from && saved);
  if (!*saved) *saved = malloc(sizeof(state));
  if (!*saved) return complain(unit, ERROR, "there is no memory for a state");
  memcpy(*saved, from, sizeof(state));
  return OK;
}

static int is_state(const void *saved) { return saved && memcmp(saved, TOKEN, sizeof TOKEN) == 0; }

static status restore(instance *unit, const void *saved)
{
  REQUIRE(unit, 1);
  if (!is_state(saved)) return complain(unit, ERROR, "this is no state of this unit");
  memcpy(&unit->now, saved, sizeof(state));
  unit->known = 0;
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
  return save(unit, bytes, saved);
}
