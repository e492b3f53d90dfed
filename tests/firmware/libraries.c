#include "sections.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* CMSIS-DSP, arm_biquad_cascade_df2T_f32: y = b0 x + d1, d1 = b1 x + a1 y + d2, d2 = b2 x + a2 y. */
static float cmsis(const float *table, int sections, float *d, float x)
{
    int k;
    for (k = 0; k < sections; ++k, table += 5, d += 2) {
        const float y = table[0] * x + d[0];
        d[0] = table[1] * x + table[3] * y + d[1];
        d[1] = table[2] * x + table[4] * y;
        x = y;
    }
    return x;
}

/* TI Digital Control Library, DCL_runDF22: u = b0 e + x1, x1 = b1 e + x2 - a1 u, x2 = b2 e - a2 u. */
static float dcl(const float (*table)[5], int sections, float *x, float e)
{
    int k;
    for (k = 0; k < sections; ++k, x += 2) {
        const float u = e * table[k][0] + x[0];
        x[0] = e * table[k][1] + x[1] - u * table[k][3];
        x[1] = e * table[k][2] - u * table[k][4];
        e = u;
    }
    return e;
}

int main(void)
{
    static char line[4096];
    static float states[2][4][64];
    FILE *file = fopen("test_vectors.csv", "r");
    float largest = 0, worst = 0;
    int sample, j;
    if (!file || !fgets(line, sizeof line, file)) {
        return 1;
    }
    for (sample = 0; sample < 176 && fgets(line, sizeof line, file); ++sample) {
        float y[4], u[4];
        char *at = strchr(line, ',');
        for (j = 0; j < 4; ++j) {
            y[j] = strtof(at + 1, &at);
        }
        for (j = 0; j < 4; ++j) {
            const float expected = strtof(at + 1, &at);
            if (j == 0) {
                u[0] = cmsis(sections_cmsis_front_x, SECTIONS_SECTIONS_FRONT_X, states[0][j], y[j]);
                u[1] = dcl(sections_dcl_front_x, SECTIONS_SECTIONS_FRONT_X, states[1][j], y[j]);
            } else {
                u[0] = cmsis(sections_cmsis_rear_y, SECTIONS_SECTIONS_REAR_Y, states[0][j], y[j]);
                u[1] = dcl(sections_dcl_rear_y, SECTIONS_SECTIONS_REAR_Y, states[1][j], y[j]);
            }
            if (j == 0 || j == 3) {
                largest = fmaxf(largest, fabsf(expected));
                worst = fmaxf(worst, fmaxf(fabsf(u[0] - expected), fabsf(u[1] - expected)));
            }
        }
    }
    fclose(file);
    printf("%d %.9f %.9f\n", sample, (double)largest, (double)worst);
    return 0;
}
