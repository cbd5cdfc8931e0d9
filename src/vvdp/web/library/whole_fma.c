/* `fma` of musl, in whole numbers, under another name. */
#define fma in_whole_numbers
#include "math/fma.c"
