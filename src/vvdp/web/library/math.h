/* What the files of the C library that a module has call of each other. */
#pragma once
double fma(double, double, double), pow(double, double), exp(double), expm1(double), scalbn(double, int);
typedef double double_t;
typedef float float_t;
