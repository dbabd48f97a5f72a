/* ---- FMI 3.0: nothing below needs a change ------------------------------------------------------------------------------ */

typedef enum { INSTANTIATED, INITIALIZATION, STEPPING, TERMINATED } Mode;

/* What a saved state holds. */
typedef struct {
    Mode mode;
    double time;
    State state;
} Saved;

typedef struct {
    Saved now;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Instance;

static fmi3Status refuse(fmi3Instance instance, const char *call, const char *why, ...)
{
    const Instance *unit = instance;
    char text[512];
    int said = snprintf(text, sizeof text, "%s: ", call);
    va_list values;
    va_start(values, why);
    vsnprintf(text + said, sizeof text - (size_t)said, why, values);
    va_end(values);
    if (unit != NULL && unit->log != NULL)
        unit->log(unit->environment, fmi3Error, "logStatusError", text);
    else
        fprintf(stderr, "%s\n", text);
    return fmi3Error;
}

static const Variable *find(fmi3ValueReference reference)
{
    for (size_t i = 0; i < sizeof VARIABLES / sizeof VARIABLES[0]; i++)
        if (VARIABLES[i].reference == reference)
            return &VARIABLES[i];
    return NULL;
}

static double *values_in(State *state, const Variable *variable)
{
    return (double *)(void *)((char *)state + variable->offset);
}

EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
    fmi3Boolean early_return, const fmi3ValueReference intermediate[], size_t intermediate_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)early_return, (void)intermediate;
    (void)intermediate_count, (void)update;
    Instance *unit = calloc(1, sizeof *unit);
    if (unit == NULL)
        return NULL;
    unit->environment = environment;
    unit->log = log;
    unit->now.state = START;
    if (token == NULL || strcmp(token, TOKEN) != 0)
        refuse(unit, __func__, "the instantiation token is not %s: library and modelDescription.xml differ; build anew", TOKEN);
    else if (events)
        refuse(unit, __func__, "this unit has no events; pass eventModeUsed = false");
    else
        return unit;
    free(unit);
    return NULL;
}

EXPORT void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

/* Errors are always told, and there is nothing else to tell. */
EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    (void)instance, (void)on, (void)count, (void)categories;
    return fmi3OK;
}

EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                              fmi3Float64 start_time, fmi3Boolean has_stop_time, fmi3Float64 stop_time)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop_time, (void)stop_time;
    Instance *unit = instance;
    if (unit->now.mode != INSTANTIATED)
        return refuse(unit, __func__, "the instance has begun already; call fmi3Reset first");
    unit->now.mode = INITIALIZATION;
    unit->now.time = start_time;
    return fmi3OK;
}

EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    Instance *unit = instance;
    if (unit->now.mode != INITIALIZATION)
        return refuse(unit, __func__, "call fmi3EnterInitializationMode first");
    const char *why = start(&unit->now.state);
    if (why != NULL)
        return refuse(unit, __func__, "%s", why);
    unit->now.mode = STEPPING;
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                 fmi3Float64 values[], size_t length)
{
    Instance *unit = instance;
    /* Inputs and parameters may have changed since the last time. */
    const char *why = unit->now.mode == INITIALIZATION ? start(&unit->now.state) : NULL;
    if (why != NULL)
        return refuse(unit, __func__, "%s", why);
    size_t at = 0;
    for (size_t i = 0; i < count; i++) {
        const Variable time = {0, 1, FIXED, 0, &unit->now.time};
        const Variable *variable = references[i] == 0 ? &time : find(references[i]);
        if (variable == NULL)
            return refuse(unit, __func__, "no variable has value reference %u", references[i]);
        if (variable->size > length - at)
            return refuse(unit, __func__, "the variables have more values than %zu", length);
        const double *from = variable->kind == FIXED ? variable->constant : values_in(&unit->now.state, variable);
        memcpy(values + at, from, variable->size * sizeof *values);
        at += variable->size;
    }
    return at == length ? fmi3OK : refuse(unit, __func__, "the variables have %zu values, not %zu", at, length);
}

EXPORT fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                 const fmi3Float64 values[], size_t length)
{
    Instance *unit = instance;
    size_t at = 0;
    for (size_t i = 0; i < count; i++) {
        const Variable *variable = find(references[i]);
        if (variable == NULL)
            return refuse(unit, __func__, "no variable has value reference %u", references[i]);
        if (variable->kind != SET_ANY_TIME && (variable->kind != SET_BEFORE_START || unit->now.mode > INITIALIZATION))
            return refuse(unit, __func__, "value reference %u: only inputs can be set, and parameters before the first step",
                          references[i]);
        if (variable->size > length - at)
            return refuse(unit, __func__, "the variables have more values than %zu", length);
        for (size_t k = 0; k < variable->size; k++)
            if (!isfinite(values[at + k]))
                return refuse(unit, __func__, "value reference %u: value %zu is not finite", references[i], k);
        memcpy(values_in(&unit->now.state, variable), values + at, variable->size * sizeof *values);
        at += variable->size;
    }
    return at == length ? fmi3OK : refuse(unit, __func__, "the variables have %zu values, not %zu", at, length);
}

EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_earlier_state,
                             fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                             fmi3Float64 *last_time)
{
    (void)no_earlier_state;
    Instance *unit = instance;
    *event_needed = *terminate = *early_return = false;
    *last_time = unit->now.time;
    if (unit->now.mode != STEPPING)
        return refuse(unit, __func__, "initialise the instance first");
    if (!(length > 0.0 && isfinite(length)))
        return refuse(unit, __func__, "a step of %g s; its length must be above 0", length);
    if (!(fabs(time - unit->now.time) <= 1e-6 * length))
        return refuse(unit, __func__, "a step from %.9g s, but the unit stands at %.9g s; restore the state of that time",
                      time, unit->now.time);
    const char *why = step(&unit->now.state, time, length);
    if (why != NULL)
        return refuse(unit, __func__, "the step from %.9g s: %s", time, why);
    for (size_t i = 0; i < sizeof VARIABLES / sizeof VARIABLES[0]; i++)
        for (size_t k = 0; VARIABLES[i].kind == COMPUTED && k < VARIABLES[i].size; k++)
            if (!isfinite(values_in(&unit->now.state, &VARIABLES[i])[k]))
                return refuse(unit, __func__, "the step from %.9g s: value %zu of value reference %u is not finite", time, k,
                              VARIABLES[i].reference);
    unit->now.time = *last_time = time + length;
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *saved)
{
    Instance *unit = instance;
    if (*saved == NULL)
        *saved = malloc(sizeof(Saved));
    if (*saved == NULL)
        return refuse(unit, __func__, "no memory is left");
    memcpy(*saved, &unit->now, sizeof(Saved));
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState saved)
{
    Instance *unit = instance;
    if (saved == NULL)
        return refuse(unit, __func__, "no state is given");
    memcpy(&unit->now, saved, sizeof(Saved));
    return fmi3OK;
}

EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *saved)
{
    (void)instance;
    free(*saved);
    *saved = NULL;
    return fmi3OK;
}

/* A state as bytes: the token, by which another unit refuses it, and the state. */
EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState saved, size_t *size)
{
    (void)instance, (void)saved;
    *size = sizeof TOKEN + sizeof(Saved);
    return fmi3OK;
}

EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState saved, fmi3Byte bytes[], size_t size)
{
    if (saved == NULL || size != sizeof TOKEN + sizeof(Saved))
        return refuse(instance, __func__, "a state needs %zu bytes, not %zu", sizeof TOKEN + sizeof(Saved), size);
    memcpy(bytes, TOKEN, sizeof TOKEN);
    memcpy(bytes + sizeof TOKEN, saved, sizeof(Saved));
    return fmi3OK;
}

EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *saved)
{
    if (size != sizeof TOKEN + sizeof(Saved) || memcmp(bytes, TOKEN, sizeof TOKEN) != 0)
        return refuse(instance, __func__, "the bytes are no state of this unit");
    if (*saved == NULL)
        *saved = malloc(sizeof(Saved));
    if (*saved == NULL)
        return refuse(instance, __func__, "no memory is left");
    memcpy(*saved, bytes + sizeof TOKEN, sizeof(Saved));
    return fmi3OK;
}

EXPORT fmi3Status fmi3Terminate(fmi3Instance instance)
{
    Instance *unit = instance;
    if (unit->now.mode != STEPPING)
        return refuse(unit, __func__, "the instance is not initialised");
    unit->now.mode = TERMINATED;
    return fmi3OK;
}

EXPORT fmi3Status fmi3Reset(fmi3Instance instance)
{
    Instance *unit = instance;
    unit->now.mode = INSTANTIATED;
    unit->now.time = 0.0;
    unit->now.state = START;
    return fmi3OK;
}
