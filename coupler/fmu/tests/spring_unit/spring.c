/* A unit as a stranger might write it: points that move together on a spring under the pressure gradient that they are given,
 * m u'' + k u = -sum V grad p, by the classical Runge-Kutta method. FMI_VERSION is 2 or 3.
 *
 * On request it misbehaves from a given time on: `fault` 1 fails the step, 2 ends the process, 3 hangs, 4 gives what is no number, 5 asks for the end,
 * 6 leaves the velocity out of the state that it goes back to. Compiled WITHOUT_STATE it has no functions for that; UNRESOLVED, it cannot be opened. */

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MOST_POINTS 64
#define VOLUME 1e-4
#define SPACING 0.01
#define DENSITY 1000.0

#ifdef UNRESOLVED
extern int nowhere;
int *const unresolved = &nowhere;
#endif

enum { OK, WARNING, DISCARD, ERROR, FATAL };

/* Value references. Those of FMI 2.0's scalars are BASE + 2 point + component. */
enum { TIME, POINTS, GRADIENT, POSITION, VELOCITY, VOLUMES, STIFFNESS, STEPS, FAULT, FAULT_TIME, ENERGY, SWING, BASE = 100, BLOCK = 1000 };

typedef struct {
    double time, u[2], v[2], gradient[2 * MOST_POINTS], stiffness, fault_time;
    uint64_t points;
    int32_t steps, fault;
} State;

typedef void (*Log3)(void *, int, const char *, const char *);
typedef void (*Log2)(void *, const char *, int, const char *, const char *, ...);

typedef struct {
    State s;
    void *environment;
    Log3 log3;
    Log2 log2;
} Unit;

static void say(Unit *unit, const char *words) {
    if (unit->log3) unit->log3(unit->environment, ERROR, "logStatusError", words);
    if (unit->log2) unit->log2(unit->environment, "spring", ERROR, "logStatusError", "%s of %d at %g", words, 5, unit->s.time);
}

static Unit *new_unit(void *environment, Log3 log3, Log2 log2) {
    Unit *unit = calloc(1, sizeof(Unit));
    unit->environment = environment;
    unit->log3 = log3;
    unit->log2 = log2;
    unit->s.points = 5;
    unit->s.stiffness = 1e3;
    unit->s.steps = 10;
    unit->s.fault_time = 1e300;
    return unit;
}

static double mass(const State *s) { return DENSITY * VOLUME * (double)s->points; }

static int step(Unit *unit, double start, double size, bool *ended) {
    State *s = &unit->s;
    if (s->fault != 0 && start + size > s->fault_time) {
        switch (s->fault) {
        case 1: say(unit, "the spring broke"); return ERROR;
        case 2: abort();
        case 3: for (;;) pause();
        case 4: s->v[0] = NAN; return OK;
        case 5: *ended = true; break;
        }
    }
    double force[2] = {0.0, 0.0};
    for (uint64_t p = 0; p < s->points; p++)
        for (int c = 0; c < 2; c++) force[c] -= VOLUME * s->gradient[2 * p + c];
    const double m = mass(s), k = s->stiffness / m, dt = size / s->steps;
    for (int n = 0; n < s->steps; n++)
        for (int c = 0; c < 2; c++) {
            const double f = force[c] / m, u = s->u[c], v = s->v[c];
            const double u1 = v, v1 = f - k * u;
            const double u2 = v + 0.5 * dt * v1, v2 = f - k * (u + 0.5 * dt * u1);
            const double u3 = v + 0.5 * dt * v2, v3 = f - k * (u + 0.5 * dt * u2);
            const double u4 = v + dt * v3, v4 = f - k * (u + dt * u3);
            s->u[c] += dt / 6.0 * (u1 + 2.0 * u2 + 2.0 * u3 + u4);
            s->v[c] += dt / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        }
    s->time = start + size;
    return OK;
}

static double kinetic(const State *s) { return 0.5 * mass(s) * (s->v[0] * s->v[0] + s->v[1] * s->v[1]); }

static double position(const State *s, uint64_t point, int c) {
    return s->u[c] + (c == 0 ? SPACING * (double)point : 0.0);
}

static int restore(Unit *unit, void *state) {
    const double v[2] = {unit->s.v[0], unit->s.v[1]};
    memcpy(&unit->s, state, sizeof(State));
    if (unit->s.fault == 6) memcpy(unit->s.v, v, sizeof v);
    return OK;
}

static size_t save(Unit *unit, void **state) {
    if (*state == NULL) *state = malloc(sizeof(State));
    memcpy(*state, &unit->s, sizeof(State));
    return OK;
}

#if FMI_VERSION == 3

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const uint32_t *required, size_t count, void *environment,
                                  Log3 log, void *update) {
    if (strcmp(token, "spring") != 0) {
        log(environment, ERROR, "logStatusError", "the token is not mine");
        return NULL;
    }
    return new_unit(environment, log, NULL);
}
void fmi3FreeInstance(void *unit) { free(unit); }
int fmi3EnterConfigurationMode(void *unit) { return OK; }
int fmi3ExitConfigurationMode(void *unit) { return OK; }
int fmi3EnterInitializationMode(void *unit, bool tolerance, double value, double start, bool stop, double at) {
    ((Unit *)unit)->s.time = start;
    return OK;
}
int fmi3ExitInitializationMode(void *unit) { return OK; }
int fmi3Terminate(void *unit) { return OK; }

int fmi3GetFloat64(void *handle, const uint32_t *references, size_t count, double *values, size_t length) {
    const State *s = &((Unit *)handle)->s;
    double *end = values + length;
    for (size_t i = 0; i < count; i++) {
        const size_t vector = 2 * s->points;
        switch (references[i]) {
        case TIME: *values++ = s->time; break;
        case GRADIENT: memcpy(values, s->gradient, vector * sizeof(double)); values += vector; break;
        case POSITION: for (size_t n = 0; n < vector; n++) *values++ = position(s, n / 2, n % 2); break;
        case VELOCITY: for (size_t n = 0; n < vector; n++) *values++ = s->v[n % 2]; break;
        case VOLUMES: for (size_t n = 0; n < s->points; n++) *values++ = VOLUME; break;
        case STIFFNESS: *values++ = s->stiffness; break;
        case ENERGY: *values++ = kinetic(s); break;
        default: say(handle, "no such variable"); return ERROR;
        }
    }
    return values == end ? OK : ERROR;
}

int fmi3SetFloat64(void *handle, const uint32_t *references, size_t count, const double *values, size_t length) {
    State *s = &((Unit *)handle)->s;
    for (size_t i = 0; i < count; i++) {
        switch (references[i]) {
        case GRADIENT: memcpy(s->gradient, values, 2 * s->points * sizeof(double)); values += 2 * s->points; break;
        case STIFFNESS: s->stiffness = *values++; break;
        case FAULT_TIME: s->fault_time = *values++; break;
        case SWING: s->u[0] = *values++; break;
        default: say(handle, "no such variable"); return ERROR;
        }
    }
    return OK;
}

int fmi3SetUInt64(void *handle, const uint32_t *references, size_t count, const uint64_t *values, size_t length) {
    if (references[0] != POINTS || values[0] > MOST_POINTS) return ERROR;
    ((Unit *)handle)->s.points = values[0];
    return OK;
}

int fmi3SetInt32(void *handle, const uint32_t *references, size_t count, const int32_t *values, size_t length) {
    State *s = &((Unit *)handle)->s;
    *(references[0] == FAULT ? &s->fault : &s->steps) = values[0];
    return OK;
}

int fmi3GetInt32(void *handle, const uint32_t *references, size_t count, int32_t *values, size_t length) {
    values[0] = ((Unit *)handle)->s.steps;
    return OK;
}

int fmi3DoStep(void *unit, double start, double size, bool prior, bool *event, bool *end, bool *early, double *last) {
    *event = *end = *early = false;
    *last = start + size;
    return step(unit, start, size, end);
}

#ifndef WITHOUT_STATE
int fmi3GetFMUState(void *unit, void **state) { return save(unit, state); }
int fmi3SetFMUState(void *unit, void *state) { return restore(unit, state); }
int fmi3FreeFMUState(void *unit, void **state) { free(*state); *state = NULL; return OK; }
int fmi3SerializedFMUStateSize(void *unit, void *state, size_t *size) { *size = sizeof(State); return OK; }
int fmi3SerializeFMUState(void *unit, void *state, uint8_t *bytes, size_t size) { memcpy(bytes, state, size); return OK; }
int fmi3DeserializeFMUState(void *unit, const uint8_t *bytes, size_t size, void **state) {
    if (size != sizeof(State)) { say(unit, "these bytes are no state of mine"); return ERROR; }
    if (*state == NULL) *state = malloc(sizeof(State));
    memcpy(*state, bytes, size);
    return OK;
}
#endif

#else

typedef struct {
    Log2 logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished;
    void *environment;
} Callbacks;

const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int kind, const char *token, const char *resources, const Callbacks *callbacks,
                      int visible, int logging) {
    if (kind != 1 || strcmp(token, "spring") != 0 || strncmp(resources, "file:///", 8) != 0) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatusError", "the token is not mine");
        return NULL;
    }
    return new_unit(callbacks->environment, NULL, callbacks->logger);
}
void fmi2FreeInstance(void *unit) { free(unit); }
int fmi2SetupExperiment(void *unit, int tolerance, double value, double start, int stop, double at) {
    ((Unit *)unit)->s.time = start;
    return OK;
}
int fmi2EnterInitializationMode(void *unit) { return OK; }
int fmi2ExitInitializationMode(void *unit) { return OK; }
int fmi2Terminate(void *unit) { return OK; }

int fmi2GetReal(void *handle, const uint32_t *references, size_t count, double *values) {
    const State *s = &((Unit *)handle)->s;
    for (size_t i = 0; i < count; i++) {
        const uint32_t r = references[i], n = (r - BASE) % BLOCK;
        if (r < BASE) values[i] = r == STIFFNESS ? s->stiffness : r == ENERGY ? kinetic(s) : s->time;
        else if ((r - BASE) / BLOCK == 0) values[i] = s->gradient[n];
        else if ((r - BASE) / BLOCK == 1) values[i] = position(s, n / 2, n % 2);
        else values[i] = s->v[n % 2];
    }
    return OK;
}

int fmi2SetReal(void *handle, const uint32_t *references, size_t count, const double *values) {
    State *s = &((Unit *)handle)->s;
    for (size_t i = 0; i < count; i++) {
        const uint32_t r = references[i];
        if (r == STIFFNESS) s->stiffness = values[i];
        else if (r == FAULT_TIME) s->fault_time = values[i];
        else if (r >= BASE && r < BASE + 2 * MOST_POINTS) s->gradient[r - BASE] = values[i];
        else { say(handle, "no such variable"); return ERROR; }
    }
    return OK;
}

int fmi2SetInteger(void *handle, const uint32_t *references, size_t count, const int *values) {
    State *s = &((Unit *)handle)->s;
    *(references[0] == FAULT ? &s->fault : &s->steps) = values[0];
    return OK;
}

int fmi2GetInteger(void *handle, const uint32_t *references, size_t count, int *values) {
    values[0] = ((Unit *)handle)->s.steps;
    return OK;
}

int fmi2DoStep(void *unit, double start, double size, int no_going_back) {
    bool end = false;
    return step(unit, start, size, &end);
}

#ifndef WITHOUT_STATE
int fmi2GetFMUstate(void *unit, void **state) { return save(unit, state); }
int fmi2SetFMUstate(void *unit, void *state) { return restore(unit, state); }
int fmi2FreeFMUstate(void *unit, void **state) { free(*state); *state = NULL; return OK; }
int fmi2SerializedFMUstateSize(void *unit, void *state, size_t *size) { *size = sizeof(State); return OK; }
int fmi2SerializeFMUstate(void *unit, void *state, char *bytes, size_t size) { memcpy(bytes, state, size); return OK; }
int fmi2DeSerializeFMUstate(void *unit, const char *bytes, size_t size, void **state) {
    if (size != sizeof(State)) { say(unit, "these bytes are no state of mine"); return ERROR; }
    if (*state == NULL) *state = malloc(sizeof(State));
    memcpy(*state, bytes, size);
    return OK;
}
#endif

#endif
