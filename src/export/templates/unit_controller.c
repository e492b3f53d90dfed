/* Written by muspin: the exported controller as a unit. A sample is taken at every multiple of the sample time. */
#include "controller.h"
#include "unit.h"

struct unit {
    struct unit_base base;
    muspin_f32 controller;
};

const unsigned long unit_bytes = sizeof(unit);
struct unit_base *unit_of(unit *u) { return &u->base; }

void unit_start(unit *u)
{
    int k;
    for (k = 0; k < UNIT_VARIABLES; ++k) {
        u->base.value[k] = 0.0;
    }
    u->base.done = 0;
    muspin_f32_init(&u->controller);
}

void unit_advance(unit *u, double end_s)
{
    double *v = u->base.value;
    /* A sample that falls on the end belongs to the next step; a thousandth of a sample is rounding. */
    while ((double)u->base.done * MUSPIN_SAMPLE_TIME_S < end_s - 1e-3 * MUSPIN_SAMPLE_TIME_S) {
        float y[MUSPIN_INPUTS], current[MUSPIN_OUTPUTS];
        int k;
        for (k = 0; k < MUSPIN_INPUTS; ++k) {
            y[k] = (float)v[1 + k];
        }
        muspin_f32_step(&u->controller, y, current);
        for (k = 0; k < MUSPIN_OUTPUTS; ++k) {
            v[1 + MUSPIN_INPUTS + k] = (double)current[k];
        }
        ++u->base.done;
    }
    v[0] = end_s;
}
