"""Small FMUs for tests: a spring with a damper in C, for FMI 2 and FMI 3, which can be made to fail."""

import subprocess
import zipfile
from pathlib import Path

from tests.generator.c_way import compilers

from vvdp.programs.foreign.platforms import this_platform

SOURCE = r"""
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef struct { double v, k, c, mode, x; } Model;
__attribute__((constructor)) static void loaded(void) {
    const char *mark = getenv("FMU_MARK");
    if (mark) fclose(fopen(mark, "w"));
}
static void *instance(const char *token) {
    Model *m = strcmp(token, "{spring}") ? 0 : calloc(1, sizeof(Model));
    if (m) m->k = 1000.0;
    return m;
}
static int set(Model *m, const unsigned *r, size_t n, const double *values) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] > 3) return 3;
        (&m->v)[r[i]] = values[i];
    }
    return 0;
}
static int get(Model *m, size_t n, double *values) {
    for (size_t i = 0; i < n; i++) values[i] = m->mode == 3.0 && m->x ? NAN : -m->k * m->x - m->c * m->v;
    return 0;
}
static int step(Model *m, double t, double h) {
    if (m->mode == 4.0) puts("noise");
    if (t > 0.0505 && m->mode == 1.0) abort();
    if (t > 0.0505 && m->mode == 2.0) return 3;
    m->x += h * m->v;
    return 0;
}
#if FMI == 2
#define DO(name) fmi2##name
void *DO(Instantiate)(const char *n, int t, const char *g, const char *r, const void *c, int v, int l) {
    return instance(g);
}
int DO(SetupExperiment)(void *m, int a, double b, double c, int d, double e) { return 0; }
int DO(EnterInitializationMode)(void *m) { return 0; }
int DO(SetReal)(void *m, const unsigned *r, size_t n, const double *v) { return set(m, r, n, v); }
int DO(GetReal)(void *m, const unsigned *r, size_t n, double *v) { return get(m, n, v); }
#ifndef MISSING
int DO(DoStep)(void *m, double t, double h, int s) { return step(m, t, h); }
#endif
#else
#define DO(name) fmi3##name
void *DO(InstantiateCoSimulation)(const char *n, const char *g, const char *r, _Bool a, _Bool b, _Bool c, _Bool d,
                                  const unsigned *q, size_t s, void *e, void *l, void *i) { return instance(g); }
int DO(EnterInitializationMode)(void *m, _Bool a, double b, double c, _Bool d, double e) { return 0; }
int DO(SetFloat64)(void *m, const unsigned *r, size_t n, const double *v, size_t k) { return set(m, r, n, v); }
int DO(GetFloat64)(void *m, const unsigned *r, size_t n, double *v, size_t k) { return get(m, n, v); }
int DO(DoStep)(void *m, double t, double h, _Bool s, _Bool *e, _Bool *q, _Bool *y, double *last) {
    *e = *q = *y = 0;
    *last = t + h;
    return s ? step(m, t, h) : 3;
}
#endif
int DO(ExitInitializationMode)(void *m) { return 0; }
int DO(Terminate)(void *m) { return 0; }
void DO(FreeInstance)(void *m) { free(m); }
"""
HEAD = {
    2: '<fmiModelDescription fmiVersion="2.0" modelName="spring" guid="{token}">',
    3: '<fmiModelDescription fmiVersion="3.0" modelName="spring" instantiationToken="{token}">',
}
UNITS = """<UnitDefinitions><Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit><Unit name="kN">
<BaseUnit kg="1" m="1" s="-2" factor="1000"/></Unit><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
<Unit name="N/m"><BaseUnit kg="1" s="-2"/></Unit></UnitDefinitions>"""
VARIABLES = (
    ("v", 0, "input", "continuous", "m/s"),
    ("k", 1, "parameter", "fixed", "N/m"),
    ("c", 2, "parameter", "fixed", "N*s/m"),
    ("mode", 3, "parameter", "fixed", ""),
    ("joint.F", 4, "output", "continuous", "N"),
)


def description(fmi, *, token="{spring}", unit="N", before="", features="", kind="CoSimulation"):
    """The text of a modelDescription.xml."""
    rows = []
    for name, reference, causality, variability, own in VARIABLES:
        told = unit if name == "joint.F" else own
        given = f'name="{name}" valueReference="{reference}" causality="{causality}" variability="{variability}"'
        start = 'start="0"' if causality != "output" else ""
        words = f"{f'unit={told!r}' if told else ''} {start}".replace("'", '"')
        rows.append(f"<ScalarVariable {given}><Real {words}/></ScalarVariable>" if fmi == 2
                    else f"<Float64 {given} {words}/>")  # fmt: skip
    return "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>', before, HEAD[fmi].format(token=token),
        f'<{kind} modelIdentifier="spring" {features}/>', UNITS, "<ModelVariables>", *rows, "</ModelVariables>",
        "<ModelStructure/></fmiModelDescription>",
    ])  # fmt: skip


def binary(folder: Path, fmi: int, *flags: str) -> bytes:
    """The library for this machine."""
    source, target = folder / "spring.c", folder / "spring.bin"
    source.write_text(SOURCE)
    words = [f"-DFMI={fmi}", "-O1", "-fPIC", "-shared", *flags, "-o", str(target), str(source), "-lm"]
    subprocess.run([next(iter(compilers())), *words], check=True, capture_output=True)
    return target.read_bytes()


def entries_of(fmi, library, **others):
    """The entries of an FMU for this machine."""
    place = f"binaries/{this_platform().folder(fmi)}/spring{this_platform().end}"
    return {"modelDescription.xml": description(fmi, **others).encode(), place: library}


def write_fmu(path: Path, entries) -> Path:
    """The file of an FMU."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in entries.items():
            file.writestr(name, content)
    return path
