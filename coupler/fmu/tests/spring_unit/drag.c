/* A fluid as a stranger might write it, FMI 3.0: every point is dragged by DRAG times its velocity, grad p = DRAG v / V. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define POINTS 5
#define DRAG 0.5

typedef void (*Log)(void *, int, const char *, const char *);
typedef struct { double volume[POINTS], position[2 * POINTS], velocity[2 * POINTS], gradient[2 * POINTS], dissipated; } State;

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const uint32_t *required, size_t count, void *environment,
                                  Log log, void *update) {
    return calloc(1, sizeof(State));
}
void fmi3FreeInstance(void *unit) { free(unit); }
int fmi3EnterConfigurationMode(void *unit) { return 0; }
int fmi3ExitConfigurationMode(void *unit) { return 0; }
int fmi3EnterInitializationMode(void *unit, bool tolerance, double value, double start, bool stop, double at) { return 0; }
int fmi3ExitInitializationMode(void *unit) { return 0; }
int fmi3Terminate(void *unit) { return 0; }

static double *at(State *s, uint32_t reference, size_t *length) {
    *length = reference == 5 ? 1 : reference == 1 ? POINTS : 2 * POINTS;
    double *places[] = {s->volume, s->position, s->velocity, s->gradient, &s->dissipated};
    return places[reference - 1];
}

int fmi3GetFloat64(void *unit, const uint32_t *references, size_t count, double *values, size_t total) {
    for (size_t i = 0, length; i < count; i++, values += length) {
        const double *from = at(unit, references[i], &length);
        memcpy(values, from, length * sizeof(double));
    }
    return 0;
}

int fmi3SetFloat64(void *unit, const uint32_t *references, size_t count, const double *values, size_t total) {
    for (size_t i = 0, length; i < count; i++, values += length) {
        double *to = at(unit, references[i], &length);
        memcpy(to, values, length * sizeof(double));
    }
    return 0;
}

int fmi3DoStep(void *unit, double start, double size, bool prior, bool *event, bool *end, bool *early, double *last) {
    State *s = unit;
    *event = *end = *early = false;
    *last = start + size;
    for (int n = 0; n < 2 * POINTS; n++) {
        s->gradient[n] = DRAG * s->velocity[n] / s->volume[n / 2];
        s->dissipated += DRAG * s->velocity[n] * s->velocity[n] * size;
    }
    return 0;
}

int fmi3GetFMUState(void *unit, void **state) {
    if (*state == NULL) *state = malloc(sizeof(State));
    memcpy(*state, unit, sizeof(State));
    return 0;
}
int fmi3SetFMUState(void *unit, void *state) { memcpy(unit, state, sizeof(State)); return 0; }
int fmi3FreeFMUState(void *unit, void **state) { free(*state); *state = NULL; return 0; }
int fmi3SerializedFMUStateSize(void *unit, void *state, size_t *size) { *size = sizeof(State); return 0; }
int fmi3SerializeFMUState(void *unit, void *state, uint8_t *bytes, size_t size) { memcpy(bytes, state, size); return 0; }
int fmi3DeserializeFMUState(void *unit, const uint8_t *bytes, size_t size, void **state) {
    if (*state == NULL) *state = malloc(sizeof(State));
    memcpy(*state, bytes, size);
    return 0;
}
