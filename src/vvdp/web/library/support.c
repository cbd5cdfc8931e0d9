/* What the objects of a model call besides formulas: memory for arrays that outgrow a frame, and ends of functions. */
#include "libm.h"

static uint64_t room[1 << 17];
static uint64_t taken, held;

/* All that was taken in a call of the model is given back at its end. */
void *malloc(uint64_t bytes) {
    uint64_t count = (bytes + 7) / 8;
    if (count > sizeof room / 8 - taken) __builtin_trap();
    void *found = room + taken;
    taken += count;
    held++;
    return found;
}

void free(void *place) {
    if (place && --held == 0) taken = 0;
}

double __math_oflow(uint32_t sign) { return sign ? -INFINITY : INFINITY; }
double __math_uflow(uint32_t sign) { return sign ? -0.0 : 0.0; }
double __math_divzero(uint32_t sign) { return sign ? -INFINITY : INFINITY; }
double __math_invalid(double x) { return (x - x) / (x - x); }
double __math_check_oflow(double y) { return y; }
double __math_check_uflow(double y) { return y; }
