/* tanh(x) by expm1, as Sun's library has it. */
#include "libm.h"

double tanh(double x) {
    double size = fabs(x), t, z;
    if (isnan(x)) return x;
    if (size >= 22.0) z = 1.0;
    else if (size < 0x1p-55) return x * (1.0 + x);
    else if (size >= 1.0) {
        t = expm1(2.0 * size);
        z = 1.0 - 2.0 / (t + 2.0);
    } else {
        t = expm1(-2.0 * size);
        z = -t / (t + 2.0);
    }
    return x < 0.0 ? -z : z;
}
