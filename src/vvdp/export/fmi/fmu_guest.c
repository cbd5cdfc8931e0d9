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
