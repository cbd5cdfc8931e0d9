/* What both versions of FMI share: a machine with its variables by reference. */
#ifndef FMU_H
#define FMU_H

#include <stddef.h>
#include <stdint.h>

#include "fmu_model.h"

/* References behind those of the outputs: the clock of periods, and the time at which the last one has ended. */
#define FMU_MARK_CLOCK (1u + FMU_SETTABLES + FMU_OUTPUTS)
#define FMU_MARK_TIME (2u + FMU_SETTABLES + FMU_OUTPUTS)

typedef enum { FMU_CREATED, FMU_INITIALISING, FMU_RUNNING, FMU_ENDED, FMU_FAILED } fmu_phase;
typedef enum { FMU_FIXED, FMU_TUNABLE, FMU_INPUT } fmu_role;
typedef enum { FMU_STATE, FMU_COMMAND, FMU_OUTPUT, FMU_MEMORY, FMU_PARAMETERS, FMU_RATE, FMU_INDICATOR } fmu_vector;
typedef enum { FMU_ADD, FMU_TIMES, FMU_BY, FMU_OVER } fmu_operation;

/* A variable that can be set, within its range. */
typedef struct {
    double start;
    double low;
    double high;
    fmu_role role;
    int name; /* where it begins in the names */
} fmu_settable;

/* A number of the machine that follows a variable by an operation with a constant. */
typedef struct {
    double constant;
    int32_t place;
    uint16_t variable;
    uint8_t vector;    /* an fmu_vector */
    uint8_t operation; /* an fmu_operation */
} fmu_follower;

/* Where the number of an output is. */
typedef struct {
    fmu_vector vector;
    int place;
} fmu_output;

extern const char fmu_names[]; /* of variables that can be set */
extern const fmu_settable fmu_settables[];
extern const fmu_follower fmu_followers[];
extern const fmu_output fmu_outputs[];
#if FMU_IS_GUEST
extern const double fmu_nominals[];
#endif

/* All that changes; it contains no address. */
typedef struct {
    char token[FMU_TOKEN_SIZE];
    fmu_phase phase;
    double time;
    double values[FMU_SETTABLES + 1];
    fmu_machine machine;
    double before[FMU_COMMANDS]; /* the command before the event at which a step has ended */
    int is_before;               /* whether this event is still to be shown */
    double marks;                /* periods that have been shown */
#if FMU_IS_GUEST
    double next; /* the time of the next event that is known */
#endif
} fmu_kept;

/* A direction: changes of variables by their references. */
typedef struct {
    const uint32_t *references;
    const double *changes;
    size_t count;
} fmu_direction;

typedef struct {
    fmu_kept kept;
    fmu_machine shown; /* the machine whose numbers the outputs show */
    fmu_model_output outputs;
    int is_shown;
#if FMU_IS_GUEST
    double rates[FMU_POSITIONS];
    double indicators[FMU_INDICATORS + 1];
#endif
    char problem[256];
} fmu;

/* An instance at its start; NULL without memory. */
fmu *fmu_new(void);
void fmu_reset(fmu *f);

/* The functions below answer 1, or 0 with a sentence in `problem`. */
int fmu_fail(fmu *f, const char *words); /* answers 0 */
int fmu_get(fmu *f, const uint32_t *references, size_t count, double *values);
int fmu_set(fmu *f, const uint32_t *references, size_t count, const double *values);
int fmu_setup(fmu *f, double start, int has_tolerance, double tolerance);
int fmu_begin(fmu *f);

/* Carries the machine on; with `halts` at most to the next event, of which `is_before` tells. */
int fmu_step(fmu *f, double time, double size, int halts);
int fmu_next(fmu *f, double *next); /* the time of the next event that is known; infinite where there is none */
int fmu_pass(fmu *f, double *next); /* shows what an event has changed */
int fmu_ticks(const fmu *f);        /* whether a period has ended since the event before */

/* States as bytes: copies of what is kept. */
fmu_kept *fmu_copy(const fmu *f);
int fmu_restore(fmu *f, const fmu_kept *kept);
int fmu_restore_bytes(fmu *f, const void *bytes, size_t count, fmu_kept **kept);

#if FMU_IS_GUEST
/* Model exchange: what happens at an event, and what the integrator of the host asks between events. */
fmu_machine *fmu_begun(fmu *f); /* the machine, before its first step as it would begin; NULL where it cannot */
int fmu_enter(fmu *f);
int fmu_move(fmu *f, double time);
int fmu_put_states(fmu *f, const double *states, size_t count);
int fmu_get_states(fmu *f, double *states, size_t count);
int fmu_get_nominals(fmu *f, double *nominals, size_t count);
int fmu_derive(fmu *f, double *rates, size_t count);
int fmu_indicate(fmu *f, double *indicators, size_t count);
int fmu_complete(fmu *f);
int fmu_derive_along(fmu *f, const fmu_direction *way, const uint32_t *unknowns, size_t count, double *found);
#endif

#endif
