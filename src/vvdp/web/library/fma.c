/* a b + c rounded once, where a processor has no instruction for it.

   The error of the product is exact, and so are those of the sums; what is left of them is rounded to odd, so that the
   last sum rounds as the exact one would (Boldo, Melquiond: Emulation of FMA and correctly rounded sums, 2008). */
#include "libm.h"

static double sum_error(double a, double b, double s) {
    double z = s - a;
    return (a - (s - z)) + (b - z);
}

/* The same in whole numbers, for very large and very small ones: `fma` of musl. */
double in_whole_numbers(double a, double b, double c);

double fma(double a, double b, double c) {
    uint32_t ea = asuint64(a) >> 52 & 0x7ff, eb = asuint64(b) >> 52 & 0x7ff, ec = asuint64(c) >> 52 & 0x7ff;
    if (a == 0.0 || b == 0.0) return a * b + c;
    if (c == 0.0) return a * b;
    if (ea - 0x200 > 0x400 || eb - 0x200 > 0x400 || ea + eb - 0x4a0 > 0x6c0 || ec > 0x780) return in_whole_numbers(a, b, c);
    double p = a * b, lost = product_error(a, b, p);
    double t = c + lost, t_lost = sum_error(c, lost, t);
    double v = p + t, v_lost = sum_error(p, t, v);
    double rest = t_lost + v_lost, gone = sum_error(t_lost, v_lost, rest);
    uint64_t bits = asuint64(rest);
    if (gone != 0.0 && !(bits & 1)) bits += (gone > 0.0) == (rest > 0.0) ? 1 : -1;
    return v + asdouble(bits);
}
