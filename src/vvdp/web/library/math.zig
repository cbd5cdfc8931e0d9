// Functions of the C library that zig has in its own one.
const m = @import("std").math;

export fn acos(x: f64) f64 {
    return m.acos(x);
}
export fn acosh(x: f64) f64 {
    return m.acosh(x);
}
export fn asin(x: f64) f64 {
    return m.asin(x);
}
export fn asinh(x: f64) f64 {
    return m.asinh(x);
}
export fn atan(x: f64) f64 {
    return m.atan(x);
}
export fn atanh(x: f64) f64 {
    return m.atanh(x);
}
export fn log1p(x: f64) f64 {
    return m.log1p(x);
}
export fn cbrt(x: f64) f64 {
    return m.cbrt(x);
}
export fn cosh(x: f64) f64 {
    return m.cosh(x);
}
export fn sinh(x: f64) f64 {
    return m.sinh(x);
}
export fn atan2(x: f64, y: f64) f64 {
    return m.atan2(x, y);
}
export fn hypot(x: f64, y: f64) f64 {
    return m.hypot(x, y);
}
export fn tgamma(x: f64) f64 {
    return m.gamma(f64, x);
}
export fn lgamma(x: f64) f64 {
    return m.lgamma(f64, x);
}
