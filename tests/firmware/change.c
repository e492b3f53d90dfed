#include "controllers.h"
#include <math.h>
#include <stdio.h>

#define TS 5e-5
#define FULL 2147483648.0

static double position[4], speed[4];

static void advance(const double *u)
{
    int j;
    for (j = 0; j < 4; ++j) {
        const double load = j % 2 ? -60.0 : 30.0;
        speed[j] += TS * (200.0 * u[j] + 1e6 * position[j] + load) / 2.0;
        position[j] += TS * speed[j];
    }
}

int main(void)
{
    int kind;
    for (kind = 0; kind < 2; ++kind) {
        controllers_f32 f;
        controllers_q31 q;
        double last[4] = {0}, u[4] = {0}, jump = 0, later = 0, worst = 0;
        int k, j;
        for (j = 0; j < 4; ++j) {
            position[j] = 1e-4;
            speed[j] = 0;
        }
        controllers_f32_init(&f, CONTROLLERS_LIFT);
        controllers_q31_init(&q, CONTROLLERS_LIFT);
        for (k = 0; k < 12000; ++k) {
            float y[4], uf[4];
            int32_t yq[4], uq[4];
            for (j = 0; j < 4; ++j) {
                y[j] = (float)position[j];
                yq[j] = (int32_t)(position[j] / LIFT_INPUT_LIMIT_M * FULL);
            }
            if (k == 4000 || k == 8000) {
                const int next = k == 4000 ? CONTROLLERS_WORK : CONTROLLERS_LIFT;
                if (controllers_f32_change(&f, next, y) != 0 || controllers_q31_change(&q, next, yq) != 0) {
                    return 1;
                }
            }
            controllers_f32_output(&f, y, uf);
            controllers_q31_output(&q, yq, uq);
            for (j = 0; j < 4; ++j) {
                last[j] = u[j];
                u[j] = kind == 0 ? (double)uf[j] : uq[j] / FULL * LIFT_OUTPUT_LIMIT_A;
                if (k == 4000 || k == 8000) {
                    jump = fmax(jump, fabs(u[j] - last[j]));
                } else if (k > 4000 && k < 8000) {
                    later = fmax(later, fabs(u[j] - last[j]));
                }
            }
            controllers_f32_update(&f);
            controllers_q31_update(&q);
            advance(u);
            /* Before the way back the integrator has brought the position to zero; at the end the PD rests at its own. */
            if (k == 7999 || k == 11999) {
                for (j = 0; j < 4; ++j) {
                    const double load = j % 2 ? -60.0 : 30.0;
                    const double rest = k == 7999 ? 0.0 : load / (200.0 * 12000.0 - 1e6);
                    worst = fmax(worst, fabs(position[j] - rest));
                }
            }
        }
        if (controllers_f32_change(&f, CONTROLLERS_COUNT, (const float[4]){0}) != -1 || f.active != CONTROLLERS_LIFT) {
            return 1;
        }
        printf("%.9f %.9f %.9f\n", jump, later, worst * 1e6);
    }
    return 0;
}
