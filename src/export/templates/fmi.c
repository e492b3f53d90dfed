/* Written by muspin: FMI 2.0 and 3.0 for co-simulation of the unit in unit.h; real variables only. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "unit.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

enum { OK = 0, ERROR = 3 };
typedef const char *text;

static void *make(text token)
{
    unit *u = token && strcmp(token, unit_token) == 0 ? (unit *)malloc(unit_bytes) : NULL;
    if (u) {
        unit_start(u);
    }
    return u;
}

static int get(void *u, const unsigned *names, size_t count, double *values)
{
    size_t k;
    for (k = 0; k < count; ++k) {
        if (names[k] >= UNIT_VARIABLES) {
            return ERROR;
        }
        values[k] = unit_of((unit *)u)->value[names[k]];
    }
    return OK;
}

/* Inputs stand behind the time; nothing else may be set. */
static int set(void *u, const unsigned *names, size_t count, const double *values)
{
    size_t k;
    for (k = 0; k < count; ++k) {
        if (names[k] < 1 || names[k] > UNIT_INPUTS) {
            return ERROR;
        }
        unit_of((unit *)u)->value[names[k]] = values[k];
    }
    return OK;
}

static int advance(void *u, double from_s, double step_s)
{
    if (!(step_s >= 0.0 && step_s <= 3600.0 && from_s >= 0.0)) {
        return ERROR;
    }
    unit_advance((unit *)u, from_s + step_s);
    return OK;
}

#ifdef UNIT_FMI2
EXPORT text fmi2GetTypesPlatform(void) { return "default"; }
EXPORT text fmi2GetVersion(void) { return "2.0"; }
EXPORT int fmi2SetDebugLogging(void *u, int on, size_t n, const text *c) { (void)u; (void)on; (void)n; (void)c; return OK; }
EXPORT void *fmi2Instantiate(text name, int kind, text token, text place, const void *calls, int visible, int logging)
{
    (void)name; (void)place; (void)calls; (void)visible; (void)logging;
    return kind == 1 ? make(token) : NULL;
}
EXPORT void fmi2FreeInstance(void *u) { free(u); }
EXPORT int fmi2SetupExperiment(void *u, int t, double tolerance, double start_s, int s, double stop_s)
{
    (void)u; (void)t; (void)tolerance; (void)s; (void)stop_s;
    return start_s == 0.0 ? OK : ERROR;
}
EXPORT int fmi2EnterInitializationMode(void *u) { (void)u; return OK; }
EXPORT int fmi2ExitInitializationMode(void *u) { (void)u; return OK; }
EXPORT int fmi2Terminate(void *u) { (void)u; return OK; }
EXPORT int fmi2Reset(void *u) { unit_start((unit *)u); return OK; }
EXPORT int fmi2GetReal(void *u, const unsigned *r, size_t n, double *v) { return get(u, r, n, v); }
EXPORT int fmi2SetReal(void *u, const unsigned *r, size_t n, const double *v) { return set(u, r, n, v); }
EXPORT int fmi2DoStep(void *u, double from_s, double step_s, int keep) { (void)keep; return advance(u, from_s, step_s); }
#define NO_VALUES(name, type) \
    EXPORT int name(void *u, const unsigned *r, size_t n, type v) { (void)u; (void)r; (void)v; return n == 0 ? OK : ERROR; }
NO_VALUES(fmi2GetInteger, int *)
NO_VALUES(fmi2SetInteger, const int *)
NO_VALUES(fmi2GetBoolean, int *)
NO_VALUES(fmi2SetBoolean, const int *)
NO_VALUES(fmi2GetString, text *)
NO_VALUES(fmi2SetString, const text *)
EXPORT int fmi2SetRealInputDerivatives(void *u, const unsigned *r, size_t n, const int *o, const double *v)
{
    (void)u; (void)r; (void)o; (void)v;
    return n == 0 ? OK : ERROR;
}
EXPORT int fmi2GetRealOutputDerivatives(void *u, const unsigned *r, size_t n, const int *o, double *v)
{
    (void)u; (void)r; (void)o; (void)v;
    return n == 0 ? OK : ERROR;
}
EXPORT int fmi2CancelStep(void *u) { (void)u; return ERROR; }
#define NO_STATUS(name, type) \
    EXPORT int name(void *u, int kind, type v) { (void)u; (void)kind; (void)v; return ERROR; }
NO_STATUS(fmi2GetStatus, int *)
NO_STATUS(fmi2GetRealStatus, double *)
NO_STATUS(fmi2GetIntegerStatus, int *)
NO_STATUS(fmi2GetBooleanStatus, int *)
NO_STATUS(fmi2GetStringStatus, text *)
EXPORT int fmi2GetFMUstate(void *u, void **s) { (void)u; (void)s; return ERROR; }
EXPORT int fmi2SetFMUstate(void *u, void *s) { (void)u; (void)s; return ERROR; }
EXPORT int fmi2FreeFMUstate(void *u, void **s) { (void)u; (void)s; return ERROR; }
EXPORT int fmi2SerializedFMUstateSize(void *u, void *s, size_t *n) { (void)u; (void)s; (void)n; return ERROR; }
EXPORT int fmi2SerializeFMUstate(void *u, void *s, char *b, size_t n) { (void)u; (void)s; (void)b; (void)n; return ERROR; }
EXPORT int fmi2DeSerializeFMUstate(void *u, const char *b, size_t n, void **s) { (void)u; (void)b; (void)n; (void)s; return ERROR; }
EXPORT int fmi2GetDirectionalDerivative(
    void *u, const unsigned *a, size_t n, const unsigned *b, size_t m, const double *d, double *v)
{
    (void)u; (void)a; (void)n; (void)b; (void)m; (void)d; (void)v;
    return ERROR;
}
#else
#include <stdbool.h>
EXPORT text fmi3GetVersion(void) { return "3.0"; }
EXPORT int fmi3SetDebugLogging(void *u, bool on, size_t n, const text *c) { (void)u; (void)on; (void)n; (void)c; return OK; }
EXPORT void *fmi3InstantiateCoSimulation(
    text name, text token, text place, bool visible, bool logging, bool events, bool early, const unsigned *required,
    size_t count, void *environment, void *log, void *intermediate)
{
    (void)name; (void)place; (void)visible; (void)logging; (void)events; (void)early; (void)required; (void)count;
    (void)environment; (void)log; (void)intermediate;
    return make(token);
}
EXPORT void *fmi3InstantiateModelExchange(text name, text token, text place, bool visible, bool logging, void *e, void *log)
{
    (void)name; (void)token; (void)place; (void)visible; (void)logging; (void)e; (void)log;
    return NULL;
}
EXPORT void fmi3FreeInstance(void *u) { free(u); }
EXPORT int fmi3EnterInitializationMode(void *u, bool t, double tolerance, double start_s, bool s, double stop_s)
{
    (void)u; (void)t; (void)tolerance; (void)s; (void)stop_s;
    return start_s == 0.0 ? OK : ERROR;
}
EXPORT int fmi3ExitInitializationMode(void *u) { (void)u; return OK; }
EXPORT int fmi3Terminate(void *u) { (void)u; return OK; }
EXPORT int fmi3Reset(void *u) { unit_start((unit *)u); return OK; }
EXPORT int fmi3GetFloat64(void *u, const unsigned *r, size_t n, double *v, size_t m) { return n == m ? get(u, r, n, v) : ERROR; }
EXPORT int fmi3SetFloat64(void *u, const unsigned *r, size_t n, const double *v, size_t m)
{
    return n == m ? set(u, r, n, v) : ERROR;
}
EXPORT int fmi3DoStep(
    void *u, double from_s, double step_s, bool keep, bool *event, bool *stop, bool *early, double *last_s)
{
    (void)keep;
    *event = *stop = *early = false;
    *last_s = from_s + step_s;
    return advance(u, from_s, step_s);
}
/* What a unit of real variables without states or events has no use for; the caller's arguments are not read. */
#define REFUSED(name) EXPORT int name() { return ERROR; }
REFUSED(fmi3GetFloat32) REFUSED(fmi3GetInt8) REFUSED(fmi3GetUInt8) REFUSED(fmi3GetInt16) REFUSED(fmi3GetUInt16)
REFUSED(fmi3GetInt32) REFUSED(fmi3GetUInt32) REFUSED(fmi3GetInt64) REFUSED(fmi3GetUInt64) REFUSED(fmi3GetBoolean)
REFUSED(fmi3GetString) REFUSED(fmi3GetBinary) REFUSED(fmi3GetClock) REFUSED(fmi3SetFloat32) REFUSED(fmi3SetInt8)
REFUSED(fmi3SetUInt8) REFUSED(fmi3SetInt16) REFUSED(fmi3SetUInt16) REFUSED(fmi3SetInt32) REFUSED(fmi3SetUInt32)
REFUSED(fmi3SetInt64) REFUSED(fmi3SetUInt64) REFUSED(fmi3SetBoolean) REFUSED(fmi3SetString) REFUSED(fmi3SetBinary)
REFUSED(fmi3SetClock) REFUSED(fmi3GetNumberOfVariableDependencies) REFUSED(fmi3GetVariableDependencies)
REFUSED(fmi3GetFMUState) REFUSED(fmi3SetFMUState) REFUSED(fmi3FreeFMUState) REFUSED(fmi3SerializedFMUStateSize)
REFUSED(fmi3SerializeFMUState) REFUSED(fmi3DeserializeFMUState) REFUSED(fmi3GetDirectionalDerivative)
REFUSED(fmi3GetAdjointDerivative) REFUSED(fmi3EnterConfigurationMode) REFUSED(fmi3ExitConfigurationMode)
REFUSED(fmi3EnterEventMode) REFUSED(fmi3EnterStepMode) REFUSED(fmi3GetIntervalDecimal)
REFUSED(fmi3GetIntervalFraction) REFUSED(fmi3GetShiftDecimal) REFUSED(fmi3GetShiftFraction)
REFUSED(fmi3SetIntervalDecimal) REFUSED(fmi3SetIntervalFraction) REFUSED(fmi3SetShiftDecimal)
REFUSED(fmi3SetShiftFraction) REFUSED(fmi3EvaluateDiscreteStates) REFUSED(fmi3UpdateDiscreteStates)
REFUSED(fmi3EnterContinuousTimeMode) REFUSED(fmi3CompletedIntegratorStep) REFUSED(fmi3SetTime)
REFUSED(fmi3SetContinuousStates) REFUSED(fmi3GetContinuousStateDerivatives) REFUSED(fmi3GetEventIndicators)
REFUSED(fmi3GetContinuousStates) REFUSED(fmi3GetNominalsOfContinuousStates) REFUSED(fmi3GetNumberOfEventIndicators)
REFUSED(fmi3GetNumberOfContinuousStates) REFUSED(fmi3GetOutputDerivatives) REFUSED(fmi3ActivateModelPartition)
EXPORT void *fmi3InstantiateScheduledExecution() { return NULL; }
#endif
