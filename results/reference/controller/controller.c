/* Written by muspin; see controller.h. Every value is a sum of products, written out; x are states, y displacements,
 * t signals, u currents. */
#include "controller.h"

#ifndef MUSPIN_NO_F32
#include <float.h>
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16 && !defined(MUSPIN_ALLOW_EXCESS_PRECISION)
#error "float expressions are evaluated with excess precision: test vectors will not match"
#endif
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "-ffast-math removes the check for NaN and reorders sums: compile this file without it"
#endif
/* No fused multiply-add: products and sums are rounded one by one. GCC 12 fuses in its straight-line vectoriser in spite
 * of the first option (bug 107647), hence the second. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize ("fp-contract=off", "no-tree-slp-vectorize")
#else
#pragma STDC FP_CONTRACT OFF
#endif

static const float paper_tool_f32_input_limit = 0x1.0a569cp-12f;
static const float paper_tool_f32_output_limit = 0x1.800000p1f;
static const float paper_tool_f32_output_guard = 0x1.73391ep23f;

static float paper_tool_f32_clamp(float value, float limit)
{
    if (value > limit) {
        return limit;
    }
    return value < -limit ? -limit : value;
}

/* Keeps the displacements within the limit; one that is not a finite number leaves the one before in place. */
static void paper_tool_f32_hold(paper_tool_f32 *c, const float *y_m)
{
    int i;
    for (i = 0; i < 4; ++i) {
        const float sample = y_m[i];
        if (sample <= paper_tool_f32_input_limit && sample >= -paper_tool_f32_input_limit) {
            c->y_m[i] = sample;
        } else if (sample <= FLT_MAX && sample >= -FLT_MAX) {
            c->y_m[i] = paper_tool_f32_clamp(sample, paper_tool_f32_input_limit);
        } else if ((c->status & 65535u) < 65535u) {
            ++c->status;
        }
    }
}

/* Signals, and outputs before their limit. */
static void paper_tool_f32_sums(paper_tool_f32 *c, float *u)
{
    const float *x = c->state;
    const float *y = c->y_m;
    const float y0 = y[0];
    const float y1 = y[1];
    const float y2 = y[2];
    const float y3 = y[3];
    {
        float v = x[0];
        float u0 = 0x1.5f8406p-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.5e449ep0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.5e1ad2p9f * v; u2 += -0x1.7e9a7ep9f * v;
        v = x[5]; u0 += 0x1.dc4fe6p7f * v; u2 += 0x1.9a314ep9f * v;
        v = x[8]; u0 += 0x1.0d8514p9f * v; u2 += -0x1.d85066p10f * v;
        v = x[9]; u0 += -0x1.2e5502p9f * v; u2 += 0x1.36a78ep9f * v;
        v = x[12]; u0 += 0x1.6e0caep10f * v; u2 += 0x1.008c7ep9f * v;
        v = x[13]; u0 += 0x1.1b246ep6f * v; u2 += -0x1.b8d22ep9f * v;
        v = x[16]; u0 += 0x1.8bab8ep11f * v; u2 += -0x1.699be2p11f * v;
        v = x[17]; u0 += 0x1.ba25f6p9f * v; u2 += 0x1.37714cp10f * v;
        v = x[20]; u0 += 0x1.4287e0p9f * v; u2 += -0x1.930790p9f * v;
        v = x[21]; u0 += -0x1.5809b4p6f * v; u2 += -0x1.1466c8p7f * v;
        v = x[24]; u0 += -0x1.342518p8f * v; u2 += -0x1.83167ap5f * v;
        v = x[25]; u0 += 0x1.5fa880p-2f * v; u2 += -0x1.96d37cp4f * v;
        v = x[28]; u0 += 0x1.eba2acp6f * v; u2 += -0x1.ff8ea2p8f * v;
        v = x[29]; u0 += -0x1.e61b98p9f * v; u2 += -0x1.355bd0p6f * v;
        v = x[32]; u0 += 0x1.084f16p8f * v; u2 += -0x1.39aa02p7f * v;
        v = x[33]; u0 += -0x1.2d2cb4p7f * v; u2 += 0x1.048caap7f * v;
        v = x[36]; u0 += -0x1.da9aa8p4f * v; u2 += 0x1.7a4820p5f * v;
        v = y0; u0 += -0x1.c04aa8p19f * v; u2 += 0x1.9d0548p19f * v;
        v = y2; u0 += 0x1.37e2a8p17f * v; u2 += -0x1.4ffd54p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.5f8406p-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.5e449ep0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.5e1ad2p9f * v; u3 += -0x1.7e9a7ep9f * v;
        v = x[7]; u1 += 0x1.dc4fe6p7f * v; u3 += 0x1.9a314ep9f * v;
        v = x[10]; u1 += 0x1.0d8514p9f * v; u3 += -0x1.d85066p10f * v;
        v = x[11]; u1 += -0x1.2e5502p9f * v; u3 += 0x1.36a78ep9f * v;
        v = x[14]; u1 += 0x1.6e0caep10f * v; u3 += 0x1.008c7ep9f * v;
        v = x[15]; u1 += 0x1.1b246ep6f * v; u3 += -0x1.b8d22ep9f * v;
        v = x[18]; u1 += 0x1.8bab8ep11f * v; u3 += -0x1.699be2p11f * v;
        v = x[19]; u1 += 0x1.ba25f6p9f * v; u3 += 0x1.37714cp10f * v;
        v = x[22]; u1 += 0x1.4287e0p9f * v; u3 += -0x1.930790p9f * v;
        v = x[23]; u1 += -0x1.5809b4p6f * v; u3 += -0x1.1466c8p7f * v;
        v = x[26]; u1 += -0x1.342518p8f * v; u3 += -0x1.83167ap5f * v;
        v = x[27]; u1 += 0x1.5fa880p-2f * v; u3 += -0x1.96d37cp4f * v;
        v = x[30]; u1 += 0x1.eba2acp6f * v; u3 += -0x1.ff8ea2p8f * v;
        v = x[31]; u1 += -0x1.e61b98p9f * v; u3 += -0x1.355bd0p6f * v;
        v = x[34]; u1 += 0x1.084f16p8f * v; u3 += -0x1.39aa02p7f * v;
        v = x[35]; u1 += -0x1.2d2cb4p7f * v; u3 += 0x1.048caap7f * v;
        v = x[37]; u1 += -0x1.da9aa8p4f * v; u3 += 0x1.7a4820p5f * v;
        v = y1; u1 += -0x1.c04aa8p19f * v; u3 += 0x1.9d0548p19f * v;
        v = y3; u1 += 0x1.37e2a8p17f * v; u3 += -0x1.4ffd54p18f * v;
        u[1] = u1;
        u[3] = u3;
    }

}

/* Called when an output is beyond its limit or NaN: restarts from zero states if no plausible state gives such an output,
 * then limits. */
static void paper_tool_f32_limit(paper_tool_f32 *c, float *u)
{
    int i, plausible = 1;
    for (i = 0; i < 4; ++i) {
        plausible = plausible && u[i] <= paper_tool_f32_output_guard && u[i] >= -paper_tool_f32_output_guard;
    }
    if (!plausible) {
        for (i = 0; i < 38; ++i) {
            c->state[i] = 0.0f;
        }
        if ((c->status >> 16) < 65535u) {
            c->status += (uint32_t)65536u;
        }
        paper_tool_f32_sums(c, u);
    }
    for (i = 0; i < 4; ++i) {
        const float wanted = u[i] == u[i] ? u[i] : 0.0f;
        u[i] = paper_tool_f32_clamp(wanted, paper_tool_f32_output_limit);
        c->excess_a[i] = u[i] - wanted;
    }
    c->limited = 1;
}

void paper_tool_f32_init(paper_tool_f32 *c)
{
    int i;
    for (i = 0; i < 38; ++i) {
        c->state[i] = 0.0f;
    }
    for (i = 0; i < 4; ++i) {
        c->y_m[i] = 0.0f;
    }
    for (i = 0; i < 4; ++i) {
        c->excess_a[i] = 0.0f;
    }
    c->limited = 0;
    c->status = 0;
}

void paper_tool_f32_output(paper_tool_f32 *c, const float y_m[4], float u_a[4])
{
    int i, within = 1;
    c->limited = 0;
    paper_tool_f32_hold(c, y_m);
    paper_tool_f32_sums(c, u_a);
    for (i = 0; i < 4; ++i) {
        within = within && u_a[i] <= paper_tool_f32_output_limit && u_a[i] >= -paper_tool_f32_output_limit;
    }
    if (!within) {
        paper_tool_f32_limit(c, u_a);
    }
}

void paper_tool_f32_update(paper_tool_f32 *c)
{
    float *x = c->state;
    const float *y = c->y_m;
    const float y0 = y[0];
    const float y1 = y[1];
    const float y2 = y[2];
    const float y3 = y[3];
    {
        const float x0 = x[0];
        x[0] = -0x1.588dcap-10f * x0 + 0x1.6a2a0ap7f * y0 - 0x1.a830c0p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.5c6f2ap-9f * x1 - 0x1.11d3bep8f * y0 - 0x1.01577ap9f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.588dcap-10f * x2 + 0x1.6a2a0ap7f * y1 - 0x1.a830c0p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.5c6f2ap-9f * x3 - 0x1.11d3bep8f * y1 - 0x1.01577ap9f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.23f624p-4f * x4 + 0x1.3ee7b8p-2f * x5 - 0x1.17d4e8p5f * y0 + 0x1.1a0472p4f * y2
            + x4;
        x[5] = -0x1.3ee7b8p-2f * x4 - 0x1.23f624p-4f * x5 + 0x1.a3bbc4p5f * y0 - 0x1.79a974p2f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.23f624p-4f * x6 + 0x1.3ee7b8p-2f * x7 - 0x1.17d4e8p5f * y1 + 0x1.1a0472p4f * y3
            + x6;
        x[7] = -0x1.3ee7b8p-2f * x6 - 0x1.23f624p-4f * x7 + 0x1.a3bbc4p5f * y1 - 0x1.79a974p2f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.26cc6cp-3f * x8 + 0x1.dd77f0p-2f * x9 - 0x1.0bc21cp6f * y0 + 0x1.1f5f7ep5f * y2
            + x8;
        x[9] = -0x1.dd77f0p-2f * x8 - 0x1.26cc6cp-3f * x9 + 0x1.972e98p5f * y0 - 0x1.6e6d50p5f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.26cc6cp-3f * x10 + 0x1.dd77f0p-2f * x11 - 0x1.0bc21cp6f * y1 + 0x1.1f5f7ep5f * y3
            + x10;
        x[11] = -0x1.dd77f0p-2f * x10 - 0x1.26cc6cp-3f * x11 + 0x1.972e98p5f * y1 - 0x1.6e6d50p5f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.72d5d6p-1f * x12 + 0x1.06df92p-1f * x13 - 0x1.ef5968p7f * y0 + 0x1.46db76p5f * y2;
        x[13] = -0x1.06df92p-1f * x12 + 0x1.72d5d6p-1f * x13 + 0x1.2cd884p8f * y0 + 0x1.b4811cp6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.72d5d6p-1f * x14 + 0x1.06df92p-1f * x15 - 0x1.ef5968p7f * y1 + 0x1.46db76p5f * y3;
        x[15] = -0x1.06df92p-1f * x14 + 0x1.72d5d6p-1f * x15 + 0x1.2cd884p8f * y1 + 0x1.b4811cp6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.29bff4p-1f * x16 + 0x1.7b1bd6p-1f * x17 + 0x1.6a4660p5f * y0 + 0x1.801ffcp4f * y2;
        x[17] = -0x1.7b1bd6p-1f * x16 + 0x1.29bff4p-1f * x17 + 0x1.da6756p6f * y0 - 0x1.71f9b2p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.29bff4p-1f * x18 + 0x1.7b1bd6p-1f * x19 + 0x1.6a4660p5f * y1 + 0x1.801ffcp4f * y3;
        x[19] = -0x1.7b1bd6p-1f * x18 + 0x1.29bff4p-1f * x19 + 0x1.da6756p6f * y1 - 0x1.71f9b2p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.673b6cp-2f * x20 + 0x1.873b68p-1f * x21 + 0x1.04305ep0f * y0 - 0x1.974c4ep9f * y2;
        x[21] = -0x1.873b68p-1f * x20 + 0x1.673b6cp-2f * x21 + 0x1.3e3386p4f * y0 + 0x1.756888p7f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.673b6cp-2f * x22 + 0x1.873b68p-1f * x23 + 0x1.04305ep0f * y1 - 0x1.974c4ep9f * y3;
        x[23] = -0x1.873b68p-1f * x22 + 0x1.673b6cp-2f * x23 + 0x1.3e3386p4f * y1 + 0x1.756888p7f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.8af45cp-3f * x24 + 0x1.3b1cd0p-2f * x25 - 0x1.a3103cp9f * y0 - 0x1.c0733ap7f * y2;
        x[25] = -0x1.3b1cd0p0f * x24 + 0x1.8af45cp-3f * x25 + 0x1.8ba09cp9f * y0 + 0x1.0e9834p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.8af45cp-3f * x26 + 0x1.3b1cd0p-2f * x27 - 0x1.a3103cp9f * y1 - 0x1.c0733ap7f * y3;
        x[27] = -0x1.3b1cd0p0f * x26 + 0x1.8af45cp-3f * x27 + 0x1.8ba09cp9f * y1 + 0x1.0e9834p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.def766p-4f * x28 + 0x1.d12706p-1f * x29 + 0x1.527b16p6f * y0 + 0x1.d53dbcp6f * y2;
        x[29] = -0x1.d12706p-1f * x28 + 0x1.def766p-4f * x29 + 0x1.2e8d9ap3f * y0 + 0x1.2d24c4p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.def766p-4f * x30 + 0x1.d12706p-1f * x31 + 0x1.527b16p6f * y1 + 0x1.d53dbcp6f * y3;
        x[31] = -0x1.d12706p-1f * x30 + 0x1.def766p-4f * x31 + 0x1.2e8d9ap3f * y1 + 0x1.2d24c4p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.84a4c8p-3f * x32 + 0x1.247886p-3f * x33 - 0x1.7a1116p8f * y0 + 0x1.591e96p10f * y2;
        x[33] = -0x1.247886p-1f * x32 - 0x1.84a4c8p-3f * x33 + 0x1.3b266ap9f * y0 - 0x1.05c548p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.84a4c8p-3f * x34 + 0x1.247886p-3f * x35 - 0x1.7a1116p8f * y1 + 0x1.591e96p10f * y3;
        x[35] = -0x1.247886p-1f * x34 - 0x1.84a4c8p-3f * x35 + 0x1.3b266ap9f * y1 - 0x1.05c548p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.feb0f0p-1f * x36 + 0x1.8d312ep1f * y0 - 0x1.14d2c0p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.feb0f0p-1f * x37 + 0x1.8d312ep1f * y1 - 0x1.14d2c0p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += -0x1.dbdfaap-5f * e[0];
        x[0] += 0x1.34a5d2p-5f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.cf4522p-5f * e[0];
        x[1] += -0x1.69caaap-6f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.dbdfaap-5f * e[1];
        x[2] += 0x1.34a5d2p-5f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.cf4522p-5f * e[1];
        x[3] += -0x1.69caaap-6f * e[3];
        x[3] = paper_tool_f32_clamp(x[3], 1.0f);
    }
    x[0] = paper_tool_f32_clamp(x[0], 1.0f);
    x[1] = paper_tool_f32_clamp(x[1], 1.0f);
    x[2] = paper_tool_f32_clamp(x[2], 1.0f);
    x[3] = paper_tool_f32_clamp(x[3], 1.0f);

}

void paper_tool_f32_step(paper_tool_f32 *c, const float y_m[4], float u_a[4])
{
    paper_tool_f32_output(c, y_m, u_a);
    paper_tool_f32_update(c);
}

void paper_tool_f32_hand_over(paper_tool_f32 *c, const float y_m[4], const float u_a[4])
{
    static const float map[38][8] = {
        {-0x1.8e0f1ep17f, 0.0f, 0x1.f18beep15f, 0.0f, -0x1.415016p0f, 0.0f, 0x1.354b02p-1f, 0.0f},
        {0x1.554db8p17f, 0.0f, -0x1.af96e8p14f, 0.0f, 0x1.46ade0p0f, 0.0f, -0x1.1b711ap-2f, 0.0f},
        {0.0f, -0x1.8e0f1ep17f, 0.0f, 0x1.f18beep15f, 0.0f, -0x1.415016p0f, 0.0f, 0x1.354b02p-1f},
        {0.0f, 0x1.554db8p17f, 0.0f, -0x1.af96e8p14f, 0.0f, 0x1.46ade0p0f, 0.0f, -0x1.1b711ap-2f},
        {0x1.100364p7f, 0.0f, -0x1.43504ep2f, 0.0f, 0x1.7b027ep-20f, 0.0f, -0x1.3389c6p-23f, 0.0f},
        {0x1.1db7d2p7f, 0.0f, -0x1.ceece8p5f, 0.0f, -0x1.d27f68p-19f, 0.0f, 0x1.26a2a6p-20f, 0.0f},
        {0.0f, 0x1.100364p7f, 0.0f, -0x1.43504ep2f, 0.0f, 0x1.7b027ep-20f, 0.0f, -0x1.3389c6p-23f},
        {0.0f, 0x1.1db7d2p7f, 0.0f, -0x1.ceece8p5f, 0.0f, -0x1.d27f68p-19f, 0.0f, 0x1.26a2a6p-20f},
        {0x1.dc6596p5f, 0.0f, -0x1.0f9056p6f, 0.0f, 0x1.2ffc82p-19f, 0.0f, -0x1.6771d4p-21f, 0.0f},
        {0x1.4640f6p7f, 0.0f, -0x1.87742cp6f, 0.0f, 0x1.1cef22p-17f, 0.0f, -0x1.59ede2p-19f, 0.0f},
        {0.0f, 0x1.dc6596p5f, 0.0f, -0x1.0f9056p6f, 0.0f, 0x1.2ffc82p-19f, 0.0f, -0x1.6771d4p-21f},
        {0.0f, 0x1.4640f6p7f, 0.0f, -0x1.87742cp6f, 0.0f, 0x1.1cef22p-17f, 0.0f, -0x1.59ede2p-19f},
        {0x1.fa0cdcp7f, 0.0f, 0x1.8abe74p7f, 0.0f, -0x1.ecd418p-19f, 0.0f, 0x1.a917bap-21f, 0.0f},
        {0x1.37ab9ap9f, 0.0f, 0x1.b39eb0p4f, 0.0f, 0x1.04c002p-15f, 0.0f, -0x1.3f467ep-17f, 0.0f},
        {0.0f, 0x1.fa0cdcp7f, 0.0f, 0x1.8abe74p7f, 0.0f, -0x1.ecd418p-19f, 0.0f, 0x1.a917bap-21f},
        {0.0f, 0x1.37ab9ap9f, 0.0f, 0x1.b39eb0p4f, 0.0f, 0x1.04c002p-15f, 0.0f, -0x1.3f467ep-17f},
        {0x1.2659cap7f, 0.0f, -0x1.5ef936p7f, 0.0f, -0x1.7b21c8p-19f, 0.0f, 0x1.d48deep-21f, 0.0f},
        {0x1.690874p4f, 0.0f, -0x1.070510p7f, 0.0f, 0x1.095628p-19f, 0.0f, -0x1.38247ep-21f, 0.0f},
        {0.0f, 0x1.2659cap7f, 0.0f, -0x1.5ef936p7f, 0.0f, -0x1.7b21c8p-19f, 0.0f, 0x1.d48deep-21f},
        {0.0f, 0x1.690874p4f, 0.0f, -0x1.070510p7f, 0.0f, 0x1.095628p-19f, 0.0f, -0x1.38247ep-21f},
        {0x1.d66716p3f, 0.0f, -0x1.7f99c8p8f, 0.0f, -0x1.0cbb98p-17f, 0.0f, 0x1.6f563ep-19f, 0.0f},
        {0x1.038b90p4f, 0.0f, 0x1.7255a0p9f, 0.0f, 0x1.bf5522p-16f, 0.0f, -0x1.0885fap-17f, 0.0f},
        {0.0f, 0x1.d66716p3f, 0.0f, -0x1.7f99c8p8f, 0.0f, -0x1.0cbb98p-17f, 0.0f, 0x1.6f563ep-19f},
        {0.0f, 0x1.038b90p4f, 0.0f, 0x1.7255a0p9f, 0.0f, 0x1.bf5522p-16f, 0.0f, -0x1.0885fap-17f},
        {-0x1.bb8a2ap8f, -0.0f, -0x1.08ff7ap7f, 0.0f, -0x1.527196p-13f, -0.0f, 0x1.b13b42p-15f, 0.0f},
        {0x1.85ed4ap10f, 0.0f, 0x1.731caap8f, 0.0f, -0x1.afea64p-12f, 0.0f, 0x1.0aee0cp-13f, 0.0f},
        {0.0f, -0x1.bb8a2ap8f, 0.0f, -0x1.08ff7ap7f, 0.0f, -0x1.527196p-13f, 0.0f, 0x1.b13b42p-15f},
        {0.0f, 0x1.85ed4ap10f, 0.0f, 0x1.731caap8f, 0.0f, -0x1.afea64p-12f, 0.0f, 0x1.0aee0cp-13f},
        {0x1.a0a792p5f, 0.0f, 0x1.2bce4ep7f, 0.0f, 0x1.096c30p-20f, 0.0f, -0x1.0387d0p-22f, 0.0f},
        {-0x1.4fcbe8p5f, 0.0f, 0x1.047e56p4f, 0.0f, 0x1.55610ep-18f, 0.0f, -0x1.bde3dap-20f, 0.0f},
        {0.0f, 0x1.a0a792p5f, 0.0f, 0x1.2bce4ep7f, 0.0f, 0x1.096c30p-20f, 0.0f, -0x1.0387d0p-22f},
        {0.0f, -0x1.4fcbe8p5f, 0.0f, 0x1.047e56p4f, 0.0f, 0x1.55610ep-18f, 0.0f, -0x1.bde3dap-20f},
        {-0x1.89e848p7f, 0.0f, 0x1.f60a5cp9f, 0.0f, 0x1.28d4c2p-12f, 0.0f, -0x1.654456p-14f, 0.0f},
        {0x1.389b80p9f, 0.0f, -0x1.546a32p10f, 0.0f, -0x1.12032ap-13f, 0.0f, 0x1.4b30b0p-15f, 0.0f},
        {0.0f, -0x1.89e848p7f, 0.0f, 0x1.f60a5cp9f, 0.0f, 0x1.28d4c2p-12f, 0.0f, -0x1.654456p-14f},
        {0.0f, 0x1.389b80p9f, 0.0f, -0x1.546a32p10f, -0.0f, -0x1.12032ap-13f, 0.0f, 0x1.4b30b0p-15f},
        {0x1.713d14p0f, 0.0f, -0x1.181788p1f, 0.0f, -0x1.80c0a4p-21f, -0.0f, 0x1.ca477ep-23f, 0.0f},
        {0.0f, 0x1.713d14p0f, 0.0f, -0x1.181788p1f, 0.0f, -0x1.80c0a4p-21f, 0.0f, 0x1.ca477ep-23f},
    };
    int i, j;
    paper_tool_f32_hold(c, y_m);
    for (i = 0; i < 38; ++i) {
        float sum = 0.0f;
        for (j = 0; j < 4; ++j) {
            sum += map[i][j] * c->y_m[j];
        }
        for (j = 0; j < 4; ++j) {
            sum += map[i][4 + j] * (u_a[j] == u_a[j] ? paper_tool_f32_clamp(u_a[j], paper_tool_f32_output_limit) : 0.0f);
        }
        c->state[i] = sum;
    }
}

const float *paper_tool_f32_state(const paper_tool_f32 *c)
{
    return c->state;
}

uint32_t paper_tool_f32_bad_samples(const paper_tool_f32 *c)
{
    return c->status & 65535u;
}

uint32_t paper_tool_f32_restarts(const paper_tool_f32 *c)
{
    return c->status >> 16;
}
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
#endif

#ifndef MUSPIN_NO_Q31
/* Over the test vectors Q31 stays within 3.586e-4 A of exact arithmetic (bound from rounding and coefficients). */

/* Right shifts of negative numbers must be arithmetic, as on every usual target. */
typedef char paper_tool_arithmetic_shift[((-1) >> 1) == -1 ? 1 : -1];

static int32_t paper_tool_q31_saturate(int64_t value)
{
    if (value > INT32_MAX) {
        return INT32_MAX;
    }
    return value < -INT32_MAX ? -INT32_MAX : (int32_t)value;
}

static int32_t paper_tool_q31_round(int64_t sum, int shift)
{
    return paper_tool_q31_saturate((sum + ((int64_t)1 << (shift - 1))) >> shift);
}
/* A current, with what its limit takes away. */
static int32_t paper_tool_q31_current(paper_tool_q31 *c, int i, int64_t sum, int shift)
{
    const int64_t wanted = (sum + ((int64_t)1 << (shift - 1))) >> shift;
    const int32_t current = paper_tool_q31_saturate(wanted);
    c->excess[i] = 0;
    if (current != wanted) {
        c->excess[i] = paper_tool_q31_saturate((current - wanted + (((int64_t)1 << 12) >> 1)) >> 12);
        c->limited = 1;
    }
    return current;
}

static int32_t paper_tool_q31_correct(int32_t state, int64_t sum, int shift)
{
    return paper_tool_q31_saturate(state + ((sum + ((int64_t)1 << (shift - 1))) >> shift));
}

void paper_tool_q31_init(paper_tool_q31 *c)
{
    int i;
    for (i = 0; i < 38; ++i) {
        c->state[i] = 0;
    }
    for (i = 0; i < 4; ++i) {
        c->y[i] = 0;
    }
    for (i = 0; i < 4; ++i) {
        c->excess[i] = 0;
    }
    c->limited = 0;
}

void paper_tool_q31_output(paper_tool_q31 *c, const int32_t y_in[4], int32_t u[4])
{
    int32_t *y = c->y;
    const int32_t *x = c->state;
    int i;
    for (i = 0; i < 4; ++i) {
        y[i] = y_in[i] < -INT32_MAX ? -INT32_MAX : y_in[i];
    }
    c->limited = 0;
    {
    const int32_t y0 = y[0];
    const int32_t y1 = y[1];
    const int32_t y2 = y[2];
    const int32_t y3 = y[3];
    {
        int32_t v = x[0];
        int64_t u0 = 119984 * (int64_t)v, u2 = 524288 * (int64_t)v;
        v = x[1]; u0 += 239116 * (int64_t)v; u2 += 524288 * (int64_t)v;
        v = x[4]; u0 += -122370484 * (int64_t)v; u2 += -133729607 * (int64_t)v;
        v = x[5]; u0 += 41620786 * (int64_t)v; u2 += 143372703 * (int64_t)v;
        v = x[8]; u0 += 94204011 * (int64_t)v; u2 += -330171458 * (int64_t)v;
        v = x[9]; u0 += -105672714 * (int64_t)v; u2 += 108581623 * (int64_t)v;
        v = x[12]; u0 += 255887174 * (int64_t)v; u2 += 89670306 * (int64_t)v;
        v = x[13]; u0 += 12370676 * (int64_t)v; u2 += -154078109 * (int64_t)v;
        v = x[16]; u0 += 553186939 * (int64_t)v; u2 += -505565924 * (int64_t)v;
        v = x[17]; u0 += 154542022 * (int64_t)v; u2 += 217714138 * (int64_t)v;
        v = x[20]; u0 += 112732676 * (int64_t)v; u2 += -140869038 * (int64_t)v;
        v = x[21]; u0 += -15031245 * (int64_t)v; u2 += -24152330 * (int64_t)v;
        v = x[24]; u0 += -53852223 * (int64_t)v; u2 += -8456062 * (int64_t)v;
        v = x[25]; u0 += 60016 * (int64_t)v; u2 += -4443626 * (int64_t)v;
        v = x[28]; u0 += 21479880 * (int64_t)v; u2 += -89401093 * (int64_t)v;
        v = x[29]; u0 += -169906985 * (int64_t)v; u2 += -13516085 * (int64_t)v;
        v = x[32]; u0 += 46191332 * (int64_t)v; u2 += -27408386 * (int64_t)v;
        v = x[33]; u0 += -26317040 * (int64_t)v; u2 += 22767161 * (int64_t)v;
        v = x[36]; u0 += -5183943 * (int64_t)v; u2 += 8263690 * (int64_t)v;
        v = y0; u0 += -40754256 * (int64_t)v; u2 += 37547764 * (int64_t)v;
        v = y2; u0 += 7088386 * (int64_t)v; u2 += -15272429 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 19);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 119984 * (int64_t)v, u3 = 524288 * (int64_t)v;
        v = x[3]; u1 += 239116 * (int64_t)v; u3 += 524288 * (int64_t)v;
        v = x[6]; u1 += -122370484 * (int64_t)v; u3 += -133729607 * (int64_t)v;
        v = x[7]; u1 += 41620786 * (int64_t)v; u3 += 143372703 * (int64_t)v;
        v = x[10]; u1 += 94204011 * (int64_t)v; u3 += -330171458 * (int64_t)v;
        v = x[11]; u1 += -105672714 * (int64_t)v; u3 += 108581623 * (int64_t)v;
        v = x[14]; u1 += 255887174 * (int64_t)v; u3 += 89670306 * (int64_t)v;
        v = x[15]; u1 += 12370676 * (int64_t)v; u3 += -154078109 * (int64_t)v;
        v = x[18]; u1 += 553186939 * (int64_t)v; u3 += -505565924 * (int64_t)v;
        v = x[19]; u1 += 154542022 * (int64_t)v; u3 += 217714138 * (int64_t)v;
        v = x[22]; u1 += 112732676 * (int64_t)v; u3 += -140869038 * (int64_t)v;
        v = x[23]; u1 += -15031245 * (int64_t)v; u3 += -24152330 * (int64_t)v;
        v = x[26]; u1 += -53852223 * (int64_t)v; u3 += -8456062 * (int64_t)v;
        v = x[27]; u1 += 60016 * (int64_t)v; u3 += -4443626 * (int64_t)v;
        v = x[30]; u1 += 21479880 * (int64_t)v; u3 += -89401093 * (int64_t)v;
        v = x[31]; u1 += -169906985 * (int64_t)v; u3 += -13516085 * (int64_t)v;
        v = x[34]; u1 += 46191332 * (int64_t)v; u3 += -27408386 * (int64_t)v;
        v = x[35]; u1 += -26317040 * (int64_t)v; u3 += 22767161 * (int64_t)v;
        v = x[37]; u1 += -5183943 * (int64_t)v; u3 += 8263690 * (int64_t)v;
        v = y1; u1 += -40754256 * (int64_t)v; u3 += 37547764 * (int64_t)v;
        v = y3; u1 += 7088386 * (int64_t)v; u3 += -15272429 * (int64_t)v;
        u[1] = paper_tool_q31_current(c, 1, u1, 19);
        u[3] = paper_tool_q31_current(c, 3, u3, 19);
    }

    }
}

void paper_tool_q31_update(paper_tool_q31 *c)
{
    int32_t *x = c->state;
    const int32_t *y = c->y;
    const int32_t y0 = y[0];
    const int32_t y1 = y[1];
    const int32_t y2 = y[2];
    const int32_t y3 = y[3];
    {
        const int32_t x0 = x[0];
        x[0] = paper_tool_q31_round(-1411293 * (int64_t)x0 + 49386598 * (int64_t)y0 - 28922409 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2854373 * (int64_t)x1 - 74680984 * (int64_t)y0 - 140369818 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1411293 * (int64_t)x2 + 49386598 * (int64_t)y1 - 28922409 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2854373 * (int64_t)x3 - 74680984 * (int64_t)y1 - 140369818 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-76535954 * (int64_t)x4 + 334396275 * (int64_t)x5 - 9539826 * (int64_t)y0 + 4807170 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-334396275 * (int64_t)x4 - 76535954 * (int64_t)x5 + 14309261 * (int64_t)y0 - 1609373 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-76535954 * (int64_t)x6 + 334396275 * (int64_t)x7 - 9539826 * (int64_t)y1 + 4807170 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-334396275 * (int64_t)x6 - 76535954 * (int64_t)x7 + 14309261 * (int64_t)y1 - 1609373 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-154559323 * (int64_t)x8 + 500662001 * (int64_t)x9 - 18256454 * (int64_t)y0 + 9796921 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-500662001 * (int64_t)x8 - 154559323 * (int64_t)x9 + 13881366 * (int64_t)y0 - 12491974 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-154559323 * (int64_t)x10 + 500662001 * (int64_t)x11 - 18256454 * (int64_t)y1 + 9796921 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-500662001 * (int64_t)x10 - 154559323 * (int64_t)x11 + 13881366 * (int64_t)y1 - 12491974 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(777697991 * (int64_t)x12 + 551285311 * (int64_t)x13 - 67548406 * (int64_t)y0 + 11142991 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-551285311 * (int64_t)x12 + 777697991 * (int64_t)x13 + 82049792 * (int64_t)y0 + 29762003 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(777697991 * (int64_t)x14 + 551285311 * (int64_t)x15 - 67548406 * (int64_t)y1 + 11142991 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-551285311 * (int64_t)x14 + 777697991 * (int64_t)x15 + 82049792 * (int64_t)y1 + 29762003 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(624426594 * (int64_t)x16 + 795048654 * (int64_t)x17 + 12350423 * (int64_t)y0 + 6547660 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-795048654 * (int64_t)x16 + 624426594 * (int64_t)x17 + 32346077 * (int64_t)y0 - 50451769 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(624426594 * (int64_t)x18 + 795048654 * (int64_t)x19 + 12350423 * (int64_t)y1 + 6547660 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-795048654 * (int64_t)x18 + 624426594 * (int64_t)x19 + 32346077 * (int64_t)y1 - 50451769 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(376682190 * (int64_t)x20 + 820473068 * (int64_t)x21 + 277193 * (int64_t)y0 - 222165147 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-820473068 * (int64_t)x20 + 376682190 * (int64_t)x21 + 5423948 * (int64_t)y0 + 50919904 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(376682190 * (int64_t)x22 + 820473068 * (int64_t)x23 + 277193 * (int64_t)y1 - 222165147 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-820473068 * (int64_t)x22 + 376682190 * (int64_t)x23 + 5423948 * (int64_t)y1 + 50919904 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(414139829 * (int64_t)x24 + 660838882 * (int64_t)x25 - 457165363 * (int64_t)y0 - 122305983 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-1321677764 * (int64_t)x24 + 207069914 * (int64_t)x25 + 215799245 * (int64_t)y0 + 36899684 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(414139829 * (int64_t)x26 + 660838882 * (int64_t)x27 - 457165363 * (int64_t)y1 - 122305983 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-1321677764 * (int64_t)x26 + 207069914 * (int64_t)x27 + 215799245 * (int64_t)y1 + 36899684 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(125558166 * (int64_t)x28 + 975495390 * (int64_t)x29 + 23078504 * (int64_t)y0 + 31994085 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-975495390 * (int64_t)x28 + 125558166 * (int64_t)x29 + 2578608 * (int64_t)y0 + 41065512 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(125558166 * (int64_t)x30 + 975495390 * (int64_t)x31 + 23078504 * (int64_t)y1 + 31994085 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-975495390 * (int64_t)x30 + 125558166 * (int64_t)x31 + 2578608 * (int64_t)y1 + 41065512 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-407522446 * (int64_t)x32 + 306677863 * (int64_t)x33 - 206220597 * (int64_t)y0 + 752996677 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-613355727 * (int64_t)x32 - 203761223 * (int64_t)x33 + 171902021 * (int64_t)y0 - 285571273 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-407522446 * (int64_t)x34 + 306677863 * (int64_t)x35 - 206220597 * (int64_t)y1 + 752996677 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-613355727 * (int64_t)x34 - 203761223 * (int64_t)x35 + 171902021 * (int64_t)y1 - 285571273 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2141993948 * (int64_t)x36 + 1692600 * (int64_t)y0 - 2359316 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2141993948 * (int64_t)x37 + 1692600 * (int64_t)y1 - 2359316 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], -748484571 * (int64_t)e[0] + 485460921 * (int64_t)e[2], 20);
        x[1] = paper_tool_q31_correct(x[1], 1457321527 * (int64_t)e[0] - 569049082 * (int64_t)e[2], 21);
        x[2] = paper_tool_q31_correct(x[2], -748484571 * (int64_t)e[1] + 485460921 * (int64_t)e[3], 20);
        x[3] = paper_tool_q31_correct(x[3], 1457321527 * (int64_t)e[1] - 569049082 * (int64_t)e[3], 21);
    }
}

void paper_tool_q31_step(paper_tool_q31 *c, const int32_t y[4], int32_t u[4])
{
    paper_tool_q31_output(c, y, u);
    paper_tool_q31_update(c);
}

void paper_tool_q31_hand_over(paper_tool_q31 *c, const int32_t y[4], const int32_t u[4])
{
    static const int32_t map[38][8] = {
        {-868502512, 0, 271392183, 0, -63172672, 0, 30404739, 0},
        {1489341992, 0, -235415161, 0, 128455486, 0, -27863464, 0},
        {0, -868502512, 0, 271392183, 0, -63172672, 0, 30404739},
        {0, 1489341992, 0, -235415161, 0, 128455486, 0, -27863464},
        {1186980599, 0, -44088738, 0, 145540, 0, -14762, 0},
        {1246784025, 0, -505015363, 0, -358270, 0, 113140, 0},
        {0, 1186980599, 0, -44088738, 0, 145540, 0, -14762},
        {0, 1246784025, 0, -505015363, 0, -358270, 0, 113140},
        {519711628, 0, -592509681, 0, 233462, 0, -69013, 0},
        {711834622, 0, -427045451, 0, 437659, 0, -132837, 0},
        {0, 519711628, 0, -592509681, 0, 233462, 0, -69013},
        {0, 711834622, 0, -427045451, 0, 437659, 0, -132837},
        {1104122350, 0, 861269518, 0, -189246, 0, 40809, 0},
        {1360031631, 0, 59403398, 0, 801024, 0, -245203, 0},
        {0, 1104122350, 0, 861269518, 0, -189246, 0, 40809},
        {0, 1360031631, 0, 59403398, 0, 801024, 0, -245203},
        {642227211, 0, -765769155, 0, -145587, 0, 44981, 0},
        {196929383, 0, -1147735975, 0, 203778, 0, -59931, 0},
        {0, 642227211, 0, -765769155, 0, -145587, 0, 44981},
        {0, 196929383, 0, -1147735975, 0, 203778, 0, -59931},
        {64146560, 0, -1673913291, 0, -412774, 0, 141057, 0},
        {35392932, 0, 1616023613, 0, 687103, 0, -203154, 0},
        {0, 64146560, 0, -1673913291, 0, -412774, 0, 141057},
        {0, 35392932, 0, 1616023613, 0, 687103, 0, -203154},
        {-967734150, 0, -289092007, 0, -4158796, 0, 1330887, 0},
        {1701518942, 0, 404854087, 0, -5307379, 0, 1640017, 0},
        {0, -967734150, 0, -289092007, 0, -4158796, 0, 1330887},
        {0, 1701518942, 0, 404854087, 0, -5307379, 0, 1640017},
        {454537513, 0, 1308258989, 0, 101922, 0, -24915, 0},
        {-1465310837, 0, 568356006, 0, 2097433, 0, -684887, 0},
        {0, 454537513, 0, 1308258989, 0, 101922, 0, -24915},
        {0, -1465310837, 0, 568356006, 0, 2097433, 0, -684887},
        {-214861031, 0, 1095373649, 0, 3647461, 0, -1097524, 0},
        {341030202, 0, -742731815, 0, -841766, 0, 254354, 0},
        {0, -214861031, 0, 1095373649, 0, 3647461, 0, -1097524},
        {0, 341030202, 0, -742731815, 0, -841766, 0, 254354},
        {805620786, 0, -1222233387, 0, -4727839, 0, 1407834, 0},
        {0, 805620786, 0, -1222233387, 0, -4727839, 0, 1407834},
    };
    static const int16_t shift[38] = {
        24, 25, 24, 25, 35, 35, 35, 35, 35, 34, 35, 34, 34, 33, 34, 33, 34, 35, 34, 35, 34, 33, 34, 33, 33, 32, 33, 32, 35, 37, 35, 37, 32, 31, 32, 31, 41, 41};
    int i, j;
    for (i = 0; i < 38; ++i) {
        int64_t sum = 0;
        for (j = 0; j < 4; ++j) {
            sum += (int64_t)map[i][j] * paper_tool_q31_saturate(y[j]);
        }
        for (j = 0; j < 4; ++j) {
            sum += (int64_t)map[i][4 + j] * paper_tool_q31_saturate(u[j]);
        }
        c->state[i] = paper_tool_q31_round(sum, shift[i]);
    }
}

const int32_t *paper_tool_q31_state(const paper_tool_q31 *c)
{
    return c->state;
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
    paper_tool_f32 f;
    paper_tool_q31 q;
    long samples = 0, wrong_f32 = 0, wrong_q31 = 0;
    if (!file || !fgets(line, sizeof line, file)) {
        fprintf(stderr, "cannot read the test vectors\n");
        return 2;
    }
    paper_tool_f32_init(&f);
    paper_tool_q31_init(&q);
    while (fgets(line, sizeof line, file)) {
        float y[4] = {0}, u[4], expected[4] = {0};
        int32_t yq[4] = {0}, uq[4];
        char *at = strchr(line, ',');
        int i;
        for (i = 0; i < 4 && at; ++i) {
            y[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < 4 && at; ++i) {
            expected[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < 4 && at; ++i) {
            yq[i] = (int32_t)strtol(at + 1, &at, 10);
        }
        if (!at) {
            fprintf(stderr, "sample %ld: a column is missing\n", samples);
            return 2;
        }
        paper_tool_f32_step(&f, y, u);
        paper_tool_q31_step(&q, yq, uq);
        for (i = 0; i < 4; ++i) {
            wrong_f32 += memcmp(&u[i], &expected[i], sizeof u[i]) != 0;
            wrong_q31 += uq[i] != (int32_t)strtol(at + 1, &at, 10);
        }
        ++samples;
    }
    fclose(file);
    printf("%ld samples, float32 mismatches %ld, Q31 mismatches %ld\n", samples, wrong_f32, wrong_q31);
    return samples == 0 || wrong_f32 || wrong_q31;
}
#endif
