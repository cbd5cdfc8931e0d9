/* A host without Python: LIBRARY TOKEN PERIOD STEPS FIRST COUNT prints the bits of some variables after each step. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

enum { MOST = 256 };

int main(int count, char **words)
{
    if (count != 7) {
        return 2;
    }
    void *library = OPEN(words[1]);
    if (library == NULL) {
        fprintf(stderr, "the library cannot be opened\n");
        return 3;
    }
#define FUNCTION(name) name##TYPE *const own_##name = (name##TYPE *)FIND(library, #name)
    FUNCTION(fmi3InstantiateCoSimulation);
    FUNCTION(fmi3EnterInitializationMode);
    FUNCTION(fmi3ExitInitializationMode);
    FUNCTION(fmi3DoStep);
    FUNCTION(fmi3GetFloat64);
    FUNCTION(fmi3FreeInstance);
    const double period = atof(words[3]);
    const int steps = atoi(words[4]), first = atoi(words[5]);
    const size_t variables = (size_t)atoi(words[6]);
    fmi3ValueReference references[MOST];
    fmi3Float64 values[MOST];
    for (size_t i = 0; i < variables; i++) {
        references[i] = (fmi3ValueReference)first + (fmi3ValueReference)i;
    }
    fmi3Instance one = own_fmi3InstantiateCoSimulation("host", words[2], NULL, fmi3False, fmi3False, fmi3False,
            fmi3False, NULL, 0, NULL, NULL, NULL);
    if (one == NULL || own_fmi3EnterInitializationMode(one, fmi3False, 0.0, 0.0, fmi3False, 0.0) != fmi3OK
            || own_fmi3ExitInitializationMode(one) != fmi3OK) {
        return 4;
    }
    for (int step = 0; step < steps; step++) {
        fmi3Boolean event, terminate, early;
        fmi3Float64 last;
        if (own_fmi3DoStep(one, step * period, period, fmi3True, &event, &terminate, &early, &last) != fmi3OK
                || own_fmi3GetFloat64(one, references, variables, values, variables) != fmi3OK) {
            return 5;
        }
        for (size_t i = 0; i < variables; i++) {
            uint64_t bits;
            memcpy(&bits, &values[i], sizeof bits);
            printf("%016" PRIx64 "\n", bits);
        }
    }
    own_fmi3FreeInstance(one);
    return 0;
}
