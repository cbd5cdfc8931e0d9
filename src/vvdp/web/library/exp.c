/* exp(x) of the C libraries that have Arm's optimized routines (MIT), products and sums rounded once. */
#include "libm.h"
#include "exp_data.h"

#define N (1 << EXP_TABLE_BITS)

static double special(double tmp, uint64_t sbits, uint64_t ki) {
    double scale, y;
    if ((ki & 0x80000000) == 0) {
        scale = asdouble(sbits - (1009ull << 52));
        return 0x1p1009 * fma(scale, tmp, scale);
    }
    scale = asdouble(sbits + (1022ull << 52));
    y = fma(scale, tmp, scale);
    if (y < 1.0) {
        double lo = fma(scale, tmp, scale - y), hi = 1.0 + y;
        lo = ((1.0 - hi) + y) + lo;
        y = (hi + lo) - 1.0;
        if (y == 0.0) y = 0.0;
    }
    return 0x1p-1022 * y;
}

double exp(double x) {
    uint32_t top = (uint32_t)(asuint64(x) >> 52) & 0x7ff;
    if (top - 0x3c9 >= 0x408 - 0x3c9) {
        if (top - 0x3c9 >= 0x80000000) return 1.0 + x;
        if (top >= 0x409) {
            if (asuint64(x) == asuint64(-INFINITY)) return 0.0;
            if (top >= 0x7ff) return 1.0 + x;
            return asuint64(x) >> 63 ? 0.0 : INFINITY;
        }
        top = 0;
    }
    const double *c = &__exp_data.poly[5 - EXP_POLY_ORDER];
    double kd = fma(__exp_data.invln2N, x, __exp_data.shift);
    uint64_t ki = asuint64(kd);
    kd -= __exp_data.shift;
    double r = fma(kd, __exp_data.negln2loN, fma(kd, __exp_data.negln2hiN, x));
    uint64_t idx = 2 * (ki % N);
    double tail = asdouble(__exp_data.tab[idx]), r2 = r * r;
    uint64_t sbits = __exp_data.tab[idx + 1] + (ki << (52 - EXP_TABLE_BITS));
    double tmp = fma(r2 * r2, fma(r, c[3], c[2]), fma(r2, fma(r, c[1], c[0]), tail + r));
    if (top == 0) return special(tmp, sbits, ki);
    double scale = asdouble(sbits);
    return fma(scale, tmp, scale);
}
