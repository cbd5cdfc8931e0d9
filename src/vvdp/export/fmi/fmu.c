/* A machine with its variables by reference, for both versions of FMI. */
#include "fmu.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_SETTABLE 1u
#define FIRST_OUTPUT (FIRST_SETTABLE + FMU_SETTABLES)

int fmu_fail(fmu *f, const char *words)
{
    snprintf(f->problem, sizeof f->problem, "%s", words);
    return 0;
}

fmu *fmu_new(void)
{
    fmu *f = calloc(1, sizeof *f);
    if (f != NULL) {
        fmu_reset(f);
    }
    return f;
}

void fmu_reset(fmu *f)
{
    memset(f, 0, sizeof *f);
    strcpy(f->kept.token, FMU_TOKEN);
    fmu_model_start(&f->kept.machine);
    f->kept.time = FMU_BEGIN;
#if FMU_IS_GUEST
    f->kept.next = FMU_BEGIN;
#endif
    for (int i = 0; i < FMU_SETTABLES; i++) {
        f->kept.values[i] = fmu_settables[i].start;
    }
}

static double *vector_of(fmu_machine *machine, unsigned vector)
{
    switch (vector) {
    case FMU_STATE:
        return machine->state;
    case FMU_COMMAND:
        return machine->command;
    case FMU_MEMORY:
        return machine->memory;
    default:
        return machine->parameters;
    }
}

static double result_of(unsigned operation, double x, double constant)
{
    switch (operation) {
    case FMU_ADD:
        return x + constant;
    case FMU_TIMES:
        return x * constant;
    case FMU_BY:
        return x / constant;
    default:
        return constant / x;
    }
}

/* Numbers of outputs: before the first step those that the run would begin with. */
static int show(fmu *f)
{
    if (f->is_shown) {
        return 1;
    }
    memcpy(&f->shown, &f->kept.machine, sizeof f->shown);
    if (f->kept.is_before) {
        memcpy(f->shown.command, f->kept.before, sizeof f->shown.command);
    }
    if (f->kept.phase < FMU_RUNNING && fmu_model_run(&f->shown, FMU_BEGIN, NULL) != 0) {
        return fmu_fail(f, "a run cannot begin with these values");
    }
    if (fmu_model_outputs(&f->shown, &f->outputs) != 0) {
        return fmu_fail(f, "the outputs cannot be calculated");
    }
#if FMU_IS_GUEST
    if (fmu_model_derive(&f->shown, f->kept.time, f->kept.next, f->rates) != 0
            || fmu_model_indicate(&f->shown, f->kept.time, f->kept.next, f->indicators) != 0) {
        return fmu_fail(f, "the rates cannot be calculated");
    }
#endif
    f->is_shown = 1;
    return 1;
}

#if FMU_IS_GUEST
fmu_machine *fmu_begun(fmu *f)
{
    if (f->kept.phase >= FMU_RUNNING) {
        return &f->kept.machine;
    }
    return show(f) ? &f->shown : NULL;
}
#endif

static double number_of(fmu *f, const fmu_output *output)
{
    switch (output->vector) {
    case FMU_OUTPUT:
        return ((const double *)&f->outputs)[output->place];
#if FMU_IS_GUEST
    case FMU_RATE:
        return f->rates[output->place];
    case FMU_INDICATOR:
        return f->indicators[output->place];
#endif
    default:
        return vector_of(&f->shown, output->vector)[output->place];
    }
}

int fmu_get(fmu *f, const uint32_t *references, size_t count, double *values)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t r = references[i];
        if (FMU_HAS_TIME && r == 0u) {
            values[i] = f->kept.time;
        } else if (FMU_HAS_MARKS && r == FMU_MARK_TIME) {
            const int stored = (int)f->kept.machine.clock[FMU_CLOCK_STORED];
            values[i] = stored > 0 ? f->kept.machine.mark_times[stored - 1] : FMU_BEGIN;
        } else if (r >= FIRST_SETTABLE && r < FIRST_OUTPUT) {
            values[i] = f->kept.values[r - FIRST_SETTABLE];
        } else if (r >= FIRST_OUTPUT && r < FIRST_OUTPUT + FMU_OUTPUTS) {
            if (!show(f)) {
                return 0;
            }
            values[i] = number_of(f, &fmu_outputs[r - FIRST_OUTPUT]);
        } else {
            snprintf(f->problem, sizeof f->problem, "there is no variable with the reference %u", (unsigned)r);
            return 0;
        }
    }
    return 1;
}

/* Whether a variable may have a value now. */
static int may_set(fmu *f, uint32_t r, double value)
{
    if (r < FIRST_SETTABLE || r >= FIRST_OUTPUT) {
        const char *words = r >= FIRST_OUTPUT && r < FIRST_OUTPUT + FMU_OUTPUTS ? "is an output and cannot be set"
                                                                                : "is no variable that can be set";
        snprintf(f->problem, sizeof f->problem, "the reference %u %s", (unsigned)r, words);
        return 0;
    }
    const fmu_settable *own = &fmu_settables[r - FIRST_SETTABLE];
    const char *name = &fmu_names[own->name];
    if (!(value >= own->low && value <= own->high)) {
        snprintf(f->problem, sizeof f->problem, "%.100s: %g is outside %g to %g", name, value, own->low, own->high);
        return 0;
    }
    if (f->kept.phase > FMU_RUNNING || (f->kept.phase == FMU_RUNNING && own->role == FMU_FIXED)) {
        snprintf(f->problem, sizeof f->problem, "%.100s can be set before the first step only", name);
        return 0;
    }
    return 1;
}

int fmu_set(fmu *f, const uint32_t *references, size_t count, const double *values)
{
    for (size_t i = 0; i < count; i++) {
        if (!may_set(f, references[i], values[i])) {
            return 0;
        }
    }
    for (size_t i = 0; i < count; i++) {
        const int variable = (int)(references[i] - FIRST_SETTABLE);
        f->kept.values[variable] = values[i];
        for (int k = 0; k < FMU_FOLLOWERS; k++) {
            const fmu_follower *own = &fmu_followers[k];
            if (own->variable == variable) {
                const double x = result_of(own->operation, values[i], own->constant);
                vector_of(&f->kept.machine, own->vector)[own->place] = x;
            }
        }
    }
    f->is_shown = 0;
    return 1;
}

int fmu_setup(fmu *f, double start, int has_tolerance, double tolerance)
{
    if (start != FMU_BEGIN) {
        snprintf(f->problem, sizeof f->problem, "the start time must be %g s; it is %g s", FMU_BEGIN, start);
        return 0;
    }
    if (has_tolerance && !(tolerance > 0.0 && tolerance < 1.0)) {
        return fmu_fail(f, "the tolerance must be between 0 and 1");
    }
    f->kept.phase = FMU_INITIALISING;
    return 1;
}

int fmu_begin(fmu *f)
{
    if (f->kept.phase != FMU_INITIALISING) {
        return fmu_fail(f, "initialisation was not entered");
    }
    for (int i = 0; i < FMU_STATES; i++) {
        f->kept.machine.lowest[i] = f->kept.machine.highest[i] = f->kept.machine.state[i];
    }
    f->is_shown = 0;
    if (fmu_model_run(&f->kept.machine, FMU_BEGIN, NULL) != 0) {
        f->kept.phase = FMU_FAILED;
        return fmu_fail(f, "a run cannot begin with these values");
    }
    f->kept.phase = FMU_RUNNING;
    return 1;
}

/* A sample that rounding puts beside a time is at that time. */
static double on_sample(double time)
{
    const double number = floor((time - FMU_BEGIN) / FMU_PERIOD + 0.5);
    const double sample = FMU_BEGIN + number * FMU_PERIOD;
    return fabs(time - sample) < 1e-9 * FMU_PERIOD ? sample : time;
}

int fmu_next(fmu *f, double *next)
{
    const int answer = fmu_model_upcoming(&f->kept.machine, fmu_model_time(&f->kept.machine), next);
    return answer == 0 || fmu_fail(f, "the time of the next event cannot be calculated");
}

int fmu_pass(fmu *f, double *next)
{
    if (f->kept.phase != FMU_RUNNING) {
        return fmu_fail(f, "an event needs an initialised model that has neither ended nor failed");
    }
    f->kept.is_before = f->is_shown = 0;
    f->kept.marks = f->kept.machine.clock[FMU_CLOCK_MARKS];
    return fmu_next(f, next);
}

int fmu_ticks(const fmu *f)
{
    return f->kept.machine.clock[FMU_CLOCK_MARKS] != f->kept.marks;
}

int fmu_step(fmu *f, double time, double size, int halts)
{
    if (f->kept.phase != FMU_RUNNING) {
        return fmu_fail(f, "a step needs an initialised model that has neither ended nor failed");
    }
    if (!(size > 0.0 && size < 1e9)) {
        return fmu_fail(f, "a step must be greater than 0 s and finite");
    }
    if (!(fabs(time - f->kept.time) <= 1e-9 * FMU_PERIOD + 1e-12 * fabs(time))) {
        snprintf(f->problem, sizeof f->problem, "the step begins at %.17g s; the model is at %.17g s", time, f->kept.time);
        return 0;
    }
    double goal = on_sample(time + size), next;
    f->kept.is_before = 0;
    if (halts) {
        if (!fmu_next(f, &next)) {
            return 0;
        }
        if (next <= goal + 1e-9 * FMU_PERIOD) {
            goal = next;
            f->kept.is_before = 1;
            memcpy(f->kept.before, f->kept.machine.command, sizeof f->kept.before);
        }
    }
    const int answer = fmu_model_run(&f->kept.machine, goal, NULL);
    f->is_shown = 0;
    if (answer != 0) {
        f->kept.time = fmu_model_time(&f->kept.machine);
        f->kept.phase = FMU_FAILED;
        const int known = answer < (int)(sizeof fmu_reasons / sizeof *fmu_reasons);
        snprintf(f->problem, sizeof f->problem, "the run cannot go on at t = %g s: %s", f->kept.time,
                known ? fmu_reasons[answer] : "a function of the model failed");
        return 0;
    }
    f->kept.time = goal;
    return 1;
}

fmu_kept *fmu_copy(const fmu *f)
{
    fmu_kept *kept = malloc(sizeof *kept);
    if (kept != NULL) {
        memcpy(kept, &f->kept, sizeof *kept);
    }
    return kept;
}

int fmu_restore(fmu *f, const fmu_kept *kept)
{
    if (kept == NULL || memcmp(kept->token, FMU_TOKEN, sizeof FMU_TOKEN) != 0) {
        return fmu_fail(f, "the state is none of this FMU");
    }
    memcpy(&f->kept, kept, sizeof f->kept);
    f->is_shown = 0;
    return 1;
}

int fmu_restore_bytes(fmu *f, const void *bytes, size_t count, fmu_kept **kept)
{
    if (count != sizeof **kept || memcmp(bytes, FMU_TOKEN, sizeof FMU_TOKEN) != 0) {
        return fmu_fail(f, "the state is none of this FMU");
    }
    *kept = malloc(sizeof **kept);
    if (*kept == NULL) {
        return fmu_fail(f, "there is no memory left");
    }
    memcpy(*kept, bytes, count);
    return 1;
}
