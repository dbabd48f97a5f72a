/* A reservoir of FMI 2.0, p = -1000 a at three points, with the habits of other tools: one is chosen by a macro. */
#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xmmintrin.h>

#define POINTS 3

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;
typedef struct {
    double a[POINTS], p[POINTS], stop;
    int has_stop, steps;
} State;
typedef struct {
    State now;
    const Callbacks *callbacks; /* Kept as it is, as many tools do. */
    char *name;
} Instance;

#define SAY(unit, status, ...) (unit)->callbacks->logger((unit)->callbacks->environment, (unit)->name, status, "own", __VA_ARGS__)

#ifdef FLUSHES_WHEN_LOADED
/* What the compiler's -ffast-math links into a library. */
__attribute__((constructor)) static void flush(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
#endif

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const Callbacks *callbacks, int visible, int logging) {
    if (kind != 1 || strcmp(guid, "{water}") || strncmp(resources, "file:///", 8)) return NULL;
    Instance *unit = callbacks->allocate ? callbacks->allocate(1, sizeof *unit) : calloc(1, sizeof *unit);
    unit->callbacks = callbacks;
    unit->name = strdup(name);
#ifdef CHANGES_THE_PROCESS
    if (chdir("/")) return NULL;
    setlocale(LC_ALL, "C.UTF-8");
    signal(SIGTERM, SIG_IGN);
    signal(SIGSEGV, SIG_DFL);
    fesetround(FE_UPWARD);
#endif
    return unit;
}

void fmi2FreeInstance(Instance *unit) {
    free(unit->name);
    free(unit);
}

int fmi2SetupExperiment(Instance *unit, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    unit->now.has_stop = has_stop;
    unit->now.stop = stop;
#ifdef NEEDS_STOP
    if (!has_stop) {
        SAY(unit, 3, "a stop time is needed");
        return 3;
    }
    if (stop > 2.0) {
        SAY(unit, 3, "the table of the inflow ends at t = %g s", 2.0);
        return 3;
    }
#endif
    return 0;
}

int fmi2EnterInitializationMode(Instance *unit) { return 0; }

int fmi2ExitInitializationMode(Instance *unit) {
#ifdef SAYS
    SAY(unit, 0, "initialised with %d points, %.2f m, %s", POINTS, 91.75, "100%");
    SAY(unit, 1, "the depth is %s", "large");
#endif
    return 0;
}

int fmi2GetReal(Instance *unit, const unsigned *at, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) values[i] = at[i] < POINTS ? unit->now.a[at[i]] : unit->now.p[at[i] - POINTS];
    return 0;
}

int fmi2SetReal(Instance *unit, const unsigned *at, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++) {
        if (at[i] >= POINTS) return 3;
        unit->now.a[at[i]] = values[i];
    }
    return 0;
}

int fmi2GetInteger(Instance *unit, const unsigned *at, size_t count, int *values) { return count ? 3 : 0; }
int fmi2GetBoolean(Instance *unit, const unsigned *at, size_t count, int *values) { return count ? 3 : 0; }
int fmi2SetInteger(Instance *unit, const unsigned *at, size_t count, const int *values) { return count ? 3 : 0; }
int fmi2SetBoolean(Instance *unit, const unsigned *at, size_t count, const int *values) { return count ? 3 : 0; }
int fmi2SetString(Instance *unit, const unsigned *at, size_t count, const char *const *values) { return count ? 3 : 0; }

int fmi2DoStep(Instance *unit, double time, double length, int never_back) {
    unit->now.steps++;
#ifdef NEEDS_STOP
    if (unit->now.has_stop && time + length > unit->now.stop) {
        SAY(unit, 3, "t = %.17g s is beyond the stop time of %.17g s", time + length, unit->now.stop);
        return 3;
    }
#endif
#ifdef SAYS
    for (int i = 0; i < 300; i++) SAY(unit, 0, "step %d, line %d", unit->now.steps, i);
#endif
#ifdef CHANGES_THE_PROCESS
    if (chdir("/tmp")) return 3;
    signal(SIGPIPE, SIG_DFL);
    feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
    _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
#ifdef UNKNOWN_STATUS
    return 17;
#endif
    for (int i = 0; i < POINTS; i++) unit->now.p[i] = -1000.0 * unit->now.a[i];
    return 0;
}

#ifndef WITHOUT_STATES
int fmi2GetFMUstate(Instance *unit, State **state) {
    if (!*state) *state = malloc(sizeof **state);
    **state = unit->now;
    return 0;
}

int fmi2SetFMUstate(Instance *unit, const State *state) {
    unit->now = *state;
    return 0;
}

int fmi2FreeFMUstate(Instance *unit, State **state) {
    free(*state);
    *state = NULL;
    return 0;
}

int fmi2SerializedFMUstateSize(Instance *unit, const State *state, size_t *size) {
    *size = sizeof *state;
    return 0;
}

int fmi2SerializeFMUstate(Instance *unit, const State *state, char *bytes, size_t size) {
    memcpy(bytes, state, size);
    return 0;
}

int fmi2DeSerializeFMUstate(Instance *unit, const char *bytes, size_t size, State **state) {
    if (size != sizeof **state) return 3;
    if (!*state) *state = malloc(size);
    memcpy(*state, bytes, size);
    return 0;
}
#endif
