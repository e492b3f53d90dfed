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
static const float paper_tool_f32_output_guard = 0x1.73394ap23f;

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
        float u0 = 0x1.5f8494p-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.5e447ep0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.5e1abcp9f * v; u2 += -0x1.7e9ad8p9f * v;
        v = x[5]; u0 += 0x1.dc5202p7f * v; u2 += 0x1.9a319ep9f * v;
        v = x[8]; u0 += 0x1.0d851ap9f * v; u2 += -0x1.d850d4p10f * v;
        v = x[9]; u0 += -0x1.2e54d0p9f * v; u2 += 0x1.36a7b6p9f * v;
        v = x[12]; u0 += 0x1.6e0cfep10f * v; u2 += 0x1.008db8p9f * v;
        v = x[13]; u0 += 0x1.1b2a12p6f * v; u2 += -0x1.b8d332p9f * v;
        v = x[16]; u0 += 0x1.8babdap11f * v; u2 += -0x1.699c08p11f * v;
        v = x[17]; u0 += 0x1.ba264cp9f * v; u2 += 0x1.377064p10f * v;
        v = x[20]; u0 += 0x1.4287f0p9f * v; u2 += -0x1.9307a0p9f * v;
        v = x[21]; u0 += -0x1.580c0cp6f * v; u2 += -0x1.146678p7f * v;
        v = x[24]; u0 += -0x1.342518p8f * v; u2 += -0x1.8316eep5f * v;
        v = x[25]; u0 += 0x1.5fddd4p-2f * v; u2 += -0x1.96d140p4f * v;
        v = x[28]; u0 += 0x1.eba28cp6f * v; u2 += -0x1.ff8e68p8f * v;
        v = x[29]; u0 += -0x1.e61bbep9f * v; u2 += -0x1.355bc0p6f * v;
        v = x[32]; u0 += 0x1.084ef6p8f * v; u2 += -0x1.39aa96p7f * v;
        v = x[33]; u0 += -0x1.2d2cd0p7f * v; u2 += 0x1.048cecp7f * v;
        v = x[36]; u0 += -0x1.da9aa8p4f * v; u2 += 0x1.7a4820p5f * v;
        v = y0; u0 += -0x1.c04ac2p19f * v; u2 += 0x1.9d053cp19f * v;
        v = y2; u0 += 0x1.37e2c2p17f * v; u2 += -0x1.4ffd3cp18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.5f8494p-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.5e447ep0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.5e1abcp9f * v; u3 += -0x1.7e9ad8p9f * v;
        v = x[7]; u1 += 0x1.dc5202p7f * v; u3 += 0x1.9a319ep9f * v;
        v = x[10]; u1 += 0x1.0d851ap9f * v; u3 += -0x1.d850d4p10f * v;
        v = x[11]; u1 += -0x1.2e54d0p9f * v; u3 += 0x1.36a7b6p9f * v;
        v = x[14]; u1 += 0x1.6e0cfep10f * v; u3 += 0x1.008db8p9f * v;
        v = x[15]; u1 += 0x1.1b2a12p6f * v; u3 += -0x1.b8d332p9f * v;
        v = x[18]; u1 += 0x1.8babdap11f * v; u3 += -0x1.699c08p11f * v;
        v = x[19]; u1 += 0x1.ba264cp9f * v; u3 += 0x1.377064p10f * v;
        v = x[22]; u1 += 0x1.4287f0p9f * v; u3 += -0x1.9307a0p9f * v;
        v = x[23]; u1 += -0x1.580c0cp6f * v; u3 += -0x1.146678p7f * v;
        v = x[26]; u1 += -0x1.342518p8f * v; u3 += -0x1.8316eep5f * v;
        v = x[27]; u1 += 0x1.5fddd4p-2f * v; u3 += -0x1.96d140p4f * v;
        v = x[30]; u1 += 0x1.eba28cp6f * v; u3 += -0x1.ff8e68p8f * v;
        v = x[31]; u1 += -0x1.e61bbep9f * v; u3 += -0x1.355bc0p6f * v;
        v = x[34]; u1 += 0x1.084ef6p8f * v; u3 += -0x1.39aa96p7f * v;
        v = x[35]; u1 += -0x1.2d2cd0p7f * v; u3 += 0x1.048cecp7f * v;
        v = x[37]; u1 += -0x1.da9aa8p4f * v; u3 += 0x1.7a4820p5f * v;
        v = y1; u1 += -0x1.c04ac2p19f * v; u3 += 0x1.9d053cp19f * v;
        v = y3; u1 += 0x1.37e2c2p17f * v; u3 += -0x1.4ffd3cp18f * v;
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
        x[0] = -0x1.588d42p-10f * x0 + 0x1.6a29d6p7f * y0 - 0x1.a8304cp6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.5c6fcap-9f * x1 - 0x1.11d4dcp8f * y0 - 0x1.0157bcp9f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.588d42p-10f * x2 + 0x1.6a29d6p7f * y1 - 0x1.a8304cp6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.5c6fcap-9f * x3 - 0x1.11d4dcp8f * y1 - 0x1.0157bcp9f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.23f5f2p-4f * x4 + 0x1.3ee7b6p-2f * x5 - 0x1.17d536p5f * y0 + 0x1.1a049ap4f * y2
            + x4;
        x[5] = -0x1.3ee7b6p-2f * x4 - 0x1.23f5f2p-4f * x5 + 0x1.a3bc34p5f * y0 - 0x1.79ac60p2f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.23f5f2p-4f * x6 + 0x1.3ee7b6p-2f * x7 - 0x1.17d536p5f * y1 + 0x1.1a049ap4f * y3
            + x6;
        x[7] = -0x1.3ee7b6p-2f * x6 - 0x1.23f5f2p-4f * x7 + 0x1.a3bc34p5f * y1 - 0x1.79ac60p2f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.26cc68p-3f * x8 + 0x1.dd77f4p-2f * x9 - 0x1.0bc266p6f * y0 + 0x1.1f5f7cp5f * y2
            + x8;
        x[9] = -0x1.dd77f4p-2f * x8 - 0x1.26cc68p-3f * x9 + 0x1.972e5ap5f * y0 - 0x1.6e6cecp5f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.26cc68p-3f * x10 + 0x1.dd77f4p-2f * x11 - 0x1.0bc266p6f * y1 + 0x1.1f5f7cp5f * y3
            + x10;
        x[11] = -0x1.dd77f4p-2f * x10 - 0x1.26cc68p-3f * x11 + 0x1.972e5ap5f * y1 - 0x1.6e6cecp5f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.72d5dcp-1f * x12 + 0x1.06df9cp-1f * x13 - 0x1.ef59d4p7f * y0 + 0x1.46da6ap5f * y2;
        x[13] = -0x1.06df9cp-1f * x12 + 0x1.72d5dcp-1f * x13 + 0x1.2cd834p8f * y0 + 0x1.b48192p6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.72d5dcp-1f * x14 + 0x1.06df9cp-1f * x15 - 0x1.ef59d4p7f * y1 + 0x1.46da6ap5f * y3;
        x[15] = -0x1.06df9cp-1f * x14 + 0x1.72d5dcp-1f * x15 + 0x1.2cd834p8f * y1 + 0x1.b48192p6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.29bff0p-1f * x16 + 0x1.7b1bd4p-1f * x17 + 0x1.6a466ap5f * y0 + 0x1.80210ep4f * y2;
        x[17] = -0x1.7b1bd4p-1f * x16 + 0x1.29bff0p-1f * x17 + 0x1.da66fap6f * y0 - 0x1.71f99ep7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.29bff0p-1f * x18 + 0x1.7b1bd4p-1f * x19 + 0x1.6a466ap5f * y1 + 0x1.80210ep4f * y3;
        x[19] = -0x1.7b1bd4p-1f * x18 + 0x1.29bff0p-1f * x19 + 0x1.da66fap6f * y1 - 0x1.71f99ep7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.673b68p-2f * x20 + 0x1.873b64p-1f * x21 + 0x1.03e304p0f * y0 - 0x1.974c42p9f * y2;
        x[21] = -0x1.873b64p-1f * x20 + 0x1.673b68p-2f * x21 + 0x1.3e2c1cp4f * y0 + 0x1.756928p7f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.673b68p-2f * x22 + 0x1.873b64p-1f * x23 + 0x1.03e304p0f * y1 - 0x1.974c42p9f * y3;
        x[23] = -0x1.873b64p-1f * x22 + 0x1.673b68p-2f * x23 + 0x1.3e2c1cp4f * y1 + 0x1.756928p7f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.8af43cp-3f * x24 + 0x1.3b1cc6p-2f * x25 - 0x1.a3104cp9f * y0 - 0x1.c07300p7f * y2;
        x[25] = -0x1.3b1cc6p0f * x24 + 0x1.8af43cp-3f * x25 + 0x1.8ba028p9f * y0 + 0x1.0e96f0p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.8af43cp-3f * x26 + 0x1.3b1cc6p-2f * x27 - 0x1.a3104cp9f * y1 - 0x1.c07300p7f * y3;
        x[27] = -0x1.3b1cc6p0f * x26 + 0x1.8af43cp-3f * x27 + 0x1.8ba028p9f * y1 + 0x1.0e96f0p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.def75cp-4f * x28 + 0x1.d12706p-1f * x29 + 0x1.527afap6f * y0 + 0x1.d53db6p6f * y2;
        x[29] = -0x1.d12706p-1f * x28 + 0x1.def75cp-4f * x29 + 0x1.2e8a86p3f * y0 + 0x1.2d24e0p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.def75cp-4f * x30 + 0x1.d12706p-1f * x31 + 0x1.527afap6f * y1 + 0x1.d53db6p6f * y3;
        x[31] = -0x1.d12706p-1f * x30 + 0x1.def75cp-4f * x31 + 0x1.2e8a86p3f * y1 + 0x1.2d24e0p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.84a496p-3f * x32 + 0x1.2478a8p-3f * x33 - 0x1.7a10dcp8f * y0 + 0x1.591ea8p10f * y2;
        x[33] = -0x1.2478a8p-1f * x32 - 0x1.84a496p-3f * x33 + 0x1.3b2734p9f * y0 - 0x1.05c54cp10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.84a496p-3f * x34 + 0x1.2478a8p-3f * x35 - 0x1.7a10dcp8f * y1 + 0x1.591ea8p10f * y3;
        x[35] = -0x1.2478a8p-1f * x34 - 0x1.84a496p-3f * x35 + 0x1.3b2734p9f * y1 - 0x1.05c54cp10f * y3;
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
        x[0] += -0x1.dbe066p-5f * e[0];
        x[0] += 0x1.34a6f4p-5f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.cf45cap-5f * e[0];
        x[1] += -0x1.69ccbap-6f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.dbe066p-5f * e[1];
        x[2] += 0x1.34a6f4p-5f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.cf45cap-5f * e[1];
        x[3] += -0x1.69ccbap-6f * e[3];
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
        {-0x1.8e0fdap17f, 0.0f, 0x1.f18b7ap15f, 0.0f, -0x1.415094p0f, 0.0f, 0x1.354b72p-1f, 0.0f},
        {0x1.554e64p17f, 0.0f, -0x1.af96acp14f, 0.0f, 0x1.46ae66p0f, 0.0f, -0x1.1b7204p-2f, 0.0f},
        {0.0f, -0x1.8e0fdap17f, 0.0f, 0x1.f18b7ap15f, 0.0f, -0x1.415094p0f, 0.0f, 0x1.354b72p-1f},
        {0.0f, 0x1.554e64p17f, 0.0f, -0x1.af96acp14f, 0.0f, 0x1.46ae66p0f, 0.0f, -0x1.1b7204p-2f},
        {0x1.1003bap7f, 0.0f, -0x1.435970p2f, 0.0f, 0x1.7b00cep-20f, 0.0f, -0x1.33880ap-23f, 0.0f},
        {0x1.1db81cp7f, 0.0f, -0x1.ceed6ap5f, 0.0f, -0x1.d27cc0p-19f, 0.0f, 0x1.26a104p-20f, 0.0f},
        {0.0f, 0x1.1003bap7f, 0.0f, -0x1.435970p2f, 0.0f, 0x1.7b00cep-20f, 0.0f, -0x1.33880ap-23f},
        {0.0f, 0x1.1db81cp7f, 0.0f, -0x1.ceed6ap5f, 0.0f, -0x1.d27cc0p-19f, 0.0f, 0x1.26a104p-20f},
        {0x1.dc64ccp5f, 0.0f, -0x1.0f8ff6p6f, 0.0f, 0x1.2ffe66p-19f, 0.0f, -0x1.677450p-21f, 0.0f},
        {0x1.464136p7f, 0.0f, -0x1.877406p6f, 0.0f, 0x1.1cf054p-17f, 0.0f, -0x1.59ef64p-19f, 0.0f},
        {0.0f, 0x1.dc64ccp5f, 0.0f, -0x1.0f8ff6p6f, 0.0f, 0x1.2ffe66p-19f, 0.0f, -0x1.677450p-21f},
        {0.0f, 0x1.464136p7f, 0.0f, -0x1.877406p6f, 0.0f, 0x1.1cf054p-17f, 0.0f, -0x1.59ef64p-19f},
        {0x1.fa0bb0p7f, 0.0f, 0x1.8abe90p7f, 0.0f, -0x1.ecdb86p-19f, 0.0f, 0x1.a92148p-21f, 0.0f},
        {0x1.37ab98p9f, 0.0f, 0x1.b3a2f6p4f, 0.0f, 0x1.04c046p-15f, 0.0f, -0x1.3f46e4p-17f, 0.0f},
        {0.0f, 0x1.fa0bb0p7f, 0.0f, 0x1.8abe90p7f, 0.0f, -0x1.ecdb86p-19f, 0.0f, 0x1.a92148p-21f},
        {0.0f, 0x1.37ab98p9f, 0.0f, 0x1.b3a2f6p4f, 0.0f, 0x1.04c046p-15f, 0.0f, -0x1.3f46e4p-17f},
        {0x1.26599ap7f, 0.0f, -0x1.5ef90ep7f, 0.0f, -0x1.7b246ap-19f, 0.0f, 0x1.d49130p-21f, 0.0f},
        {0x1.6907a4p4f, 0.0f, -0x1.07052cp7f, 0.0f, 0x1.0957b6p-19f, 0.0f, -0x1.382676p-21f, 0.0f},
        {0.0f, 0x1.26599ap7f, 0.0f, -0x1.5ef90ep7f, 0.0f, -0x1.7b246ap-19f, 0.0f, 0x1.d49130p-21f},
        {0.0f, 0x1.6907a4p4f, 0.0f, -0x1.07052cp7f, 0.0f, 0x1.0957b6p-19f, 0.0f, -0x1.382676p-21f},
        {0x1.d65558p3f, 0.0f, -0x1.7f9984p8f, 0.0f, -0x1.0cbd34p-17f, 0.0f, 0x1.6f582cp-19f, 0.0f},
        {0x1.038b10p4f, 0.0f, 0x1.7255b0p9f, 0.0f, 0x1.bf58c8p-16f, 0.0f, -0x1.088842p-17f, 0.0f},
        {0.0f, 0x1.d65558p3f, 0.0f, -0x1.7f9984p8f, 0.0f, -0x1.0cbd34p-17f, 0.0f, 0x1.6f582cp-19f},
        {0.0f, 0x1.038b10p4f, 0.0f, 0x1.7255b0p9f, 0.0f, 0x1.bf58c8p-16f, 0.0f, -0x1.088842p-17f},
        {-0x1.bb8acep8f, -0.0f, -0x1.08ffcap7f, 0.0f, -0x1.527428p-13f, -0.0f, 0x1.b13e7ap-15f, 0.0f},
        {0x1.85ed12p10f, 0.0f, 0x1.731becp8f, 0.0f, -0x1.afebc6p-12f, 0.0f, 0x1.0aeeecp-13f, 0.0f},
        {0.0f, -0x1.bb8acep8f, 0.0f, -0x1.08ffcap7f, 0.0f, -0x1.527428p-13f, 0.0f, 0x1.b13e7ap-15f},
        {0.0f, 0x1.85ed12p10f, 0.0f, 0x1.731becp8f, 0.0f, -0x1.afebc6p-12f, 0.0f, 0x1.0aeeecp-13f},
        {0x1.a0a70ap5f, 0.0f, 0x1.2bce5cp7f, 0.0f, 0x1.097038p-20f, 0.0f, -0x1.038ce2p-22f, 0.0f},
        {-0x1.4fcc28p5f, 0.0f, 0x1.047eeap4f, 0.0f, 0x1.556396p-18f, 0.0f, -0x1.bde6fap-20f, 0.0f},
        {0.0f, 0x1.a0a70ap5f, 0.0f, 0x1.2bce5cp7f, 0.0f, 0x1.097038p-20f, 0.0f, -0x1.038ce2p-22f},
        {0.0f, -0x1.4fcc28p5f, 0.0f, 0x1.047eeap4f, 0.0f, 0x1.556396p-18f, 0.0f, -0x1.bde6fap-20f},
        {-0x1.89e72cp7f, 0.0f, 0x1.f60a7cp9f, 0.0f, 0x1.28d5dap-12f, 0.0f, -0x1.6545b8p-14f, 0.0f},
        {0x1.389c0ep9f, 0.0f, -0x1.546a50p10f, 0.0f, -0x1.1204d2p-13f, 0.0f, 0x1.4b32c4p-15f, 0.0f},
        {0.0f, -0x1.89e72cp7f, 0.0f, 0x1.f60a7cp9f, 0.0f, 0x1.28d5dap-12f, 0.0f, -0x1.6545b8p-14f},
        {0.0f, 0x1.389c0ep9f, 0.0f, -0x1.546a50p10f, -0.0f, -0x1.1204d2p-13f, 0.0f, 0x1.4b32c4p-15f},
        {0x1.713ceep0f, 0.0f, -0x1.18178ep1f, 0.0f, -0x1.80c242p-21f, -0.0f, 0x1.ca498ap-23f, 0.0f},
        {0.0f, 0x1.713ceep0f, 0.0f, -0x1.18178ep1f, 0.0f, -0x1.80c242p-21f, 0.0f, 0x1.ca498ap-23f},
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
/* Over the test vectors Q31 stays within 2.991e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 119985 * (int64_t)v, u2 = 524288 * (int64_t)v;
        v = x[1]; u0 += 239116 * (int64_t)v; u2 += 524288 * (int64_t)v;
        v = x[4]; u0 += -122370371 * (int64_t)v; u2 += -133730095 * (int64_t)v;
        v = x[5]; u0 += 41621507 * (int64_t)v; u2 += 143373132 * (int64_t)v;
        v = x[8]; u0 += 94204041 * (int64_t)v; u2 += -330172639 * (int64_t)v;
        v = x[9]; u0 += -105672453 * (int64_t)v; u2 += 108581840 * (int64_t)v;
        v = x[12]; u0 += 255888015 * (int64_t)v; u2 += 89671982 * (int64_t)v;
        v = x[13]; u0 += 12371639 * (int64_t)v; u2 += -154079500 * (int64_t)v;
        v = x[16]; u0 += 553188562 * (int64_t)v; u2 += -505566716 * (int64_t)v;
        v = x[17]; u0 += 154542486 * (int64_t)v; u2 += 217711649 * (int64_t)v;
        v = x[20]; u0 += 112732755 * (int64_t)v; u2 += -140869123 * (int64_t)v;
        v = x[21]; u0 += -15031646 * (int64_t)v; u2 += -24152224 * (int64_t)v;
        v = x[24]; u0 += -53852223 * (int64_t)v; u2 += -8456101 * (int64_t)v;
        v = x[25]; u0 += 60052 * (int64_t)v; u2 += -4443531 * (int64_t)v;
        v = x[28]; u0 += 21479858 * (int64_t)v; u2 += -89400937 * (int64_t)v;
        v = x[29]; u0 += -169907191 * (int64_t)v; u2 += -13516075 * (int64_t)v;
        v = x[32]; u0 += 46191247 * (int64_t)v; u2 += -27408585 * (int64_t)v;
        v = x[33]; u0 += -26317079 * (int64_t)v; u2 += 22767249 * (int64_t)v;
        v = x[36]; u0 += -5183943 * (int64_t)v; u2 += 8263690 * (int64_t)v;
        v = y0; u0 += -40754292 * (int64_t)v; u2 += 37547747 * (int64_t)v;
        v = y2; u0 += 7088395 * (int64_t)v; u2 += -15272412 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 19);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 119985 * (int64_t)v, u3 = 524288 * (int64_t)v;
        v = x[3]; u1 += 239116 * (int64_t)v; u3 += 524288 * (int64_t)v;
        v = x[6]; u1 += -122370371 * (int64_t)v; u3 += -133730095 * (int64_t)v;
        v = x[7]; u1 += 41621507 * (int64_t)v; u3 += 143373132 * (int64_t)v;
        v = x[10]; u1 += 94204041 * (int64_t)v; u3 += -330172639 * (int64_t)v;
        v = x[11]; u1 += -105672453 * (int64_t)v; u3 += 108581840 * (int64_t)v;
        v = x[14]; u1 += 255888015 * (int64_t)v; u3 += 89671982 * (int64_t)v;
        v = x[15]; u1 += 12371639 * (int64_t)v; u3 += -154079500 * (int64_t)v;
        v = x[18]; u1 += 553188562 * (int64_t)v; u3 += -505566716 * (int64_t)v;
        v = x[19]; u1 += 154542486 * (int64_t)v; u3 += 217711649 * (int64_t)v;
        v = x[22]; u1 += 112732755 * (int64_t)v; u3 += -140869123 * (int64_t)v;
        v = x[23]; u1 += -15031646 * (int64_t)v; u3 += -24152224 * (int64_t)v;
        v = x[26]; u1 += -53852223 * (int64_t)v; u3 += -8456101 * (int64_t)v;
        v = x[27]; u1 += 60052 * (int64_t)v; u3 += -4443531 * (int64_t)v;
        v = x[30]; u1 += 21479858 * (int64_t)v; u3 += -89400937 * (int64_t)v;
        v = x[31]; u1 += -169907191 * (int64_t)v; u3 += -13516075 * (int64_t)v;
        v = x[34]; u1 += 46191247 * (int64_t)v; u3 += -27408585 * (int64_t)v;
        v = x[35]; u1 += -26317079 * (int64_t)v; u3 += 22767249 * (int64_t)v;
        v = x[37]; u1 += -5183943 * (int64_t)v; u3 += 8263690 * (int64_t)v;
        v = y1; u1 += -40754292 * (int64_t)v; u3 += 37547747 * (int64_t)v;
        v = y3; u1 += 7088395 * (int64_t)v; u3 += -15272412 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1411284 * (int64_t)x0 + 49386491 * (int64_t)y0 - 28922288 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2854393 * (int64_t)x1 - 74682179 * (int64_t)y0 - 140370366 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1411284 * (int64_t)x2 + 49386491 * (int64_t)y1 - 28922288 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2854393 * (int64_t)x3 - 74682179 * (int64_t)y1 - 140370366 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-76535753 * (int64_t)x4 + 334396250 * (int64_t)x5 - 9539867 * (int64_t)y0 + 4807180 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-334396250 * (int64_t)x4 - 76535753 * (int64_t)x5 + 14309318 * (int64_t)y0 - 1609422 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-76535753 * (int64_t)x6 + 334396250 * (int64_t)x7 - 9539867 * (int64_t)y1 + 4807180 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-334396250 * (int64_t)x6 - 76535753 * (int64_t)x7 + 14309318 * (int64_t)y1 - 1609422 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-154559295 * (int64_t)x8 + 500662066 * (int64_t)x9 - 18256531 * (int64_t)y0 + 9796919 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-500662066 * (int64_t)x8 - 154559295 * (int64_t)x9 + 13881333 * (int64_t)y0 - 12491922 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-154559295 * (int64_t)x10 + 500662066 * (int64_t)x11 - 18256531 * (int64_t)y1 + 9796919 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-500662066 * (int64_t)x10 - 154559295 * (int64_t)x11 + 13881333 * (int64_t)y1 - 12491922 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(777698183 * (int64_t)x12 + 551285642 * (int64_t)x13 - 67548631 * (int64_t)y0 + 11142851 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-551285642 * (int64_t)x12 + 777698183 * (int64_t)x13 + 82049464 * (int64_t)y0 + 29762126 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(777698183 * (int64_t)x14 + 551285642 * (int64_t)x15 - 67548631 * (int64_t)y1 + 11142851 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-551285642 * (int64_t)x14 + 777698183 * (int64_t)x15 + 82049464 * (int64_t)y1 + 29762126 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(624426521 * (int64_t)x16 + 795048586 * (int64_t)x17 + 12350428 * (int64_t)y0 + 6547731 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-795048586 * (int64_t)x16 + 624426521 * (int64_t)x17 + 32345981 * (int64_t)y0 - 50451728 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(624426521 * (int64_t)x18 + 795048586 * (int64_t)x19 + 12350428 * (int64_t)y1 + 6547731 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-795048586 * (int64_t)x18 + 624426521 * (int64_t)x19 + 32345981 * (int64_t)y1 - 50451728 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(376682099 * (int64_t)x20 + 820472933 * (int64_t)x21 + 276871 * (int64_t)y0 - 222165043 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-820472933 * (int64_t)x20 + 376682099 * (int64_t)x21 + 5423454 * (int64_t)y0 + 50920237 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(376682099 * (int64_t)x22 + 820472933 * (int64_t)x23 + 276871 * (int64_t)y1 - 222165043 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-820472933 * (int64_t)x22 + 376682099 * (int64_t)x23 + 5423454 * (int64_t)y1 + 50920237 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(414139317 * (int64_t)x24 + 660838571 * (int64_t)x25 - 457165639 * (int64_t)y0 - 122305746 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-1321677141 * (int64_t)x24 + 207069659 * (int64_t)x25 + 215798283 * (int64_t)y0 + 36899008 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(414139317 * (int64_t)x26 + 660838571 * (int64_t)x27 - 457165639 * (int64_t)y1 - 122305746 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-1321677141 * (int64_t)x26 + 207069659 * (int64_t)x27 + 215798283 * (int64_t)y1 + 36899008 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(125558127 * (int64_t)x28 + 975495373 * (int64_t)x29 + 23078475 * (int64_t)y0 + 31994078 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-975495373 * (int64_t)x28 + 125558127 * (int64_t)x29 + 2578505 * (int64_t)y0 + 41065571 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(125558127 * (int64_t)x30 + 975495373 * (int64_t)x31 + 23078475 * (int64_t)y1 + 31994078 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-975495373 * (int64_t)x30 + 125558127 * (int64_t)x31 + 2578505 * (int64_t)y1 + 41065571 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-407521629 * (int64_t)x32 + 306678398 * (int64_t)x33 - 206220123 * (int64_t)y0 + 752997270 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-613356795 * (int64_t)x32 - 203760815 * (int64_t)x33 + 171903695 * (int64_t)y0 - 285571311 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-407521629 * (int64_t)x34 + 306678398 * (int64_t)x35 - 206220123 * (int64_t)y1 + 752997270 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-613356795 * (int64_t)x34 - 203760815 * (int64_t)x35 + 171903695 * (int64_t)y1 - 285571311 * (int64_t)y3, 30);
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
        x[0] = paper_tool_q31_correct(x[0], -748489102 * (int64_t)e[0] + 485467877 * (int64_t)e[2], 20);
        x[1] = paper_tool_q31_correct(x[1], 1457329676 * (int64_t)e[0] - 569061755 * (int64_t)e[2], 21);
        x[2] = paper_tool_q31_correct(x[2], -748489102 * (int64_t)e[1] + 485467877 * (int64_t)e[3], 20);
        x[3] = paper_tool_q31_correct(x[3], 1457329676 * (int64_t)e[1] - 569061755 * (int64_t)e[3], 21);
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
        {-868508770, 0, 271391220, 0, -63173051, 0, 30404907, 0},
        {1489353408, 0, -235414670, 0, 128456293, 0, -27863815, 0},
        {0, -868508770, 0, 271391220, 0, -63173051, 0, 30404907},
        {0, 1489353408, 0, -235414670, 0, 128456293, 0, -27863815},
        {1186986277, 0, -44093604, 0, 145537, 0, -14762, 0},
        {1246788949, 0, -505017529, 0, -358262, 0, 113138, 0},
        {0, 1186986277, 0, -44093604, 0, 145537, 0, -14762},
        {0, 1246788949, 0, -505017529, 0, -358262, 0, 113138},
        {519708247, 0, -592506503, 0, 233467, 0, -69015, 0},
        {711836729, 0, -427044811, 0, 437666, 0, -132839, 0},
        {0, 519708247, 0, -592506503, 0, 233467, 0, -69015},
        {0, 711836729, 0, -427044811, 0, 437666, 0, -132839},
        {1104112380, 0, 861270449, 0, -189257, 0, 40812, 0},
        {1360031565, 0, 59405674, 0, 801027, 0, -245205, 0},
        {0, 1104112380, 0, 861270449, 0, -189257, 0, 40812},
        {0, 1360031565, 0, 59405674, 0, 801027, 0, -245205},
        {642225637, 0, -765767803, 0, -145591, 0, 44982, 0},
        {196927644, 0, -1147737740, 0, 203783, 0, -59933, 0},
        {0, 642225637, 0, -765767803, 0, -145591, 0, 44982},
        {0, 196927644, 0, -1147737740, 0, 203783, 0, -59933},
        {64137109, 0, -1673908759, 0, -412783, 0, 141060, 0},
        {35392667, 0, 1616024699, 0, 687125, 0, -203161, 0},
        {0, 64137109, 0, -1673908759, 0, -412783, 0, 141060},
        {0, 35392667, 0, 1616024699, 0, 687125, 0, -203161},
        {-967739608, 0, -289093342, 0, -4158920, 0, 1330926, 0},
        {1701515170, 0, 404850920, 0, -5307445, 0, 1640038, 0},
        {0, -967739608, 0, -289093342, 0, -4158920, 0, 1330926},
        {0, 1701515170, 0, 404850920, 0, -5307445, 0, 1640038},
        {454535237, 0, 1308259928, 0, 101928, 0, -24917, 0},
        {-1465315059, 0, 568360943, 0, 2097494, 0, -684906, 0},
        {0, 454535237, 0, 1308259928, 0, 101928, 0, -24917},
        {0, -1465315059, 0, 568360943, 0, 2097494, 0, -684906},
        {-214858673, 0, 1095374719, 0, 3647513, 0, -1097541, 0},
        {341032581, 0, -742732832, 0, -841786, 0, 254360, 0},
        {0, -214858673, 0, 1095374719, 0, 3647513, 0, -1097541},
        {0, 341032581, 0, -742732832, 0, -841786, 0, 254360},
        {805619520, 0, -1222233755, 0, -4727916, 0, 1407858, 0},
        {0, 805619520, 0, -1222233755, 0, -4727916, 0, 1407858},
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
