/* The interface of FMI 3.0. */
#include <stdbool.h>

typedef void (*logger)(void *environment, int status, const char *category, const char *message);

#define FMI(name) fmi3##name
#include "core.c"

typedef const char *text;
typedef const uint8_t *binary;

static void tell(const instance *unit, status found, const char *message)
{
  unit->log(unit->environment, found, CATEGORY(found), message);
}

EXPORTED text fmi3GetVersion(void) { return "3.0"; }
EXPORTED status fmi3SetDebugLogging(void *unit, bool on, size_t count, const text categories[])
{
  return check(unit, 1);
}

EXPORTED void *fmi3InstantiateCoSimulation(text name, text token, text resources, bool visible, bool logging, bool events,
                                           bool early_return, const uint32_t intermediate[], size_t count,
                                           void *environment, logger log, void (*update)(void))
{
  return count ? NULL : create(name, token, CO_SIMULATION, log, environment);
}

EXPORTED void *fmi3InstantiateModelExchange(text name, text token, text resources, bool visible, bool logging,
                                            void *environment, logger log)
{
  return create(name, token, MODEL_EXCHANGE, log, environment);
}

EXPORTED void *fmi3InstantiateScheduledExecution(text name, text token, text resources, bool visible, bool logging,
                                                 void *environment, logger log, void (*update)(void),
                                                 void (*lock)(void), void (*unlock)(void))
{
  return NULL;
}

EXPORTED status fmi3EnterInitializationMode(void *unit, bool with_tolerance, double tolerance, double start,
                                            bool with_stop, double stop)
{
  const status found = set_up(unit, start);
  return found == OK ? enter(unit, INSTANTIATED, INITIALISING) : found;
}

EXPORTED status fmi3SetFloat64(void *unit, const uint32_t references[], size_t count, const double given[], size_t size)
{
  if (size != count) return complain(unit, ERROR, "every variable is one number");
  return set_numbers(unit, references, count, given);
}

EXPORTED status fmi3GetFloat64(void *unit, const uint32_t references[], size_t count, double found[], size_t size)
{
  if (size != count) return complain(unit, ERROR, "every variable is one number");
  return get_numbers(unit, references, count, found);
}

EXPORTED status fmi3GetDirectionalDerivative(void *unit, const uint32_t unknown[], size_t unknowns,
                                             const uint32_t known[], size_t knowns, const double along[], size_t seeds,
                                             double found[], size_t size)
{
  if (seeds != knowns || size != unknowns) return complain(unit, ERROR, "every variable is one number");
  return get_slopes(unit, unknown, unknowns, known, knowns, along, found);
}

EXPORTED status fmi3GetFMUState(void *unit, void **saved) { return save(unit, saved); }
EXPORTED status fmi3SetFMUState(void *unit, void *saved) { return restore(unit, saved); }
EXPORTED status fmi3FreeFMUState(void *unit, void **saved) { return release(unit, saved); }

EXPORTED status fmi3SerializedFMUStateSize(void *unit, void *saved, size_t *size) { return measure(unit, size); }

EXPORTED status fmi3SerializeFMUState(void *unit, void *saved, uint8_t bytes[], size_t size)
{
  return to_bytes(unit, saved, bytes, size);
}

EXPORTED status fmi3DeserializeFMUState(void *unit, const uint8_t bytes[], size_t size, void **saved)
{
  return from_bytes(unit, bytes, size, saved);
}

/* --- model exchange --- */

EXPORTED status fmi3UpdateDiscreteStates(void *unit, bool *update, bool *ends, bool *nominals, bool *values, bool *defined,
                                         double *next)
{
  REQUIRE(unit, update && ends && nominals && values && defined && next);
  *update = *ends = *nominals = *values = *defined = false;
  *next = 0.0;
  return OK;
}

EXPORTED status fmi3CompletedIntegratorStep(void *unit, bool forgets, bool *enters, bool *ends)
{
  REQUIRE(unit, enters && ends);
  *enters = *ends = false;
  return OK;
}

EXPORTED status fmi3GetContinuousStateDerivatives(void *unit, double rates[], size_t count)
{
  return get_rates(unit, rates, count);
}

static status tell_size(const instance *unit, size_t *found, size_t size)
{
  REQUIRE(unit, found != NULL);
  *found = size;
  return OK;
}

EXPORTED status fmi3GetNumberOfContinuousStates(void *unit, size_t *found) { return tell_size(unit, found, STATES); }
EXPORTED status fmi3GetNumberOfEventIndicators(void *unit, size_t *found) { return tell_size(unit, found, EVENTS); }

/* --- co-simulation --- */

EXPORTED status fmi3DoStep(void *unit, double time, double step, bool final, bool *event, bool *terminate, bool *early,
                           double *reached)
{
  REQUIRE(unit, event && terminate && early && reached);
  const status found = step_on(unit, time, step);
  *event = *terminate = *early = false;
  *reached = ((instance *)unit)->now.time;
  return found;
}

/* --- what the standard asks for and this unit has none of --- */

#define NO(name, ...) \
  EXPORTED status fmi3##name(__VA_ARGS__) { return complain(unit, ERROR, "this unit has none of these"); }

#define NONE_OF(name, type)                                                                        \
  NO(Get##name, void *unit, const uint32_t references[], size_t count, type found[], size_t size)  \
  NO(Set##name, void *unit, const uint32_t references[], size_t count, const type given[], size_t size)
NONE_OF(Float32, float)
NONE_OF(Int8, int8_t)
NONE_OF(UInt8, uint8_t)
NONE_OF(Int16, int16_t)
NONE_OF(UInt16, uint16_t)
NONE_OF(Int32, int32_t)
NONE_OF(UInt32, uint32_t)
NONE_OF(Int64, int64_t)
NONE_OF(UInt64, uint64_t)
NONE_OF(Boolean, bool)
NONE_OF(String, text)
NO(GetBinary, void *unit, const uint32_t references[], size_t count, size_t sizes[], binary found[], size_t size)
NO(SetBinary, void *unit, const uint32_t references[], size_t count, const size_t sizes[], const binary given[], size_t size)
NO(GetClock, void *unit, const uint32_t references[], size_t count, bool found[])
NO(SetClock, void *unit, const uint32_t references[], size_t count, const bool given[])

NO(GetNumberOfVariableDependencies, void *unit, uint32_t reference, size_t *found)
NO(GetVariableDependencies, void *unit, uint32_t dependent, size_t elements[], uint32_t independents[],
   size_t independent_elements[], int kinds[], size_t count)
NO(GetAdjointDerivative, void *unit, const uint32_t unknown[], size_t unknowns, const uint32_t known[], size_t knowns,
   const double seed[], size_t seeds, double found[], size_t size)
NO(GetOutputDerivatives, void *unit, const uint32_t references[], size_t count, const int32_t orders[], double found[],
   size_t size)

NO(EnterConfigurationMode, void *unit)
NO(ExitConfigurationMode, void *unit)
NO(EnterStepMode, void *unit)
NO(EvaluateDiscreteStates, void *unit)
NO(ActivateModelPartition, void *unit, uint32_t clock, double time)

NO(GetIntervalDecimal, void *unit, const uint32_t clocks[], size_t count, double intervals[], int kinds[])
NO(SetIntervalDecimal, void *unit, const uint32_t clocks[], size_t count, const double intervals[])
NO(GetShiftDecimal, void *unit, const uint32_t clocks[], size_t count, double shifts[])
NO(SetShiftDecimal, void *unit, const uint32_t clocks[], size_t count, const double shifts[])
NO(GetIntervalFraction, void *unit, const uint32_t clocks[], size_t count, uint64_t counters[], uint64_t parts[], int kinds[])
NO(SetIntervalFraction, void *unit, const uint32_t clocks[], size_t count, const uint64_t counters[], const uint64_t parts[])
NO(GetShiftFraction, void *unit, const uint32_t clocks[], size_t count, uint64_t counters[], uint64_t parts[])
NO(SetShiftFraction, void *unit, const uint32_t clocks[], size_t count, const uint64_t counters[], const uint64_t parts[])
