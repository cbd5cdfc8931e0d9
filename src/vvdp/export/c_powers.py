"""Powers and exponentials as C99, from the tables and series of `simulation.in_place`, with the same bits.

`fma` is called by name: a compiler makes one instruction of it where it may, and the C library calculates it elsewhere,
with the same result. On x86-64 this is chosen when the code is loaded. Compiled code has these bits on processors with
fused operations only.
"""

import re
from collections.abc import Sequence

from vvdp.simulation import in_place
from vvdp.simulation.lane_math import EXP_SERIES

CHOICE = """\
#ifdef FUSED
FUSED static double NAME_fused(ARGUMENTS)
{
    return NAME_text(VALUES);
}

static double NAME_plain(ARGUMENTS)
{
    return NAME_text(VALUES);
}

__attribute__((used)) static double (*NAME_choice(void))(ARGUMENTS)
{
    return has_fused() ? NAME_fused : NAME_plain;
}

static double NAME(ARGUMENTS) __attribute__((ifunc("NAME_choice")));
#else
static double NAME(ARGUMENTS)
{
    return NAME_text(VALUES);
}
#endif
"""
"""A function by the instruction of the processor where it has one, else by that of the C library."""
FUNCTION = """\
typedef union {
    double number;
    uint64_t bits;
} number_and_bits;

INLINED uint64_t bits_of(double x)
{
    const number_and_bits both = {.number = x};
    return both.bits;
}

INLINED double float_of(uint64_t bits)
{
    const number_and_bits both = {.bits = bits};
    return both.number;
}

/* The binary logarithm of 1 + r over r, for small r. */
INLINED double log2_series(double r)
{
LOG2_SERIES}

/* 2 to the power of rest, minus 1, over rest. */
INLINED double exp2_series(double rest)
{
EXP2_SERIES}

/* x to the power of y: 2 to the power of y times the binary logarithm of x, which is a sum of two numbers. */
INLINED double NAME_text(double x, double y)
{
    const uint64_t above = bits_of(x) - UINT64_C(FIRST);
    const uint64_t exponent = (above + (UINT64_C(1) << 63)) >> 52; /* and 2048, so that it is positive */
    const uint64_t place = (above >> LOG_SHIFT) & UINT64_C(LOG_MASK);
    const double m = float_of(bits_of(x) - ((exponent - UINT64_C(2048)) << 52));
    const double k = (double)(int64_t)exponent - 2048.0;
    const double r = fma(m, reciprocals[place], -1.0);
    const double rough = k + logarithms[place];
    const double series = log2_series(r);
    const double high = fma(r, series, rough);
    const double low = fma(r, series, rough - high) + ((k - rough) + logarithms[place]);
    const double e = y * high;
    const double lost = fma(y, high, -e);
    const double shifted = e + ROUNDING;
    const double rest = fma(y, low, lost) + (e - (shifted - ROUNDING));
    const uint64_t steps = bits_of(shifted);
    const double root = roots[steps & UINT64_C(ROOT_MASK)];
    const double part = fma(root, rest * exp2_series(rest), root);
    if (!(x > SMALLEST && x < INFINITY && fabs(e) < 1000.0)) {
        return pow(x, y);
    }
    const uint64_t whole = (steps & ~UINT64_C(ROOT_MASK)) << ROOT_SHIFT;
    return float_of(bits_of(part) + whole);
}
"""
"""The function, with capitals for what `in_place` sets."""


def c_powers() -> str:
    """The C text of `power` as a static function."""
    words = {
        "LOG2_SERIES": _polynomial("r", in_place.LOG2_SERIES),
        "EXP2_SERIES": _polynomial("rest", in_place.EXP2_SERIES),
        "FIRST": str(in_place.FIRST),
        "LOG_SHIFT": str(52 - in_place.LOG_BITS),
        "LOG_MASK": str((1 << in_place.LOG_BITS) - 1),
        "ROOT_SHIFT": str(52 - in_place.EXP_BITS),
        "ROOT_MASK": str((1 << in_place.EXP_BITS) - 1),
        "ROUNDING": repr(in_place.ROUNDING),
        "SMALLEST": repr(2.0**-1022),
    }
    tables = (
        _table("reciprocals", in_place.RECIPROCALS, "One over a number in the middle of each interval of mantissas."),
        _table("logarithms", in_place.LOGARITHMS, "The binary logarithms of those numbers."),
        _table("roots", in_place.ROOTS, f"2 to the power of i/{1 << in_place.EXP_BITS}."),
    )
    text = re.sub(r"\b[A-Z][A-Z_0-9]+\b", lambda m: words.get(m[0], m[0]), FUNCTION)
    return "\n".join([*tables, text.replace("NAME", "vvdp_power"), _choice("vvdp_power", ("x", "y"))])


def _choice(name: str, arguments: Sequence[str]) -> str:
    text = CHOICE.replace("NAME", name).replace("ARGUMENTS", ", ".join(f"double {each}" for each in arguments))
    return text.replace("VALUES", ", ".join(arguments))


def c_expm1() -> str:
    """The C text of `expm1` as a static function."""
    text = f"""\
/* (e to the power of x, minus 1, minus x) over x squared, for small x. */
INLINED double exp_series(double x)
{{
{_polynomial("x", EXP_SERIES)}}}

/* e to the power of x, minus 1. */
INLINED double vvdp_expm1_text(double x)
{{
    return fabs(x) < {in_place.SMALL!r} ? fma(x * x, exp_series(x), x) : expm1(x);
}}
"""
    return "\n".join([text, _choice("vvdp_expm1", ("x",))])


def _table(name: str, values: Sequence[float], words: str) -> str:
    rows = [", ".join(map(repr, values[i : i + 4])) for i in range(0, len(values), 4)]
    lines = "".join(f"    {row},\n" for row in rows)
    return f"/* {words} */\nstatic const double {name}[{len(values)}] = {{\n{lines}}};\n"


def _polynomial(x: str, coefficients: Sequence[float]) -> str:
    """Lines that return a series, calculated in halves as `lane_values.Code.polynomial` does."""
    lines, power, degree = "", x, 1
    terms = [repr(float(each)) for each in coefficients]
    while len(terms) > 1:
        pairs: list[str] = []
        for low, high in zip(terms[::2], terms[1::2], strict=False):
            pairs.append(f"s{degree}_{len(pairs)}")
            lines += f"    const double {pairs[-1]} = fma({high}, {power}, {low});\n"
        terms = pairs + terms[len(pairs) * 2 :]
        if len(terms) > 1:
            degree *= 2
            lines += f"    const double x{degree} = {power} * {power};\n"
            power = f"x{degree}"
    return f"{lines}    return {terms[0]};\n"


C_INTRINSICS = {"vvdp_power": c_powers(), "vvdp_expm1": c_expm1()}
"""The C text of what `simulation.in_place` writes for LLVM, by the names of the intrinsics."""
