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
static const float paper_tool_f32_output_guard = 0x1.d02bcap23f;

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
        float u0 = 0x1.f5d9aap-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.cb6a06p-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.914986p9f * v; u2 += 0x1.cfb284p9f * v;
        v = x[5]; u0 += -0x1.6007b6p6f * v; u2 += -0x1.ac54fap9f * v;
        v = x[8]; u0 += 0x1.ef4b7cp9f * v; u2 += -0x1.c51f3ap11f * v;
        v = x[9]; u0 += -0x1.781868p9f * v; u2 += 0x1.5c6534p10f * v;
        v = x[12]; u0 += -0x1.a54880p10f * v; u2 += -0x1.1aeeb8p9f * v;
        v = x[13]; u0 += -0x1.80d762p8f * v; u2 += 0x1.f1961ap9f * v;
        v = x[16]; u0 += -0x1.cfadfap11f * v; u2 += 0x1.37ea0ap11f * v;
        v = x[17]; u0 += 0x1.38dc5ap4f * v; u2 += -0x1.cfd6f0p10f * v;
        v = x[20]; u0 += 0x1.3fe708p9f * v; u2 += -0x1.89c2c2p9f * v;
        v = x[21]; u0 += -0x1.84b140p5f * v; u2 += -0x1.33b03ep8f * v;
        v = x[24]; u0 += -0x1.2bb208p6f * v; u2 += -0x1.0d7dd2p5f * v;
        v = x[25]; u0 += 0x1.29dec6p8f * v; u2 += 0x1.ce0522p0f * v;
        v = x[28]; u0 += -0x1.d451cep8f * v; u2 += -0x1.0793a2p7f * v;
        v = x[29]; u0 += -0x1.198fa6p7f * v; u2 += 0x1.c94764p7f * v;
        v = x[32]; u0 += 0x1.82c72cp6f * v; u2 += -0x1.44c994p6f * v;
        v = x[33]; u0 += 0x1.7124f8p8f * v; u2 += -0x1.bd7032p7f * v;
        v = x[36]; u0 += -0x1.ce3a4ep4f * v; u2 += 0x1.6e5034p5f * v;
        v = y0; u0 += -0x1.01b44ap20f * v; u2 += 0x1.ac8b96p19f * v;
        v = y2; u0 += 0x1.1e5fe6p16f * v; u2 += -0x1.0ac760p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.f5d9aap-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.cb6a06p-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.914986p9f * v; u3 += 0x1.cfb284p9f * v;
        v = x[7]; u1 += -0x1.6007b6p6f * v; u3 += -0x1.ac54fap9f * v;
        v = x[10]; u1 += 0x1.ef4b7cp9f * v; u3 += -0x1.c51f3ap11f * v;
        v = x[11]; u1 += -0x1.781868p9f * v; u3 += 0x1.5c6534p10f * v;
        v = x[14]; u1 += -0x1.a54880p10f * v; u3 += -0x1.1aeeb8p9f * v;
        v = x[15]; u1 += -0x1.80d762p8f * v; u3 += 0x1.f1961ap9f * v;
        v = x[18]; u1 += -0x1.cfadfap11f * v; u3 += 0x1.37ea0ap11f * v;
        v = x[19]; u1 += 0x1.38dc5ap4f * v; u3 += -0x1.cfd6f0p10f * v;
        v = x[22]; u1 += 0x1.3fe708p9f * v; u3 += -0x1.89c2c2p9f * v;
        v = x[23]; u1 += -0x1.84b140p5f * v; u3 += -0x1.33b03ep8f * v;
        v = x[26]; u1 += -0x1.2bb208p6f * v; u3 += -0x1.0d7dd2p5f * v;
        v = x[27]; u1 += 0x1.29dec6p8f * v; u3 += 0x1.ce0522p0f * v;
        v = x[30]; u1 += -0x1.d451cep8f * v; u3 += -0x1.0793a2p7f * v;
        v = x[31]; u1 += -0x1.198fa6p7f * v; u3 += 0x1.c94764p7f * v;
        v = x[34]; u1 += 0x1.82c72cp6f * v; u3 += -0x1.44c994p6f * v;
        v = x[35]; u1 += 0x1.7124f8p8f * v; u3 += -0x1.bd7032p7f * v;
        v = x[37]; u1 += -0x1.ce3a4ep4f * v; u3 += 0x1.6e5034p5f * v;
        v = y1; u1 += -0x1.01b44ap20f * v; u3 += 0x1.ac8b96p19f * v;
        v = y3; u1 += 0x1.1e5fe6p16f * v; u3 += -0x1.0ac760p18f * v;
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
        x[0] = -0x1.748578p-10f * x0 + 0x1.78c176p7f * y0 - 0x1.b57814p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.289810p-9f * x1 - 0x1.468bacp8f * y0 - 0x1.f4cbfap8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.748578p-10f * x2 + 0x1.78c176p7f * y1 - 0x1.b57814p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.289810p-9f * x3 - 0x1.468bacp8f * y1 - 0x1.f4cbfap8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.35d18ep-4f * x4 + 0x1.3d5278p-2f * x5 + 0x1.2a3cecp5f * y0 - 0x1.32a5a0p4f * y2
            + x4;
        x[5] = -0x1.3d5278p-2f * x4 - 0x1.35d18ep-4f * x5 - 0x1.ab3a6ap5f * y0 + 0x1.27b3c0p1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.35d18ep-4f * x6 + 0x1.3d5278p-2f * x7 + 0x1.2a3cecp5f * y1 - 0x1.32a5a0p4f * y3
            + x6;
        x[7] = -0x1.3d5278p-2f * x6 - 0x1.35d18ep-4f * x7 - 0x1.ab3a6ap5f * y1 + 0x1.27b3c0p1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1d35aep-3f * x8 + 0x1.e07750p-2f * x9 - 0x1.01f552p5f * y0 + 0x1.488266p4f * y2
            + x8;
        x[9] = -0x1.e07750p-2f * x8 - 0x1.1d35aep-3f * x9 + 0x1.ab7dc8p4f * y0 - 0x1.35cb96p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1d35aep-3f * x10 + 0x1.e07750p-2f * x11 - 0x1.01f552p5f * y1 + 0x1.488266p4f * y3
            + x10;
        x[11] = -0x1.e07750p-2f * x10 - 0x1.1d35aep-3f * x11 + 0x1.ab7dc8p4f * y1 - 0x1.35cb96p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6a4e04p-1f * x12 + 0x1.06f436p-1f * x13 + 0x1.06c72ep8f * y0 - 0x1.930ca8p5f * y2;
        x[13] = -0x1.06f436p-1f * x12 + 0x1.6a4e04p-1f * x13 - 0x1.2675cap8f * y0 - 0x1.1d0f02p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6a4e04p-1f * x14 + 0x1.06f436p-1f * x15 + 0x1.06c72ep8f * y1 - 0x1.930ca8p5f * y3;
        x[15] = -0x1.06f436p-1f * x14 + 0x1.6a4e04p-1f * x15 - 0x1.2675cap8f * y1 - 0x1.1d0f02p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.26da34p-1f * x16 + 0x1.7aad4ap-1f * x17 - 0x1.694570p6f * y0 + 0x1.fbde5cp4f * y2;
        x[17] = -0x1.7aad4ap-1f * x16 + 0x1.26da34p-1f * x17 - 0x1.99d804p6f * y0 + 0x1.6ffc64p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.26da34p-1f * x18 + 0x1.7aad4ap-1f * x19 - 0x1.694570p6f * y1 + 0x1.fbde5cp4f * y3;
        x[19] = -0x1.7aad4ap-1f * x18 + 0x1.26da34p-1f * x19 - 0x1.99d804p6f * y1 + 0x1.6ffc64p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.68ada2p-2f * x20 + 0x1.89b706p-1f * x21 + 0x1.3c1626p3f * y0 - 0x1.7dcf14p9f * y2;
        x[21] = -0x1.89b706p-1f * x20 + 0x1.68ada2p-2f * x21 - 0x1.ed9a34p6f * y0 + 0x1.a89f6cp6f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.68ada2p-2f * x22 + 0x1.89b706p-1f * x23 + 0x1.3c1626p3f * y1 - 0x1.7dcf14p9f * y3;
        x[23] = -0x1.89b706p-1f * x22 + 0x1.68ada2p-2f * x23 - 0x1.ed9a34p6f * y1 + 0x1.a89f6cp6f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.70d7c4p-3f * x24 + 0x1.453cacp0f * x25 - 0x1.c7639ap2f * y0 - 0x1.7a74a8p7f * y2;
        x[25] = -0x1.453cacp-2f * x24 + 0x1.70d7c4p-3f * x25 + 0x1.ed2288p9f * y0 + 0x1.172892p8f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.70d7c4p-3f * x26 + 0x1.453cacp0f * x27 - 0x1.c7639ap2f * y1 - 0x1.7a74a8p7f * y3;
        x[27] = -0x1.453cacp-2f * x26 + 0x1.70d7c4p-3f * x27 + 0x1.ed2288p9f * y1 + 0x1.172892p8f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e4bab8p-4f * x28 + 0x1.ca7378p-1f * x29 + 0x1.a71cdep5f * y0 + 0x1.7428fep8f * y2;
        x[29] = -0x1.ca7378p-1f * x28 + 0x1.e4bab8p-4f * x29 - 0x1.d9cdd6p6f * y0 - 0x1.5c4fc2p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e4bab8p-4f * x30 + 0x1.ca7378p-1f * x31 + 0x1.a71cdep5f * y1 + 0x1.7428fep8f * y3;
        x[31] = -0x1.ca7378p-1f * x30 + 0x1.e4bab8p-4f * x31 - 0x1.d9cdd6p6f * y1 - 0x1.5c4fc2p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.e03bd0p-3f * x32 + 0x1.4e57ecp-1f * x33 - 0x1.31eda8p8f * y0 - 0x1.78a44cp6f * y2;
        x[33] = -0x1.4e57ecp-3f * x32 - 0x1.e03bd0p-3f * x33 - 0x1.70854cp9f * y0 + 0x1.5fda7ep10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.e03bd0p-3f * x34 + 0x1.4e57ecp-1f * x35 - 0x1.31eda8p8f * y1 - 0x1.78a44cp6f * y3;
        x[35] = -0x1.4e57ecp-3f * x34 - 0x1.e03bd0p-3f * x35 - 0x1.70854cp9f * y1 + 0x1.5fda7ep10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fec4eap-1f * x36 + 0x1.86bcb8p1f * y0 - 0x1.0a82d4p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fec4eap-1f * x37 + 0x1.86bcb8p1f * y1 - 0x1.0a82d4p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.fcbdb2p-5f * e[0];
        x[0] += 0x1.149c66p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.da4b5cp-5f * e[0];
        x[1] += -0x1.ea143ap-5f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.fcbdb2p-5f * e[1];
        x[2] += 0x1.149c66p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.da4b5cp-5f * e[1];
        x[3] += -0x1.ea143ap-5f * e[3];
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
        {0x1.d12f76p16f, 0.0f, 0x1.6e5776p15f, 0.0f, 0x1.c21622p-1f, 0.0f, -0x1.57351ep-4f, 0.0f},
        {-0x1.0e4872p17f, 0.0f, -0x1.07742ap14f, 0.0f, -0x1.86c4c4p-1f, 0.0f, 0x1.85f5e4p-2f, 0.0f},
        {0.0f, 0x1.d12f76p16f, 0.0f, 0x1.6e5776p15f, 0.0f, 0x1.c21622p-1f, 0.0f, -0x1.57351ep-4f},
        {0.0f, -0x1.0e4872p17f, 0.0f, -0x1.07742ap14f, 0.0f, -0x1.86c4c4p-1f, 0.0f, 0x1.85f5e4p-2f},
        {-0x1.0c8f64p7f, 0.0f, -0x1.f88924p2f, 0.0f, 0x1.6a657ep-18f, 0.0f, -0x1.f2461ap-20f, 0.0f},
        {-0x1.2745b8p7f, 0.0f, 0x1.e14eeep5f, 0.0f, 0x1.320016p-15f, 0.0f, -0x1.828264p-17f, 0.0f},
        {0.0f, -0x1.0c8f64p7f, 0.0f, -0x1.f88924p2f, 0.0f, 0x1.6a657ep-18f, 0.0f, -0x1.f2461ap-20f},
        {0.0f, -0x1.2745b8p7f, 0.0f, 0x1.e14eeep5f, 0.0f, 0x1.320016p-15f, 0.0f, -0x1.828264p-17f},
        {0x1.1114b4p5f, 0.0f, -0x1.9ef1d0p4f, 0.0f, 0x1.d3c48cp-19f, 0.0f, -0x1.24bd58p-20f, 0.0f},
        {0x1.485158p6f, 0.0f, -0x1.9a8836p5f, 0.0f, 0x1.6f1ac0p-16f, 0.0f, -0x1.ce503ap-18f, 0.0f},
        {0.0f, 0x1.1114b4p5f, 0.0f, -0x1.9ef1d0p4f, 0.0f, 0x1.d3c48cp-19f, 0.0f, -0x1.24bd58p-20f},
        {0.0f, 0x1.485158p6f, 0.0f, -0x1.9a8836p5f, 0.0f, 0x1.6f1ac0p-16f, 0.0f, -0x1.ce503ap-18f},
        {-0x1.9e08d8p7f, 0.0f, -0x1.f5a2cap7f, 0.0f, 0x1.3beecep-15f, 0.0f, -0x1.88dc28p-17f, 0.0f},
        {-0x1.4b3424p9f, 0.0f, -0x1.73ac6ep5f, 0.0f, -0x1.8fa814p-13f, 0.0f, 0x1.f781bcp-15f, 0.0f},
        {0.0f, -0x1.9e08d8p7f, 0.0f, -0x1.f5a2cap7f, 0.0f, 0x1.3beecep-15f, 0.0f, -0x1.88dc28p-17f},
        {0.0f, -0x1.4b3424p9f, 0.0f, -0x1.73ac6ep5f, 0.0f, -0x1.8fa814p-13f, 0.0f, 0x1.f781bcp-15f},
        {-0x1.35dcc4p7f, 0.0f, 0x1.9b8ce6p7f, 0.0f, 0x1.b88122p-17f, 0.0f, -0x1.161d16p-18f, 0.0f},
        {0x1.d6c7a4p4f, 0.0f, 0x1.2b9328p6f, 0.0f, -0x1.22708ep-16f, 0.0f, 0x1.6d2c90p-18f, 0.0f},
        {0.0f, -0x1.35dcc4p7f, 0.0f, 0x1.9b8ce6p7f, 0.0f, 0x1.b88122p-17f, 0.0f, -0x1.161d16p-18f},
        {0.0f, 0x1.d6c7a4p4f, 0.0f, 0x1.2b9328p6f, 0.0f, -0x1.22708ep-16f, 0.0f, 0x1.6d2c90p-18f},
        {-0x1.8248bcp6f, 0.0f, -0x1.9846acp8f, 0.0f, -0x1.f36768p-15f, 0.0f, 0x1.3d0cc4p-16f, 0.0f},
        {-0x1.1878e2p6f, 0.0f, 0x1.451f2ap9f, 0.0f, 0x1.b99c4ep-14f, 0.0f, -0x1.14f002p-15f, 0.0f},
        {0.0f, -0x1.8248bcp6f, 0.0f, -0x1.9846acp8f, 0.0f, -0x1.f36768p-15f, 0.0f, 0x1.3d0cc4p-16f},
        {0.0f, -0x1.1878e2p6f, 0.0f, 0x1.451f2ap9f, 0.0f, 0x1.b99c4ep-14f, 0.0f, -0x1.14f002p-15f},
        {0x1.1eb35ep9f, 0.0f, 0x1.4fa1cap7f, 0.0f, -0x1.f20fcap-9f, 0.0f, 0x1.3a2554p-10f, 0.0f},
        {0x1.9caceep9f, 0.0f, 0x1.0ce92ep8f, 0.0f, 0x1.e9ec62p-12f, 0.0f, -0x1.35e2e8p-13f, 0.0f},
        {0.0f, 0x1.1eb35ep9f, 0.0f, 0x1.4fa1cap7f, 0.0f, -0x1.f20fcap-9f, 0.0f, 0x1.3a2554p-10f},
        {0.0f, 0x1.9caceep9f, 0.0f, 0x1.0ce92ep8f, 0.0f, 0x1.e9ec62p-12f, 0.0f, -0x1.35e2e8p-13f},
        {-0x1.5c419cp4f, 0.0f, 0x1.b4d530p6f, 0.0f, 0x1.b1e56cp-14f, 0.0f, -0x1.123e7ap-15f, 0.0f},
        {-0x1.672f7ep6f, 0.0f, -0x1.347ebap8f, 0.0f, 0x1.5e4eb0p-15f, 0.0f, -0x1.bcf504p-17f, 0.0f},
        {0.0f, -0x1.5c419cp4f, 0.0f, 0x1.b4d530p6f, 0.0f, 0x1.b1e56cp-14f, 0.0f, -0x1.123e7ap-15f},
        {0.0f, -0x1.672f7ep6f, 0.0f, -0x1.347ebap8f, 0.0f, 0x1.5e4eb0p-15f, 0.0f, -0x1.bcf504p-17f},
        {-0x1.01c2ecp9f, 0.0f, 0x1.ec1dbcp8f, 0.0f, 0x1.36919ap-14f, 0.0f, -0x1.89d820p-16f, 0.0f},
        {-0x1.2c32dap8f, 0.0f, 0x1.0fb994p10f, 0.0f, 0x1.7feb04p-10f, 0.0f, -0x1.e32140p-12f, 0.0f},
        {0.0f, -0x1.01c2ecp9f, 0.0f, 0x1.ec1dbcp8f, 0.0f, 0x1.36919ap-14f, 0.0f, -0x1.89d820p-16f},
        {0.0f, -0x1.2c32dap8f, 0.0f, 0x1.0fb994p10f, 0.0f, 0x1.7feb04p-10f, 0.0f, -0x1.e32140p-12f},
        {0x1.fa2016p-1f, 0.0f, -0x1.0fb5aap1f, 0.0f, -0x1.d08516p-19f, -0.0f, 0x1.23c87cp-20f, 0.0f},
        {0.0f, 0x1.fa2016p-1f, 0.0f, -0x1.0fb5aap1f, 0.0f, -0x1.d08516p-19f, 0.0f, 0x1.23c87cp-20f},
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
/* Over the test vectors Q31 stays within 5.183e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 171298 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 156813 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 140260045 * (int64_t)v; u2 += 81036983 * (int64_t)v;
        v = x[5]; u0 += -15380430 * (int64_t)v; u2 += -74856433 * (int64_t)v;
        v = x[8]; u0 += 173118101 * (int64_t)v; u2 += -316755229 * (int64_t)v;
        v = x[9]; u0 += -131454851 * (int64_t)v; u2 += 121772996 * (int64_t)v;
        v = x[12]; u0 += -294498303 * (int64_t)v; u2 += -49446036 * (int64_t)v;
        v = x[13]; u0 += -67255900 * (int64_t)v; u2 += 86959516 * (int64_t)v;
        v = x[16]; u0 += -648271078 * (int64_t)v; u2 += 218043834 * (int64_t)v;
        v = x[17]; u0 += 3417274 * (int64_t)v; u2 += -162123689 * (int64_t)v;
        v = x[20]; u0 += 111814012 * (int64_t)v; u2 += -68814683 * (int64_t)v;
        v = x[21]; u0 += -8491115 * (int64_t)v; u2 += -26886227 * (int64_t)v;
        v = x[24]; u0 += -13093893 * (int64_t)v; u2 += -2943566 * (int64_t)v;
        v = x[25]; u0 += 52056593 * (int64_t)v; u2 += 157703 * (int64_t)v;
        v = x[28]; u0 += -81844773 * (int64_t)v; u2 += -11515841 * (int64_t)v;
        v = x[29]; u0 += -24603186 * (int64_t)v; u2 += 19978818 * (int64_t)v;
        v = x[32]; u0 += 16898590 * (int64_t)v; u2 += -7095089 * (int64_t)v;
        v = x[33]; u0 += 64512660 * (int64_t)v; u2 += -19461495 * (int64_t)v;
        v = x[36]; u0 += -5048760 * (int64_t)v; u2 += 4001118 * (int64_t)v;
        v = y0; u0 += -46855862 * (int64_t)v; u2 += 19479555 * (int64_t)v;
        v = y2; u0 += 3254295 * (int64_t)v; u2 += -6063225 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 171298 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 156813 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 140260045 * (int64_t)v; u3 += 81036983 * (int64_t)v;
        v = x[7]; u1 += -15380430 * (int64_t)v; u3 += -74856433 * (int64_t)v;
        v = x[10]; u1 += 173118101 * (int64_t)v; u3 += -316755229 * (int64_t)v;
        v = x[11]; u1 += -131454851 * (int64_t)v; u3 += 121772996 * (int64_t)v;
        v = x[14]; u1 += -294498303 * (int64_t)v; u3 += -49446036 * (int64_t)v;
        v = x[15]; u1 += -67255900 * (int64_t)v; u3 += 86959516 * (int64_t)v;
        v = x[18]; u1 += -648271078 * (int64_t)v; u3 += 218043834 * (int64_t)v;
        v = x[19]; u1 += 3417274 * (int64_t)v; u3 += -162123689 * (int64_t)v;
        v = x[22]; u1 += 111814012 * (int64_t)v; u3 += -68814683 * (int64_t)v;
        v = x[23]; u1 += -8491115 * (int64_t)v; u3 += -26886227 * (int64_t)v;
        v = x[26]; u1 += -13093893 * (int64_t)v; u3 += -2943566 * (int64_t)v;
        v = x[27]; u1 += 52056593 * (int64_t)v; u3 += 157703 * (int64_t)v;
        v = x[30]; u1 += -81844773 * (int64_t)v; u3 += -11515841 * (int64_t)v;
        v = x[31]; u1 += -24603186 * (int64_t)v; u3 += 19978818 * (int64_t)v;
        v = x[34]; u1 += 16898590 * (int64_t)v; u3 += -7095089 * (int64_t)v;
        v = x[35]; u1 += 64512660 * (int64_t)v; u3 += -19461495 * (int64_t)v;
        v = x[37]; u1 += -5048760 * (int64_t)v; u3 += 4001118 * (int64_t)v;
        v = y1; u1 += -46855862 * (int64_t)v; u3 += 19479555 * (int64_t)v;
        v = y3; u1 += 3254295 * (int64_t)v; u3 += -6063225 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1525848 * (int64_t)x0 + 51376374 * (int64_t)y0 - 29827781 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2429698 * (int64_t)x1 - 89058921 * (int64_t)y0 - 136582520 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1525848 * (int64_t)x2 + 51376374 * (int64_t)y1 - 29827781 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2429698 * (int64_t)x3 - 89058921 * (int64_t)y1 - 136582520 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-81217078 * (int64_t)x4 + 332736392 * (int64_t)x5 + 10167321 * (int64_t)y0 - 5226998 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-332736392 * (int64_t)x4 - 81217078 * (int64_t)x5 - 14564765 * (int64_t)y0 + 630054 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-81217078 * (int64_t)x6 + 332736392 * (int64_t)x7 + 10167321 * (int64_t)y1 - 5226998 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-332736392 * (int64_t)x6 - 81217078 * (int64_t)x7 - 14564765 * (int64_t)y1 + 630054 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149532013 * (int64_t)x8 + 503805185 * (int64_t)x9 - 8794134 * (int64_t)y0 + 5599656 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503805185 * (int64_t)x8 - 149532013 * (int64_t)x9 + 7286868 * (int64_t)y0 - 5280662 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149532013 * (int64_t)x10 + 503805185 * (int64_t)x11 - 8794134 * (int64_t)y1 + 5599656 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503805185 * (int64_t)x10 - 149532013 * (int64_t)x11 + 7286868 * (int64_t)y1 - 5280662 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(759808103 * (int64_t)x12 + 551454397 * (int64_t)x13 + 71667568 * (int64_t)y0 - 13740481 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-551454397 * (int64_t)x12 + 759808103 * (int64_t)x13 - 80308233 * (int64_t)y0 - 38872081 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(759808103 * (int64_t)x14 + 551454397 * (int64_t)x15 + 71667568 * (int64_t)y1 - 13740481 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-551454397 * (int64_t)x14 + 759808103 * (int64_t)x15 - 80308233 * (int64_t)y1 - 38872081 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(618350192 * (int64_t)x16 + 794143070 * (int64_t)x17 - 24632415 * (int64_t)y0 + 8656951 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-794143070 * (int64_t)x16 + 618350192 * (int64_t)x17 - 27944219 * (int64_t)y0 + 50180476 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(618350192 * (int64_t)x18 + 794143070 * (int64_t)x19 - 24632415 * (int64_t)y1 + 8656951 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-794143070 * (int64_t)x18 + 618350192 * (int64_t)x19 - 27944219 * (int64_t)y1 + 50180476 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(378198557 * (int64_t)x20 + 825680037 * (int64_t)x21 + 2693950 * (int64_t)y0 - 208261813 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-825680037 * (int64_t)x20 + 378198557 * (int64_t)x21 - 33655095 * (int64_t)y0 + 28951884 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(378198557 * (int64_t)x22 + 825680037 * (int64_t)x23 + 2693950 * (int64_t)y1 - 208261813 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-825680037 * (int64_t)x22 + 378198557 * (int64_t)x23 - 33655095 * (int64_t)y1 + 28951884 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(193379871 * (int64_t)x24 + 1364142842 * (int64_t)x25 - 1940601 * (int64_t)y0 - 51608189 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-682071421 * (int64_t)x24 + 386759741 * (int64_t)x25 + 537971534 * (int64_t)y0 + 152270026 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(193379871 * (int64_t)x26 + 1364142842 * (int64_t)x27 - 1940601 * (int64_t)y1 - 51608189 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-682071421 * (int64_t)x26 + 386759741 * (int64_t)x27 + 537971534 * (int64_t)y1 + 152270026 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(127068894 * (int64_t)x28 + 961441537 * (int64_t)x29 + 14424465 * (int64_t)y0 + 101499391 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-961441537 * (int64_t)x28 + 127068894 * (int64_t)x29 - 32305195 * (int64_t)y0 - 47497579 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(127068894 * (int64_t)x30 + 961441537 * (int64_t)x31 + 14424465 * (int64_t)y1 + 101499391 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-961441537 * (int64_t)x30 + 127068894 * (int64_t)x31 - 32305195 * (int64_t)y1 - 47497579 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-503561475 * (int64_t)x32 + 1402338063 * (int64_t)x33 - 166871939 * (int64_t)y0 - 51360837 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-350584516 * (int64_t)x32 - 503561475 * (int64_t)x33 - 402027221 * (int64_t)y0 + 767689216 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-503561475 * (int64_t)x34 + 1402338063 * (int64_t)x35 - 166871939 * (int64_t)y1 - 51360837 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-350584516 * (int64_t)x34 - 503561475 * (int64_t)x35 - 402027221 * (int64_t)y1 + 767689216 * (int64_t)y3, 31);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142321264 * (int64_t)x36 + 1665092 * (int64_t)y0 - 2271427 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142321264 * (int64_t)x37 + 1665092 * (int64_t)y1 - 2271427 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 800180381 * (int64_t)e[0] + 870142755 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], -746000558 * (int64_t)e[0] - 770827640 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 800180381 * (int64_t)e[1] + 870142755 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], -746000558 * (int64_t)e[1] - 770827640 * (int64_t)e[3], 19);
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
        {1014961677, 0, 399650031, 0, 88490597, 0, -8434668, 0},
        {-1179430332, 0, -143703707, 0, -76828235, 0, 38334679, 0},
        {0, 1014961677, 0, 399650031, 0, 88490597, 0, -8434668},
        {0, -1179430332, 0, -143703707, 0, -76828235, 0, 38334679},
        {-1171912259, 0, -68801120, 0, 556641, 0, -191337, 0},
        {-1288476046, 0, 525069681, 0, 3760132, 0, -1187357, 0},
        {0, -1171912259, 0, -68801120, 0, 556641, 0, -191337},
        {0, -1288476046, 0, 525069681, 0, 3760132, 0, -1187357},
        {1191639345, 0, -905344068, 0, 1436983, 0, -449648, 0},
        {716337908, 0, -447858354, 0, 2255490, 0, -710113, 0},
        {0, 1191639345, 0, -905344068, 0, 1436983, 0, -449648},
        {0, 716337908, 0, -447858354, 0, 2255490, 0, -710113},
        {-903358531, 0, -1094490955, 0, 1941091, 0, -603433, 0},
        {-1445269125, 0, -101366683, 0, -4910980, 0, 1546773, 0},
        {0, -903358531, 0, -1094490955, 0, 1941091, 0, -603433},
        {0, -1445269125, 0, -101366683, 0, -4910980, 0, 1546773},
        {-676071148, 0, 897938503, 0, 676615, 0, -213591, 0},
        {513583942, 0, 1307250701, 0, -3568923, 0, 1121815, 0},
        {0, -676071148, 0, 897938503, 0, 676615, 0, -213591},
        {0, 513583942, 0, 1307250701, 0, -3568923, 0, 1121815},
        {-210702868, 0, -890794438, 0, -1534169, 0, 486989, 0},
        {-152986597, 0, 1418729358, 0, 2713255, 0, -850752, 0},
        {0, -210702868, 0, -890794438, 0, -1534169, 0, 486989},
        {0, -152986597, 0, 1418729358, 0, 2713255, 0, -850752},
        {1251071825, 0, 366148226, 0, -97922913, 0, 30881790, 0},
        {900393311, 0, 293360705, 0, 6020178, 0, -1903942, 0},
        {0, 1251071825, 0, 366148226, 0, -97922913, 0, 30881790},
        {0, 900393311, 0, 293360705, 0, 6020178, 0, -1903942},
        {-189960165, 0, 953100684, 0, 10663432, 0, -3369911, 0},
        {-391843278, 0, -1346175717, 0, 2152288, 0, -683454, 0},
        {0, -189960165, 0, 953100684, 0, 10663432, 0, -3369911},
        {0, -391843278, 0, -1346175717, 0, 2152288, 0, -683454},
        {-562395004, 0, 536860174, 0, 954067, 0, -302472, 0},
        {-327493213, 0, 1185722369, 0, 18870340, 0, -5936700, 0},
        {0, -562395004, 0, 536860174, 0, 954067, 0, -302472},
        {0, -327493213, 0, 1185722369, 0, 18870340, 0, -5936700},
        {552143116, 0, -1185655733, 0, -22832081, 0, 7170862, 0},
        {0, 552143116, 0, -1185655733, 0, -22832081, 0, 7170862},
    };
    static const int16_t shift[38] = {
        25, 25, 25, 25, 35, 35, 35, 35, 37, 35, 37, 35, 34, 33, 34, 33, 34, 36, 34, 36, 33, 33, 33, 33, 33, 32, 33, 32, 35, 34, 35, 34, 32, 32, 32, 32, 41, 41};
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
