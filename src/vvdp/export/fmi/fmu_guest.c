/* A machine that the integrator of a host carries: model exchange of both versions of FMI. */
#include "fmu.h"

#include <math.h>
#include <string.h>

static int may_run(fmu *f)
{
    return f->kept.phase == FMU_RUNNING || fmu_fail(f, "this needs an initialised model that has neither ended nor failed");
}

static int are(fmu *f, size_t count, size_t expected)
{
    return count == expected || fmu_fail(f, "the number of states or indicators is another one");
}

int fmu_enter(fmu *f)
{
    fmu_kept *kept = &f->kept;
    if (!may_run(f)) {
        return 0;
    }
    if (fabs(kept->time - kept->next) <= 1e-12 * fabs(kept->next)) {
        kept->time = kept->next; /* the host has rounded */
    }
    f->is_shown = 0;
    if (fmu_model_enter(&kept->machine, kept->time, &kept->next) != 0 || isnan(kept->next)) {
        kept->phase = FMU_FAILED;
        return fmu_fail(f, "the run cannot go on: a mode changes without end, or too many commands of a program wait");
    }
    return 1;
}

int fmu_move(fmu *f, double time)
{
    if (!may_run(f)) {
        return 0;
    }
    if (!(fabs(time) < 1e300)) {
        return fmu_fail(f, "the time is not finite");
    }
    f->kept.time = time;
    fmu_model_move(&f->kept.machine, time);
    f->is_shown = 0;
    return 1;
}

int fmu_put_states(fmu *f, const double *states, size_t count)
{
    if (!may_run(f) || !are(f, count, FMU_CARRIED)) {
        return 0;
    }
    for (size_t i = 0; i < count; i++) {
        if (!(fabs(states[i]) < 1e300)) {
            return fmu_fail(f, "a state is not finite");
        }
    }
    memcpy(f->kept.machine.state, states, count * sizeof *states);
    f->is_shown = 0;
    return 1;
}

int fmu_get_states(fmu *f, double *states, size_t count)
{
    if (!are(f, count, FMU_CARRIED)) {
        return 0;
    }
    memcpy(states, f->kept.machine.state, count * sizeof *states);
    return 1;
}

int fmu_get_nominals(fmu *f, double *nominals, size_t count)
{
    if (!are(f, count, FMU_CARRIED)) {
        return 0;
    }
    memcpy(nominals, fmu_nominals, count * sizeof *nominals);
    return 1;
}

int fmu_derive(fmu *f, double *rates, size_t count)
{
    fmu_machine *machine = fmu_begun(f);
    if (machine == NULL || !are(f, count, FMU_CARRIED)) {
        return 0;
    }
    if (fmu_model_derive(machine, f->kept.time, f->kept.next, f->rates) != 0) {
        return fmu_fail(f, "a function of the model failed");
    }
    memcpy(rates, f->rates, count * sizeof *rates);
    return 1;
}

int fmu_indicate(fmu *f, double *indicators, size_t count)
{
    fmu_machine *machine = fmu_begun(f);
    if (machine == NULL || !are(f, count, FMU_INDICATORS)) {
        return 0;
    }
    if (fmu_model_indicate(machine, f->kept.time, f->kept.next, f->indicators) != 0) {
        return fmu_fail(f, "a function of the model failed");
    }
    memcpy(indicators, f->indicators, count * sizeof *indicators);
    return 1;
}

int fmu_complete(fmu *f)
{
    if (!may_run(f)) {
        return 0;
    }
    if (fmu_model_fallen(&f->kept.machine) >= 0) {
        f->kept.phase = FMU_FAILED;
        return fmu_fail(f, "the run cannot go on: a pressure has fallen below 0 Pa absolute");
    }
    return 1;
}

#if FMU_HAS_TANGENT
/* The derivative of what follows a variable. */
static double slope_of(const fmu_follower *own, double x)
{
    switch (own->operation) {
    case FMU_ADD:
        return 1.0;
    case FMU_TIMES:
        return own->constant;
    case FMU_BY:
        return 1.0 / own->constant;
    default:
        return -own->constant / (x * x);
    }
}

/* Adds the change of a variable, an input or a state, to a direction. */
static int add_change(fmu *f, uint32_t r, double change, double *dy, double *dp)
{
    if (r - 1u < FMU_SETTABLES && fmu_settables[r - 1u].role == FMU_INPUT) {
        for (int k = 0; k < FMU_FOLLOWERS; k++) {
            const fmu_follower *own = &fmu_followers[k];
            if (own->variable == (int)(r - 1u)) {
                dp[own->place] += slope_of(own, f->kept.values[r - 1u]) * change;
            }
        }
        return 1;
    }
    const uint32_t shown = r - 1u - FMU_SETTABLES;
    if (shown < FMU_OUTPUTS && fmu_outputs[shown].vector == FMU_STATE) {
        dy[fmu_outputs[shown].place] += change;
        return 1;
    }
    return fmu_fail(f, "directions are those of inputs and states");
}

int fmu_derive_along(fmu *f, const fmu_direction *way, const uint32_t *unknowns, size_t count, double *found)
{
    double dy[FMU_STATES] = {0.0}, dp[FMU_PARAMETERS_SIZE] = {0.0}, all[FMU_TANGENTS];
    const fmu_machine *machine = fmu_begun(f);
    if (machine == NULL) {
        return 0;
    }
    for (size_t i = 0; i < way->count; i++) {
        if (!add_change(f, way->references[i], way->changes[i], dy, dp)) {
            return 0;
        }
    }
    const double t = f->kept.time < f->kept.next ? f->kept.time : nextafter(f->kept.next, -INFINITY);
    fmu_model_tangent(machine, t, dy, dp, all);
    for (size_t i = 0; i < count; i++) {
        const uint32_t shown = unknowns[i] - 1u - FMU_SETTABLES;
        const fmu_output *own = shown < FMU_OUTPUTS ? &fmu_outputs[shown] : NULL;
        if (own == NULL || (own->vector > FMU_OUTPUT && own->vector != FMU_RATE)) {
            return fmu_fail(f, "there are derivatives of outputs and rates only");
        }
        found[i] = own->vector == FMU_STATE ? dy[own->place]
                : own->vector == FMU_RATE ? all[own->place]
                : own->vector == FMU_OUTPUT ? all[FMU_POSITIONS + own->place]
                : 0.0; /* a command, which holds between two samples */
    }
    return 1;
}
#else
int fmu_derive_along(fmu *f, const fmu_direction *way, const uint32_t *unknowns, size_t count, double *found)
{
    (void)way;
    (void)unknowns;
    (void)count;
    (void)found;
    return fmu_fail(f, "directional derivatives are not provided");
}
#endif
