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
    /* output 0 */ -0x1.5f76a4p7f, -0x1.037d1ap4f, -0x1.4ae84ep8f, 0x1.e607c4p6f, -0x1.d37288p8f, 0x1.f3821ep10f, -0x1.fc0e0cp9f, -0x1.9573bcp8f, 0x1.65ebaep10f, -0x1.e6a786p8f, -0x1.8ba6e8p10f, -0x1.157698p9f, 0x1.8135cap9f, 0x1.45db8ep9f, 0x1.4c29ccp6f, 0x1.bebe6cp7f, -0x1.90bc5cp5f, -0x1.7952f0p4f, -0x1.18c0bap18f, 0x1.49e476p17f,
    /* output 1 */ -0x1.5f76a4p7f, -0x1.037d1ap4f, -0x1.4ae84ep8f, 0x1.e607c4p6f, -0x1.d37288p8f, 0x1.f3821ep10f, -0x1.fc0e0cp9f, -0x1.9573bcp8f, 0x1.65ebaep10f, -0x1.e6a786p8f, -0x1.8ba6e8p10f, -0x1.157698p9f, 0x1.8135cap9f, 0x1.45db8ep9f, 0x1.4c29ccp6f, 0x1.bebe6cp7f, -0x1.90bc5cp5f, -0x1.7952f0p4f, -0x1.18c0bap18f, 0x1.49e476p17f,
    /* output 2 */ 0x1.305230p6f, 0x1.37a0d8p8f, -0x1.edcba8p6f, 0x1.8bae98p9f, 0x1.84e7d4p10f, -0x1.5cddd0p10f, -0x1.34e788p10f, 0x1.0fd812p9f, -0x1.f985f6p9f, 0x1.840dc2p10f, 0x1.2663f2p11f, 0x1.5d774ap9f, -0x1.3d7cdcp7f, -0x1.0a3d18p9f, -0x1.83ed88p7f, -0x1.362130p8f, -0x1.d8c468p3f, 0x1.230f76p5f, 0x1.73e64ep18f, -0x1.f02b0ap18f,
    /* output 3 */ 0x1.305230p6f, 0x1.37a0d8p8f, -0x1.edcba8p6f, 0x1.8bae98p9f, 0x1.84e7d4p10f, -0x1.5cddd0p10f, -0x1.34e788p10f, 0x1.0fd812p9f, -0x1.f985f6p9f, 0x1.840dc2p10f, 0x1.2663f2p11f, 0x1.5d774ap9f, -0x1.3d7cdcp7f, -0x1.0a3d18p9f, -0x1.83ed88p7f, -0x1.362130p8f, -0x1.d8c468p3f, 0x1.230f76p5f, 0x1.73e64ep18f, -0x1.f02b0ap18f,
    /* state 0 */ -0x1.088e66p-8f, 0x1.3fc54ep3f, 0x1.78561cp1f, 0x1.000000p0f,
    /* state 1 */ -0x1.dfcd16p-9f, 0x1.8b248cp0f, -0x1.38a798p3f, 0x1.000000p0f,
    /* state 2 */ -0x1.088e66p-8f, 0x1.3fc54ep3f, 0x1.78561cp1f, 0x1.000000p0f,
    /* state 3 */ -0x1.dfcd16p-9f, 0x1.8b248cp0f, -0x1.38a798p3f, 0x1.000000p0f,
    /* state 4 */ -0x1.1746ccp-4f, 0x1.361c5ep-2f, -0x1.ad8becp4f, 0x1.dc36b6p4f, 0x1.000000p0f,
    /* state 5 */ -0x1.361c5ep-2f, -0x1.1746ccp-4f, 0x1.30622ap6f, -0x1.46f4eap4f, 0x1.000000p0f,
    /* state 6 */ -0x1.1746ccp-4f, 0x1.361c5ep-2f, -0x1.ad8becp4f, 0x1.dc36b6p4f, 0x1.000000p0f,
    /* state 7 */ -0x1.361c5ep-2f, -0x1.1746ccp-4f, 0x1.30622ap6f, -0x1.46f4eap4f, 0x1.000000p0f,
    /* state 8 */ -0x1.1b741ap-3f, 0x1.c878e6p-2f, 0x1.b56226p5f, 0x1.d3d432p2f, 0x1.000000p0f,
    /* state 9 */ -0x1.c878e6p-2f, -0x1.1b741ap-3f, -0x1.be18ccp5f, 0x1.a13fa4p4f, 0x1.000000p0f,
    /* state 10 */ -0x1.1b741ap-3f, 0x1.c878e6p-2f, 0x1.b56226p5f, 0x1.d3d432p2f, 0x1.000000p0f,
    /* state 11 */ -0x1.c878e6p-2f, -0x1.1b741ap-3f, -0x1.be18ccp5f, 0x1.a13fa4p4f, 0x1.000000p0f,
    /* state 12 */ -0x1.dcf618p-3f, 0x1.f0cddcp-2f, 0x1.9527c2p7f, 0x1.dc8d1ap5f, 0x1.000000p0f,
    /* state 13 */ -0x1.f0cddcp-2f, -0x1.dcf618p-3f, -0x1.e69f80p6f, -0x1.253418p7f, 0x1.000000p0f,
    /* state 14 */ -0x1.dcf618p-3f, 0x1.f0cddcp-2f, 0x1.9527c2p7f, 0x1.dc8d1ap5f, 0x1.000000p0f,
    /* state 15 */ -0x1.f0cddcp-2f, -0x1.dcf618p-3f, -0x1.e69f80p6f, -0x1.253418p7f, 0x1.000000p0f,
    /* state 16 */ 0x1.33f44cp-1f, 0x1.6fff80p-1f, 0x1.3adc72p6f, -0x1.99a316p6f,
    /* state 17 */ -0x1.6fff80p-1f, 0x1.33f44cp-1f, -0x1.c572b6p1f, -0x1.99e34cp7f,
    /* state 18 */ 0x1.33f44cp-1f, 0x1.6fff80p-1f, 0x1.3adc72p6f, -0x1.99a316p6f,
    /* state 19 */ -0x1.6fff80p-1f, 0x1.33f44cp-1f, -0x1.c572b6p1f, -0x1.99e34cp7f,
    /* state 20 */ 0x1.4a0eeap-2f, 0x1.a6aedep-1f, 0x1.6a66b8p6f, 0x1.635cd6p7f,
    /* state 21 */ -0x1.a6aedep-1f, 0x1.4a0eeap-2f, -0x1.ae5956p7f, 0x1.ae621ap7f,
    /* state 22 */ 0x1.4a0eeap-2f, 0x1.a6aedep-1f, 0x1.6a66b8p6f, 0x1.635cd6p7f,
    /* state 23 */ -0x1.a6aedep-1f, 0x1.4a0eeap-2f, -0x1.ae5956p7f, 0x1.ae621ap7f,
    /* state 24 */ 0x1.e97a9ap-4f, 0x1.e5f75ep-1f, -0x1.43170ap5f, -0x1.395784p7f,
    /* state 25 */ -0x1.e5f75ep-1f, 0x1.e97a9ap-4f, 0x1.13903ep5f, -0x1.9502e4p4f,
    /* state 26 */ 0x1.e97a9ap-4f, 0x1.e5f75ep-1f, -0x1.43170ap5f, -0x1.395784p7f,
    /* state 27 */ -0x1.e5f75ep-1f, 0x1.e97a9ap-4f, 0x1.13903ep5f, -0x1.9502e4p4f,
    /* state 28 */ -0x1.40ea74p-4f, 0x1.6ed030p-1f, -0x1.1cb9f8p6f, 0x1.ee8aa8p8f,
    /* state 29 */ -0x1.6ed030p-3f, -0x1.40ea74p-4f, -0x1.596676p9f, 0x1.772936p10f,
    /* state 30 */ -0x1.40ea74p-4f, 0x1.6ed030p-1f, -0x1.1cb9f8p6f, 0x1.ee8aa8p8f,
    /* state 31 */ -0x1.6ed030p-3f, -0x1.40ea74p-4f, -0x1.596676p9f, 0x1.772936p10f,
    /* state 32 */ -0x1.cd0cd0p-2f, -0x1.99bad2p10f, -0x1.4e0e66p8f,
    /* state 33 */ -0x1.febcf8p-1f, 0x1.ff74f0p1f, -0x1.4e5772p2f,
    /* state 34 */ -0x1.cd0cd0p-2f, -0x1.99bad2p10f, -0x1.4e0e66p8f,
    /* state 35 */ -0x1.febcf8p-1f, 0x1.ff74f0p1f, -0x1.4e5772p2f,
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
/* Over the test vectors Q31 stays within 3.804e-4 A of exact arithmetic (bound from rounding and coefficients). */
static const int32_t q31_coefficient[232] = {
    /* output 0 */ -30711345, -2834308, -57830266, 21234989, -81692352, 349181588, -177578051, -70857888, 250204661, -85049018, -276580782, -96980438, 134640689, 113895503, 14512435, 39037073, -8754207, -4121384, -12761640, 7497642,
    /* output 1 */ -30711345, -2834308, -57830266, 21234989, -81692352, 349181588, -177578051, -70857888, 250204661, -85049018, -276580782, -96980438, 134640689, 113895503, 14512435, 39037073, -8754207, -4121384, -12761640, 7497642,
    /* output 2 */ 6647995, 27230495, -10787128, 69150441, 135932356, -121937661, -107969923, 47508184, -88346595, 135634618, 205793815, 61073606, -13871251, -46528578, -16948827, -27099541, -1290970, 3179156, 8452362, -11276678,
    /* output 3 */ 6647995, 27230495, -10787128, 69150441, 135932356, -121937661, -107969923, 47508184, -88346595, 135634618, 205793815, 61073606, -13871251, -46528578, -16948827, -27099541, -1290970, 3179156, 8452362, -11276678,
    /* state 0 */ -4334490, 2725350, 801862, 1073741824,
    /* state 1 */ -3930531, 420967, -2664701, 1073741824,
    /* state 2 */ -4334490, 2725350, 801862, 1073741824,
    /* state 3 */ -3930531, 420967, -2664701, 1073741824,
    /* state 4 */ -73210672, 325174764, -7321901, 8117373, 1073741824,
    /* state 5 */ -325174764, -73210672, 20753657, -5573190, 1073741824,
    /* state 6 */ -73210672, 325174764, -7321901, 8117373, 1073741824,
    /* state 7 */ -325174764, -73210672, 20753657, -5573190, 1073741824,
    /* state 8 */ -148611285, 478645865, 14910970, 1993612, 1073741824,
    /* state 9 */ -478645865, -148611285, -15208023, 7112274, 1073741824,
    /* state 10 */ -148611285, 478645865, 14910970, 1993612, 1073741824,
    /* state 11 */ -478645865, -148611285, -15208023, 7112274, 1073741824,
    /* state 12 */ -250065085, 520936896, 55249087, 16246251, 1073741824,
    /* state 13 */ -520936896, -250065085, -33179228, -39982756, 1073741824,
    /* state 14 */ -250065085, 520936896, 55249087, 16246251, 1073741824,
    /* state 15 */ -520936896, -250065085, -33179228, -39982756, 1073741824,
    /* state 16 */ 645826961, 771747812, 21468051, -27930122,
    /* state 17 */ -771747812, 645826961, -966165, -55894448,
    /* state 18 */ 645826961, 771747812, 21468051, -27930122,
    /* state 19 */ -771747812, 645826961, -966165, -55894448,
    /* state 20 */ 346091167, 886430654, 24709461, 48459102,
    /* state 21 */ -886430654, 346091167, -58684630, 58689297,
    /* state 22 */ 346091167, 886430654, 24709461, 48459102,
    /* state 23 */ -886430654, 346091167, -58684630, 58689297,
    /* state 24 */ 128313964, 1019145157, -11014559, -42728930,
    /* state 25 */ -1019145157, 128313964, 9394317, -6903681,
    /* state 26 */ 128313964, 1019145157, -11014559, -42728930,
    /* state 27 */ -1019145157, 128313964, 9394317, -6903681,
    /* state 28 */ -168252320, 1538526225, -38826782, 269753091,
    /* state 29 */ -384631556, -168252320, -376804616, 818542489,
    /* state 30 */ -168252320, 1538526225, -38826782, 269753091,
    /* state 31 */ -384631556, -168252320, -376804616, 818542489,
    /* state 32 */ -966892038, -893966149, -182214606,
    /* state 33 */ -2142191091, 2179529, -2849535,
    /* state 34 */ -966892038, -893966149, -182214606,
    /* state 35 */ -2142191091, 2179529, -2849535,
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
