/* The interface of FMI 2.0. */
typedef void (*logger)(void *environment, const char *instance, int status, const char *category, const char *message, ...);

#define FMI(name) fmi2##name
#include "core.c"

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
typedef const char *text;

enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, IS_TERMINATED };

static void tell(const instance *unit, status found, const char *message)
{
  unit->log(unit->environment, unit->name, found, CATEGORY(found), "%s", message);
}

EXPORTED text fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED text fmi2GetVersion(void) { return "2.0"; }
EXPORTED status fmi2SetDebugLogging(void *unit, int on, size_t count, const text categories[])
{
  return check(unit, 1);
}

EXPORTED void *fmi2Instantiate(text name, int type, text token, text resources, const callbacks *given, int visible,
                               int logging)
{
  if (type != CO_SIMULATION && type != MODEL_EXCHANGE) return NULL;
  return create(name, token, (use)type, given ? given->log : NULL, given ? given->environment : NULL);
}

EXPORTED status fmi2SetupExperiment(void *unit, int with_tolerance, double tolerance, double start, int with_stop,
                                    double stop)
{
  return set_up(unit, start);
}

EXPORTED status fmi2EnterInitializationMode(void *unit) { return enter(unit, INSTANTIATED, INITIALISING); }

EXPORTED status fmi2SetReal(void *unit, const uint32_t references[], size_t count, const double given[])
{
  return set_numbers(unit, references, count, given);
}

EXPORTED status fmi2GetReal(void *unit, const uint32_t references[], size_t count, double found[])
{
  return get_numbers(unit, references, count, found);
}

EXPORTED status fmi2GetDirectionalDerivative(void *unit, const uint32_t unknown[], size_t unknowns,
                                             const uint32_t known[], size_t knowns, const double along[],
                                             double found[])
{
  return get_slopes(unit, unknown, unknowns, known, knowns, along, found);
}

EXPORTED status fmi2GetFMUstate(void *unit, void **saved) { return save(unit, saved); }
EXPORTED status fmi2SetFMUstate(void *unit, void *saved) { return restore(unit, saved); }
EXPORTED status fmi2FreeFMUstate(void *unit, void **saved) { return release(unit, saved); }
EXPORTED status fmi2SerializedFMUstateSize(void *unit, void *saved, size_t *size) { return measure(unit, size); }

EXPORTED status fmi2SerializeFMUstate(void *unit, void *saved, char bytes[], size_t size)
{
  return to_bytes(unit, saved, bytes, size);
}

EXPORTED status fmi2DeSerializeFMUstate(void *unit, const char bytes[], size_t size, void **saved)
{
  return from_bytes(unit, bytes, size, saved);
}

/* --- model exchange --- */

EXPORTED status fmi2NewDiscreteStates(void *unit, event_info *found)
{
  REQUIRE(unit, found != NULL);
  memset(found, 0, sizeof *found);
  return OK;
}

EXPORTED status fmi2CompletedIntegratorStep(void *unit, int forgets, int *enters, int *ends)
{
  REQUIRE(unit, enters && ends);
  *enters = *ends = 0;
  return OK;
}

EXPORTED status fmi2GetDerivatives(void *unit, double rates[], size_t count) { return get_rates(unit, rates, count); }

/* --- co-simulation --- */

EXPORTED status fmi2DoStep(void *unit, double time, double step, int final) { return step_on(unit, time, step); }

EXPORTED status fmi2GetRealStatus(void *component, int kind, double *found)
{
  const instance *unit = component;
  REQUIRE(unit, found != NULL);
  if (kind != LAST_SUCCESSFUL_TIME) return complain(unit, DISCARD, "this status is no real number");
  *found = unit->now.time;
  return OK;
}

EXPORTED status fmi2GetBooleanStatus(void *unit, int kind, int *found)
{
  REQUIRE(unit, found != NULL);
  if (kind != IS_TERMINATED) return complain(unit, DISCARD, "this status is no truth value");
  *found = 0;
  return OK;
}

/* --- what the standard asks for and this unit has none of --- */

#define NONE_OF(name, type)                                                                                \
  EXPORTED status fmi2Get##name(void *unit, const uint32_t references[], size_t count, type found[])       \
  {                                                                                                        \
    return count ? complain(unit, ERROR, "all variables are real") : check(unit, 1);                       \
  }                                                                                                        \
  EXPORTED status fmi2Set##name(void *unit, const uint32_t references[], size_t count, const type given[]) \
  {                                                                                                        \
    return count ? complain(unit, ERROR, "all variables are real") : check(unit, 1);                       \
  }
NONE_OF(Integer, int)
NONE_OF(Boolean, int)
NONE_OF(String, text)

#define NO_STATUS(name, type)                                        \
  EXPORTED status fmi2Get##name(void *unit, int kind, type *found)   \
  {                                                                  \
    return complain(unit, DISCARD, "no step is pending");            \
  }
NO_STATUS(Status, status)
NO_STATUS(IntegerStatus, int)
NO_STATUS(StringStatus, text)

EXPORTED status fmi2SetRealInputDerivatives(void *unit, const uint32_t references[], size_t count, const int order[],
                                            const double given[])
{
  return count ? complain(unit, ERROR, "an input is held over a step") : check(unit, 1);
}

EXPORTED status fmi2GetRealOutputDerivatives(void *unit, const uint32_t references[], size_t count, const int order[],
                                             double found[])
{
  return count ? complain(unit, ERROR, "there are no derivatives") : check(unit, 1);
}

EXPORTED status fmi2CancelStep(void *unit) { return complain(unit, ERROR, "a step has ended when it returns"); }
