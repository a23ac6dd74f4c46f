/* $headline, as a unit for model exchange (FMI 2.0): see ../modelDescription.xml.
 *
 * Written by planter $version; do not edit.
 */
#include "$name.c"

#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define TOKEN "TOKEN_OF_THIS"

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

/* Variables in their order: states, derivatives, inputs, parameters, outputs. Events are the last outputs. */
enum { N = ${NAME}_STATES, M = ${NAME}_INPUTS, Q = ${NAME}_PARAMETERS, R = ${NAME}_OUTPUTS, EVENTS = $events };
enum { DERIVATIVES = N, INPUTS = 2 * N, PARAMETERS = INPUTS + M, OUTPUTS = PARAMETERS + Q, VARIABLES = OUTPUTS + R };

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status;
typedef enum { INSTANTIATED, INITIALISING, EVENT, CONTINUOUS, TERMINATED } phase;
typedef const char *text;
typedef uint32_t reference;
typedef void (*logger)(void *environment, text instance, int status, text category, text message, ...);
typedef struct {
  logger log;
  void *(*allocate)(size_t count, size_t size);
  void (*release)(void *memory);
  void (*finished)(void *environment, status status);
  void *environment;
} callbacks;
typedef struct {
  int discrete_states_needed, terminate, nominals_changed, states_changed, next_time_defined;
  double next_time;
} event_info;

/* All that a state is: what is saved and restored. */
typedef struct {
  char token[sizeof TOKEN];
  phase phase;
  double time, x[N], u[M + 1], p[Q + 1];
} state;

typedef struct {
  state now;
  logger log;
  void *environment;
  char name[256];
} instance;

static status complain(const instance *unit, status found, text message)
{
  if (unit && unit->log) unit->log(unit->environment, unit->name, found, "logStatusError", "%s", message);
  return found;
}

#define REQUIRE(unit, is_complete) \
  if (!(unit) || !(is_complete)) return complain(unit, ERROR, "an address is missing")

static void begin(instance *unit)
{
  memset(&unit->now, 0, sizeof unit->now);
  memcpy(unit->now.token, TOKEN, sizeof TOKEN);
  memcpy(unit->now.x, ${name}_start, sizeof unit->now.x);
  if (M) memcpy(unit->now.u, ${name}_u, M * sizeof *unit->now.u);
  if (Q) memcpy(unit->now.p, ${name}_p, Q * sizeof *unit->now.p);
}

static status enter(instance *unit, phase from, phase to)
{
  REQUIRE(unit, 1);
  if (unit->now.phase != from) return complain(unit, ERROR, "this is not its turn");
  unit->now.phase = to;
  return OK;
}

EXPORTED text fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED text fmi2GetVersion(void) { return "2.0"; }

EXPORTED status fmi2SetDebugLogging(void *unit, int on, size_t count, const text categories[])
{
  REQUIRE((instance *)unit, 1);
  return OK;
}

EXPORTED void *fmi2Instantiate(text name, int type, text token, text resources, const callbacks *given, int visible,
                               int logging)
{
  instance *unit = type == 0 && token && !strcmp(token, TOKEN) ? calloc(1, sizeof *unit) : NULL;
  if (!unit) return NULL;
  unit->log = given ? given->log : NULL;
  unit->environment = given ? given->environment : NULL;
  if (name) strncpy(unit->name, name, sizeof unit->name - 1);
  begin(unit);
  return unit;
}

EXPORTED void fmi2FreeInstance(void *unit) { free(unit); }

EXPORTED status fmi2SetupExperiment(void *component, int with_tolerance, double tolerance, double start, int with_stop,
                                    double stop)
{
  instance *unit = component;
  REQUIRE(unit, 1);
  if (!isfinite(start)) return complain(unit, ERROR, "the start of an experiment is a number");
  if (unit->now.phase != INSTANTIATED) return complain(unit, ERROR, "an experiment is set up before it begins");
  unit->now.time = start;
  return OK;
}

EXPORTED status fmi2EnterInitializationMode(void *unit) { return enter(unit, INSTANTIATED, INITIALISING); }
EXPORTED status fmi2ExitInitializationMode(void *unit) { return enter(unit, INITIALISING, EVENT); }
EXPORTED status fmi2EnterContinuousTimeMode(void *unit) { return enter(unit, EVENT, CONTINUOUS); }
EXPORTED status fmi2EnterEventMode(void *unit) { return enter(unit, CONTINUOUS, EVENT); }

EXPORTED status fmi2NewDiscreteStates(void *component, event_info *found)
{
  instance *unit = component;
  REQUIRE(unit, found);
  memset(found, 0, sizeof *found);
  return OK;
}

EXPORTED status fmi2CompletedIntegratorStep(void *unit, int forgets, int *enters, int *ends)
{
  REQUIRE((instance *)unit, enters && ends);
  *enters = *ends = 0;
  return OK;
}

EXPORTED status fmi2Terminate(void *component)
{
  instance *unit = component;
  REQUIRE(unit, 1);
  unit->now.phase = TERMINATED;
  return OK;
}

EXPORTED status fmi2Reset(void *component)
{
  instance *unit = component;
  REQUIRE(unit, 1);
  begin(unit);
  return OK;
}

EXPORTED status fmi2SetTime(void *component, double time)
{
  instance *unit = component;
  REQUIRE(unit, 1);
  if (!isfinite(time)) return complain(unit, DISCARD, "a time is a number");
  unit->now.time = time;
  return OK;
}

/* The place of a variable that can be set. */
static double *find_value(instance *unit, reference place)
{
  if (place < DERIVATIVES) return unit->now.x + place;
  if (place >= INPUTS && place < PARAMETERS) return unit->now.u + (place - INPUTS);
  if (place >= PARAMETERS && place < OUTPUTS) return unit->now.p + (place - PARAMETERS);
  return NULL;
}

static status explain(instance *unit, int found)
{
  return found ? complain(unit, DISCARD, "a rate or an output is not finite") : OK;
}

static status find_rates(instance *unit, double *rates)
{
  const state *now = &unit->now;
  return explain(unit, ${name}_rates(now->time, now->x, now->u, now->p, rates, NULL));
}

static status find_outputs(instance *unit, double *outputs)
{
  const state *now = &unit->now;
  return explain(unit, ${name}_outputs_at(now->time, now->x, now->u, now->p, outputs));
}

EXPORTED status fmi2SetReal(void *component, const reference references[], size_t count, const double given[])
{
  instance *unit = component;
  size_t i;
  REQUIRE(unit, !count || (references && given));
  for (i = 0; i < count; ++i) {
    double *value = find_value(unit, references[i]);
    if (!value) return complain(unit, ERROR, "only states, inputs and parameters can be set");
    if (!isfinite(given[i])) return complain(unit, DISCARD, "a value is not finite");
    *value = given[i];
  }
  return OK;
}

EXPORTED status fmi2GetReal(void *component, const reference references[], size_t count, double found[])
{
  instance *unit = component;
  double rates[N], outputs[R + 1];
  int has_rates = 0, has_outputs = 0;
  size_t i;
  REQUIRE(unit, !count || (references && found));
  for (i = 0; i < count; ++i) {
    const reference place = references[i];
    const double *value = find_value(unit, place);
    if (place >= VARIABLES) return complain(unit, ERROR, "there is no variable of this reference");
    if (value) {
      found[i] = *value;
    } else if (place < INPUTS) {
      if (!has_rates && find_rates(unit, rates) != OK) return DISCARD;
      has_rates = 1;
      found[i] = rates[place - DERIVATIVES];
    } else {
      if (!has_outputs && find_outputs(unit, outputs) != OK) return DISCARD;
      has_outputs = 1;
      found[i] = outputs[place - OUTPUTS];
    }
  }
  return OK;
}

EXPORTED status fmi2SetContinuousStates(void *component, const double x[], size_t count)
{
  instance *unit = component;
  REQUIRE(unit, x && count == N);
  memcpy(unit->now.x, x, sizeof unit->now.x);
  return OK;
}

EXPORTED status fmi2GetContinuousStates(void *component, double x[], size_t count)
{
  instance *unit = component;
  REQUIRE(unit, x && count == N);
  memcpy(x, unit->now.x, sizeof unit->now.x);
  return OK;
}

EXPORTED status fmi2GetDerivatives(void *component, double rates[], size_t count)
{
  instance *unit = component;
  REQUIRE(unit, rates && count == N);
  return find_rates(unit, rates);
}

EXPORTED status fmi2GetEventIndicators(void *component, double found[], size_t count)
{
  instance *unit = component;
  double outputs[R + 1];
  REQUIRE(unit, (found || !count) && count == EVENTS);
  if (!count) return OK;
  if (find_outputs(unit, outputs) != OK) return DISCARD;
  memcpy(found, outputs + R - EVENTS, count * sizeof *found);
  return OK;
}

EXPORTED status fmi2GetNominalsOfContinuousStates(void *component, double found[], size_t count)
{
  size_t i;
  REQUIRE((instance *)component, found && count == N);
  for (i = 0; i < count; ++i) found[i] = 1.0;
  return OK;
}

/* Derivatives by states, inputs and parameters, row by row, each block behind the other. */
typedef struct {
  double x[(N + R) * N], u[(N + R) * M + 1], p[(N + R) * Q + 1];
} slopes;

static status differentiate(instance *unit, slopes *found)
{
  const state *now = &unit->now;
  const int rates = ${name}_rates_jacobian(now->time, now->x, now->u, now->p, found->x, found->u, found->p);
  if (rates) return explain(unit, rates);
  return explain(unit, ${name}_outputs_jacobian(now->time, now->x, now->u, now->p, found->x + N * N, found->u + N * M,
                                                found->p + N * Q));
}

static int find_slope(const slopes *found, reference row, reference known, double *slope)
{
  if (known < DERIVATIVES) *slope = found->x[row * N + known];
  else if (known >= INPUTS && known < PARAMETERS) *slope = found->u[row * M + (known - INPUTS)];
  else if (known >= PARAMETERS && known < OUTPUTS) *slope = found->p[row * Q + (known - PARAMETERS)];
  else return 0;
  return 1;
}

EXPORTED status fmi2GetDirectionalDerivative(void *component, const reference unknown[], size_t unknowns,
                                             const reference known[], size_t knowns, const double along[],
                                             double found[])
{
  instance *unit = component;
  slopes *all;
  status outcome;
  size_t i, j;
  REQUIRE(unit, (!unknowns || (unknown && found)) && (!knowns || (known && along)));
  all = malloc(sizeof *all);
  if (!all) return complain(unit, ERROR, "there is no memory for derivatives");
  outcome = differentiate(unit, all);
  for (i = 0; outcome == OK && i < unknowns; ++i) {
    const int is_rate = unknown[i] >= DERIVATIVES && unknown[i] < INPUTS;
    if (!is_rate && (unknown[i] < OUTPUTS || unknown[i] >= VARIABLES)) outcome = ERROR;
    found[i] = 0.0;
    for (j = 0; outcome == OK && j < knowns; ++j) {
      double slope = 0.0;
      const reference row = is_rate ? unknown[i] - DERIVATIVES : N + (unknown[i] - OUTPUTS);
      if (!find_slope(all, row, known[j], &slope)) outcome = ERROR;
      else found[i] += slope * along[j];
    }
  }
  free(all);
  return outcome == ERROR ? complain(unit, ERROR, "there is no such derivative") : outcome;
}

EXPORTED status fmi2GetFMUstate(void *component, void **saved)
{
  instance *unit = component;
  REQUIRE(unit, saved);
  if (!*saved) *saved = malloc(sizeof(state));
  if (!*saved) return complain(unit, ERROR, "there is no memory for a state");
  memcpy(*saved, &unit->now, sizeof(state));
  return OK;
}

static int is_state(const void *saved) { return saved && !memcmp(saved, TOKEN, sizeof TOKEN); }

EXPORTED status fmi2SetFMUstate(void *component, void *saved)
{
  instance *unit = component;
  REQUIRE(unit, 1);
  if (!is_state(saved)) return complain(unit, ERROR, "this is no state of this unit");
  memcpy(&unit->now, saved, sizeof(state));
  return OK;
}

EXPORTED status fmi2FreeFMUstate(void *unit, void **saved)
{
  REQUIRE((instance *)unit, 1);
  if (saved) {
    free(*saved);
    *saved = NULL;
  }
  return OK;
}

EXPORTED status fmi2SerializedFMUstateSize(void *unit, void *saved, size_t *size)
{
  REQUIRE((instance *)unit, size);
  *size = sizeof(state);
  return OK;
}

EXPORTED status fmi2SerializeFMUstate(void *unit, void *saved, char bytes[], size_t size)
{
  REQUIRE((instance *)unit, bytes);
  if (!is_state(saved) || size < sizeof(state)) return complain(unit, ERROR, "there is no room for a state");
  memcpy(bytes, saved, sizeof(state));
  return OK;
}

EXPORTED status fmi2DeSerializeFMUstate(void *unit, const char bytes[], size_t size, void **saved)
{
  REQUIRE((instance *)unit, bytes && saved);
  if (size != sizeof(state) || !is_state(bytes)) return complain(unit, ERROR, "these bytes are no state of this unit");
  if (!*saved) *saved = malloc(sizeof(state));
  if (!*saved) return complain(unit, ERROR, "there is no memory for a state");
  memcpy(*saved, bytes, sizeof(state));
  return OK;
}

/* What the standard asks for and this unit has none of. */
#define NONE_OF(name, type)                                                                                 \
  EXPORTED status fmi2Get##name(void *unit, const reference references[], size_t count, type found[])       \
  {                                                                                                         \
    return count ? complain(unit, ERROR, "all variables are real") : OK;                                    \
  }                                                                                                         \
  EXPORTED status fmi2Set##name(void *unit, const reference references[], size_t count, const type given[]) \
  {                                                                                                         \
    return count ? complain(unit, ERROR, "all variables are real") : OK;                                    \
  }
NONE_OF(Integer, int)
NONE_OF(Boolean, int)
NONE_OF(String, text)
