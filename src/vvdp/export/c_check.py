"""The C program that replays the vectors of an exported folder and compares every number."""

from collections.abc import Sequence

from vvdp.export.c_parts import IN, KEPT, Entry, Precision
from vvdp.generator.c_text import wrap

CHECK = """\
/* Replays the vectors and compares every bit. */
#include "{name}.h"

#ifndef COUNTED
#define COUNTED(call) (call) /* make pil counts the instructions of a call */
#define COUNT_REPORT(entry, samples) ((void)0)
#endif
#ifndef TOLERANCE
#define TOLERANCE {tolerance} /* of a number, as a share of its largest value */
#endif

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vectors.h"

typedef {real} real;

typedef struct {{
    int differing; /* samples */
    double largest; /* difference, as a share of the largest value of its number */
    double difference;
    const char *where; /* block with the largest difference */
    size_t number; /* in the block */
}} outcome;

static double float_of(uint64_t bits)
{{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}}

static void fill(real *numbers, const uint64_t *bits, size_t count)
{{
    for (size_t i = 0; i < count; i++) {{
        numbers[i] = (real)float_of(bits[i]);
    }}
}}

/* The largest finite value of a number of a block. */
static double largest_of(const uint64_t *column, size_t count)
{{
    double largest = 0.0;
    for (size_t sample = 0; sample < SAMPLES; sample++) {{
        const double value = fabs(float_of(column[sample * count]));
        largest = isfinite(value) && value > largest ? value : largest;
    }}
    return largest;
}}

/* Whether all numbers of a sample have the expected bits; any number that is none equals any other. */
static int compare(const char *where, const real *found, const uint64_t *all_expected, size_t sample, size_t count,
                   outcome *all)
{{
    int differs = 0;
    const uint64_t *expected = all_expected + sample * count;
    for (size_t i = 0; i < count; i++) {{
        const real wanted = (real)float_of(expected[i]);
        if (memcmp(&found[i], &wanted, sizeof wanted) == 0 || (isnan(found[i]) && isnan(wanted))) {{
            continue;
        }}
        const double difference = fabs((double)found[i] - float_of(expected[i]));
        const double largest = largest_of(all_expected + i, count);
        const double share = difference / (largest > 0.0 ? largest : 1.0);
        if (all->where == NULL || !(share <= all->largest)) {{
            all->largest = share;
            all->difference = difference;
            all->where = where;
            all->number = i;
        }}
        differs = 1;
    }}
    return differs;
}}

/* Prints the outcome; the result is whether a difference is larger than it may be. */
static int report(const char *entry, const outcome *all)
{{
    printf("%s: %d of %d samples have the same bits\\n", entry, SAMPLES - all->differing, SAMPLES);
    if (all->differing != 0) {{
        printf("largest difference: %g in number %u of %s, %.2g of its largest value\\n", all->difference,
               (unsigned)all->number, all->where, all->largest);
    }}
    COUNT_REPORT(entry, SAMPLES);
    return all->differing != 0 && !(all->largest <= TOLERANCE);
}}

{checks}
int main(void)
{{
    int wrong = 0;
{calls}    return wrong;
}}
"""


def check_text(name: str, entries: Sequence[Entry], precision: Precision) -> str:
    """The program that replays the vectors."""
    calls = "".join(f"    wrong |= check_{entry.name}();\n" for entry in entries)
    return CHECK.format(
        name=name,
        real=precision.real,
        tolerance=precision.tolerance,
        checks="\n".join(_check(name, entry) for entry in entries),
        calls=calls,
    )


def _check(name: str, entry: Entry) -> str:
    lines = [f"static int check_{entry.name}(void)", "{", "    outcome all = {0, 0.0, 0.0, NULL, 0};"]
    for block in entry.arguments:
        first = f" = {name}_first_{block.name}" if block.role == KEPT else ""
        if block.drawn or block.role != IN:
            lines.append(f"    {name}_{block.name} {block.name}{first};")
    lines.append("    for (size_t i = 0; i < SAMPLES; i++) {")
    for block in entry.arguments:
        if block.drawn:
            lines.append(f"        fill((real *)&{block.name}, drawn_{block.name}[i], {block.size});")
    handed = [
        f"&{block.name}" if block.drawn or block.role != IN else f"&{name}_first_{block.name}"
        for block in entry.arguments
    ]
    call = f"{name}_{entry.name}((real)float_of(times[i]), {', '.join(handed)})"
    lines.append(f"        int differs = COUNTED({call}) != 0;")
    for block in entry.arguments:
        if block.role != IN:
            expected = f"{entry.name}_{block.name}[0], i, {block.size}, &all"
            lines.append(f'        differs |= compare("{block.name}", (const real *)&{block.name}, {expected});')
    lines += ["        all.differing += differs;", "    }", f'    return report("{name}_{entry.name}", &all);', "}", ""]
    return "\n".join(wrap(line) for line in lines)
