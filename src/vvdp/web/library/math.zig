// Functions of the C library that zig has in its own one.
const m = @import("std").math;

export fn asin(x: f64) f64 {
    return m.asin(x);
}
export fn log1p(x: f64) f64 {
    return m.log1p(x);
}
