#pragma once
#include <stdint.h>
#include <math.h>
#define hidden
#define WANT_ROUNDING 1
#define WANT_SNAN 0
#define TOINT_INTRINSICS 0
#define issignaling_inline(x) 0
#define predict_true(x) __builtin_expect(!!(x),1)
#define predict_false(x) __builtin_expect(x,0)
#define isnan(x) __builtin_isnan(x)
#define fabs(x) __builtin_fabs(x)
#define INFINITY __builtin_inff()
#define NAN __builtin_nanf("")
static inline uint64_t asuint64(double f){union{double f;uint64_t i;}u={f};return u.i;}
static inline double asdouble(uint64_t i){union{uint64_t i;double f;}u={i};return u.f;}
#define eval_as_double(x) (x)
static inline double fp_barrier(double x){return x;}
#define FORCE_EVAL(x) ((void)(x))
static inline void fp_force_evalf(float x){}static inline void fp_force_eval(double x){}
double __math_oflow(uint32_t),__math_uflow(uint32_t),__math_xflow(uint32_t,double),__math_invalid(double),__math_divzero(uint32_t),__math_check_oflow(double),__math_check_uflow(double);
#define GET_HIGH_WORD(h,d) do{(h)=asuint64(d)>>32;}while(0)
#define GET_LOW_WORD(l,d) do{(l)=(uint32_t)asuint64(d);}while(0)
#define SET_LOW_WORD(d,l) do{(d)=asdouble(asuint64(d)&0xffffffff00000000ull|(uint32_t)(l));}while(0)
#define INSERT_WORDS(d,h,l) do{(d)=asdouble(((uint64_t)(h)<<32)|(uint32_t)(l));}while(0)
