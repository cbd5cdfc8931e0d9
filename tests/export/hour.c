/* An encoder on a shaft that starts, stops and turns back, and its event filter in double and single precision. */
#include "edges.h"
#include "twice.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

int single_step(float t, float *memory, const float *reading, const float *settings, float *command);
extern const float single_first_memory[], single_first_settings[];

/* Numbers from 0 to 1 that look random (a linear congruential generator, Knuth's MMIX). */
static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* What a course of `samples` of 1 ms has shown. */
typedef struct {
    double angle, speed;       /* largest differences [rad, rad/s] */
    double beyond;             /* samples with a difference of more than 1e-3 rad or 0.02 rad/s */
    double edges, revolutions; /* that passed */
    double standing, back;     /* samples at rest, and of negative speed */
    double memory[256];        /* of the filter in single precision at the end */
} outcome;

int course(int samples, uint64_t seed, outcome *found)
{
    edges_memory encoder = edges_first_memory;
    twice_memory exact = twice_first_memory;
    float memory[sizeof(twice_memory) / sizeof(double)];
    float reading[5], command[sizeof(twice_command) / sizeof(double)];
    double angle = 0.0, speed = 0.0, goal = 0.0, rate = 1.0;
    int left = 300;
    memcpy(memory, single_first_memory, sizeof memory);
    memset(found, 0, sizeof *found);
    for (int i = 0; i < samples; i++) {
        if (--left < 0) { /* stands, turns forward or turns back, after a ramp */
            const double kind = uniform(&seed);
            goal = kind < 0.35 ? 0.0 : kind < 0.85 ? 5.0 + 155.0 * uniform(&seed) : -60.0 * uniform(&seed);
            rate = (fabs(goal - speed) + 1.0) / (50.0 + 450.0 * uniform(&seed));
            left = (int)(500.0 + 4500.0 * uniform(&seed));
        }
        const double before = speed, away = goal - speed;
        speed += fabs(away) < rate ? away : copysign(rate, away);
        angle += i == 0 ? 0.0 : 0.0005 * (before + speed);
        found->standing += speed == 0.0;
        found->back += speed < 0.0;

        const double t = 1e-3 * i;
        edges_reading shaft = {.time = t, .angle = angle, .speed = speed, .threshold_shift = 0.0};
        edges_command seen;
        twice_command double_command;
        if (edges_step(t, &encoder, &shaft, &edges_first_settings, &seen) != 0) {
            return 1;
        }
        const twice_reading passed = {seen.elapsed, seen.edges, seen.edge_age, seen.edge_interval, seen.polarity};
        for (int k = 0; k < 5; k++) {
            reading[k] = (float)((const double *)&passed)[k];
        }
        if (twice_step(t, &exact, &passed, &twice_first_settings, &double_command) != 0 ||
            single_step((float)t, memory, reading, single_first_settings, command) != 0) {
            return 2;
        }
        const double turns = (double)command[9] - double_command.revolutions;
        const double off = fabs(turns * 6.283185307179586 + ((double)command[10] - double_command.remainder));
        const double apart = fabs((double)command[1] - double_command.speed);
        found->angle = off <= found->angle ? found->angle : off;
        found->speed = apart <= found->speed ? found->speed : apart;
        found->beyond += !(off <= 1e-3 && apart <= 0.02);
        found->edges += seen.edges;
        found->revolutions = double_command.revolutions;
    }
    for (size_t k = 0; k < sizeof memory / sizeof memory[0]; k++) {
        found->memory[k] = memory[k];
    }
    return 0;
}
