#pragma once
#define a_clz_64(x) __builtin_clzll(x)
