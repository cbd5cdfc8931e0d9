/* FMI 2.0 for co-simulation and, for a guest, model exchange. */
#include "fmi2Functions.h"
#include "fmu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    fmu *model;
    char *name;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    int is_logging;
} component;

static fmi2Status fail(component *c, const char *words)
{
    if (c->logger != NULL) {
        c->logger(c->environment, c->name, fmi2Error, "logStatusError", "%s", words);
    }
    return fmi2Error;
}

static fmi2Status status_of(component *c, int is_well)
{
    return is_well ? fmi2OK : fail(c, c->model->problem);
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)count;
    (void)categories;
    ((component *)c)->is_logging = on;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String location,
        const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    component told = {NULL, (char *)name, functions == NULL ? NULL : functions->logger,
            functions == NULL ? NULL : functions->componentEnvironment, logging};
    (void)location;
    (void)visible;
    if (name == NULL || *name == '\0') {
        told.name = (char *)"FMU";
        fail(&told, "an instance needs a name");
        return NULL;
    }
    if (type == fmi2ModelExchange && !FMU_IS_GUEST) {
        fail(&told, "this FMU is for co-simulation only");
        return NULL;
    }
    if (token == NULL || strcmp(token, FMU_TOKEN) != 0) {
        fail(&told, "the guid is that of another FMU");
        return NULL;
    }
    component *c = calloc(1, sizeof *c);
    char *own = malloc(strlen(name) + 1);
    fmu *model = fmu_new();
    if (c == NULL || own == NULL || model == NULL) {
        free(c);
        free(own);
        free(model);
        fail(&told, "there is no memory left");
        return NULL;
    }
    strcpy(own, name);
    *c = told;
    c->name = own;
    c->model = model;
    return c;
}

void fmi2FreeInstance(fmi2Component instance)
{
    component *c = instance;
    if (c != NULL) {
        free(c->model);
        free(c->name);
        free(c);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
        fmi2Boolean has_stop, fmi2Real stop)
{
    (void)has_stop;
    (void)stop;
    fmu *model = ((component *)c)->model;
    const fmu_phase before = model->kept.phase;
    if (before != FMU_CREATED) {
        return fail(c, "the experiment can be set up before initialisation only");
    }
    const int is_well = fmu_setup(model, start, has_tolerance, tolerance);
    model->kept.phase = before;
    return status_of(c, is_well);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    fmu *model = ((component *)c)->model;
    if (model->kept.phase != FMU_CREATED) {
        return fail(c, "the model was initialised before");
    }
    return status_of(c, fmu_setup(model, FMU_BEGIN, 0, 0.0));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return status_of(c, fmu_begin(((component *)c)->model));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ((component *)c)->model->kept.phase = FMU_ENDED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    fmu_reset(((component *)c)->model);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    return status_of(c, fmu_get(((component *)c)->model, references, count, values));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Real values[])
{
    return status_of(c, fmu_set(((component *)c)->model, references, count, values));
}

static fmi2Status only_real(fmi2Component c, size_t count)
{
    return count == 0 ? fmi2OK : fail(c, "all variables are real");
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Integer values[])
{
    (void)references;
    (void)values;
    return only_real(c, count);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Boolean values[])
{
    (void)references;
    (void)values;
    return only_real(c, count);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2String values[])
{
    (void)references;
    (void)values;
    return only_real(c, count);
}

fmi2Status fmi2SetInteger(
        fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Integer values[])
{
    (void)references;
    (void)values;
    return only_real(c, count);
}

fmi2Status fmi2SetBoolean(
        fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Boolean values[])
{
    (void)references;
    (void)values;
    return only_real(c, count);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2String values[])
{
    (void)references;
    (void)values;
    return only_real(c, count);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    fmu_kept *kept = fmu_copy(((component *)c)->model);
    if (kept == NULL) {
        return fail(c, "there is no memory left");
    }
    free(*state);
    *state = kept;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    return status_of(c, fmu_restore(((component *)c)->model, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(fmu_kept);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size < sizeof(fmu_kept)) {
        return fail(c, "the room for the state is too small");
    }
    memcpy(bytes, state, sizeof(fmu_kept));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    fmu_kept *kept = NULL;
    if (!fmu_restore_bytes(((component *)c)->model, bytes, size, &kept)) {
        return status_of(c, 0);
    }
    free(*state);
    *state = kept;
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
        const fmi2Integer orders[], const fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    return fail(c, "derivatives of inputs are not used");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
        const fmi2Integer orders[], fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    return fail(c, "derivatives of outputs are not provided");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean is_final)
{
    (void)is_final;
    return status_of(c, fmu_step(((component *)c)->model, time, size, 0));
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return fail(c, "steps are not asynchronous");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind;
    (void)value;
    return fail(c, "steps are not asynchronous");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) {
        return fail(c, "the only status that is a number is the last successful time");
    }
    *value = ((component *)c)->model->kept.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    (void)value;
    return fail(c, "steps are not asynchronous");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated) {
        return fail(c, "the only status that is a truth is whether the model has ended");
    }
    *value = ((component *)c)->model->kept.phase == FMU_ENDED;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind;
    (void)value;
    return fail(c, "steps are not asynchronous");
}

/* Model exchange. */

#if FMU_IS_GUEST
#define AS_GUEST(call) status_of(c, call)
#define MODEL (((component *)c)->model)
#else
#define AS_GUEST(call) fail(c, "this FMU is for co-simulation only")
#endif

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    return AS_GUEST(1);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *found)
{
    memset(found, 0, sizeof *found);
    const fmi2Status status = AS_GUEST(fmu_enter(MODEL));
#if FMU_IS_GUEST
    found->nextEventTimeDefined = isfinite(MODEL->kept.next) ? fmi2True : fmi2False;
    found->nextEventTime = MODEL->kept.next;
#endif
    return status;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    return AS_GUEST(1);
}

fmi2Status fmi2CompletedIntegratorStep(
        fmi2Component c, fmi2Boolean is_kept, fmi2Boolean *enters_event, fmi2Boolean *terminates)
{
    (void)is_kept;
    *enters_event = *terminates = fmi2False;
    return AS_GUEST(fmu_complete(MODEL));
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    (void)time;
    return AS_GUEST(fmu_move(MODEL, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_put_states(MODEL, x, count));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_derive(MODEL, x, count));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_indicate(MODEL, x, count));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_get_states(MODEL, x, count));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return AS_GUEST(fmu_get_nominals(MODEL, x, count));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real seed[], fmi2Real found[])
{
#if FMU_IS_GUEST
    const fmu_direction way = {knowns, seed, known_count};
    return status_of(c, fmu_derive_along(MODEL, &way, unknowns, unknown_count, found));
#else
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)found;
    return fail(c, "directional derivatives are not provided");
#endif
}
