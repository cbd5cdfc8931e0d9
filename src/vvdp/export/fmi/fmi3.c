/* FMI 3.0 for co-simulation and, for a guest, model exchange. */
#include "fmi3Functions.h"
#include "fmu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    fmu *model;
    fmi3LogMessageCallback logger;
    fmi3InstanceEnvironment environment;
    int is_logging;
    int is_solved;   /* by its own loop: co-simulation */
    int has_events;  /* the host handles them in event mode */
    int may_return;  /* at an event, before the end of a step */
} component;

static fmi3Status fail(component *c, const char *words)
{
    if (c->logger != NULL) {
        c->logger(c->environment, fmi3Error, "logStatusError", words);
    }
    return fmi3Error;
}

static fmi3Status status_of(component *c, int is_well)
{
    return is_well ? fmi3OK : fail(c, c->model->problem);
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    (void)count;
    (void)categories;
    ((component *)c)->is_logging = on;
    return fmi3OK;
}

/* An instance; NULL, told to the logger, where it cannot be made. */
static fmi3Instance instance_of(component told, fmi3String name, fmi3String token)
{
    if (name == NULL || *name == '\0') {
        fail(&told, "an instance needs a name");
        return NULL;
    }
    if (token == NULL || strcmp(token, FMU_TOKEN) != 0) {
        fail(&told, "the instantiation token is that of another FMU");
        return NULL;
    }
    component *c = calloc(1, sizeof *c);
    fmu *model = fmu_new();
    if (c == NULL || model == NULL) {
        free(c);
        free(model);
        fail(&told, "there is no memory left");
        return NULL;
    }
    *c = told;
    c->model = model;
    return c;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
        fmi3Boolean logging, fmi3Boolean with_events, fmi3Boolean early_return,
        const fmi3ValueReference intermediate[], size_t intermediate_count, fmi3InstanceEnvironment environment,
        fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update)
{
    component told = {NULL, logger, environment, logging, 1, with_events, early_return};
    (void)resources;
    (void)visible;
    (void)intermediate;
    (void)update;
    if (intermediate_count != 0) {
        fail(&told, "intermediate variables are not provided");
        return NULL;
    }
    return instance_of(told, name, token);
}

static fmi3Instance only_co_simulation(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    component told = {NULL, logger, environment, 0, 0, 0, 0};
    fail(&told, "this FMU is for co-simulation only");
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
        fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    (void)resources;
    (void)visible;
#if FMU_IS_GUEST
    const component told = {NULL, logger, environment, logging, 0, 1, 0};
    return instance_of(told, name, token);
#else
    (void)name;
    (void)token;
    (void)logging;
    return only_co_simulation(environment, logger);
#endif
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
        fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
        fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    return only_co_simulation(environment, logger);
}

void fmi3FreeInstance(fmi3Instance instance)
{
    component *c = instance;
    if (c != NULL) {
        free(c->model);
        free(c);
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
        fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop)
{
    (void)has_stop;
    (void)stop;
    fmu *model = ((component *)c)->model;
    if (model->kept.phase != FMU_CREATED) {
        return fail(c, "the model was initialised before");
    }
    return status_of(c, fmu_setup(model, start, has_tolerance, tolerance));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return status_of(c, fmu_begin(((component *)c)->model));
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    ((component *)c)->model->kept.phase = FMU_ENDED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    fmu_reset(((component *)c)->model);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t count, fmi3Float64 values[],
        size_t value_count)
{
    if (count != value_count) {
        return fail(c, "all variables are scalars");
    }
    return status_of(c, fmu_get(((component *)c)->model, references, count, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t count,
        const fmi3Float64 values[], size_t value_count)
{
    if (count != value_count) {
        return fail(c, "all variables are scalars");
    }
    return status_of(c, fmu_set(((component *)c)->model, references, count, values));
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    fmu_kept *kept = fmu_copy(((component *)c)->model);
    if (kept == NULL) {
        return fail(c, "there is no memory left");
    }
    free(*state);
    *state = kept;
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    return status_of(c, fmu_restore(((component *)c)->model, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(fmu_kept);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size < sizeof(fmu_kept)) {
        return fail(c, "the room for the state is too small");
    }
    memcpy(bytes, state, sizeof(fmu_kept));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    fmu_kept *kept = NULL;
    if (!fmu_restore_bytes(((component *)c)->model, bytes, size, &kept)) {
        return status_of(c, 0);
    }
    free(*state);
    *state = kept;
    return fmi3OK;
}

static fmi3Status with_events(component *c)
{
    return c->has_events ? fmi3OK : fail(c, "the instance was made without event mode");
}

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    return with_events(c);
}

fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    return with_events(c);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 size, fmi3Boolean keeps_state,
        fmi3Boolean *needs_event, fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *last)
{
    component *c = instance;
    (void)keeps_state;
    const int is_well = fmu_step(c->model, time, size, c->has_events && c->may_return);
    *terminate = fmi3False;
    *last = c->model->kept.time;
    *needs_event = is_well && c->model->kept.is_before;
    *early_return = *needs_event && *last < time + size - 1e-9 * FMU_PERIOD;
    return status_of(c, is_well);
}

/* What happens at an event, and when the next one that is known is. */
static int pass(component *c, double *next)
{
#if FMU_IS_GUEST
    if (!c->is_solved) {
        const int is_well = fmu_enter(c->model);
        *next = c->model->kept.next;
        return is_well;
    }
#endif
    return fmu_pass(c->model, next);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminates, fmi3Boolean *nominals,
        fmi3Boolean *values, fmi3Boolean *is_known, fmi3Float64 *next)
{
    *again = *terminates = *nominals = *values = fmi3False;
    *next = INFINITY;
    const fmi3Status status = with_events(c) == fmi3OK ? status_of(c, pass(c, next)) : fmi3Error;
    *is_known = isfinite(*next) ? fmi3True : fmi3False;
    return status;
}

/* Model exchange. */

#if FMU_IS_GUEST
#define AS_GUEST(call) status_of(c, call)
#define MODEL (((component *)c)->model)
enum { CARRIED = FMU_CARRIED, INDICATORS = FMU_INDICATORS };
#else
#define AS_GUEST(call) fail(c, "this FMU is for co-simulation only")
enum { CARRIED = 0, INDICATORS = 0 };
#endif

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c)
{
    return AS_GUEST(1);
}

fmi3Status fmi3CompletedIntegratorStep(
        fmi3Instance c, fmi3Boolean is_kept, fmi3Boolean *enters_event, fmi3Boolean *terminates)
{
    (void)is_kept;
    *enters_event = *terminates = fmi3False;
    return AS_GUEST(fmu_complete(MODEL));
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time)
{
    (void)time;
    return AS_GUEST(fmu_move(MODEL, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_put_states(MODEL, x, count));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_derive(MODEL, x, count));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_indicate(MODEL, x, count));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_get_states(MODEL, x, count));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_get_nominals(MODEL, x, count));
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count)
{
    *count = INDICATORS;
    return AS_GUEST(1);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count)
{
    *count = CARRIED;
    return AS_GUEST(1);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t unknown_count,
        const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
        fmi3Float64 found[], size_t found_count)
{
#if FMU_IS_GUEST
    if (seed_count != known_count || found_count != unknown_count) {
        return fail(c, "all variables are scalars");
    }
    const fmu_direction way = {knowns, seed, known_count};
    return status_of(c, fmu_derive_along(MODEL, &way, unknowns, unknown_count, found));
#else
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)seed_count;
    (void)found;
    (void)found_count;
    return fail(c, "directional derivatives are not provided");
#endif
}

/* What this FMU does not provide. */

fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Float32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
        fmi3Int8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3UInt8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Int16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3UInt16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Int32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3UInt32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Int64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3UInt64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Boolean values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3String values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)valueReferences;
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Clock values[])
{
    for (size_t i = 0; i < count; i++) {
        if (!FMU_HAS_MARKS || references[i] != FMU_MARK_CLOCK) {
            return fail(instance, "there is no clock with this reference");
        }
        values[i] = fmu_ticks(((component *)instance)->model) ? fmi3ClockActive : fmi3ClockInactive;
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Float32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
        const fmi3Int8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3UInt8 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Int16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3UInt16 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Int32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3UInt32 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Int64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3UInt64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Boolean values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3String values[], size_t nValues)
{
    (void)valueReferences;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)valueReferences;
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Clock values[])
{
    (void)valueReferences;
    (void)values;
    return nValueReferences == 0 ? fmi3OK : fail(instance, "all variables are of the type Float64");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference,
        size_t* nDependencies)
{
    (void)valueReference;
    (void)nDependencies;
    return fail(instance, "fmi3GetNumberOfVariableDependencies is not provided");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
        size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
        size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    (void)dependent;
    (void)elementIndicesOfDependent;
    (void)independents;
    (void)elementIndicesOfIndependents;
    (void)dependencyKinds;
    (void)nDependencies;
    return fail(instance, "fmi3GetVariableDependencies is not provided");
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
        fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)unknowns;
    (void)nUnknowns;
    (void)knowns;
    (void)nKnowns;
    (void)seed;
    (void)nSeed;
    (void)sensitivity;
    (void)nSensitivity;
    return fail(instance, "fmi3GetAdjointDerivative is not provided");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return fail(instance, "fmi3EnterConfigurationMode is not provided");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return fail(instance, "fmi3ExitConfigurationMode is not provided");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)intervals;
    (void)qualifiers;
    return fail(instance, "fmi3GetIntervalDecimal is not provided");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
        fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return fail(instance, "fmi3GetIntervalFraction is not provided");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3Float64 shifts[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)shifts;
    return fail(instance, "fmi3GetShiftDecimal is not provided");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)counters;
    (void)resolutions;
    return fail(instance, "fmi3GetShiftFraction is not provided");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Float64 intervals[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)intervals;
    return fail(instance, "fmi3SetIntervalDecimal is not provided");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)counters;
    (void)resolutions;
    return fail(instance, "fmi3SetIntervalFraction is not provided");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Float64 shifts[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)shifts;
    return fail(instance, "fmi3SetShiftDecimal is not provided");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)counters;
    (void)resolutions;
    return fail(instance, "fmi3SetShiftFraction is not provided");
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    return fail(instance, "fmi3EvaluateDiscreteStates is not provided");
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
        size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
{
    (void)valueReferences;
    (void)nValueReferences;
    (void)orders;
    (void)values;
    (void)nValues;
    return fail(instance, "fmi3GetOutputDerivatives is not provided");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
        fmi3Float64 activationTime)
{
    (void)clockReference;
    (void)activationTime;
    return fail(instance, "fmi3ActivateModelPartition is not provided");
}
