/* A co-simulation unit by FMI 2.0 around a model that has no states but how far its input has turned it.
 *
 * Stands behind what the model brings: GUID, the number SET of inputs and parameters, which come first, and OUTPUTS;
 * `starts` and `names` (SET); `evaluate(memory *, values, turned, outputs)`, nonzero where a result is not finite, which
 * works on a `memory` that begins as zeros; `rate(values)`, by which `turned` grows with time.
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

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void (*logger)(void *environment, const char *instance, fmi2Status status, const char *category,
                       const char *message, ...);
typedef struct {
  logger log;
  void *(*allocate)(size_t count, size_t size);
  void (*release)(void *memory);
  void (*finished)(void *environment, fmi2Status status);
  void *environment;
} callbacks;

typedef enum { INSTANTIATED, INITIALISING, STEPPING, TERMINATED } phase;

/* All that a state is: what is saved and restored. */
typedef struct {
  char guid[sizeof GUID];
  phase phase;
  double time, turned, values[SET];
} state;

typedef struct {
  state now;
  int known; /* whether the outputs are those of the state */
  double outputs[OUTPUTS];
  memory work;
  callbacks told;
  char *name;
} instance;

static void begin(state *now)
{
  memset(now, 0, sizeof *now);
  memcpy(now->guid, GUID, sizeof GUID);
  memcpy(now->values, starts, sizeof starts);
}

static fmi2Status complain(const instance *unit, fmi2Status status, const char *message)
{
  if (unit->told.log)
    unit->told.log(unit->told.environment, unit->name, status, "logStatusError", "%s", message);
  return status;
}

static int is_number(double value)
{
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

EXPORTED fmi2Status fmi2SetDebugLogging(void *unit, int on, size_t count, const char *const categories[])
{
  (void)unit, (void)on, (void)count, (void)categories;
  return fmi2OK;
}

EXPORTED void *fmi2Instantiate(const char *name, fmi2Type type, const char *guid, const char *resources,
                               const callbacks *told, int visible, int logging)
{
  (void)resources, (void)visible, (void)logging;
  instance *unit = calloc(1, sizeof *unit);
  if (!unit) return NULL;
  if (told) unit->told = *told;
  unit->name = calloc(name ? strlen(name) + 1 : 1, 1);
  if (!unit->name || type != fmi2CoSimulation || !guid || strcmp(guid, GUID) != 0) {
    complain(unit, fmi2Error, "this unit is for co-simulation, and of another guid than its description");
    free(unit->name);
    free(unit);
    return NULL;
  }
  if (name) strcpy(unit->name, name);
  begin(&unit->now);
  return unit;
}

EXPORTED void fmi2FreeInstance(void *component)
{
  instance *unit = component;
  if (unit) free(unit->name);
  free(unit);
}

EXPORTED fmi2Status fmi2SetupExperiment(void *component, int with_tolerance, double tolerance, double start,
                                        int with_stop, double stop)
{
  instance *unit = component;
  (void)with_tolerance, (void)tolerance, (void)with_stop, (void)stop;
  if (unit->now.phase != INSTANTIATED) return complain(unit, fmi2Error, "an experiment is set up before it begins");
  unit->now.time = start;
  return fmi2OK;
}

static fmi2Status enter(instance *unit, phase from, phase to)
{
  if (unit->now.phase != from) return complain(unit, fmi2Error, "this is not its turn");
  unit->now.phase = to;
  return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(void *unit) { return enter(unit, INSTANTIATED, INITIALISING); }
EXPORTED fmi2Status fmi2ExitInitializationMode(void *unit) { return enter(unit, INITIALISING, STEPPING); }
EXPORTED fmi2Status fmi2Terminate(void *unit) { return enter(unit, STEPPING, TERMINATED); }

EXPORTED fmi2Status fmi2Reset(void *component)
{
  instance *unit = component;
  begin(&unit->now);
  unit->known = 0;
  return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(void *component, const unsigned references[], size_t count, const double given[])
{
  instance *unit = component;
  for (size_t i = 0; i < count; ++i) {
    if (references[i] >= SET) return complain(unit, fmi2Error, "only inputs and parameters can be set");
    if (!is_number(given[i])) return complain(unit, fmi2Discard, names[references[i]]);
    unit->now.values[references[i]] = given[i];
  }
  unit->known = 0;
  return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(void *component, const unsigned references[], size_t count, double found[])
{
  instance *unit = component;
  for (size_t i = 0; i < count; ++i) {
    if (references[i] >= SET + OUTPUTS) return complain(unit, fmi2Error, "there is no variable of this reference");
    if (references[i] < SET) {
      found[i] = unit->now.values[references[i]];
      continue;
    }
    if (!unit->known && evaluate(&unit->work, unit->now.values, unit->now.turned, unit->outputs))
      return complain(unit, fmi2Discard, "a result is not finite with these parameters");
    unit->known = 1;
    found[i] = unit->outputs[references[i] - SET];
  }
  return fmi2OK;
}

EXPORTED fmi2Status fmi2DoStep(void *component, double time, double step, int final)
{
  instance *unit = component;
  (void)final;
  if (unit->now.phase != STEPPING) return complain(unit, fmi2Error, "a step comes after the initialisation");
  if (!is_number(time) || !is_number(step) || step < 0.0)
    return complain(unit, fmi2Error, "time does not go backwards");
  unit->now.turned += rate(unit->now.values) * step;
  unit->now.time = time + step;
  unit->known = 0;
  return fmi2OK;
}

/* States: all that is saved is `state`, which holds no addresses. */

EXPORTED fmi2Status fmi2GetFMUstate(void *component, void **saved)
{
  const instance *unit = component;
  if (!*saved) *saved = malloc(sizeof(state));
  if (!*saved) return complain(unit, fmi2Error, "there is no memory for a state");
  memcpy(*saved, &unit->now, sizeof(state));
  return fmi2OK;
}

EXPORTED fmi2Status fmi2SetFMUstate(void *component, void *saved)
{
  instance *unit = component;
  if (!saved || memcmp(saved, GUID, sizeof GUID) != 0) return complain(unit, fmi2Error, "this is no state of this unit");
  memcpy(&unit->now, saved, sizeof(state));
  unit->known = 0;
  return fmi2OK;
}

EXPORTED fmi2Status fmi2FreeFMUstate(void *unit, void **saved)
{
  (void)unit;
  if (saved) {
    free(*saved);
    *saved = NULL;
  }
  return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(void *unit, void *saved, size_t *size)
{
  (void)unit, (void)saved;
  *size = sizeof(state);
  return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(void *unit, void *saved, char bytes[], size_t size)
{
  if (!saved || size < sizeof(state)) return complain(unit, fmi2Error, "there is no room for a state");
  memcpy(bytes, saved, sizeof(state));
  return fmi2OK;
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(void *unit, const char bytes[], size_t size, void **saved)
{
  if (size != sizeof(state) || memcmp(bytes, GUID, sizeof GUID) != 0)
    return complain(unit, fmi2Error, "these bytes are no state of this unit");
  if (!*saved) *saved = malloc(sizeof(state));
  if (!*saved) return complain(unit, fmi2Error, "there is no memory for a state");
  memcpy(*saved, bytes, sizeof(state));
  return fmi2OK;
}

/* What the standard asks for and this unit has none of. */

#define NONE_OF(name, type)                                                                                   \
  EXPORTED fmi2Status fmi2Get##name(void *unit, const unsigned references[], size_t count, type found[])       \
  {                                                                                                            \
    (void)references, (void)found;                                                                             \
    return count ? complain(unit, fmi2Error, "all variables are real") : fmi2OK;                               \
  }                                                                                                            \
  EXPORTED fmi2Status fmi2Set##name(void *unit, const unsigned references[], size_t count, const type given[]) \
  {                                                                                                            \
    (void)references, (void)given;                                                                             \
    return count ? complain(unit, fmi2Error, "all variables are real") : fmi2OK;                               \
  }
typedef const char *text;
NONE_OF(Integer, int)
NONE_OF(Boolean, int)
NONE_OF(String, text)

EXPORTED fmi2Status fmi2GetDirectionalDerivative(void *unit, const unsigned unknown[], size_t unknowns,
                                                 const unsigned known[], size_t knowns, const double along[],
                                                 double found[])
{
  (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)along, (void)found;
  return complain(unit, fmi2Error, "there are no derivatives");
}

EXPORTED fmi2Status fmi2SetRealInputDerivatives(void *unit, const unsigned references[], size_t count,
                                                const int order[], const double given[])
{
  (void)references, (void)order, (void)given;
  return count ? complain(unit, fmi2Error, "an input is held over a step") : fmi2OK;
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(void *unit, const unsigned references[], size_t count,
                                                 const int order[], double found[])
{
  (void)references, (void)order, (void)found;
  return count ? complain(unit, fmi2Error, "there are no derivatives") : fmi2OK;
}

EXPORTED fmi2Status fmi2CancelStep(void *unit) { return complain(unit, fmi2Error, "a step has ended when it returns"); }

EXPORTED fmi2Status fmi2GetStatus(void *unit, fmi2StatusKind kind, fmi2Status *found)
{
  (void)kind, (void)found;
  return complain(unit, fmi2Discard, "no step is pending");
}

EXPORTED fmi2Status fmi2GetRealStatus(void *component, fmi2StatusKind kind, double *found)
{
  const instance *unit = component;
  if (kind != fmi2LastSuccessfulTime) return complain(unit, fmi2Discard, "this status is no real number");
  *found = unit->now.time;
  return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(void *unit, fmi2StatusKind kind, int *found)
{
  (void)kind, (void)found;
  return complain(unit, fmi2Discard, "no status is an integer");
}

EXPORTED fmi2Status fmi2GetBooleanStatus(void *unit, fmi2StatusKind kind, int *found)
{
  if (kind != fmi2Terminated) return complain(unit, fmi2Discard, "this status is no truth value");
  *found = 0;
  return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(void *unit, fmi2StatusKind kind, const char **found)
{
  (void)kind, (void)found;
  return complain(unit, fmi2Discard, "no step is pending");
}
