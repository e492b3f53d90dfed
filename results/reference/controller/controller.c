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
static const float paper_tool_f32_output_guard = 0x1.c9b6c2p23f;

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
        float u0 = 0x1.d0a0bcp-2f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.d3ec26p-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.64d6f6p9f * v; u2 += -0x1.93bb90p9f * v;
        v = x[5]; u0 += 0x1.f466bap7f * v; u2 += 0x1.ac5fb6p9f * v;
        v = x[8]; u0 += 0x1.14a922p10f * v; u2 += -0x1.da2060p11f * v;
        v = x[9]; u0 += -0x1.ef6248p9f * v; u2 += 0x1.56343ep10f * v;
        v = x[12]; u0 += 0x1.759164p10f * v; u2 += 0x1.173f6ep9f * v;
        v = x[13]; u0 += 0x1.66987ep7f * v; u2 += -0x1.d80682p9f * v;
        v = x[16]; u0 += 0x1.83978ap11f * v; u2 += -0x1.687508p11f * v;
        v = x[17]; u0 += 0x1.b1463ep9f * v; u2 += 0x1.1ef178p10f * v;
        v = x[20]; u0 += 0x1.1dda78p9f * v; u2 += -0x1.9d5192p9f * v;
        v = x[21]; u0 += -0x1.964e22p6f * v; u2 += -0x1.e91aa0p6f * v;
        v = x[24]; u0 += -0x1.34c0c2p8f * v; u2 += -0x1.832d02p5f * v;
        v = x[25]; u0 += -0x1.ee7c8cp2f * v; u2 += -0x1.3c143ap5f * v;
        v = x[28]; u0 += 0x1.8707e4p6f * v; u2 += -0x1.fd2192p8f * v;
        v = x[29]; u0 += -0x1.e2ca4ep9f * v; u2 += -0x1.48b9e8p6f * v;
        v = x[32]; u0 += 0x1.f3b4c0p7f * v; u2 += -0x1.46098ap7f * v;
        v = x[33]; u0 += -0x1.17bf02p7f * v; u2 += 0x1.14ffeep7f * v;
        v = x[36]; u0 += -0x1.da9ddep4f * v; u2 += 0x1.7a4b92p5f * v;
        v = y0; u0 += -0x1.c9a072p19f * v; u2 += 0x1.953628p19f * v;
        v = y2; u0 += 0x1.f16260p16f * v; u2 += -0x1.65f25ap18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.d0a0bcp-2f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.d3ec26p-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.64d6f6p9f * v; u3 += -0x1.93bb90p9f * v;
        v = x[7]; u1 += 0x1.f466bap7f * v; u3 += 0x1.ac5fb6p9f * v;
        v = x[10]; u1 += 0x1.14a922p10f * v; u3 += -0x1.da2060p11f * v;
        v = x[11]; u1 += -0x1.ef6248p9f * v; u3 += 0x1.56343ep10f * v;
        v = x[14]; u1 += 0x1.759164p10f * v; u3 += 0x1.173f6ep9f * v;
        v = x[15]; u1 += 0x1.66987ep7f * v; u3 += -0x1.d80682p9f * v;
        v = x[18]; u1 += 0x1.83978ap11f * v; u3 += -0x1.687508p11f * v;
        v = x[19]; u1 += 0x1.b1463ep9f * v; u3 += 0x1.1ef178p10f * v;
        v = x[22]; u1 += 0x1.1dda78p9f * v; u3 += -0x1.9d5192p9f * v;
        v = x[23]; u1 += -0x1.964e22p6f * v; u3 += -0x1.e91aa0p6f * v;
        v = x[26]; u1 += -0x1.34c0c2p8f * v; u3 += -0x1.832d02p5f * v;
        v = x[27]; u1 += -0x1.ee7c8cp2f * v; u3 += -0x1.3c143ap5f * v;
        v = x[30]; u1 += 0x1.8707e4p6f * v; u3 += -0x1.fd2192p8f * v;
        v = x[31]; u1 += -0x1.e2ca4ep9f * v; u3 += -0x1.48b9e8p6f * v;
        v = x[34]; u1 += 0x1.f3b4c0p7f * v; u3 += -0x1.46098ap7f * v;
        v = x[35]; u1 += -0x1.17bf02p7f * v; u3 += 0x1.14ffeep7f * v;
        v = x[37]; u1 += -0x1.da9ddep4f * v; u3 += 0x1.7a4b92p5f * v;
        v = y1; u1 += -0x1.c9a072p19f * v; u3 += 0x1.953628p19f * v;
        v = y3; u1 += 0x1.f16260p16f * v; u3 += -0x1.65f25ap18f * v;
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
        x[0] = -0x1.5efdb4p-10f * x0 + 0x1.a988a0p7f * y0 - 0x1.001704p7f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.2806ecp-9f * x1 - 0x1.4190e6p8f * y0 - 0x1.b78f58p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.5efdb4p-10f * x2 + 0x1.a988a0p7f * y1 - 0x1.001704p7f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.2806ecp-9f * x3 - 0x1.4190e6p8f * y1 - 0x1.b78f58p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.21cb42p-4f * x4 + 0x1.3e56e0p-2f * x5 - 0x1.285c1ap5f * y0 + 0x1.3129e4p4f * y2
            + x4;
        x[5] = -0x1.3e56e0p-2f * x4 - 0x1.21cb42p-4f * x5 + 0x1.af9726p5f * y0 - 0x1.8fdc66p2f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.21cb42p-4f * x6 + 0x1.3e56e0p-2f * x7 - 0x1.285c1ap5f * y1 + 0x1.3129e4p4f * y3
            + x6;
        x[7] = -0x1.3e56e0p-2f * x6 - 0x1.21cb42p-4f * x7 + 0x1.af9726p5f * y1 - 0x1.8fdc66p2f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.22a37cp-3f * x8 + 0x1.df4e2ap-2f * x9 - 0x1.1f50d0p5f * y0 + 0x1.11b184p4f * y2
            + x8;
        x[9] = -0x1.df4e2ap-2f * x8 - 0x1.22a37cp-3f * x9 + 0x1.959b9ap4f * y0 - 0x1.48599cp4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.22a37cp-3f * x10 + 0x1.df4e2ap-2f * x11 - 0x1.1f50d0p5f * y1 + 0x1.11b184p4f * y3
            + x10;
        x[11] = -0x1.df4e2ap-2f * x10 - 0x1.22a37cp-3f * x11 + 0x1.959b9ap4f * y1 - 0x1.48599cp4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.7001fcp-1f * x12 + 0x1.03be6cp-1f * x13 - 0x1.00b7e8p8f * y0 + 0x1.44bb18p5f * y2;
        x[13] = -0x1.03be6cp-1f * x12 + 0x1.7001fcp-1f * x13 + 0x1.377604p8f * y0 + 0x1.0a34eep7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.7001fcp-1f * x14 + 0x1.03be6cp-1f * x15 - 0x1.00b7e8p8f * y1 + 0x1.44bb18p5f * y3;
        x[15] = -0x1.03be6cp-1f * x14 + 0x1.7001fcp-1f * x15 + 0x1.377604p8f * y1 + 0x1.0a34eep7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.2982aep-1f * x16 + 0x1.7a30f0p-1f * x17 + 0x1.bf6b56p5f * y0 + 0x1.670c28p4f * y2;
        x[17] = -0x1.7a30f0p-1f * x16 + 0x1.2982aep-1f * x17 + 0x1.d17950p6f * y0 - 0x1.73e7cap7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.2982aep-1f * x18 + 0x1.7a30f0p-1f * x19 + 0x1.bf6b56p5f * y1 + 0x1.670c28p4f * y3;
        x[19] = -0x1.7a30f0p-1f * x18 + 0x1.2982aep-1f * x19 + 0x1.d17950p6f * y1 - 0x1.73e7cap7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.5fe0cap-2f * x20 + 0x1.8ca2bcp-1f * x21 - 0x1.342d98p3f * y0 - 0x1.864776p9f * y2;
        x[21] = -0x1.8ca2bcp-1f * x20 + 0x1.5fe0cap-2f * x21 - 0x1.544c2ap4f * y0 + 0x1.4d6beep7f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.5fe0cap-2f * x22 + 0x1.8ca2bcp-1f * x23 - 0x1.342d98p3f * y1 - 0x1.864776p9f * y3;
        x[23] = -0x1.8ca2bcp-1f * x22 + 0x1.5fe0cap-2f * x23 - 0x1.544c2ap4f * y1 + 0x1.4d6beep7f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.982982p-3f * x24 + 0x1.3aa936p-1f * x25 - 0x1.9db412p9f * y0 - 0x1.bd5278p7f * y2;
        x[25] = -0x1.3aa936p-1f * x24 + 0x1.982982p-3f * x25 + 0x1.94b760p8f * y0 + 0x1.5e4d5ap6f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.982982p-3f * x26 + 0x1.3aa936p-1f * x27 - 0x1.9db412p9f * y1 - 0x1.bd5278p7f * y3;
        x[27] = -0x1.3aa936p-1f * x26 + 0x1.982982p-3f * x27 + 0x1.94b760p8f * y1 + 0x1.5e4d5ap6f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e2bd20p-4f * x28 + 0x1.d13d02p-1f * x29 + 0x1.39b84cp6f * y0 + 0x1.ccea14p6f * y2;
        x[29] = -0x1.d13d02p-1f * x28 + 0x1.e2bd20p-4f * x29 + 0x1.21a3c0p3f * y0 + 0x1.3190f0p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e2bd20p-4f * x30 + 0x1.d13d02p-1f * x31 + 0x1.39b84cp6f * y1 + 0x1.ccea14p6f * y3;
        x[31] = -0x1.d13d02p-1f * x30 + 0x1.e2bd20p-4f * x31 + 0x1.21a3c0p3f * y1 + 0x1.3190f0p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.9a0ccep-3f * x32 + 0x1.273cf4p-3f * x33 - 0x1.f8e246p8f * y0 + 0x1.4273acp10f * y2;
        x[33] = -0x1.273cf4p-1f * x32 - 0x1.9a0ccep-3f * x33 + 0x1.75da4ap9f * y0 - 0x1.d25892p9f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.9a0ccep-3f * x34 + 0x1.273cf4p-3f * x35 - 0x1.f8e246p8f * y1 + 0x1.4273acp10f * y3;
        x[35] = -0x1.273cf4p-1f * x34 - 0x1.9a0ccep-3f * x35 + 0x1.75da4ap9f * y1 - 0x1.d25892p9f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.feb0eep-1f * x36 + 0x1.8d3a62p1f * y0 - 0x1.14d2fep2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.feb0eep-1f * x37 + 0x1.8d3a62p1f * y1 - 0x1.14d2fep2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += -0x1.027aa0p-4f * e[0];
        x[0] += 0x1.1292d8p-5f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.f74eccp-5f * e[0];
        x[1] += -0x1.66e156p-6f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.027aa0p-4f * e[1];
        x[2] += 0x1.1292d8p-5f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.f74eccp-5f * e[1];
        x[3] += -0x1.66e156p-6f * e[3];
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
        {-0x1.c8ebfep17f, 0.0f, 0x1.6b4694p14f, 0.0f, -0x1.882c70p0f, 0.0f, 0x1.0c0cacp-1f, 0.0f},
        {0x1.8bb5b2p17f, 0.0f, 0x1.48c14ep13f, 0.0f, 0x1.905b74p0f, 0.0f, -0x1.9348c2p-3f, 0.0f},
        {0.0f, -0x1.c8ebfep17f, 0.0f, 0x1.6b4694p14f, 0.0f, -0x1.882c70p0f, 0.0f, 0x1.0c0cacp-1f},
        {0.0f, 0x1.8bb5b2p17f, 0.0f, 0x1.48c14ep13f, 0.0f, 0x1.905b74p0f, 0.0f, -0x1.9348c2p-3f},
        {0x1.14e1cap7f, 0.0f, -0x1.585d90p2f, 0.0f, -0x1.b084aap-18f, 0.0f, 0x1.9670eap-20f, 0.0f},
        {0x1.2b7f44p7f, 0.0f, -0x1.f5ce74p5f, 0.0f, -0x1.07c602p-17f, 0.0f, 0x1.cb1374p-20f, 0.0f},
        {0.0f, 0x1.14e1cap7f, 0.0f, -0x1.585d90p2f, 0.0f, -0x1.b084aap-18f, 0.0f, 0x1.9670eap-20f},
        {0.0f, 0x1.2b7f44p7f, 0.0f, -0x1.f5ce74p5f, 0.0f, -0x1.07c602p-17f, 0.0f, 0x1.cb1374p-20f},
        {0x1.c8ad50p4f, 0.0f, -0x1.df4c12p4f, 0.0f, 0x1.c813a4p-20f, 0.0f, -0x1.84833ep-22f, 0.0f},
        {0x1.59c058p6f, 0.0f, -0x1.6be2d2p5f, 0.0f, 0x1.0955b0p-17f, 0.0f, -0x1.c89ae8p-20f, 0.0f},
        {0.0f, 0x1.c8ad50p4f, 0.0f, -0x1.df4c12p4f, 0.0f, 0x1.c813a4p-20f, 0.0f, -0x1.84833ep-22f},
        {0.0f, 0x1.59c058p6f, 0.0f, -0x1.6be2d2p5f, 0.0f, 0x1.0955b0p-17f, 0.0f, -0x1.c89ae8p-20f},
        {0x1.fdf352p7f, 0.0f, 0x1.d3c86ep7f, 0.0f, 0x1.029444p-20f, 0.0f, -0x1.8ed1a0p-22f, 0.0f},
        {0x1.4889e8p9f, 0.0f, 0x1.998096p5f, 0.0f, 0x1.1d013ep-14f, 0.0f, -0x1.ebe098p-17f, 0.0f},
        {0.0f, 0x1.fdf352p7f, 0.0f, 0x1.d3c86ep7f, 0.0f, 0x1.029444p-20f, 0.0f, -0x1.8ed1a0p-22f},
        {0.0f, 0x1.4889e8p9f, 0.0f, 0x1.998096p5f, 0.0f, 0x1.1d013ep-14f, 0.0f, -0x1.ebe098p-17f},
        {0x1.2d9c70p7f, 0.0f, -0x1.630eacp7f, 0.0f, -0x1.a4059ap-18f, 0.0f, 0x1.6b8aa4p-20f, 0.0f},
        {0x1.5c12d6p3f, 0.0f, -0x1.05ca06p7f, 0.0f, 0x1.02335cp-18f, 0.0f, -0x1.b71e48p-21f, 0.0f},
        {0.0f, 0x1.2d9c70p7f, 0.0f, -0x1.630eacp7f, 0.0f, -0x1.a4059ap-18f, 0.0f, 0x1.6b8aa4p-20f},
        {0.0f, 0x1.5c12d6p3f, 0.0f, -0x1.05ca06p7f, 0.0f, 0x1.02335cp-18f, 0.0f, -0x1.b71e48p-21f},
        {-0x1.980a9cp4f, 0.0f, -0x1.738ddcp8f, 0.0f, -0x1.a149d4p-16f, 0.0f, 0x1.7048bap-18f, 0.0f},
        {-0x1.7e8194p-2f, 0.0f, 0x1.5af716p9f, 0.0f, 0x1.54dc00p-15f, 0.0f, -0x1.21f1bcp-17f, 0.0f},
        {0.0f, -0x1.980a9cp4f, 0.0f, -0x1.738ddcp8f, 0.0f, -0x1.a149d4p-16f, 0.0f, 0x1.7048bap-18f},
        {0.0f, -0x1.7e8194p-2f, 0.0f, 0x1.5af716p9f, 0.0f, 0x1.54dc00p-15f, 0.0f, -0x1.21f1bcp-17f},
        {-0x1.d80baap8f, -0.0f, -0x1.f7c6b4p6f, 0.0f, -0x1.ee5a64p-12f, -0.0f, 0x1.ae7240p-14f, 0.0f},
        {0x1.78941cp9f, 0.0f, 0x1.87d8fcp7f, 0.0f, -0x1.d8ef78p-12f, 0.0f, 0x1.9876ccp-14f, 0.0f},
        {0.0f, -0x1.d80baap8f, 0.0f, -0x1.f7c6b4p6f, 0.0f, -0x1.ee5a64p-12f, 0.0f, 0x1.ae7240p-14f},
        {0.0f, 0x1.78941cp9f, 0.0f, 0x1.87d8fcp7f, 0.0f, -0x1.d8ef78p-12f, 0.0f, 0x1.9876ccp-14f},
        {0x1.801a86p5f, 0.0f, 0x1.2c0c02p7f, 0.0f, -0x1.0cd338p-19f, 0.0f, 0x1.ebffacp-22f, 0.0f},
        {-0x1.296a34p5f, 0.0f, 0x1.2d2822p4f, 0.0f, 0x1.137232p-16f, 0.0f, -0x1.e16fdap-19f, 0.0f},
        {0.0f, 0x1.801a86p5f, 0.0f, 0x1.2c0c02p7f, 0.0f, -0x1.0cd338p-19f, 0.0f, 0x1.ebffacp-22f},
        {0.0f, -0x1.296a34p5f, 0.0f, 0x1.2d2822p4f, 0.0f, 0x1.137232p-16f, 0.0f, -0x1.e16fdap-19f},
        {-0x1.feaa30p7f, 0.0f, 0x1.d5e90ap9f, 0.0f, 0x1.048ab0p-11f, 0.0f, -0x1.be4ac4p-14f, 0.0f},
        {0x1.752a62p9f, 0.0f, -0x1.331c94p10f, 0.0f, -0x1.eb0784p-13f, 0.0f, 0x1.a4a34cp-15f, 0.0f},
        {0.0f, -0x1.feaa30p7f, 0.0f, 0x1.d5e90ap9f, 0.0f, 0x1.048ab0p-11f, 0.0f, -0x1.be4ac4p-14f},
        {0.0f, 0x1.752a62p9f, 0.0f, -0x1.331c94p10f, 0.0f, -0x1.eb0784p-13f, 0.0f, 0x1.a4a34cp-15f},
        {0x1.5b5e54p0f, 0.0f, -0x1.19d19cp1f, 0.0f, -0x1.6c5210p-20f, -0.0f, 0x1.379206p-22f, 0.0f},
        {0.0f, 0x1.5b5e54p0f, 0.0f, -0x1.19d19cp1f, 0.0f, -0x1.6c5210p-20f, 0.0f, 0x1.379206p-22f},
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
/* Over the test vectors Q31 stays within 5.669e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 79296 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 159718 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += -124724510 * (int64_t)v; u2 += -70557400 * (int64_t)v;
        v = x[5]; u0 += 43725730 * (int64_t)v; u2 += 74863761 * (int64_t)v;
        v = x[8]; u0 += 193399832 * (int64_t)v; u2 += -331438426 * (int64_t)v;
        v = x[9]; u0 += -173149228 * (int64_t)v; u2 += 119608996 * (int64_t)v;
        v = x[12]; u0 += 261142920 * (int64_t)v; u2 += 48802084 * (int64_t)v;
        v = x[13]; u0 += 31334569 * (int64_t)v; u2 += -82492423 * (int64_t)v;
        v = x[16]; u0 += 541892822 * (int64_t)v; u2 += -251977815 * (int64_t)v;
        v = x[17]; u0 += 151440376 * (int64_t)v; u2 += 100293934 * (int64_t)v;
        v = x[20]; u0 += 99913003 * (int64_t)v; u2 += -72232667 * (int64_t)v;
        v = x[21]; u0 += -17751745 * (int64_t)v; u2 += -10684640 * (int64_t)v;
        v = x[24]; u0 += -53958493 * (int64_t)v; u2 += -4228992 * (int64_t)v;
        v = x[25]; u0 += -1350278 * (int64_t)v; u2 += -3452426 * (int64_t)v;
        v = x[28]; u0 += 17084397 * (int64_t)v; u2 += -44488557 * (int64_t)v;
        v = x[29]; u0 += -168747424 * (int64_t)v; u2 += -7181133 * (int64_t)v;
        v = x[32]; u0 += 43664981 * (int64_t)v; u2 += -14244786 * (int64_t)v;
        v = x[33]; u0 += -24444590 * (int64_t)v; u2 += 12102303 * (int64_t)v;
        v = x[36]; u0 += -5184080 * (int64_t)v; u2 += 4131992 * (int64_t)v;
        v = y0; u0 += -41602912 * (int64_t)v; u2 += 18418919 * (int64_t)v;
        v = y2; u0 += 5652159 * (int64_t)v; u2 += -8135246 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 79296 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 159718 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += -124724510 * (int64_t)v; u3 += -70557400 * (int64_t)v;
        v = x[7]; u1 += 43725730 * (int64_t)v; u3 += 74863761 * (int64_t)v;
        v = x[10]; u1 += 193399832 * (int64_t)v; u3 += -331438426 * (int64_t)v;
        v = x[11]; u1 += -173149228 * (int64_t)v; u3 += 119608996 * (int64_t)v;
        v = x[14]; u1 += 261142920 * (int64_t)v; u3 += 48802084 * (int64_t)v;
        v = x[15]; u1 += 31334569 * (int64_t)v; u3 += -82492423 * (int64_t)v;
        v = x[18]; u1 += 541892822 * (int64_t)v; u3 += -251977815 * (int64_t)v;
        v = x[19]; u1 += 151440376 * (int64_t)v; u3 += 100293934 * (int64_t)v;
        v = x[22]; u1 += 99913003 * (int64_t)v; u3 += -72232667 * (int64_t)v;
        v = x[23]; u1 += -17751745 * (int64_t)v; u3 += -10684640 * (int64_t)v;
        v = x[26]; u1 += -53958493 * (int64_t)v; u3 += -4228992 * (int64_t)v;
        v = x[27]; u1 += -1350278 * (int64_t)v; u3 += -3452426 * (int64_t)v;
        v = x[30]; u1 += 17084397 * (int64_t)v; u3 += -44488557 * (int64_t)v;
        v = x[31]; u1 += -168747424 * (int64_t)v; u3 += -7181133 * (int64_t)v;
        v = x[34]; u1 += 43664981 * (int64_t)v; u3 += -14244786 * (int64_t)v;
        v = x[35]; u1 += -24444590 * (int64_t)v; u3 += 12102303 * (int64_t)v;
        v = x[37]; u1 += -5184080 * (int64_t)v; u3 += 4131992 * (int64_t)v;
        v = y1; u1 += -41602912 * (int64_t)v; u3 += 18418919 * (int64_t)v;
        v = y3; u1 += 5652159 * (int64_t)v; u3 += -8135246 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1437659 * (int64_t)x0 + 58027994 * (int64_t)y0 - 34921755 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2425053 * (int64_t)x1 - 87700831 * (int64_t)y0 - 119881368 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1437659 * (int64_t)x2 + 58027994 * (int64_t)y1 - 34921755 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2425053 * (int64_t)x3 - 87700831 * (int64_t)y1 - 119881368 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-75967752 * (int64_t)x4 + 333803015 * (int64_t)x5 - 10103291 * (int64_t)y0 + 5201713 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-333803015 * (int64_t)x4 - 75967752 * (int64_t)x5 + 14713480 * (int64_t)y0 - 1703972 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-75967752 * (int64_t)x6 + 333803015 * (int64_t)x7 - 10103291 * (int64_t)y1 + 5201713 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-333803015 * (int64_t)x6 - 75967752 * (int64_t)x7 + 14713480 * (int64_t)y1 - 1703972 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-152378331 * (int64_t)x8 + 502588068 * (int64_t)x9 - 9794966 * (int64_t)y0 + 4665283 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-502588068 * (int64_t)x8 - 152378331 * (int64_t)x9 + 6913849 * (int64_t)y0 - 5596940 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-152378331 * (int64_t)x10 + 502588068 * (int64_t)x11 - 9794966 * (int64_t)y1 + 4665283 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-502588068 * (int64_t)x10 - 152378331 * (int64_t)x11 + 6913849 * (int64_t)y1 - 5596940 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(771768189 * (int64_t)x12 + 544722283 * (int64_t)x13 - 70014912 * (int64_t)y0 + 11070497 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-544722283 * (int64_t)x12 + 771768189 * (int64_t)x13 + 84944888 * (int64_t)y0 + 36301341 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(771768189 * (int64_t)x14 + 544722283 * (int64_t)x15 - 70014912 * (int64_t)y1 + 11070497 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-544722283 * (int64_t)x14 + 771768189 * (int64_t)x15 + 84944888 * (int64_t)y1 + 36301341 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(623924686 * (int64_t)x16 + 793124370 * (int64_t)x17 + 15253107 * (int64_t)y0 + 6120198 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-793124370 * (int64_t)x16 + 623924686 * (int64_t)x17 + 31737221 * (int64_t)y0 - 50714961 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(623924686 * (int64_t)x18 + 793124370 * (int64_t)x19 + 15253107 * (int64_t)y1 + 6120198 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-793124370 * (int64_t)x18 + 623924686 * (int64_t)x19 + 31737221 * (int64_t)y1 - 50714961 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(368970906 * (int64_t)x20 + 831805290 * (int64_t)x21 - 2626548 * (int64_t)y0 - 212881997 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-831805290 * (int64_t)x20 + 368970906 * (int64_t)x21 - 5800593 * (int64_t)y0 + 45467105 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(368970906 * (int64_t)x22 + 831805290 * (int64_t)x23 - 2626548 * (int64_t)y1 - 212881997 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-831805290 * (int64_t)x22 + 368970906 * (int64_t)x23 - 5800593 * (int64_t)y1 + 45467105 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(213994507 * (int64_t)x24 + 659891878 * (int64_t)x25 - 225659004 * (int64_t)y0 - 60726447 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-1319783756 * (int64_t)x24 + 427989013 * (int64_t)x25 + 220756906 * (int64_t)y0 + 47769028 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(213994507 * (int64_t)x26 + 659891878 * (int64_t)x27 - 225659004 * (int64_t)y1 - 60726447 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-1319783756 * (int64_t)x26 + 427989013 * (int64_t)x27 + 220756906 * (int64_t)y1 + 47769028 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(126547074 * (int64_t)x28 + 975675458 * (int64_t)x29 + 21390242 * (int64_t)y0 + 31426343 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-975675458 * (int64_t)x28 + 126547074 * (int64_t)x29 + 2468548 * (int64_t)y0 + 41668592 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(126547074 * (int64_t)x30 + 975675458 * (int64_t)x31 + 21390242 * (int64_t)y1 + 31426343 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-975675458 * (int64_t)x30 + 126547074 * (int64_t)x31 + 2468548 * (int64_t)y1 + 41668592 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-429968611 * (int64_t)x32 + 309579573 * (int64_t)x33 - 275394390 * (int64_t)y0 + 703539393 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-619159145 * (int64_t)x32 - 214984306 * (int64_t)x33 + 203922007 * (int64_t)y0 - 254373473 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-429968611 * (int64_t)x34 + 309579573 * (int64_t)x35 - 275394390 * (int64_t)y1 + 703539393 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-619159145 * (int64_t)x34 - 214984306 * (int64_t)x35 + 203922007 * (int64_t)y1 - 254373473 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2141993846 * (int64_t)x36 + 1692753 * (int64_t)y0 - 2359324 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2141993846 * (int64_t)x37 + 1692753 * (int64_t)y1 - 2359324 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], -813104620 * (int64_t)e[0] + 431866962 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], 791634730 * (int64_t)e[0] - 282234896 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], -813104620 * (int64_t)e[1] + 431866962 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], 791634730 * (int64_t)e[1] - 282234896 * (int64_t)e[3], 19);
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
        {-996931936, 0, 99076334, 0, -77104466, 0, 26350339, 0},
        {1726753431, 0, 89661513, 0, 157426873, 0, -19822225, 0},
        {0, -996931936, 0, 99076334, 0, -77104466, 0, 26350339},
        {0, 1726753431, 0, 89661513, 0, 157426873, 0, -19822225},
        {1208226215, 0, -46959471, 0, -664348, 0, 156073, 0},
        {1306911720, 0, -547431544, 0, -810312, 0, 176285, 0},
        {0, 1208226215, 0, -46959471, 0, -664348, 0, 156073},
        {0, 1306911720, 0, -547431544, 0, -810312, 0, 176285},
        {996397691, 0, -1045751329, 0, 700534, 0, -149189, 0},
        {754375251, 0, -396971163, 0, 815108, 0, -175336, 0},
        {0, 996397691, 0, -1045751329, 0, 700534, 0, -149189},
        {0, 754375251, 0, -396971163, 0, 815108, 0, -175336},
        {1112632036, 0, 1020629107, 0, 49647, 0, -19143, 0},
        {1433640023, 0, 111683731, 0, 1751070, 0, -377762, 0},
        {0, 1112632036, 0, 1020629107, 0, 49647, 0, -19143},
        {0, 1433640023, 0, 111683731, 0, 1751070, 0, -377762},
        {658068174, 0, -774679458, 0, -322577, 0, 69800, 0},
        {94930257, 0, -1142365824, 0, 396596, 0, -84311, 0},
        {0, 658068174, 0, -774679458, 0, -322577, 0, 69800},
        {0, 94930257, 0, -1142365824, 0, 396596, 0, -84311},
        {-111285317, 0, -1621345921, 0, -1281910, 0, 282842, 0},
        {-815008, 0, 1514047360, 0, 1047120, 0, -222677, 0},
        {0, -111285317, 0, -1621345921, 0, -1281910, 0, 282842},
        {0, -815008, 0, 1514047360, 0, 1047120, 0, -222677},
        {-1029929497, 0, -274790178, 0, -12149221, 0, 2644662, 0},
        {1643270908, 0, 427475035, 0, -11622861, 0, 2509603, 0},
        {0, -1029929497, 0, -274790178, 0, -12149221, 0, 2644662},
        {0, 1643270908, 0, 427475035, 0, -11622861, 0, 2509603},
        {419026952, 0, 1309310668, 0, -206458, 0, 47232, 0},
        {-1297825317, 0, 657076890, 0, 6769363, 0, -1478974, 0},
        {0, 419026952, 0, 1309310668, 0, -206458, 0, 47232},
        {0, -1297825317, 0, 657076890, 0, 6769363, 0, -1478974},
        {-278547651, 0, 1025270728, 0, 6403074, 0, -1371009, 0},
        {407094406, 0, -670069505, 0, -1508442, 0, 323050, 0},
        {0, -278547651, 0, 1025270728, 0, 6403074, 0, -1371009},
        {0, 407094406, 0, -670069505, 0, -1508442, 0, 323050},
        {757903594, 0, -1229768957, 0, -8953542, 0, 1914289, 0},
        {0, 757903594, 0, -1229768957, 0, -8953542, 0, 1914289},
    };
    static const int16_t shift[38] = {
        24, 25, 24, 25, 35, 35, 35, 35, 37, 35, 37, 35, 34, 33, 34, 33, 34, 35, 34, 35, 34, 33, 34, 33, 33, 33, 33, 33, 35, 37, 35, 37, 32, 31, 32, 31, 41, 41};
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
