/* FMI 3.0 in C: its types, and the 58 functions that this unit does not offer but importers look for.
 *
 * Nothing here needs a change. The 17 functions that do something are in the unit's own file. */

/* FMI's own headers may be included before; then they check every function. */
#ifndef fmi3FunctionTypes_h

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;

typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                                       fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment environment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean setRequested,
                                               fmi3Boolean getAllowed, fmi3Boolean finished, fmi3Boolean canReturnEarly,
                                               fmi3Boolean *earlyReturnRequested, fmi3Float64 *earlyReturnTime);
typedef void (*fmi3LockPreemptionCallback)();
typedef void (*fmi3UnlockPreemptionCallback)();

#endif

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* A variable: its value reference in modelDescription.xml, number of values, who sets it, and where its values are: in the
 * unit's State, or constant. */
typedef struct {
    fmi3ValueReference reference;
    size_t size;
    enum { SET_ANY_TIME, SET_BEFORE_START, COMPUTED, FIXED } kind;
    size_t offset;
    const double *constant;
} Variable;

#define MEMBER(reference, kind, name) {reference, sizeof(((State *)0)->name) / sizeof(double), kind, offsetof(State, name), NULL}
#define INPUT(reference, name) MEMBER(reference, SET_ANY_TIME, name)
#define PARAMETER(reference, name) MEMBER(reference, SET_BEFORE_START, name)
#define OUTPUT(reference, name) MEMBER(reference, COMPUTED, name)
#define CONSTANT(reference, values) {reference, sizeof(values) / sizeof(double), FIXED, 0, values}

/* Tells the importer why a call is refused. Defined in the unit's file. */
static fmi3Status refuse(fmi3Instance instance, const char *call, const char *why, ...);

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

/* ---- Variables of other types than Float64: there are none, so that only an empty list is accepted ---------------------- */

#define NO_VARIABLE(name, ...)                                                                                          \
    EXPORT fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t count, __VA_ARGS__)     \
    {                                                                                                                   \
        return count == 0 ? fmi3OK : refuse(instance, #name, "all variables of this unit are of type Float64");         \
    }
#define GET_AND_SET(type)                                                                                               \
    NO_VARIABLE(fmi3Get##type, fmi3##type values[], size_t length)                                                      \
    NO_VARIABLE(fmi3Set##type, const fmi3##type values[], size_t length)

GET_AND_SET(Float32)
GET_AND_SET(Int8)
GET_AND_SET(UInt8)
GET_AND_SET(Int16)
GET_AND_SET(UInt16)
GET_AND_SET(Int32)
GET_AND_SET(UInt32)
GET_AND_SET(Int64)
GET_AND_SET(UInt64)
GET_AND_SET(Boolean)
GET_AND_SET(String)
NO_VARIABLE(fmi3GetBinary, size_t sizes[], fmi3Binary values[], size_t length)
NO_VARIABLE(fmi3SetBinary, const size_t sizes[], const fmi3Binary values[], size_t length)
NO_VARIABLE(fmi3GetClock, fmi3Clock values[])
NO_VARIABLE(fmi3SetClock, const fmi3Clock values[])
NO_VARIABLE(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
NO_VARIABLE(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
NO_VARIABLE(fmi3GetShiftDecimal, fmi3Float64 shifts[])
NO_VARIABLE(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
NO_VARIABLE(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
NO_VARIABLE(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NO_VARIABLE(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
NO_VARIABLE(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NO_VARIABLE(fmi3GetOutputDerivatives, const fmi3Int32 orders[], fmi3Float64 values[], size_t length)

/* ---- What modelDescription.xml does not promise ------------------------------------------------------------------------- */

#define NOT_OFFERED(name, parameters)                                                                                   \
    EXPORT fmi3Status name parameters                                                                                   \
    {                                                                                                                   \
        return refuse(instance, #name, "this unit does not offer it; see modelDescription.xml");                        \
    }

NOT_OFFERED(fmi3EnterEventMode, (fmi3Instance instance))
NOT_OFFERED(fmi3EnterStepMode, (fmi3Instance instance))
NOT_OFFERED(fmi3EnterConfigurationMode, (fmi3Instance instance))
NOT_OFFERED(fmi3ExitConfigurationMode, (fmi3Instance instance))
NOT_OFFERED(fmi3EvaluateDiscreteStates, (fmi3Instance instance))
NOT_OFFERED(fmi3UpdateDiscreteStates, (fmi3Instance instance, fmi3Boolean *needUpdate, fmi3Boolean *terminate,
                                       fmi3Boolean *nominalsChanged, fmi3Boolean *valuesChanged, fmi3Boolean *nextEventDefined,
                                       fmi3Float64 *nextEvent))
NOT_OFFERED(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference reference, size_t *count))
NOT_OFFERED(fmi3GetVariableDependencies, (fmi3Instance instance, fmi3ValueReference dependent, size_t ofDependent[],
                                          fmi3ValueReference independents[], size_t ofIndependents[],
                                          fmi3DependencyKind kinds[], size_t count))
NOT_OFFERED(fmi3GetDirectionalDerivative, (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknownCount,
                                           const fmi3ValueReference knowns[], size_t knownCount, const fmi3Float64 seed[],
                                           size_t seedLength, fmi3Float64 sensitivity[], size_t sensitivityLength))
NOT_OFFERED(fmi3GetAdjointDerivative, (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknownCount,
                                       const fmi3ValueReference knowns[], size_t knownCount, const fmi3Float64 seed[],
                                       size_t seedLength, fmi3Float64 sensitivity[], size_t sensitivityLength))
NOT_OFFERED(fmi3EnterContinuousTimeMode, (fmi3Instance instance))
NOT_OFFERED(fmi3CompletedIntegratorStep, (fmi3Instance instance, fmi3Boolean noEarlierState, fmi3Boolean *enterEventMode,
                                          fmi3Boolean *terminate))
NOT_OFFERED(fmi3SetTime, (fmi3Instance instance, fmi3Float64 time))
NOT_OFFERED(fmi3SetContinuousStates, (fmi3Instance instance, const fmi3Float64 states[], size_t count))
NOT_OFFERED(fmi3GetContinuousStateDerivatives, (fmi3Instance instance, fmi3Float64 derivatives[], size_t count))
NOT_OFFERED(fmi3GetEventIndicators, (fmi3Instance instance, fmi3Float64 indicators[], size_t count))
NOT_OFFERED(fmi3GetContinuousStates, (fmi3Instance instance, fmi3Float64 states[], size_t count))
NOT_OFFERED(fmi3GetNominalsOfContinuousStates, (fmi3Instance instance, fmi3Float64 nominals[], size_t count))
NOT_OFFERED(fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t *count))
NOT_OFFERED(fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t *count))
NOT_OFFERED(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time))

/* ---- Other kinds of FMU ------------------------------------------------------------------------------------------------- */

#define NO_INSTANCE(name, ...)                                                                                          \
    EXPORT fmi3Instance name(fmi3String instanceName, fmi3String token, fmi3String resources, fmi3Boolean visible,      \
                             fmi3Boolean loggingOn, fmi3InstanceEnvironment environment, __VA_ARGS__)                   \
    {                                                                                                                   \
        refuse(NULL, #name, "this FMU is for co-simulation");                                                           \
        return NULL;                                                                                                    \
    }

NO_INSTANCE(fmi3InstantiateModelExchange, fmi3LogMessageCallback log)
NO_INSTANCE(fmi3InstantiateScheduledExecution, fmi3LogMessageCallback log, fmi3ClockUpdateCallback clockUpdate,
            fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
