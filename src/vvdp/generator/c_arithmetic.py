"""Operations that C leaves undefined or does otherwise than the language, as short functions in C99."""

SELDOM = """\
/* Functions that take little of the time: their code is short rather than fast, but where vectors are wide: there, GCC
   12.2 copies constants wrongly in short code. */
#if defined(__GNUC__) && !defined(__AVX__)
#define SELDOM __attribute__((cold))
#else
#define SELDOM
#endif
"""
HELPERS = {
    "add64": """\
/* a + b, which wraps around beyond 64 bits. */
static inline int64_t add64(int64_t a, int64_t b)
{
    const uint64_t sum = (uint64_t)a + (uint64_t)b;
    return (int64_t)sum;
}
""",
    "sub64": """\
/* a - b, which wraps around beyond 64 bits. */
static inline int64_t sub64(int64_t a, int64_t b)
{
    const uint64_t difference = (uint64_t)a - (uint64_t)b;
    return (int64_t)difference;
}
""",
    "mul64": """\
/* a * b, which wraps around beyond 64 bits. */
static inline int64_t mul64(int64_t a, int64_t b)
{
    const uint64_t product = (uint64_t)a * (uint64_t)b;
    return (int64_t)product;
}
""",
    "neg64": """\
/* -a, which is itself for the lowest number. */
static inline int64_t neg64(int64_t a)
{
    const uint64_t negative = UINT64_C(0) - (uint64_t)a;
    return (int64_t)negative;
}
""",
    "floor_mod64": """\
/* The remainder of a division that rounds towards minus infinity; 0 if b is 0. */
static inline int64_t floor_mod64(int64_t a, int64_t b)
{
    if (b == 0 || b == -1) {
        return 0;
    }
    const int64_t rest = a % b;
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}
""",
    "floor_div64": """\
/* A division that rounds towards minus infinity; 0 if b is 0, and it wraps around for the lowest number and -1. */
static inline int64_t floor_div64(int64_t a, int64_t b)
{
    if (b == 0) {
        return 0;
    }
    if (b == -1) {
        const uint64_t negative = UINT64_C(0) - (uint64_t)a;
        return (int64_t)negative;
    }
    const int64_t rest = a % b;
    return a / b - (int64_t)(rest != 0 && (rest < 0) != (b < 0));
}
""",
    "shl64": """\
/* a shifted to the left; 0 for 64 places and more. */
static inline int64_t shl64(int64_t a, int64_t places)
{
    return places >= 0 && places < 64 ? (int64_t)((uint64_t)a << places) : 0;
}
""",
    "shr64": """\
/* a shifted to the right; only the sign is left after 63 places and more. */
static inline int64_t shr64(int64_t a, int64_t places)
{
    const int64_t moved = places >= 0 && places < 64 ? places : 63;
    return a < 0 ? ~(int64_t)(~(uint64_t)a >> moved) : (int64_t)((uint64_t)a >> moved);
}
""",
    "cut64": """\
/* A float cut towards zero and held within 64 bits; 0 for what is not a number. */
static inline int64_t cut64(double x)
{
    if (!(x >= -9223372036854775808.0)) {
        return x < 0.0 ? -INT64_MAX - 1 : 0;
    }
    return x < 9223372036854775808.0 ? (int64_t)x : INT64_MAX;
}
""",
    "fits_add64": """\
/* Whether a + b has at most 64 bits. */
static inline bool fits_add64(int64_t a, int64_t b)
{
    return b < 0 ? a >= INT64_MIN - b : a <= INT64_MAX - b;
}
""",
    "fits_sub64": """\
/* Whether a - b has at most 64 bits. */
static inline bool fits_sub64(int64_t a, int64_t b)
{
    return b < 0 ? a <= INT64_MAX + b : a >= INT64_MIN + b;
}
""",
    "fits_mul64": """\
/* Whether a * b has at most 64 bits. */
static inline bool fits_mul64(int64_t a, int64_t b)
{
    if (a == 0 || b == 0) {
        return true;
    }
    if (a == -1 || b == -1) {
        return (a == -1 ? b : a) != INT64_MIN;
    }
    if ((a < 0) == (b < 0)) {
        return a < 0 ? a >= INT64_MAX / b : a <= INT64_MAX / b;
    }
    return a < 0 ? a >= INT64_MIN / b : b >= INT64_MIN / a;
}
""",
    "fits_shift64": """\
/* Whether a number can be shifted by so many places. */
static inline bool fits_shift64(int64_t a, int64_t places)
{
    (void)a;
    return places >= 0 && places < 64;
}
""",
    "has_fused": """\
/* On x86-64, which functions to call is chosen when they are loaded: a processor multiplies and adds with one rounding
   far faster than the C library, and the compiler may not know that it can. Both have the same bits. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__FMA__)
#include <cpuid.h>
#define FUSED __attribute__((target("fma")))
#define INLINED static inline __attribute__((always_inline))
static inline bool has_fused(void)
{
    unsigned a = 0u;
    unsigned b = 0u;
    unsigned c = 0u;
    unsigned d = 0u;
    unsigned low;
    unsigned high;
    const unsigned wanted = bit_FMA | bit_AVX | bit_OSXSAVE;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & wanted) != wanted) {
        return false;
    }
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (low & 6u) == 6u; /* the system keeps the registers */
}
#else
#define INLINED static inline
#endif
""",
}
"""By name, in the order in which they are written; none needs another."""

WHOLE = {
    "+": "add64", "-": "sub64", "*": "mul64", "//": "floor_div64", "%": "floor_mod64", "<<": "shl64", ">>": "shr64",
}  # fmt: skip
"""The functions for Python's operators on whole numbers."""

FITTING = {
    "fits+": "fits_add64", "fits-": "fits_sub64", "fits*": "fits_mul64", "fits<<": "fits_shift64",
    "fits>>": "fits_shift64",
}  # fmt: skip
"""The functions for the checks of `library.FITS`."""

ROOM = """\
/* Takes {words} from the workspace; reports failure {number} if there are not so many. */
static {kind} *{name}({workspace} *workspace, int64_t count, int64_t *failure)
{{
    if (count < 0) {{
        count = 0;
    }}
    if (count > workspace->{left}) {{
        *failure = {number};
        return NULL;
    }}
    {kind} *const taken = workspace->{free};
    workspace->{free} += count;
    workspace->{left} -= count;
    return taken;
}}
"""

GUARD = """\
#ifdef __FAST_MATH__
#error "this text needs IEEE 754 arithmetic: compile without -ffast-math, with -std=c99 -ffp-contract=off"
#endif
#if FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 1 && FLT_EVAL_METHOD != 16
#error "this text needs arithmetic without wider intermediate values"
#endif
#if defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#endif
"""
"""GCC ignores the pragma, hence the flag `-ffp-contract=off`. Methods 1 and 16 widen smaller types only."""
