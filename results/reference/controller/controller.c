/* Written by muspin; see controller.h. Every value is a sum of products: coefficient k times value source[k] of
 * v = [states; inputs; signals]. Rows in order: signals, outputs, next states; row r ends before row_end[r]. */
#include "controller.h"

static const uint8_t source[232] = {
    /* output 0 */ 0, 1, 4, 5, 8, 9, 12, 13, 16, 17, 20, 21, 24, 25, 28, 29, 32, 33, 36, 38,
    /* output 1 */ 2, 3, 6, 7, 10, 11, 14, 15, 18, 19, 22, 23, 26, 27, 30, 31, 34, 35, 37, 39,
    /* output 2 */ 0, 1, 4, 5, 8, 9, 12, 13, 16, 17, 20, 21, 24, 25, 28, 29, 32, 33, 36, 38,
    /* output 3 */ 2, 3, 6, 7, 10, 11, 14, 15, 18, 19, 22, 23, 26, 27, 30, 31, 34, 35, 37, 39,
    /* state 0 */ 0, 36, 38, 0,
    /* state 1 */ 1, 36, 38, 1,
    /* state 2 */ 2, 37, 39, 2,
    /* state 3 */ 3, 37, 39, 3,
    /* state 4 */ 4, 5, 36, 38, 4,
    /* state 5 */ 4, 5, 36, 38, 5,
    /* state 6 */ 6, 7, 37, 39, 6,
    /* state 7 */ 6, 7, 37, 39, 7,
    /* state 8 */ 8, 9, 36, 38, 8,
    /* state 9 */ 8, 9, 36, 38, 9,
    /* state 10 */ 10, 11, 37, 39, 10,
    /* state 11 */ 10, 11, 37, 39, 11,
    /* state 12 */ 12, 13, 36, 38, 12,
    /* state 13 */ 12, 13, 36, 38, 13,
    /* state 14 */ 14, 15, 37, 39, 14,
    /* state 15 */ 14, 15, 37, 39, 15,
    /* state 16 */ 16, 17, 36, 38,
    /* state 17 */ 16, 17, 36, 38,
    /* state 18 */ 18, 19, 37, 39,
    /* state 19 */ 18, 19, 37, 39,
    /* state 20 */ 20, 21, 36, 38,
    /* state 21 */ 20, 21, 36, 38,
    /* state 22 */ 22, 23, 37, 39,
    /* state 23 */ 22, 23, 37, 39,
    /* state 24 */ 24, 25, 36, 38,
    /* state 25 */ 24, 25, 36, 38,
    /* state 26 */ 26, 27, 37, 39,
    /* state 27 */ 26, 27, 37, 39,
    /* state 28 */ 28, 29, 36, 38,
    /* state 29 */ 28, 29, 36, 38,
    /* state 30 */ 30, 31, 37, 39,
    /* state 31 */ 30, 31, 37, 39,
    /* state 32 */ 32, 36, 38,
    /* state 33 */ 33, 36, 38,
    /* state 34 */ 34, 37, 39,
    /* state 35 */ 35, 37, 39,
};
static const uint16_t row_end[40] = {
    /* rows */ 20, 40, 60, 80, 84, 88, 92, 96, 101, 106, 111, 116, 121, 126, 131, 136, 141, 146, 151, 156, 160, 164, 168, 172, 176, 180, 184, 188, 192, 196, 200, 204, 208, 212, 216, 220, 223, 226, 229, 232,
};

#ifndef MUSPIN_NO_F32
#include <float.h>
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && !defined(MUSPIN_ALLOW_EXCESS_PRECISION)
#error "float expressions are evaluated with excess precision: test vectors will not match"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

static const float f32_coefficient[232] = {
    /* output 0 */ -0x1.5eec90p7f, -0x1.07aa3cp4f, -0x1.443770p8f, 0x1.03a9e8p7f, -0x1.d8e16ap8f, 0x1.ea7606p10f, -0x1.e6bb24p9f, -0x1.abe8a6p8f, 0x1.5902c2p10f, -0x1.031a72p9f, 0x1.b8b1a4p10f, 0x1.e840d6p8f, 0x1.91b7d6p8f, 0x1.598016p7f, 0x1.f1e374p5f, 0x1.b7e762p7f, -0x1.5864f6p6f, -0x1.641912p4f, -0x1.0a3ce4p18f, 0x1.6283fep17f,
    /* output 1 */ -0x1.5eec90p7f, -0x1.07aa3cp4f, -0x1.443770p8f, 0x1.03a9e8p7f, -0x1.d8e16ap8f, 0x1.ea7606p10f, -0x1.e6bb24p9f, -0x1.abe8a6p8f, 0x1.5902c2p10f, -0x1.031a72p9f, 0x1.b8b1a4p10f, 0x1.e840d6p8f, 0x1.91b7d6p8f, 0x1.598016p7f, 0x1.f1e374p5f, 0x1.b7e762p7f, -0x1.5864f6p6f, -0x1.641912p4f, -0x1.0a3ce4p18f, 0x1.6283fep17f,
    /* output 2 */ 0x1.2e51f6p6f, 0x1.37edfcp8f, -0x1.bacd6ap6f, 0x1.8e4510p9f, 0x1.76af82p10f, -0x1.6f9280p10f, -0x1.4a4660p10f, 0x1.bf8fa6p8f, -0x1.087022p10f, 0x1.89a660p10f, -0x1.25fa50p11f, -0x1.61665ep8f, -0x1.274130p9f, -0x1.e08e92p5f, -0x1.69f67ap7f, -0x1.41439ap8f, -0x1.1d6490p5f, 0x1.161528p5f, 0x1.774ec0p18f, -0x1.f47ee4p18f,
    /* output 3 */ 0x1.2e51f6p6f, 0x1.37edfcp8f, -0x1.bacd6ap6f, 0x1.8e4510p9f, 0x1.76af82p10f, -0x1.6f9280p10f, -0x1.4a4660p10f, 0x1.bf8fa6p8f, -0x1.087022p10f, 0x1.89a660p10f, -0x1.25fa50p11f, -0x1.61665ep8f, -0x1.274130p9f, -0x1.e08e92p5f, -0x1.69f67ap7f, -0x1.41439ap8f, -0x1.1d6490p5f, 0x1.161528p5f, 0x1.774ec0p18f, -0x1.f47ee4p18f,
    /* state 0 */ -0x1.08a818p-8f, 0x1.3f94fcp3f, 0x1.7501e4p1f, 0x1.000000p0f,
    /* state 1 */ -0x1.dfa2ccp-9f, 0x1.8ed524p0f, -0x1.38b3c2p3f, 0x1.000000p0f,
    /* state 2 */ -0x1.08a818p-8f, 0x1.3f94fcp3f, 0x1.7501e4p1f, 0x1.000000p0f,
    /* state 3 */ -0x1.dfa2ccp-9f, 0x1.8ed524p0f, -0x1.38b3c2p3f, 0x1.000000p0f,
    /* state 4 */ -0x1.1540b4p-4f, 0x1.3622f8p-2f, -0x1.9e2282p4f, 0x1.d07864p4f, 0x1.000000p0f,
    /* state 5 */ -0x1.3622f8p-2f, -0x1.1540b4p-4f, 0x1.2e41bcp6f, -0x1.4d242cp4f, 0x1.000000p0f,
    /* state 6 */ -0x1.1540b4p-4f, 0x1.3622f8p-2f, -0x1.9e2282p4f, 0x1.d07864p4f, 0x1.000000p0f,
    /* state 7 */ -0x1.3622f8p-2f, -0x1.1540b4p-4f, 0x1.2e41bcp6f, -0x1.4d242cp4f, 0x1.000000p0f,
    /* state 8 */ -0x1.1943b4p-3f, 0x1.c9bb8ap-2f, 0x1.adc382p5f, 0x1.74af0ap2f, 0x1.000000p0f,
    /* state 9 */ -0x1.c9bb8ap-2f, -0x1.1943b4p-3f, -0x1.c6b6dcp5f, 0x1.911a2cp4f, 0x1.000000p0f,
    /* state 10 */ -0x1.1943b4p-3f, 0x1.c9bb8ap-2f, 0x1.adc382p5f, 0x1.74af0ap2f, 0x1.000000p0f,
    /* state 11 */ -0x1.c9bb8ap-2f, -0x1.1943b4p-3f, -0x1.c6b6dcp5f, 0x1.911a2cp4f, 0x1.000000p0f,
    /* state 12 */ -0x1.d62152p-3f, 0x1.fad8e4p-2f, 0x1.b9ce84p7f, 0x1.327fa2p6f, 0x1.000000p0f,
    /* state 13 */ -0x1.fad8e4p-2f, -0x1.d62152p-3f, -0x1.5f62fap6f, -0x1.16e6b4p7f, 0x1.000000p0f,
    /* state 14 */ -0x1.d62152p-3f, 0x1.fad8e4p-2f, 0x1.b9ce84p7f, 0x1.327fa2p6f, 0x1.000000p0f,
    /* state 15 */ -0x1.fad8e4p-2f, -0x1.d62152p-3f, -0x1.5f62fap6f, -0x1.16e6b4p7f, 0x1.000000p0f,
    /* state 16 */ 0x1.34b84ep-1f, 0x1.705b26p-1f, 0x1.1c1ad0p6f, -0x1.9bc210p6f,
    /* state 17 */ -0x1.705b26p-1f, 0x1.34b84ep-1f, -0x1.859abap1f, -0x1.8ef604p7f,
    /* state 18 */ 0x1.34b84ep-1f, 0x1.705b26p-1f, 0x1.1c1ad0p6f, -0x1.9bc210p6f,
    /* state 19 */ -0x1.705b26p-1f, 0x1.34b84ep-1f, -0x1.859abap1f, -0x1.8ef604p7f,
    /* state 20 */ 0x1.430116p-2f, 0x1.a421e6p-1f, -0x1.eac784p5f, -0x1.c826dap7f,
    /* state 21 */ -0x1.a421e6p-1f, 0x1.430116p-2f, 0x1.d56e78p7f, -0x1.5d53fcp7f,
    /* state 22 */ 0x1.430116p-2f, 0x1.a421e6p-1f, -0x1.eac784p5f, -0x1.c826dap7f,
    /* state 23 */ -0x1.a421e6p-1f, 0x1.430116p-2f, 0x1.d56e78p7f, -0x1.5d53fcp7f,
    /* state 24 */ 0x1.12cd22p-3f, 0x1.f51900p-1f, -0x1.d22096p2f, -0x1.0124a6p5f,
    /* state 25 */ -0x1.f51900p-1f, 0x1.12cd22p-3f, 0x1.0e0800p5f, 0x1.5503aap4f,
    /* state 26 */ 0x1.12cd22p-3f, 0x1.f51900p-1f, -0x1.d22096p2f, -0x1.0124a6p5f,
    /* state 27 */ -0x1.f51900p-1f, 0x1.12cd22p-3f, 0x1.0e0800p5f, 0x1.5503aap4f,
    /* state 28 */ -0x1.3cad06p-4f, 0x1.6f24cap-1f, 0x1.82a2dap6f, 0x1.3b44dep8f,
    /* state 29 */ -0x1.6f24cap-3f, -0x1.3cad06p-4f, -0x1.6e6d32p9f, 0x1.86e9aap10f,
    /* state 30 */ -0x1.3cad06p-4f, 0x1.6f24cap-1f, 0x1.82a2dap6f, 0x1.3b44dep8f,
    /* state 31 */ -0x1.6f24cap-3f, -0x1.3cad06p-4f, -0x1.6e6d32p9f, 0x1.86e9aap10f,
    /* state 32 */ -0x1.038676p-1f, -0x1.bb671ep9f, -0x1.9c0148p6f,
    /* state 33 */ -0x1.fedab0p-1f, 0x1.dd88f2p1f, -0x1.41d9a8p2f,
    /* state 34 */ -0x1.038676p-1f, -0x1.bb671ep9f, -0x1.9c0148p6f,
    /* state 35 */ -0x1.fedab0p-1f, 0x1.dd88f2p1f, -0x1.41d9a8p2f,
};

static const float f32_input_limit = 0x1.0a569cp-12f;
static const float f32_output_limit = 0x1.800000p1f;

static float f32_clamp(float value, float limit)
{
    if (value > limit) {
        return limit;
    }
    return value < -limit ? -limit : value;
}

static float f32_sum(const float *v, unsigned *k, unsigned end)
{
    float sum = 0.0f;
    for (; *k < end; ++*k) {
        const float product = f32_coefficient[*k] * v[source[*k]];
        sum = sum + product;
    }
    return sum;
}

void muspin_f32_init(muspin_f32 *c)
{
    unsigned i;
    for (i = 0; i < sizeof c->state / sizeof c->state[0]; ++i) {
        c->state[i] = 0.0f;
    }
}

void muspin_f32_step(muspin_f32 *c, const float y_m[MUSPIN_INPUTS], float u_a[MUSPIN_OUTPUTS])
{
    float v[MUSPIN_STATES + MUSPIN_INPUTS + MUSPIN_SIGNALS];
    int i;
    unsigned k = 0, row = 0;
    for (i = 0; i < MUSPIN_STATES; ++i) {
        v[i] = c->state[i];
    }
    for (i = 0; i < MUSPIN_INPUTS; ++i) {
        v[MUSPIN_STATES + i] = f32_clamp(y_m[i], f32_input_limit);
    }
    for (i = 0; i < MUSPIN_SIGNALS; ++i) {
        v[MUSPIN_STATES + MUSPIN_INPUTS + i] = f32_sum(v, &k, row_end[row++]);
    }
    for (i = 0; i < MUSPIN_OUTPUTS; ++i) {
        u_a[i] = f32_clamp(f32_sum(v, &k, row_end[row++]), f32_output_limit);
    }
    for (i = 0; i < MUSPIN_STATES; ++i) {
        c->state[i] = f32_clamp(f32_sum(v, &k, row_end[row++]), 1.0f);
    }
}
#endif

#ifndef MUSPIN_NO_Q31
/* Over the test vectors Q31 stays within 3.990e-4 A of exact arithmetic (bound from rounding and coefficients). */
static const int32_t q31_coefficient[232] = {
    /* output 0 */ -30664213, -2879925, -56660950, 22689761, -82641861, 342857115, -170124823, -74782482, 241180012, -90563173, 308067380, 85328443, 70205330, 30190279, 10876540, 38439383, -15046820, -3889539, -12101860, 8057266,
    /* output 1 */ -30664213, -2879925, -56660950, 22689761, -82641861, 342857115, -170124823, -74782482, 241180012, -90563173, 308067380, 85328443, 70205330, 30190279, 10876540, 38439383, -15046820, -3889539, -12101860, 8057266,
    /* output 2 */ 6604285, 27256827, -9673166, 69602688, 130962101, -128475815, -115439441, 39108488, -92427785, 137590611, -205505356, -30880553, -51599490, -5248963, -15814396, -28072482, -3117251, 3037404, 8529817, -11375033,
    /* output 3 */ 6604285, 27256827, -9673166, 69602688, 130962101, -128475815, -115439441, 39108488, -92427785, 137590611, -205505356, -30880553, -51599490, -5248963, -15814396, -28072482, -3117251, 3037404, 8529817, -11375033,
    /* state 0 */ -4336134, 2723741, 794769, 1073741824,
    /* state 1 */ -3929178, 424898, -2665106, 1073741824,
    /* state 2 */ -4336134, 2723741, 794769, 1073741824,
    /* state 3 */ -3929178, 424898, -2665106, 1073741824,
    /* state 4 */ -72680146, 325201783, -7059197, 7917199, 1073741824,
    /* state 5 */ -325201783, -72680146, 20608655, -5678611, 1073741824,
    /* state 6 */ -72680146, 325201783, -7059197, 7917199, 1073741824,
    /* state 7 */ -325201783, -72680146, 20608655, -5678611, 1073741824,
    /* state 8 */ -147463590, 479967392, 14651204, 1588159, 1073741824,
    /* state 9 */ -479967392, -147463590, -15501803, 6837049, 1073741824,
    /* state 10 */ -147463590, 479967392, 14651204, 1588159, 1073741824,
    /* state 11 */ -479967392, -147463590, -15501803, 6837049, 1073741824,
    /* state 12 */ -246483602, 531467855, 60247066, 20897872, 1073741824,
    /* state 13 */ -531467855, -246483602, -23958455, -38032417, 1073741824,
    /* state 14 */ -246483602, 531467855, 60247066, 20897872, 1073741824,
    /* state 15 */ -531467855, -246483602, -23958455, -38032417, 1073741824,
    /* state 16 */ 647432657, 772498609, 19371001, -28074737,
    /* state 17 */ -772498609, 647432657, -830133, -54404401,
    /* state 18 */ 647432657, 772498609, 19371001, -28074737,
    /* state 19 */ -772498609, 647432657, -830133, -54404401,
    /* state 20 */ 338694496, 881081514, -16731307, -62203230,
    /* state 21 */ -881081514, 338694496, 64014127, -47636193,
    /* state 22 */ 338694496, 881081514, -16731307, -62203230,
    /* state 23 */ -881081514, 338694496, 64014127, -47636193,
    /* state 24 */ 144075020, 1050877962, -1986361, -8766345,
    /* state 25 */ -1050877962, 144075020, 9205717, 5812811,
    /* state 26 */ 144075020, 1050877962, -1986361, -8766345,
    /* state 27 */ -1050877962, 144075020, 9205717, 5812811,
    /* state 28 */ -166029365, 1539912343, 52723718, 171966897,
    /* state 29 */ -384978086, -166029365, -399742652, 852910390,
    /* state 30 */ -166029365, 1539912343, 52723718, 171966897,
    /* state 31 */ -384978086, -166029365, -399742652, 852910390,
    /* state 32 */ -1088527793, -483717729, -56183150,
    /* state 33 */ -2142678035, 2034974, -2743073,
    /* state 34 */ -1088527793, -483717729, -56183150,
    /* state 35 */ -2142678035, 2034974, -2743073,
};
static const uint8_t q31_shift[40] = {
    /* rows */ 19, 19, 18, 18, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 31, 31, 31, 31, 31, 31, 31, 31,
};

/* Right shifts of negative numbers must be arithmetic, as on every usual target. */
typedef char muspin_arithmetic_shift[((-1) >> 1) == -1 ? 1 : -1];

static int32_t q31_saturate(int64_t value)
{
    if (value > INT32_MAX) {
        return INT32_MAX;
    }
    return value < -INT32_MAX ? -INT32_MAX : (int32_t)value;
}

static int32_t q31_sum(const int32_t *v, unsigned *k, unsigned end, unsigned shift)
{
    int64_t sum = 0;
    for (; *k < end; ++*k) {
        sum += (int64_t)q31_coefficient[*k] * v[source[*k]];
    }
    return q31_saturate((sum + ((int64_t)1 << (shift - 1))) >> shift);
}

void muspin_q31_init(muspin_q31 *c)
{
    unsigned i;
    for (i = 0; i < sizeof c->state / sizeof c->state[0]; ++i) {
        c->state[i] = 0;
    }
}

void muspin_q31_step(muspin_q31 *c, const int32_t y[MUSPIN_INPUTS], int32_t u[MUSPIN_OUTPUTS])
{
    int32_t v[MUSPIN_STATES + MUSPIN_INPUTS + MUSPIN_SIGNALS];
    int i;
    unsigned k = 0, row = 0;
    for (i = 0; i < MUSPIN_STATES; ++i) {
        v[i] = c->state[i];
    }
    for (i = 0; i < MUSPIN_INPUTS; ++i) {
        v[MUSPIN_STATES + i] = q31_saturate(y[i]);
    }
    for (i = 0; i < MUSPIN_SIGNALS; ++i, ++row) {
        v[MUSPIN_STATES + MUSPIN_INPUTS + i] = q31_sum(v, &k, row_end[row], q31_shift[row]);
    }
    for (i = 0; i < MUSPIN_OUTPUTS; ++i, ++row) {
        u[i] = q31_sum(v, &k, row_end[row], q31_shift[row]);
    }
    for (i = 0; i < MUSPIN_STATES; ++i, ++row) {
        c->state[i] = q31_sum(v, &k, row_end[row], q31_shift[row]);
    }
}
#endif

#ifdef MUSPIN_SELF_TEST
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads test_vectors.csv (columns: sample, y in m, u in A, y and u in Q31) and compares bit for bit. */
int main(int argc, char **argv)
{
    static char line[4096];
    FILE *file = fopen(argc > 1 ? argv[1] : "test_vectors.csv", "r");
    muspin_f32 f;
    muspin_q31 q;
    long samples = 0, wrong_f32 = 0, wrong_q31 = 0;
    if (!file || !fgets(line, sizeof line, file)) {
        fprintf(stderr, "cannot read the test vectors\n");
        return 2;
    }
    muspin_f32_init(&f);
    muspin_q31_init(&q);
    while (fgets(line, sizeof line, file)) {
        float y[MUSPIN_INPUTS], u[MUSPIN_OUTPUTS], expected;
        int32_t yq[MUSPIN_INPUTS], uq[MUSPIN_OUTPUTS];
        char *at = strchr(line, ',');
        int i;
        float uf[MUSPIN_OUTPUTS];
        for (i = 0; i < MUSPIN_INPUTS && at; ++i) {
            y[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < MUSPIN_OUTPUTS && at; ++i) {
            uf[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < MUSPIN_INPUTS && at; ++i) {
            yq[i] = (int32_t)strtol(at + 1, &at, 10);
        }
        if (!at) {
            fprintf(stderr, "sample %ld: a column is missing\n", samples);
            return 2;
        }
        muspin_f32_step(&f, y, u);
        muspin_q31_step(&q, yq, uq);
        for (i = 0; i < MUSPIN_OUTPUTS; ++i) {
            expected = uf[i];
            wrong_f32 += memcmp(&u[i], &expected, sizeof expected) != 0;
            wrong_q31 += uq[i] != (int32_t)strtol(at + 1, &at, 10);
        }
        ++samples;
    }
    fclose(file);
    printf("%ld samples, float32 mismatches %ld, Q31 mismatches %ld\n", samples, wrong_f32, wrong_q31);
    return samples == 0 || wrong_f32 || wrong_q31;
}
#endif
