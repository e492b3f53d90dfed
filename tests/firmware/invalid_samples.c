#include "controller.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static int finite4(const float *u)
{
    int i, good = 1;
    for (i = 0; i < 4; ++i) {
        good = good && u[i] >= -3.0f && u[i] <= 3.0f;
    }
    return good;
}

int main(void)
{
    const float bad[3] = {NAN, INFINITY, -INFINITY};
    int k, i, j, wrong = 0;
    /* Replaced by the last valid sample of the channel, which a second instance is given. */
    for (k = 0; k < 3; ++k) {
        muspin_f32 a, b;
        muspin_f32_init(&a);
        muspin_f32_init(&b);
        for (i = 0; i < 300; ++i) {
            float y[4], z[4], u[4], w[4];
            for (j = 0; j < 4; ++j) {
                y[j] = z[j] = 1e-7f * (float)((i * 7 + j * 3) % 11 - 5);
            }
            if (i % 40 == 13) {
                y[i % 4] = bad[k];
                z[i % 4] = 1e-7f * (float)(((i - 1) * 7 + (i % 4) * 3) % 11 - 5);
            }
            muspin_f32_step(&a, y, u);
            muspin_f32_step(&b, z, w);
            wrong += !finite4(u) || memcmp(u, w, sizeof u) != 0;
        }
        wrong += muspin_f32_bad_samples(&a) != 8 || muspin_f32_bad_samples(&b) != 0 || muspin_f32_restarts(&a) != 0;
    }
    /* Memory that was never set: from the second sample on the instance does what a fresh one does. */
    for (k = 0; k < 3; ++k) {
        muspin_f32 a, b;
        const float y[4] = {1e-6f, -1e-6f, 2e-6f, 0.0f}, value = k == 2 ? 1e30f : bad[k];
        float u[4], w[4];
        muspin_f32_init(&a);
        muspin_f32_init(&b);
        for (i = 0; i < MUSPIN_STATES; ++i) {
            a.state[i] = value;
        }
        for (i = 0; i < 100; ++i) {
            muspin_f32_step(&a, y, u);
            muspin_f32_step(&b, y, w);
            wrong += !finite4(u) || memcmp(u, w, sizeof u) != 0;
        }
        wrong += muspin_f32_restarts(&a) != 1;
    }
    printf("%d\n", wrong);
    return 0;
}
