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
static const float paper_tool_f32_output_guard = 0x1.bfac9ep23f;

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
        float u0 = 0x1.13c0c6p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.013a36p0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a441b2p8f * v; u2 += 0x1.0c9734p9f * v;
        v = x[5]; u0 += 0x1.222aa6p5f * v; u2 += -0x1.7ceab6p9f * v;
        v = x[8]; u0 += 0x1.06d6f6p10f * v; u2 += -0x1.ce26eep11f * v;
        v = x[9]; u0 += -0x1.61c400p9f * v; u2 += 0x1.55b908p10f * v;
        v = x[12]; u0 += -0x1.b3fa7cp10f * v; u2 += -0x1.12590ap9f * v;
        v = x[13]; u0 += -0x1.b12066p8f * v; u2 += 0x1.0730f2p10f * v;
        v = x[16]; u0 += -0x1.f01a18p11f * v; u2 += 0x1.1db404p11f * v;
        v = x[17]; u0 += 0x1.b33b08p5f * v; u2 += -0x1.cbfab8p10f * v;
        v = x[20]; u0 += 0x1.b916a8p9f * v; u2 += -0x1.627136p9f * v;
        v = x[21]; u0 += 0x1.ebc65cp5f * v; u2 += -0x1.e14048p8f * v;
        v = x[24]; u0 += -0x1.4b2bfcp7f * v; u2 += -0x1.7f5810p6f * v;
        v = x[25]; u0 += 0x1.3f8906p8f * v; u2 += -0x1.d14ee2p4f * v;
        v = x[28]; u0 += -0x1.d11772p8f * v; u2 += -0x1.ed4bd4p6f * v;
        v = x[29]; u0 += -0x1.481ad8p7f * v; u2 += 0x1.aab53ap7f * v;
        v = x[32]; u0 += 0x1.29de6cp7f * v; u2 += -0x1.e21dc0p5f * v;
        v = x[33]; u0 += 0x1.c528f2p8f * v; u2 += -0x1.52e1fcp7f * v;
        v = x[36]; u0 += -0x1.d0f75ap4f * v; u2 += 0x1.7085bcp5f * v;
        v = y0; u0 += -0x1.044c26p20f * v; u2 += 0x1.ca368cp19f * v;
        v = y2; u0 += 0x1.e1d992p15f * v; u2 += -0x1.e8f8d8p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.13c0c6p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.013a36p0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a441b2p8f * v; u3 += 0x1.0c9734p9f * v;
        v = x[7]; u1 += 0x1.222aa6p5f * v; u3 += -0x1.7ceab6p9f * v;
        v = x[10]; u1 += 0x1.06d6f6p10f * v; u3 += -0x1.ce26eep11f * v;
        v = x[11]; u1 += -0x1.61c400p9f * v; u3 += 0x1.55b908p10f * v;
        v = x[14]; u1 += -0x1.b3fa7cp10f * v; u3 += -0x1.12590ap9f * v;
        v = x[15]; u1 += -0x1.b12066p8f * v; u3 += 0x1.0730f2p10f * v;
        v = x[18]; u1 += -0x1.f01a18p11f * v; u3 += 0x1.1db404p11f * v;
        v = x[19]; u1 += 0x1.b33b08p5f * v; u3 += -0x1.cbfab8p10f * v;
        v = x[22]; u1 += 0x1.b916a8p9f * v; u3 += -0x1.627136p9f * v;
        v = x[23]; u1 += 0x1.ebc65cp5f * v; u3 += -0x1.e14048p8f * v;
        v = x[26]; u1 += -0x1.4b2bfcp7f * v; u3 += -0x1.7f5810p6f * v;
        v = x[27]; u1 += 0x1.3f8906p8f * v; u3 += -0x1.d14ee2p4f * v;
        v = x[30]; u1 += -0x1.d11772p8f * v; u3 += -0x1.ed4bd4p6f * v;
        v = x[31]; u1 += -0x1.481ad8p7f * v; u3 += 0x1.aab53ap7f * v;
        v = x[34]; u1 += 0x1.29de6cp7f * v; u3 += -0x1.e21dc0p5f * v;
        v = x[35]; u1 += 0x1.c528f2p8f * v; u3 += -0x1.52e1fcp7f * v;
        v = x[37]; u1 += -0x1.d0f75ap4f * v; u3 += 0x1.7085bcp5f * v;
        v = y1; u1 += -0x1.044c26p20f * v; u3 += 0x1.ca368cp19f * v;
        v = y3; u1 += 0x1.e1d992p15f * v; u3 += -0x1.e8f8d8p17f * v;
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
        x[0] = -0x1.981aa0p-10f * x0 + 0x1.e7a1cap7f * y0 - 0x1.a9f432p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.174944p-9f * x1 - 0x1.611fa2p8f * y0 - 0x1.bbada6p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.981aa0p-10f * x2 + 0x1.e7a1cap7f * y1 - 0x1.a9f432p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.174944p-9f * x3 - 0x1.611fa2p8f * y1 - 0x1.bbada6p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.42c886p-4f * x4 + 0x1.3bff14p-1f * x5 + 0x1.30b3a8p6f * y0 - 0x1.38a4f2p5f * y2
            + x4;
        x[5] = -0x1.3bff14p-3f * x4 - 0x1.42c886p-4f * x5 - 0x1.d9c142p5f * y0 + 0x1.265abcp0f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.42c886p-4f * x6 + 0x1.3bff14p-1f * x7 + 0x1.30b3a8p6f * y1 - 0x1.38a4f2p5f * y3
            + x6;
        x[7] = -0x1.3bff14p-3f * x6 - 0x1.42c886p-4f * x7 - 0x1.d9c142p5f * y1 + 0x1.265abcp0f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1ce440p-3f * x8 + 0x1.e0ade0p-2f * x9 - 0x1.0cc0f0p5f * y0 + 0x1.4c3326p4f * y2
            + x8;
        x[9] = -0x1.e0ade0p-2f * x8 - 0x1.1ce440p-3f * x9 + 0x1.d34186p4f * y0 - 0x1.0ed034p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1ce440p-3f * x10 + 0x1.e0ade0p-2f * x11 - 0x1.0cc0f0p5f * y1 + 0x1.4c3326p4f * y3
            + x10;
        x[11] = -0x1.e0ade0p-2f * x10 - 0x1.1ce440p-3f * x11 + 0x1.d34186p4f * y1 - 0x1.0ed034p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6bf5a2p-1f * x12 + 0x1.024570p-1f * x13 + 0x1.ca4bcap7f * y0 - 0x1.29aa2ap6f * y2;
        x[13] = -0x1.024570p-1f * x12 + 0x1.6bf5a2p-1f * x13 - 0x1.49968ep8f * y0 - 0x1.04390ap7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6bf5a2p-1f * x14 + 0x1.024570p-1f * x15 + 0x1.ca4bcap7f * y1 - 0x1.29aa2ap6f * y3;
        x[15] = -0x1.024570p-1f * x14 + 0x1.6bf5a2p-1f * x15 - 0x1.49968ep8f * y1 - 0x1.04390ap7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.238608p-1f * x16 + 0x1.799cfap-1f * x17 - 0x1.b49d3ep6f * y0 + 0x1.2e11aep5f * y2;
        x[17] = -0x1.799cfap-1f * x16 + 0x1.238608p-1f * x17 - 0x1.ade786p6f * y0 + 0x1.833e5cp7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.238608p-1f * x18 + 0x1.799cfap-1f * x19 - 0x1.b49d3ep6f * y1 + 0x1.2e11aep5f * y3;
        x[19] = -0x1.799cfap-1f * x18 + 0x1.238608p-1f * x19 - 0x1.ade786p6f * y1 + 0x1.833e5cp7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6e5bb4p-2f * x20 + 0x1.85c8e6p-1f * x21 + 0x1.704832p5f * y0 - 0x1.632126p9f * y2;
        x[21] = -0x1.85c8e6p-1f * x20 + 0x1.6e5bb4p-2f * x21 - 0x1.a1d65ap7f * y0 + 0x1.52614cp5f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6e5bb4p-2f * x22 + 0x1.85c8e6p-1f * x23 + 0x1.704832p5f * y1 - 0x1.632126p9f * y3;
        x[23] = -0x1.85c8e6p-1f * x22 + 0x1.6e5bb4p-2f * x23 - 0x1.a1d65ap7f * y1 + 0x1.52614cp5f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.5ce240p-3f * x24 + 0x1.4d6e64p-1f * x25 + 0x1.e5b26ep5f * y0 - 0x1.1877e8p7f * y2;
        x[25] = -0x1.4d6e64p-1f * x24 + 0x1.5ce240p-3f * x25 + 0x1.056174p10f * y0 + 0x1.9d81d8p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.5ce240p-3f * x26 + 0x1.4d6e64p-1f * x27 + 0x1.e5b26ep5f * y1 - 0x1.1877e8p7f * y3;
        x[27] = -0x1.4d6e64p-1f * x26 + 0x1.5ce240p-3f * x27 + 0x1.056174p10f * y1 + 0x1.9d81d8p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.eb74e4p-4f * x28 + 0x1.c93f5ap-1f * x29 + 0x1.fe7f5ap5f * y0 + 0x1.67fa1ep8f * y2;
        x[29] = -0x1.c93f5ap-1f * x28 + 0x1.eb74e4p-4f * x29 - 0x1.434e5ap5f * y0 - 0x1.8e8e0cp7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.eb74e4p-4f * x30 + 0x1.c93f5ap-1f * x31 + 0x1.fe7f5ap5f * y1 + 0x1.67fa1ep8f * y3;
        x[31] = -0x1.c93f5ap-1f * x30 + 0x1.eb74e4p-4f * x31 - 0x1.434e5ap5f * y1 - 0x1.8e8e0cp7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.03f2a6p-2f * x32 + 0x1.5f3762p-1f * x33 - 0x1.132c8cp9f * y0 - 0x1.0e22ccp8f * y2;
        x[33] = -0x1.5f3762p-3f * x32 - 0x1.03f2a6p-2f * x33 - 0x1.b61ceep9f * y0 + 0x1.6ecb4cp10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.03f2a6p-2f * x34 + 0x1.5f3762p-1f * x35 - 0x1.132c8cp9f * y1 - 0x1.0e22ccp8f * y3;
        x[35] = -0x1.5f3762p-3f * x34 - 0x1.03f2a6p-2f * x35 - 0x1.b61ceep9f * y1 + 0x1.6ecb4cp10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fec070p-1f * x36 + 0x1.8938aep1f * y0 - 0x1.0c0f1cp2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fec070p-1f * x37 + 0x1.8938aep1f * y1 - 0x1.0c0f1cp2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.8653b4p-4f * e[0];
        x[0] += 0x1.486bf8p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.74b9dcp-4f * e[0];
        x[1] += -0x1.2bfdd4p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.8653b4p-4f * e[1];
        x[2] += 0x1.486bf8p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.74b9dcp-4f * e[1];
        x[3] += -0x1.2bfdd4p-4f * e[3];
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
        {0x1.8c5858p16f, 0.0f, 0x1.2ba4a2p15f, 0.0f, 0x1.8432f0p-1f, 0.0f, -0x1.413226p-4f, 0.0f},
        {-0x1.dd4c66p16f, 0.0f, -0x1.75e9eep13f, 0.0f, -0x1.470036p-1f, 0.0f, 0x1.7b3b4cp-2f, 0.0f},
        {0.0f, 0x1.8c5858p16f, 0.0f, 0x1.2ba4a2p15f, 0.0f, 0x1.8432f0p-1f, 0.0f, -0x1.413226p-4f},
        {0.0f, -0x1.dd4c66p16f, 0.0f, -0x1.75e9eep13f, 0.0f, -0x1.470036p-1f, 0.0f, 0x1.7b3b4cp-2f},
        {-0x1.314ff4p8f, 0.0f, -0x1.9016bcp4f, 0.0f, -0x1.981c76p-16f, 0.0f, 0x1.0f8a1cp-17f, 0.0f},
        {-0x1.3707c0p7f, 0.0f, 0x1.e49536p5f, 0.0f, 0x1.50ee38p-15f, 0.0f, -0x1.d74f60p-17f, 0.0f},
        {0.0f, -0x1.314ff4p8f, 0.0f, -0x1.9016bcp4f, 0.0f, -0x1.981c76p-16f, 0.0f, 0x1.0f8a1cp-17f},
        {0.0f, -0x1.3707c0p7f, 0.0f, 0x1.e49536p5f, 0.0f, 0x1.50ee38p-15f, 0.0f, -0x1.d74f60p-17f},
        {0x1.2f4ce8p5f, 0.0f, -0x1.50cc76p4f, 0.0f, 0x1.6332ccp-20f, 0.0f, -0x1.e531b6p-22f, 0.0f},
        {0x1.58a68ap6f, 0.0f, -0x1.91c794p5f, 0.0f, 0x1.67d7f4p-16f, 0.0f, -0x1.f51456p-18f, 0.0f},
        {0.0f, 0x1.2f4ce8p5f, 0.0f, -0x1.50cc76p4f, 0.0f, 0x1.6332ccp-20f, 0.0f, -0x1.e531b6p-22f},
        {0.0f, 0x1.58a68ap6f, 0.0f, -0x1.91c794p5f, 0.0f, 0x1.67d7f4p-16f, 0.0f, -0x1.f51456p-18f},
        {-0x1.1f8a26p8f, 0.0f, -0x1.009816p8f, 0.0f, 0x1.ab6910p-15f, 0.0f, -0x1.26e3b4p-16f, 0.0f},
        {-0x1.47f7dcp9f, 0.0f, -0x1.593194p1f, 0.0f, -0x1.a5a082p-13f, 0.0f, 0x1.2585aap-14f, 0.0f},
        {0.0f, -0x1.1f8a26p8f, 0.0f, -0x1.009816p8f, 0.0f, 0x1.ab6910p-15f, 0.0f, -0x1.26e3b4p-16f},
        {0.0f, -0x1.47f7dcp9f, 0.0f, -0x1.593194p1f, 0.0f, -0x1.a5a082p-13f, 0.0f, 0x1.2585aap-14f},
        {-0x1.564678p7f, 0.0f, 0x1.b45c0cp7f, 0.0f, 0x1.a2d0bap-17f, 0.0f, -0x1.248446p-18f, 0.0f},
        {0x1.5cd4aap5f, 0.0f, 0x1.2f5ce2p6f, 0.0f, -0x1.5b66a6p-16f, 0.0f, 0x1.e30070p-18f, 0.0f},
        {0.0f, -0x1.564678p7f, 0.0f, 0x1.b45c0cp7f, 0.0f, 0x1.a2d0bap-17f, 0.0f, -0x1.248446p-18f},
        {0.0f, 0x1.5cd4aap5f, 0.0f, 0x1.2f5ce2p6f, 0.0f, -0x1.5b66a6p-16f, 0.0f, 0x1.e30070p-18f},
        {-0x1.05076cp7f, 0.0f, -0x1.aadb4cp8f, 0.0f, -0x1.5475a6p-21f, 0.0f, 0x1.83fcfep-22f, 0.0f},
        {-0x1.2fe0fcp7f, 0.0f, 0x1.1f3bd6p9f, 0.0f, 0x1.e5e506p-14f, 0.0f, -0x1.50dfbcp-15f, 0.0f},
        {0.0f, -0x1.05076cp7f, 0.0f, -0x1.aadb4cp8f, 0.0f, -0x1.5475a6p-21f, 0.0f, 0x1.83fcfep-22f},
        {0.0f, -0x1.2fe0fcp7f, 0.0f, 0x1.1f3bd6p9f, 0.0f, 0x1.e5e506p-14f, 0.0f, -0x1.50dfbcp-15f},
        {0x1.a77be4p8f, 0.0f, 0x1.ab3354p1f, 0.0f, -0x1.818ac0p-10f, 0.0f, 0x1.0d1c54p-11f, 0.0f},
        {0x1.7454a8p9f, 0.0f, 0x1.d6e8b0p7f, 0.0f, 0x1.0e89b6p-18f, 0.0f, -0x1.bbebbap-20f, 0.0f},
        {0.0f, 0x1.a77be4p8f, 0.0f, 0x1.ab3354p1f, 0.0f, -0x1.818ac0p-10f, 0.0f, 0x1.0d1c54p-11f},
        {0.0f, 0x1.7454a8p9f, 0.0f, 0x1.d6e8b0p7f, 0.0f, 0x1.0e89b6p-18f, 0.0f, -0x1.bbebbap-20f},
        {0x1.022454p4f, 0.0f, 0x1.6074b4p6f, 0.0f, 0x1.6c9c6ap-16f, 0.0f, -0x1.021d70p-17f, 0.0f},
        {-0x1.ded3b6p5f, 0.0f, -0x1.3ca89ap8f, 0.0f, -0x1.698ce2p-18f, 0.0f, 0x1.d0771cp-20f, -0.0f},
        {0.0f, 0x1.022454p4f, 0.0f, 0x1.6074b4p6f, 0.0f, 0x1.6c9c6ap-16f, 0.0f, -0x1.021d70p-17f},
        {0.0f, -0x1.ded3b6p5f, 0.0f, -0x1.3ca89ap8f, 0.0f, -0x1.698ce2p-18f, 0.0f, 0x1.d0771cp-20f},
        {-0x1.5bac94p9f, 0.0f, 0x1.8f92d6p8f, 0.0f, 0x1.c456c0p-12f, 0.0f, -0x1.3b6618p-13f, 0.0f},
        {-0x1.810d02p8f, 0.0f, 0x1.1b12cap10f, 0.0f, 0x1.5758d4p-10f, 0.0f, -0x1.de015ep-12f, 0.0f},
        {0.0f, -0x1.5bac94p9f, 0.0f, 0x1.8f92d6p8f, 0.0f, 0x1.c456c0p-12f, 0.0f, -0x1.3b6618p-13f},
        {0.0f, -0x1.810d02p8f, 0.0f, 0x1.1b12cap10f, 0.0f, 0x1.5758d4p-10f, 0.0f, -0x1.de015ep-12f},
        {0x1.145be8p0f, 0.0f, -0x1.12bf98p1f, -0.0f, -0x1.7e3f18p-19f, -0.0f, 0x1.091510p-20f, 0.0f},
        {0.0f, 0x1.145be8p0f, 0.0f, -0x1.12bf98p1f, 0.0f, -0x1.7e3f18p-19f, 0.0f, 0x1.091510p-20f},
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
/* Over the test vectors Q31 stays within 4.006e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        c->excess[i] = paper_tool_q31_saturate((current - wanted + (((int64_t)1 << 13) >> 1)) >> 13);
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
        int64_t u0 = 188247 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 175601 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73445170 * (int64_t)v; u2 += 46939617 * (int64_t)v;
        v = x[5]; u0 += 6338786 * (int64_t)v; u2 += -66570041 * (int64_t)v;
        v = x[8]; u0 += 183738269 * (int64_t)v; u2 += -323067706 * (int64_t)v;
        v = x[9]; u0 += -123650048 * (int64_t)v; u2 += 119440772 * (int64_t)v;
        v = x[12]; u0 += -304771028 * (int64_t)v; u2 += -47945753 * (int64_t)v;
        v = x[13]; u0 += -75694353 * (int64_t)v; u2 += 91991990 * (int64_t)v;
        v = x[16]; u0 += -693600767 * (int64_t)v; u2 += 199721008 * (int64_t)v;
        v = x[17]; u0 += 9507758 * (int64_t)v; u2 += -160774442 * (int64_t)v;
        v = x[20]; u0 += 154171610 * (int64_t)v; u2 += -61943271 * (int64_t)v;
        v = x[21]; u0 += 10742985 * (int64_t)v; u2 += -42052362 * (int64_t)v;
        v = x[24]; u0 += -28938233 * (int64_t)v; u2 += -8374278 * (int64_t)v;
        v = x[25]; u0 += 55842830 * (int64_t)v; u2 += -2541203 * (int64_t)v;
        v = x[28]; u0 += -81280645 * (int64_t)v; u2 += -10776220 * (int64_t)v;
        v = x[29]; u0 += -28670240 * (int64_t)v; u2 += 18643154 * (int64_t)v;
        v = x[32]; u0 += 26028177 * (int64_t)v; u2 += -5265995 * (int64_t)v;
        v = x[33]; u0 += 79195438 * (int64_t)v; u2 += -14806013 * (int64_t)v;
        v = x[36]; u0 += -5078671 * (int64_t)v; u2 += 4025247 * (int64_t)v;
        v = y0; u0 += -47327355 * (int64_t)v; u2 += 20828108 * (int64_t)v;
        v = y2; u0 += 2737815 * (int64_t)v; u2 += -5556565 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 188247 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 175601 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73445170 * (int64_t)v; u3 += 46939617 * (int64_t)v;
        v = x[7]; u1 += 6338786 * (int64_t)v; u3 += -66570041 * (int64_t)v;
        v = x[10]; u1 += 183738269 * (int64_t)v; u3 += -323067706 * (int64_t)v;
        v = x[11]; u1 += -123650048 * (int64_t)v; u3 += 119440772 * (int64_t)v;
        v = x[14]; u1 += -304771028 * (int64_t)v; u3 += -47945753 * (int64_t)v;
        v = x[15]; u1 += -75694353 * (int64_t)v; u3 += 91991990 * (int64_t)v;
        v = x[18]; u1 += -693600767 * (int64_t)v; u3 += 199721008 * (int64_t)v;
        v = x[19]; u1 += 9507758 * (int64_t)v; u3 += -160774442 * (int64_t)v;
        v = x[22]; u1 += 154171610 * (int64_t)v; u3 += -61943271 * (int64_t)v;
        v = x[23]; u1 += 10742985 * (int64_t)v; u3 += -42052362 * (int64_t)v;
        v = x[26]; u1 += -28938233 * (int64_t)v; u3 += -8374278 * (int64_t)v;
        v = x[27]; u1 += 55842830 * (int64_t)v; u3 += -2541203 * (int64_t)v;
        v = x[30]; u1 += -81280645 * (int64_t)v; u3 += -10776220 * (int64_t)v;
        v = x[31]; u1 += -28670240 * (int64_t)v; u3 += 18643154 * (int64_t)v;
        v = x[34]; u1 += 26028177 * (int64_t)v; u3 += -5265995 * (int64_t)v;
        v = x[35]; u1 += 79195438 * (int64_t)v; u3 += -14806013 * (int64_t)v;
        v = x[37]; u1 += -5078671 * (int64_t)v; u3 += 4025247 * (int64_t)v;
        v = y1; u1 += -47327355 * (int64_t)v; u3 += 20828108 * (int64_t)v;
        v = y3; u1 += 2737815 * (int64_t)v; u3 += -5556565 * (int64_t)v;
        u[1] = paper_tool_q31_current(c, 1, u1, 19);
        u[3] = paper_tool_q31_current(c, 3, u3, 18);
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
        x[0] = paper_tool_q31_round(-1671594 * (int64_t)x0 + 66496040 * (int64_t)y0 - 29042647 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2287912 * (int64_t)x1 - 96307544 * (int64_t)y0 - 121004570 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1671594 * (int64_t)x2 + 66496040 * (int64_t)y1 - 29042647 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2287912 * (int64_t)x3 - 96307544 * (int64_t)y1 - 121004570 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-84615707 * (int64_t)x4 + 662692482 * (int64_t)x5 + 20775362 * (int64_t)y0 - 10658452 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165673121 * (int64_t)x4 - 84615707 * (int64_t)x5 - 16150922 * (int64_t)y0 + 313591 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-84615707 * (int64_t)x6 + 662692482 * (int64_t)x7 + 20775362 * (int64_t)y1 - 10658452 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165673121 * (int64_t)x6 - 84615707 * (int64_t)x7 - 16150922 * (int64_t)y1 + 313591 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149365248 * (int64_t)x8 + 504028662 * (int64_t)x9 - 9162162 * (int64_t)y0 + 5662562 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504028662 * (int64_t)x8 - 149365248 * (int64_t)x9 + 7964682 * (int64_t)y0 - 4616189 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149365248 * (int64_t)x10 + 504028662 * (int64_t)x11 - 9162162 * (int64_t)y1 + 5662562 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504028662 * (int64_t)x10 - 149365248 * (int64_t)x11 + 7964682 * (int64_t)y1 - 4616189 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763278377 * (int64_t)x12 + 541634040 * (int64_t)x13 + 62495639 * (int64_t)y0 - 20295556 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-541634040 * (int64_t)x12 + 763278377 * (int64_t)x13 - 89888700 * (int64_t)y0 - 35485337 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763278377 * (int64_t)x14 + 541634040 * (int64_t)x15 + 62495639 * (int64_t)y1 - 20295556 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-541634040 * (int64_t)x14 + 763278377 * (int64_t)x15 - 89888700 * (int64_t)y1 - 35485337 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611369192 * (int64_t)x16 + 791912241 * (int64_t)x17 - 29769495 * (int64_t)y0 + 10297928 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791912241 * (int64_t)x16 + 611369192 * (int64_t)x17 - 29312002 * (int64_t)y0 + 52806555 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611369192 * (int64_t)x18 + 791912241 * (int64_t)x19 - 29769495 * (int64_t)y1 + 10297928 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791912241 * (int64_t)x18 + 611369192 * (int64_t)x19 - 29312002 * (int64_t)y1 + 52806555 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(384154421 * (int64_t)x20 + 817437886 * (int64_t)x21 + 12555214 * (int64_t)y0 - 193709232 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817437886 * (int64_t)x20 + 384154421 * (int64_t)x21 - 56978473 * (int64_t)y0 + 11535817 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(384154421 * (int64_t)x22 + 817437886 * (int64_t)x23 + 12555214 * (int64_t)y1 - 193709232 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817437886 * (int64_t)x22 + 384154421 * (int64_t)x23 - 56978473 * (int64_t)y1 + 11535817 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(365831157 * (int64_t)x24 + 1398511873 * (int64_t)x25 + 33116086 * (int64_t)y0 - 76492263 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-699255936 * (int64_t)x24 + 182915578 * (int64_t)x25 + 285145860 * (int64_t)y0 + 56387995 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(365831157 * (int64_t)x26 + 1398511873 * (int64_t)x27 + 33116086 * (int64_t)y1 - 76492263 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-699255936 * (int64_t)x26 + 182915578 * (int64_t)x27 + 285145860 * (int64_t)y1 + 56387995 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128832401 * (int64_t)x28 + 958917470 * (int64_t)x29 + 17403523 * (int64_t)y0 + 98176687 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-958917470 * (int64_t)x28 + 128832401 * (int64_t)x29 - 11021925 * (int64_t)y0 - 54349021 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128832401 * (int64_t)x30 + 958917470 * (int64_t)x31 + 17403523 * (int64_t)y1 + 98176687 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-958917470 * (int64_t)x30 + 128832401 * (int64_t)x31 - 11021925 * (int64_t)y1 - 54349021 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-272575075 * (int64_t)x32 + 736554069 * (int64_t)x33 - 150096642 * (int64_t)y0 - 73674282 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-184138517 * (int64_t)x32 - 272575075 * (int64_t)x33 - 238973497 * (int64_t)y0 + 400143686 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-272575075 * (int64_t)x34 + 736554069 * (int64_t)x35 - 150096642 * (int64_t)y1 - 73674282 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-184138517 * (int64_t)x34 - 272575075 * (int64_t)x35 - 238973497 * (int64_t)y1 + 400143686 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142247981 * (int64_t)x36 + 1675679 * (int64_t)y0 - 2284620 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142247981 * (int64_t)x37 + 1675679 * (int64_t)y1 - 2284620 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 613931254 * (int64_t)e[0] + 516562752 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1172494691 * (int64_t)e[0] - 943691677 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 613931254 * (int64_t)e[1] + 516562752 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1172494691 * (int64_t)e[1] - 943691677 * (int64_t)e[3], 19);
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
        {864762932, 0, 326887168, 0, 76323027, 0, -7893710, 0},
        {-1041390452, 0, -101977668, 0, -64290979, 0, 37279987, 0},
        {0, 864762932, 0, 326887168, 0, 76323027, 0, -7893710},
        {0, -1041390452, 0, -101977668, 0, -64290979, 0, 37279987},
        {-1332287268, 0, -109116387, 0, -1253718, 0, 417085, 0},
        {-1357238735, 0, 528641954, 0, 4140202, 0, -1447864, 0},
        {0, -1332287268, 0, -109116387, 0, -1253718, 0, 417085},
        {0, -1357238735, 0, 528641954, 0, 4140202, 0, -1447864},
        {1323507962, 0, -734841981, 0, 545585, 0, -186315, 0},
        {751973538, 0, -438310098, 0, 2210879, 0, -769658, 0},
        {0, 1323507962, 0, -734841981, 0, 545585, 0, -186315},
        {0, 751973538, 0, -438310098, 0, 2210879, 0, -769658},
        {-627366437, 0, -559848117, 0, 1313005, 0, -452950, 0},
        {-1431150444, 0, -5884051, 0, -5180953, 0, 1803400, 0},
        {0, -627366437, 0, -559848117, 0, 1313005, 0, -452950},
        {0, -1431150444, 0, -5884051, 0, -5180953, 0, 1803400},
        {-746791015, 0, 952068212, 0, 643300, 0, -224653, 0},
        {761093977, 0, 1323780319, 0, -4268863, 0, 1483781, 0},
        {0, -746791015, 0, 952068212, 0, 643300, 0, -224653},
        {0, 761093977, 0, 1323780319, 0, -4268863, 0, 1483781},
        {-284762192, 0, -931334334, 0, -16342, 0, 9312, 0},
        {-331508034, 0, 1253398008, 0, 2985337, 0, -1034877, 0},
        {0, -284762192, 0, -931334334, 0, -16342, 0, 9312},
        {0, -331508034, 0, 1253398008, 0, 2985337, 0, -1034877},
        {1847951362, 0, 14563822, 0, -75800642, 0, 26454655, 0},
        {1624734484, 0, 513724761, 0, 103887, 0, -42616, 0},
        {0, 1847951362, 0, 14563822, 0, -75800642, 0, 26454655},
        {0, 1624734484, 0, 513724761, 0, 103887, 0, -42616},
        {281612617, 0, 1538006983, 0, 4480340, 0, -1585859, 0},
        {-261181382, 0, -1381798935, 0, -277671, 0, 89177, 0},
        {0, 281612617, 0, 1538006983, 0, 4480340, 0, -1585859},
        {0, -261181382, 0, -1381798935, 0, -277671, 0, 89177},
        {-758570538, 0, 435903483, 0, 5558340, 0, -1937810, 0},
        {-420060288, 0, 1235243588, 0, 16876191, 0, -5873730, 0},
        {0, -758570538, 0, 435903483, 0, 5558340, 0, -1937810},
        {0, -420060288, 0, 1235243588, 0, 16876191, 0, -5873730},
        {602972078, 0, -1198916033, 0, -18788177, 0, 6514662, 0},
        {0, 602972078, 0, -1198916033, 0, -18788177, 0, 6514662},
    };
    static const int16_t shift[38] = {
        25, 25, 25, 25, 34, 35, 34, 35, 37, 35, 37, 35, 33, 33, 33, 33, 34, 36, 34, 36, 33, 33, 33, 33, 34, 33, 34, 33, 36, 34, 36, 34, 32, 32, 32, 32, 41, 41};
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
