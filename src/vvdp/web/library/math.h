/* What the files of the C library that a module has call of each other. */
#pragma once
double pow(double, double), exp(double), expm1(double), scalbn(double, int);
typedef double double_t;
typedef float float_t;
/* What the rounding of a product p of a and b has taken away. */
static inline double product_error(double a, double b, double p) {
    double s = 134217729.0 * a, t = 134217729.0 * b;
    double ah = s - (s - a), bh = t - (t - b), al = a - ah, bl = b - bh;
    return ((ah * bh - p) + ah * bl + al * bh) + al * bl;
}
#if defined(__wasm_relaxed_simd__)
typedef double pair __attribute__((vector_size(16)));
static inline double fma(double a, double b, double c) {
    pair x = {a, a}, y = {b, b}, z = {c, c};
    return __builtin_wasm_relaxed_madd_f64x2(x, y, z)[0];
}
#elif defined(SPLIT)
static inline double fma(double a, double b, double c) {
    double p = a * b;
    return (p + c) + product_error(a, b, p);
}
#else
double fma(double, double, double);
#endif
