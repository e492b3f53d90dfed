/* Changes between controllers on a machine whose sampled model stands in plant.h: N states, inputs 4 currents and a load. */
#include "controllers.h"
#include "plant.h"
#include <math.h>
#include <stdio.h>

#define FULL 2147483648.0
#define SAMPLES 4000
#define TAIL 400

static const int sequence[] = {CONTROLLERS_PID, CONTROLLERS_MU, CONTROLLERS_PID, CONTROLLERS_OTHER,
                               CONTROLLERS_MU, CONTROLLERS_PD, CONTROLLERS_MU, CONTROLLERS_PID, CONTROLLERS_PD};
static double x[N], next[N];

int main(void)
{
    int kind, phase, k, i, j;
    for (kind = 0; kind < 2; ++kind) {
        controllers_f32 f;
        controllers_q31 q;
        double u[4] = {0}, last[4] = {0};
        for (i = 0; i < N; ++i) {
            x[i] = 0;
        }
        controllers_f32_init(&f, (uint_least8_t)sequence[0]);
        controllers_q31_init(&q, (uint_least8_t)sequence[0]);
        for (phase = 0; phase < (int)(sizeof sequence / sizeof *sequence); ++phase) {
            double jump = 0, peak = 0, low[4] = {1, 1, 1, 1}, high[4] = {-1, -1, -1, -1}, moved = 0;
            for (k = 0; k < SAMPLES; ++k) {
                float y[4], uf[4];
                int32_t yq[4], uq[4];
                for (j = 0; j < 4; ++j) {
                    double sum = 0;
                    for (i = 0; i < N; ++i) {
                        sum += C[j][i] * x[i];
                    }
                    y[j] = (float)sum;
                    yq[j] = (int32_t)lrint(sum / MU_INPUT_LIMIT_M * FULL);
                    peak = fmax(peak, fabs(sum));
                    if (k >= SAMPLES - TAIL) {
                        low[j] = fmin(low[j], sum);
                        high[j] = fmax(high[j], sum);
                    }
                }
                if (k == 0 && phase > 0) {
                    const uint_least8_t to = (uint_least8_t)sequence[phase];
                    if (controllers_f32_change(&f, to, y) != 0 || controllers_q31_change(&q, to, yq) != 0) {
                        return 1;
                    }
                }
                controllers_f32_output(&f, y, uf);
                controllers_q31_output(&q, yq, uq);
                for (j = 0; j < 4; ++j) {
                    last[j] = u[j];
                    u[j] = kind == 0 ? (double)uf[j] : uq[j] / FULL * MU_OUTPUT_LIMIT_A;
                    if (k == 0) {
                        jump = fmax(jump, fabs(u[j] - last[j]));
                    }
                }
                controllers_f32_update(&f);
                controllers_q31_update(&q);
                for (i = 0; i < N; ++i) {
                    double sum = E[i] * LOAD;
                    for (j = 0; j < N; ++j) {
                        sum += A[i][j] * x[j];
                    }
                    for (j = 0; j < 4; ++j) {
                        sum += B[i][j] * u[j];
                    }
                    next[i] = sum;
                }
                for (i = 0; i < N; ++i) {
                    x[i] = next[i];
                }
            }
            for (j = 0; j < 4; ++j) {
                moved = fmax(moved, high[j] - low[j]);
            }
            if (phase > 0) {
                printf("%d %d %d %.9f %.6f %.6f\n", kind, sequence[phase - 1], sequence[phase], jump, 1e6 * peak, 1e6 * moved);
            }
        }
    }
    return 0;
}
