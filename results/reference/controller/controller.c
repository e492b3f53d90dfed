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
    /* output 0 */ -0x1.5f8aa6p7f, -0x1.14612ap4f, -0x1.4de962p8f, 0x1.e1a3fap6f, 0x1.e4260ap8f, -0x1.fa12a4p10f, -0x1.fda062p9f, -0x1.956474p8f, 0x1.6775f0p10f, -0x1.db1450p8f, 0x1.8a96a6p10f, 0x1.205720p9f, 0x1.80ce6cp9f, 0x1.403014p9f, 0x1.4b37d8p6f, 0x1.bff508p7f, -0x1.93ed70p5f, -0x1.78c03ap4f, -0x1.183188p18f, 0x1.49d5c0p17f,
    /* output 1 */ -0x1.5f8aa6p7f, -0x1.14612ap4f, -0x1.4de962p8f, 0x1.e1a3fap6f, 0x1.e4260ap8f, -0x1.fa12a4p10f, -0x1.fda062p9f, -0x1.956474p8f, 0x1.6775f0p10f, -0x1.db1450p8f, 0x1.8a96a6p10f, 0x1.205720p9f, 0x1.80ce6cp9f, 0x1.403014p9f, 0x1.4b37d8p6f, 0x1.bff508p7f, -0x1.93ed70p5f, -0x1.78c03ap4f, -0x1.183188p18f, 0x1.49d5c0p17f,
    /* output 2 */ 0x1.287fb4p6f, 0x1.381588p8f, -0x1.008938p7f, 0x1.8e6ac0p9f, -0x1.8ab5dap10f, 0x1.61415ap10f, -0x1.369bdap10f, 0x1.10f730p9f, -0x1.01e872p10f, 0x1.8341b2p10f, -0x1.250642p11f, -0x1.696b2cp9f, -0x1.4b00d6p7f, -0x1.08c22ap9f, -0x1.840700p7f, -0x1.36fc94p8f, -0x1.e2f7e4p3f, 0x1.231356p5f, 0x1.73e296p18f, -0x1.f09b24p18f,
    /* output 3 */ 0x1.287fb4p6f, 0x1.381588p8f, -0x1.008938p7f, 0x1.8e6ac0p9f, -0x1.8ab5dap10f, 0x1.61415ap10f, -0x1.369bdap10f, 0x1.10f730p9f, -0x1.01e872p10f, 0x1.8341b2p10f, -0x1.250642p11f, -0x1.696b2cp9f, -0x1.4b00d6p7f, -0x1.08c22ap9f, -0x1.840700p7f, -0x1.36fc94p8f, -0x1.e2f7e4p3f, 0x1.231356p5f, 0x1.73e296p18f, -0x1.f09b24p18f,
    /* state 0 */ -0x1.0843ecp-8f, 0x1.3f4786p3f, 0x1.7f356ep1f, 0x1.000000p0f,
    /* state 1 */ -0x1.dfa476p-9f, 0x1.9c8a42p0f, -0x1.37fccep3f, 0x1.000000p0f,
    /* state 2 */ -0x1.0843ecp-8f, 0x1.3f4786p3f, 0x1.7f356ep1f, 0x1.000000p0f,
    /* state 3 */ -0x1.dfa476p-9f, 0x1.9c8a42p0f, -0x1.37fccep3f, 0x1.000000p0f,
    /* state 4 */ -0x1.172ac6p-4f, 0x1.3615eep-2f, -0x1.b06582p4f, 0x1.d99a28p4f, 0x1.000000p0f,
    /* state 5 */ -0x1.3615eep-2f, -0x1.172ac6p-4f, 0x1.2d3ee2p6f, -0x1.428ca0p4f, 0x1.000000p0f,
    /* state 6 */ -0x1.172ac6p-4f, 0x1.3615eep-2f, -0x1.b06582p4f, 0x1.d99a28p4f, 0x1.000000p0f,
    /* state 7 */ -0x1.3615eep-2f, -0x1.172ac6p-4f, 0x1.2d3ee2p6f, -0x1.428ca0p4f, 0x1.000000p0f,
    /* state 8 */ -0x1.1b2e8ep-3f, 0x1.c87b34p-2f, -0x1.aff8f0p5f, -0x1.c1fdeap2f, 0x1.000000p0f,
    /* state 9 */ -0x1.c87b34p-2f, -0x1.1b2e8ep-3f, 0x1.b634bap5f, -0x1.9aa190p4f, 0x1.000000p0f,
    /* state 10 */ -0x1.1b2e8ep-3f, 0x1.c87b34p-2f, -0x1.aff8f0p5f, -0x1.c1fdeap2f, 0x1.000000p0f,
    /* state 11 */ -0x1.c87b34p-2f, -0x1.1b2e8ep-3f, 0x1.b634bap5f, -0x1.9aa190p4f, 0x1.000000p0f,
    /* state 12 */ -0x1.dcb888p-3f, 0x1.f1422ap-2f, 0x1.940028p7f, 0x1.db9df6p5f, 0x1.000000p0f,
    /* state 13 */ -0x1.f1422ap-2f, -0x1.dcb888p-3f, -0x1.e0e520p6f, -0x1.23a638p7f, 0x1.000000p0f,
    /* state 14 */ -0x1.dcb888p-3f, 0x1.f1422ap-2f, 0x1.940028p7f, 0x1.db9df6p5f, 0x1.000000p0f,
    /* state 15 */ -0x1.f1422ap-2f, -0x1.dcb888p-3f, -0x1.e0e520p6f, -0x1.23a638p7f, 0x1.000000p0f,
    /* state 16 */ 0x1.33fb6cp-1f, 0x1.70023ap-1f, 0x1.390e14p6f, -0x1.906680p6f,
    /* state 17 */ -0x1.70023ap-1f, 0x1.33fb6cp-1f, -0x1.5e20e8p1f, -0x1.9a3c02p7f,
    /* state 18 */ 0x1.33fb6cp-1f, 0x1.70023ap-1f, 0x1.390e14p6f, -0x1.906680p6f,
    /* state 19 */ -0x1.70023ap-1f, 0x1.33fb6cp-1f, -0x1.5e20e8p1f, -0x1.9a3c02p7f,
    /* state 20 */ 0x1.49e8cep-2f, 0x1.a69f3ap-1f, -0x1.73a7e2p6f, -0x1.605ca0p7f,
    /* state 21 */ -0x1.a69f3ap-1f, 0x1.49e8cep-2f, 0x1.ad3efep7f, -0x1.b20950p7f,
    /* state 22 */ 0x1.49e8cep-2f, 0x1.a69f3ap-1f, -0x1.73a7e2p6f, -0x1.605ca0p7f,
    /* state 23 */ -0x1.a69f3ap-1f, 0x1.49e8cep-2f, 0x1.ad3efep7f, -0x1.b20950p7f,
    /* state 24 */ 0x1.eae72cp-4f, 0x1.e64a1ep-1f, -0x1.3c55ccp5f, -0x1.34d946p7f,
    /* state 25 */ -0x1.e64a1ep-1f, 0x1.eae72cp-4f, 0x1.142152p5f, -0x1.6f7c76p4f,
    /* state 26 */ 0x1.eae72cp-4f, 0x1.e64a1ep-1f, -0x1.3c55ccp5f, -0x1.34d946p7f,
    /* state 27 */ -0x1.e64a1ep-1f, 0x1.eae72cp-4f, 0x1.142152p5f, -0x1.6f7c76p4f,
    /* state 28 */ -0x1.4184a8p-4f, 0x1.6ea12cp-1f, -0x1.04efbap6f, 0x1.ea5fdap8f,
    /* state 29 */ -0x1.6ea12cp-3f, -0x1.4184a8p-4f, -0x1.5a602cp9f, 0x1.7696e2p10f,
    /* state 30 */ -0x1.4184a8p-4f, 0x1.6ea12cp-1f, -0x1.04efbap6f, 0x1.ea5fdap8f,
    /* state 31 */ -0x1.6ea12cp-3f, -0x1.4184a8p-4f, -0x1.5a602cp9f, 0x1.7696e2p10f,
    /* state 32 */ -0x1.c9a14cp-2f, -0x1.9a523ep10f, -0x1.43d726p8f,
    /* state 33 */ -0x1.febd44p-1f, 0x1.fe3aeep1f, -0x1.4e9390p2f,
    /* state 34 */ -0x1.c9a14cp-2f, -0x1.9a523ep10f, -0x1.43d726p8f,
    /* state 35 */ -0x1.febd44p-1f, 0x1.fe3aeep1f, -0x1.4e9390p2f,
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
/* Over the test vectors Q31 stays within 4.180e-4 A of exact arithmetic (bound from rounding and coefficients). */
static const int32_t q31_coefficient[232] = {
    /* output 0 */ -30718173, -3018802, -58355288, 21043196, 84611100, -353770548, -178127367, -70847458, 251281227, -83026131, 275837341, 100782246, 134499564, 111913751, 14471141, 39143092, -8823931, -4115124, -12736214, 7496336,
    /* output 1 */ -30718173, -3018802, -58355288, 21043196, 84611100, -353770548, -178127367, -70847458, 251281227, -83026131, 275837341, 100782246, 134499564, 111913751, 14471141, 39143092, -8823931, -4115124, -12736214, 7496336,
    /* output 2 */ 6477116, 27270325, -11208230, 69628415, -137961267, 123471673, -108565639, 47704193, -90145374, 135356004, -204838924, -63162483, -14461754, -46269894, -16953174, -27174428, -1318825, 3179321, 8452032, -11286631,
    /* output 3 */ 6477116, 27270325, -11208230, 69628415, -137961267, 123471673, -108565639, 47704193, -90145374, 135356004, -204838924, -63162483, -14461754, -46269894, -16953174, -27174428, -1318825, 3179321, 8452032, -11286631,
    /* state 0 */ -4329723, 2721163, 816505, 1073741824,
    /* state 1 */ -3929231, 439501, -2659015, 1073741824,
    /* state 2 */ -4329723, 2721163, 816505, 1073741824,
    /* state 3 */ -3929231, 439501, -2659015, 1073741824,
    /* state 4 */ -73181973, 325148393, -7370480, 8072857, 1073741824,
    /* state 5 */ -325148393, -73181973, 20539713, -5498063, 1073741824,
    /* state 6 */ -73181973, 325148393, -7370480, 8072857, 1073741824,
    /* state 7 */ -325148393, -73181973, 20539713, -5498063, 1073741824,
    /* state 8 */ -148468855, 478655293, -14726502, -1917601, 1073741824,
    /* state 9 */ -478655293, -148468855, 14939013, -6999474, 1073741824,
    /* state 10 */ -148468855, 478655293, -14726502, -1917601, 1073741824,
    /* state 11 */ -478655293, -148468855, 14939013, -6999474, 1073741824,
    /* state 12 */ -249939014, 521413280, 55091630, 16214404, 1073741824,
    /* state 13 */ -521413280, -249939014, -32788675, -39770815, 1073741824,
    /* state 14 */ -249939014, 521413280, 55091630, 16214404, 1073741824,
    /* state 15 */ -521413280, -249939014, -32788675, -39770815, 1073741824,
    /* state 16 */ 645885305, 771770186, 21344905, -27300342,
    /* state 17 */ -771770186, 645885305, -746021, -55941702,
    /* state 18 */ 645885305, 771770186, 21344905, -27300342,
    /* state 19 */ -771770186, 645885305, -746021, -55941702,
    /* state 20 */ 345935062, 886302522, -25340460, -48049895,
    /* state 21 */ -886302522, 345935062, 58534231, -59187464,
    /* state 22 */ 345935062, 886302522, -25340460, -48049895,
    /* state 23 */ -886302522, 345935062, 58534231, -59187464,
    /* state 24 */ 128687279, 1019823067, -10784278, -42116221,
    /* state 25 */ -1019823067, 128687279, 9413637, -6264041,
    /* state 26 */ 128687279, 1019823067, -10784278, -42116221,
    /* state 27 */ -1019823067, 128687279, 9413637, -6264041,
    /* state 28 */ -168568126, 1537755841, -35582653, 267480047,
    /* state 29 */ -384438960, -168568126, -377868722, 817295341,
    /* state 30 */ -168568126, 1537755841, -35582653, 267480047,
    /* state 31 */ -384438960, -168568126, -377868722, 817295341,
    /* state 32 */ -959719794, -895256705, -176642280,
    /* state 33 */ -2142195959, 2174302, -2851537,
    /* state 34 */ -959719794, -895256705, -176642280,
    /* state 35 */ -2142195959, 2174302, -2851537,
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
