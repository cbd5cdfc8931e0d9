/* Many instances at once: LIBRARY TOKEN PERIOD STEPS THREADS CYCLES [STATE]. Each thread steps an instance of its own;
   whether all end with the same bytes is checked, and that creating and freeing instances takes no memory. If STATE
   is the name of a file, the first half of the steps is taken from it: written where it is missing, else read. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "fmi3Functions.h"

enum { MOST = 16 };

#define FUNCTION(name) static name##TYPE *own_##name
FUNCTION(fmi3InstantiateCoSimulation);
FUNCTION(fmi3EnterInitializationMode);
FUNCTION(fmi3ExitInitializationMode);
FUNCTION(fmi3DoStep);
FUNCTION(fmi3Reset);
FUNCTION(fmi3GetFMUState);
FUNCTION(fmi3SetFMUState);
FUNCTION(fmi3FreeFMUState);
FUNCTION(fmi3SerializedFMUStateSize);
FUNCTION(fmi3SerializeFMUState);
FUNCTION(fmi3DeserializeFMUState);
FUNCTION(fmi3FreeInstance);

typedef struct {
    unsigned char *bytes;
    size_t size;
} content;

static const char *token;
static double period;
static int steps;

static void require(int is_well, const char *what)
{
    if (!is_well) {
        fprintf(stderr, "%s failed\n", what);
        exit(3);
    }
}

static fmi3Instance made(void)
{
    fmi3Instance one = own_fmi3InstantiateCoSimulation("one", token, NULL, fmi3False, fmi3False, fmi3False, fmi3False,
            NULL, 0, NULL, NULL, NULL);
    require(one != NULL, "instantiate");
    return one;
}

static void begin(fmi3Instance one)
{
    require(own_fmi3EnterInitializationMode(one, fmi3False, 0.0, 0.0, fmi3False, 0.0) == fmi3OK, "enter");
    require(own_fmi3ExitInitializationMode(one) == fmi3OK, "exit");
}

static void take(fmi3Instance one, int from, int to)
{
    for (int i = from; i < to; i++) {
        fmi3Boolean event, terminate, early;
        fmi3Float64 last;
        require(own_fmi3DoStep(one, i * period, period, fmi3True, &event, &terminate, &early, &last) == fmi3OK, "step");
    }
}

static content kept_of(fmi3Instance one)
{
    fmi3FMUState state = NULL;
    content found;
    require(own_fmi3GetFMUState(one, &state) == fmi3OK, "get state");
    require(own_fmi3SerializedFMUStateSize(one, state, &found.size) == fmi3OK, "size");
    found.bytes = malloc(found.size);
    require(found.bytes != NULL && own_fmi3SerializeFMUState(one, state, found.bytes, found.size) == fmi3OK, "serialise");
    require(own_fmi3FreeFMUState(one, &state) == fmi3OK && state == NULL, "free state");
    return found;
}

static void put(fmi3Instance one, content kept)
{
    fmi3FMUState state = NULL;
    require(own_fmi3DeserializeFMUState(one, kept.bytes, kept.size, &state) == fmi3OK, "deserialise");
    require(own_fmi3SetFMUState(one, state) == fmi3OK, "set state");
    require(own_fmi3FreeFMUState(one, &state) == fmi3OK, "free state");
}

static void *run(void *result)
{
    fmi3Instance one = made();
    begin(one);
    take(one, 0, steps);
    *(content *)result = kept_of(one);
    own_fmi3FreeInstance(one);
    return NULL;
}

/* The state after half of the steps, from a file; where there is none, it is written there. */
static void use_file(fmi3Instance one, const char *name)
{
    FILE *file = fopen(name, "rb");
    if (file == NULL) {
        begin(one);
        take(one, 0, steps / 2);
        content kept = kept_of(one);
        file = fopen(name, "wb");
        require(file != NULL && fwrite(kept.bytes, 1, kept.size, file) == kept.size, "write");
        free(kept.bytes);
    } else {
        content kept = kept_of(one);
        require(fread(kept.bytes, 1, kept.size, file) == kept.size, "read");
        put(one, kept);
        free(kept.bytes);
    }
    fclose(file);
    take(one, steps / 2, steps);
}

static long memory(void)
{
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    return used.ru_maxrss;
}

int main(int count, char **words)
{
    if (count != 7 && count != 8) {
        return 2;
    }
    void *library = dlopen(words[1], RTLD_NOW);
    require(library != NULL, "dlopen");
#define FIND(name) require((*(void **)&own_##name = dlsym(library, #name)) != NULL, #name)
    FIND(fmi3InstantiateCoSimulation);
    FIND(fmi3EnterInitializationMode);
    FIND(fmi3ExitInitializationMode);
    FIND(fmi3DoStep);
    FIND(fmi3Reset);
    FIND(fmi3GetFMUState);
    FIND(fmi3SetFMUState);
    FIND(fmi3FreeFMUState);
    FIND(fmi3SerializedFMUStateSize);
    FIND(fmi3SerializeFMUState);
    FIND(fmi3DeserializeFMUState);
    FIND(fmi3FreeInstance);
    token = words[2];
    period = atof(words[3]);
    steps = atoi(words[4]);
    const int threads = atoi(words[5]), cycles = atoi(words[6]);
    require(threads <= MOST, "so many threads");
    pthread_t own[MOST];
    content found[MOST], alone;
    for (int i = 0; i < threads; i++) {
        require(pthread_create(&own[i], NULL, run, &found[i]) == 0, "create");
    }
    for (int i = 0; i < threads; i++) {
        require(pthread_join(own[i], NULL) == 0, "join");
    }
    if (count == 8) {
        fmi3Instance one = made();
        use_file(one, words[7]);
        alone = kept_of(one);
        own_fmi3FreeInstance(one);
    } else {
        run(&alone);
    }
    int same = 0;
    for (int i = 0; i < threads; i++) {
        same += found[i].size == alone.size && memcmp(found[i].bytes, alone.bytes, alone.size) == 0;
        free(found[i].bytes);
    }
    free(alone.bytes);
    long before = 0;
    for (int i = 0; i < cycles; i++) {
        fmi3Instance one = made();
        begin(one);
        take(one, 0, 1);
        require(own_fmi3Reset(one) == fmi3OK, "reset");
        begin(one);
        own_fmi3FreeInstance(one);
        before = i == cycles / 10 ? memory() : before;
    }
    printf("%d of %d threads have the same bytes; %ld kB more after %d cycles\n", same, threads, memory() - before,
            cycles - cycles / 10);
    dlclose(library);
    return 0;
}
