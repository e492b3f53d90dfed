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
static const float paper_tool_f32_output_guard = 0x1.cd4736p23f;

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
        float u0 = 0x1.16c572p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.0ad88ap0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.cc72dap6f * v; u2 += 0x1.74186ap8f * v;
        v = x[5]; u0 += 0x1.ee32e8p8f * v; u2 += 0x1.c672ccp8f * v;
        v = x[8]; u0 += 0x1.33a642p9f * v; u2 += -0x1.1db2f6p10f * v;
        v = x[9]; u0 += 0x1.053f46p10f * v; u2 += -0x1.f6bc52p11f * v;
        v = x[12]; u0 += 0x1.c9daeap8f * v; u2 += -0x1.0a45c6p10f * v;
        v = x[13]; u0 += -0x1.ba9fb6p10f * v; u2 += -0x1.f833b2p8f * v;
        v = x[16]; u0 += 0x1.855ae8p7f * v; u2 += 0x1.f49820p10f * v;
        v = x[17]; u0 += -0x1.1d4e60p12f * v; u2 += 0x1.2ea89cp11f * v;
        v = x[20]; u0 += -0x1.60affcp7f * v; u2 += 0x1.68fbfep9f * v;
        v = x[21]; u0 += 0x1.a32d0ep10f * v; u2 += -0x1.0eb12cp10f * v;
        v = x[24]; u0 += -0x1.495a16p8f * v; u2 += 0x1.25d768p4f * v;
        v = x[25]; u0 += -0x1.5305a6p7f * v; u2 += -0x1.a02562p6f * v;
        v = x[28]; u0 += 0x1.69988cp7f * v; u2 += -0x1.7b9e52p7f * v;
        v = x[29]; u0 += -0x1.d5b5a8p8f * v; u2 += -0x1.dfecdap6f * v;
        v = x[32]; u0 += -0x1.e23ba6p8f * v; u2 += 0x1.bbd39cp6f * v;
        v = x[33]; u0 += 0x1.58cf04p8f * v; u2 += -0x1.28ea1ap6f * v;
        v = x[36]; u0 += -0x1.d1325ap4f * v; u2 += 0x1.70a738p5f * v;
        v = y0; u0 += -0x1.003fe2p20f * v; u2 += 0x1.d7d5bep19f * v;
        v = y2; u0 += 0x1.c5ecb6p15f * v; u2 += -0x1.b70c06p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.16c572p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.0ad88ap0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.cc72dap6f * v; u3 += 0x1.74186ap8f * v;
        v = x[7]; u1 += 0x1.ee32e8p8f * v; u3 += 0x1.c672ccp8f * v;
        v = x[10]; u1 += 0x1.33a642p9f * v; u3 += -0x1.1db2f6p10f * v;
        v = x[11]; u1 += 0x1.053f46p10f * v; u3 += -0x1.f6bc52p11f * v;
        v = x[14]; u1 += 0x1.c9daeap8f * v; u3 += -0x1.0a45c6p10f * v;
        v = x[15]; u1 += -0x1.ba9fb6p10f * v; u3 += -0x1.f833b2p8f * v;
        v = x[18]; u1 += 0x1.855ae8p7f * v; u3 += 0x1.f49820p10f * v;
        v = x[19]; u1 += -0x1.1d4e60p12f * v; u3 += 0x1.2ea89cp11f * v;
        v = x[22]; u1 += -0x1.60affcp7f * v; u3 += 0x1.68fbfep9f * v;
        v = x[23]; u1 += 0x1.a32d0ep10f * v; u3 += -0x1.0eb12cp10f * v;
        v = x[26]; u1 += -0x1.495a16p8f * v; u3 += 0x1.25d768p4f * v;
        v = x[27]; u1 += -0x1.5305a6p7f * v; u3 += -0x1.a02562p6f * v;
        v = x[30]; u1 += 0x1.69988cp7f * v; u3 += -0x1.7b9e52p7f * v;
        v = x[31]; u1 += -0x1.d5b5a8p8f * v; u3 += -0x1.dfecdap6f * v;
        v = x[34]; u1 += -0x1.e23ba6p8f * v; u3 += 0x1.bbd39cp6f * v;
        v = x[35]; u1 += 0x1.58cf04p8f * v; u3 += -0x1.28ea1ap6f * v;
        v = x[37]; u1 += -0x1.d1325ap4f * v; u3 += 0x1.70a738p5f * v;
        v = y1; u1 += -0x1.003fe2p20f * v; u3 += 0x1.d7d5bep19f * v;
        v = y3; u1 += 0x1.c5ecb6p15f * v; u3 += -0x1.b70c06p17f * v;
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
        x[0] = -0x1.aaa862p-10f * x0 + 0x1.f8ebbap7f * y0 - 0x1.a5c0dep6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.0fecb8p-9f * x1 - 0x1.4e6ebep8f * y0 - 0x1.9f5b2cp8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.aaa862p-10f * x2 + 0x1.f8ebbap7f * y1 - 0x1.a5c0dep6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.0fecb8p-9f * x3 - 0x1.4e6ebep8f * y1 - 0x1.9f5b2cp8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.621d06p-4f * x4 + 0x1.3bd448p-2f * x5 + 0x1.01f588p7f * y0 + 0x1.8b90f6p2f * y2
            + x4;
        x[5] = -0x1.3bd448p-2f * x4 - 0x1.621d06p-4f * x5 + 0x1.086264p6f * y0 - 0x1.28b542p5f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.621d06p-4f * x6 + 0x1.3bd448p-2f * x7 + 0x1.01f588p7f * y1 + 0x1.8b90f6p2f * y3
            + x6;
        x[7] = -0x1.3bd448p-2f * x6 - 0x1.621d06p-4f * x7 + 0x1.086264p6f * y1 - 0x1.28b542p5f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1f7614p-3f * x8 + 0x1.e094f6p-2f * x9 - 0x1.ef4348p4f * y0 + 0x1.cc2a7ep3f * y2
            + x8;
        x[9] = -0x1.e094f6p-2f * x8 - 0x1.1f7614p-3f * x9 - 0x1.cc51a0p4f * y0 + 0x1.5b2c38p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1f7614p-3f * x10 + 0x1.e094f6p-2f * x11 - 0x1.ef4348p4f * y1 + 0x1.cc2a7ep3f * y3
            + x10;
        x[11] = -0x1.e094f6p-2f * x10 - 0x1.1f7614p-3f * x11 - 0x1.cc51a0p4f * y1 + 0x1.5b2c38p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6e8192p-1f * x12 + 0x1.025fb6p-1f * x13 + 0x1.4ec2eap8f * y0 + 0x1.b3139ep6f * y2;
        x[13] = -0x1.025fb6p-1f * x12 + 0x1.6e8192p-1f * x13 + 0x1.7ea4bcp7f * y0 - 0x1.2394cep6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6e8192p-1f * x14 + 0x1.025fb6p-1f * x15 + 0x1.4ec2eap8f * y1 + 0x1.b3139ep6f * y3;
        x[15] = -0x1.025fb6p-1f * x14 + 0x1.6e8192p-1f * x15 + 0x1.7ea4bcp7f * y1 - 0x1.2394cep6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.2130b4p-1f * x16 + 0x1.7ad1eep-1f * x17 + 0x1.a14602p6f * y0 - 0x1.5867dap7f * y2;
        x[17] = -0x1.7ad1eep-1f * x16 + 0x1.2130b4p-1f * x17 - 0x1.764fb2p6f * y0 + 0x1.134614p5f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.2130b4p-1f * x18 + 0x1.7ad1eep-1f * x19 + 0x1.a14602p6f * y1 - 0x1.5867dap7f * y3;
        x[19] = -0x1.7ad1eep-1f * x18 + 0x1.2130b4p-1f * x19 - 0x1.764fb2p6f * y1 + 0x1.134614p5f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.7279f6p-2f * x20 + 0x1.849090p-1f * x21 + 0x1.0e2af0p7f * y0 - 0x1.011df6p6f * y2;
        x[21] = -0x1.849090p-1f * x20 + 0x1.7279f6p-2f * x21 + 0x1.247da8p4f * y0 - 0x1.995ea0p8f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.7279f6p-2f * x22 + 0x1.849090p-1f * x23 + 0x1.0e2af0p7f * y1 - 0x1.011df6p6f * y3;
        x[23] = -0x1.849090p-1f * x22 + 0x1.7279f6p-2f * x23 + 0x1.247da8p4f * y1 - 0x1.995ea0p8f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.48eaa2p-3f * x24 + 0x1.5227dcp-1f * x25 - 0x1.1c911cp10f * y0 - 0x1.2ab406p7f * y2;
        x[25] = -0x1.5227dcp-1f * x24 + 0x1.48eaa2p-3f * x25 + 0x1.07ad04p6f * y0 - 0x1.95be72p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.48eaa2p-3f * x26 + 0x1.5227dcp-1f * x27 - 0x1.1c911cp10f * y1 - 0x1.2ab406p7f * y3;
        x[27] = -0x1.5227dcp-1f * x26 + 0x1.48eaa2p-3f * x27 + 0x1.07ad04p6f * y1 - 0x1.95be72p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e2b4e2p-4f * x28 + 0x1.c7afe8p-1f * x29 + 0x1.75f220p3f * y0 + 0x1.b7225ap7f * y2;
        x[29] = -0x1.c7afe8p-1f * x28 + 0x1.e2b4e2p-4f * x29 + 0x1.4695f8p6f * y0 + 0x1.5ba110p8f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e2b4e2p-4f * x30 + 0x1.c7afe8p-1f * x31 + 0x1.75f220p3f * y1 + 0x1.b7225ap7f * y3;
        x[31] = -0x1.c7afe8p-1f * x30 + 0x1.e2b4e2p-4f * x31 + 0x1.4695f8p6f * y1 + 0x1.5ba110p8f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.3234f2p-2f * x32 + 0x1.70a076p-2f * x33 + 0x1.a260bap9f * y0 - 0x1.8a4d02p10f * y2;
        x[33] = -0x1.70a076p-2f * x32 - 0x1.3234f2p-2f * x33 - 0x1.88d32ep8f * y0 - 0x1.fd340ep7f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.3234f2p-2f * x34 + 0x1.70a076p-2f * x35 + 0x1.a260bap9f * y1 - 0x1.8a4d02p10f * y3;
        x[35] = -0x1.70a076p-2f * x34 - 0x1.3234f2p-2f * x35 - 0x1.88d32ep8f * y1 - 0x1.fd340ep7f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.febf64p-1f * x36 + 0x1.89e376p1f * y0 - 0x1.0bfa1ep2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.febf64p-1f * x37 + 0x1.89e376p1f * y1 - 0x1.0bfa1ep2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.b01328p-5f * e[0];
        x[0] += 0x1.11d66cp-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.97a91ep-5f * e[0];
        x[1] += -0x1.f62f98p-5f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.b01328p-5f * e[1];
        x[2] += 0x1.11d66cp-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.97a91ep-5f * e[1];
        x[3] += -0x1.f62f98p-5f * e[3];
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
        {0x1.508eacp15f, 0.0f, 0x1.365370p14f, 0.0f, 0x1.bdf9bap-2f, 0.0f, 0x1.8f69d0p-6f, 0.0f},
        {-0x1.f554f8p15f, 0.0f, -0x1.456968p11f, 0.0f, -0x1.4a3002p-2f, 0.0f, 0x1.134cd6p-2f, 0.0f},
        {0.0f, 0x1.508eacp15f, 0.0f, 0x1.365370p14f, 0.0f, 0x1.bdf9bap-2f, 0.0f, 0x1.8f69d0p-6f},
        {0.0f, -0x1.f554f8p15f, 0.0f, -0x1.456968p11f, 0.0f, -0x1.4a3002p-2f, 0.0f, 0x1.134cd6p-2f},
        {0x1.149000p8f, 0.0f, -0x1.a85aecp6f, 0.0f, -0x1.c97b8ep-13f, 0.0f, 0x1.45d096p-14f, 0.0f},
        {-0x1.5411d4p8f, 0.0f, -0x1.9bb16ep5f, 0.0f, -0x1.cad88ap-15f, 0.0f, 0x1.42556ep-16f, 0.0f},
        {0.0f, 0x1.149000p8f, 0.0f, -0x1.a85aecp6f, 0.0f, -0x1.c97b8ep-13f, 0.0f, 0x1.45d096p-14f},
        {0.0f, -0x1.5411d4p8f, 0.0f, -0x1.9bb16ep5f, 0.0f, -0x1.cad88ap-15f, 0.0f, 0x1.42556ep-16f},
        {-0x1.34884ep6f, -0.0f, 0x1.965b04p5f, 0.0f, -0x1.4615c0p-16f, -0.0f, 0x1.cfd3a2p-18f, 0.0f},
        {0x1.5d18c4p5f, 0.0f, -0x1.eca7a2p3f, 0.0f, -0x1.34ecb4p-21f, 0.0f, 0x1.c4f3b2p-23f, 0.0f},
        {0.0f, -0x1.34884ep6f, 0.0f, 0x1.965b04p5f, 0.0f, -0x1.4615c0p-16f, 0.0f, 0x1.cfd3a2p-18f},
        {0.0f, 0x1.5d18c4p5f, 0.0f, -0x1.eca7a2p3f, 0.0f, -0x1.34ecb4p-21f, 0.0f, 0x1.c4f3b2p-23f},
        {0x1.2c9db8p9f, 0.0f, -0x1.0e8384p4f, 0.0f, 0x1.b7b630p-13f, 0.0f, -0x1.38af74p-14f, 0.0f},
        {-0x1.52af44p8f, 0.0f, -0x1.c1c666p7f, 0.0f, 0x1.4a978ap-16f, 0.0f, -0x1.d17246p-18f, 0.0f},
        {0.0f, 0x1.2c9db8p9f, 0.0f, -0x1.0e8384p4f, 0.0f, 0x1.b7b630p-13f, 0.0f, -0x1.38af74p-14f},
        {0.0f, -0x1.52af44p8f, 0.0f, -0x1.c1c666p7f, 0.0f, 0x1.4a978ap-16f, 0.0f, -0x1.d17246p-18f},
        {-0x1.dbb6fep4f, 0.0f, -0x1.0c4d44p6f, 0.0f, 0x1.3588acp-16f, 0.0f, -0x1.b7fe08p-18f, 0.0f},
        {-0x1.3d1aacp7f, 0.0f, 0x1.8273e2p7f, 0.0f, 0x1.5e13a8p-17f, 0.0f, -0x1.f2fa5ep-19f, 0.0f},
        {0.0f, -0x1.dbb6fep4f, 0.0f, -0x1.0c4d44p6f, 0.0f, 0x1.3588acp-16f, 0.0f, -0x1.b7fe08p-18f},
        {0.0f, -0x1.3d1aacp7f, 0.0f, 0x1.8273e2p7f, 0.0f, 0x1.5e13a8p-17f, 0.0f, -0x1.f2fa5ep-19f},
        {0x1.6ea176p6f, 0.0f, -0x1.6628c6p8f, 0.0f, -0x1.29e31ap-14f, 0.0f, 0x1.a700eap-16f, 0.0f},
        {-0x1.617dcep6f, 0.0f, -0x1.af7366p7f, 0.0f, 0x1.d52b8ep-16f, 0.0f, -0x1.4c160ep-17f, 0.0f},
        {0.0f, 0x1.6ea176p6f, 0.0f, -0x1.6628c6p8f, 0.0f, -0x1.29e31ap-14f, 0.0f, 0x1.a700eap-16f},
        {0.0f, -0x1.617dcep6f, 0.0f, -0x1.af7366p7f, 0.0f, 0x1.d52b8ep-16f, 0.0f, -0x1.4c160ep-17f},
        {-0x1.8ca4d0p9f, 0.0f, -0x1.c5cd70p7f, 0.0f, 0x1.641360p-15f, 0.0f, -0x1.f8845ap-17f, 0.0f},
        {0x1.0b7292p9f, 0.0f, -0x1.e74b38p5f, 0.0f, -0x1.40abc2p-10f, 0.0f, 0x1.c8fc88p-12f, 0.0f},
        {0.0f, -0x1.8ca4d0p9f, 0.0f, -0x1.c5cd70p7f, 0.0f, 0x1.641360p-15f, 0.0f, -0x1.f8845ap-17f},
        {0.0f, 0x1.0b7292p9f, 0.0f, -0x1.e74b38p5f, 0.0f, -0x1.40abc2p-10f, 0.0f, 0x1.c8fc88p-12f},
        {0x1.b38816p5f, 0.0f, 0x1.40e7dep8f, 0.0f, 0x1.6435cap-17f, 0.0f, -0x1.f03674p-19f, 0.0f},
        {0x1.182fb0p5f, 0.0f, 0x1.196432p6f, 0.0f, -0x1.e9a394p-16f, 0.0f, 0x1.5a062ep-17f, 0.0f},
        {0.0f, 0x1.b38816p5f, 0.0f, 0x1.40e7dep8f, 0.0f, 0x1.6435cap-17f, 0.0f, -0x1.f03674p-19f},
        {0.0f, 0x1.182fb0p5f, 0.0f, 0x1.196432p6f, 0.0f, -0x1.e9a394p-16f, 0.0f, 0x1.5a062ep-17f},
        {0x1.767186p8f, 0.0f, -0x1.270d02p10f, 0.0f, -0x1.0dc7bep-10f, 0.0f, 0x1.7fd5f8p-12f, 0.0f},
        {-0x1.97d230p8f, 0.0f, 0x1.0556b4p7f, 0.0f, 0x1.1f5066p-12f, 0.0f, -0x1.99060ep-14f, 0.0f},
        {0.0f, 0x1.767186p8f, 0.0f, -0x1.270d02p10f, 0.0f, -0x1.0dc7bep-10f, 0.0f, 0x1.7fd5f8p-12f},
        {0.0f, -0x1.97d230p8f, 0.0f, 0x1.0556b4p7f, 0.0f, 0x1.1f5066p-12f, 0.0f, -0x1.99060ep-14f},
        {0x1.2c43aep0f, 0.0f, -0x1.0efe6ep1f, 0.0f, -0x1.5911dep-19f, -0.0f, 0x1.e9d184p-21f, 0.0f},
        {0.0f, 0x1.2c43aep0f, 0.0f, -0x1.0efe6ep1f, 0.0f, -0x1.5911dep-19f, 0.0f, 0x1.e9d184p-21f},
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
/* Over the test vectors Q31 stays within 5.690e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 95154 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 91083 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += -10058654 * (int64_t)v; u2 += 32514190 * (int64_t)v;
        v = x[5]; u0 += 43183754 * (int64_t)v; u2 += 39710310 * (int64_t)v;
        v = x[8]; u0 += 53765639 * (int64_t)v; u2 += -99859061 * (int64_t)v;
        v = x[9]; u0 += 91312505 * (int64_t)v; u2 += -351437685 * (int64_t)v;
        v = x[12]; u0 += 40007992 * (int64_t)v; u2 += -93069006 * (int64_t)v;
        v = x[13]; u0 += -154708252 * (int64_t)v; u2 += -44057838 * (int64_t)v;
        v = x[16]; u0 += 17011183 * (int64_t)v; u2 += 174970363 * (int64_t)v;
        v = x[17]; u0 += -398886894 * (int64_t)v; u2 += 211573717 * (int64_t)v;
        v = x[20]; u0 += -15409149 * (int64_t)v; u2 += 63086584 * (int64_t)v;
        v = x[21]; u0 += 146512627 * (int64_t)v; u2 += -94613734 * (int64_t)v;
        v = x[24]; u0 += -28779208 * (int64_t)v; u2 += 1604766 * (int64_t)v;
        v = x[25]; u0 += -14812099 * (int64_t)v; u2 += -9090849 * (int64_t)v;
        v = x[28]; u0 += 15798365 * (int64_t)v; u2 += -16585783 * (int64_t)v;
        v = x[29]; u0 += -41043850 * (int64_t)v; u2 += -10484126 * (int64_t)v;
        v = x[32]; u0 += -42138164 * (int64_t)v; u2 += 9695540 * (int64_t)v;
        v = x[33]; u0 += 30129839 * (int64_t)v; u2 += -6486195 * (int64_t)v;
        v = x[36]; u0 += -2540594 * (int64_t)v; u2 += 4026676 * (int64_t)v;
        v = y0; u0 += -23295681 * (int64_t)v; u2 += 21447290 * (int64_t)v;
        v = y2; u0 += 1289574 * (int64_t)v; u2 += -4989228 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 18);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 95154 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 91083 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += -10058654 * (int64_t)v; u3 += 32514190 * (int64_t)v;
        v = x[7]; u1 += 43183754 * (int64_t)v; u3 += 39710310 * (int64_t)v;
        v = x[10]; u1 += 53765639 * (int64_t)v; u3 += -99859061 * (int64_t)v;
        v = x[11]; u1 += 91312505 * (int64_t)v; u3 += -351437685 * (int64_t)v;
        v = x[14]; u1 += 40007992 * (int64_t)v; u3 += -93069006 * (int64_t)v;
        v = x[15]; u1 += -154708252 * (int64_t)v; u3 += -44057838 * (int64_t)v;
        v = x[18]; u1 += 17011183 * (int64_t)v; u3 += 174970363 * (int64_t)v;
        v = x[19]; u1 += -398886894 * (int64_t)v; u3 += 211573717 * (int64_t)v;
        v = x[22]; u1 += -15409149 * (int64_t)v; u3 += 63086584 * (int64_t)v;
        v = x[23]; u1 += 146512627 * (int64_t)v; u3 += -94613734 * (int64_t)v;
        v = x[26]; u1 += -28779208 * (int64_t)v; u3 += 1604766 * (int64_t)v;
        v = x[27]; u1 += -14812099 * (int64_t)v; u3 += -9090849 * (int64_t)v;
        v = x[30]; u1 += 15798365 * (int64_t)v; u3 += -16585783 * (int64_t)v;
        v = x[31]; u1 += -41043850 * (int64_t)v; u3 += -10484126 * (int64_t)v;
        v = x[34]; u1 += -42138164 * (int64_t)v; u3 += 9695540 * (int64_t)v;
        v = x[35]; u1 += 30129839 * (int64_t)v; u3 += -6486195 * (int64_t)v;
        v = x[37]; u1 += -2540594 * (int64_t)v; u3 += 4026676 * (int64_t)v;
        v = y1; u1 += -23295681 * (int64_t)v; u3 += 21447290 * (int64_t)v;
        v = y3; u1 += 1289574 * (int64_t)v; u3 += -4989228 * (int64_t)v;
        u[1] = paper_tool_q31_current(c, 1, u1, 18);
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
        x[0] = paper_tool_q31_round(-1747590 * (int64_t)x0 + 68853633 * (int64_t)y0 - 28756246 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2227607 * (int64_t)x1 - 91209945 * (int64_t)y0 - 113280260 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1747590 * (int64_t)x2 + 68853633 * (int64_t)y1 - 28756246 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2227607 * (int64_t)x3 - 91209945 * (int64_t)y1 - 113280260 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-92828700 * (int64_t)x4 + 331170929 * (int64_t)x5 + 35176648 * (int64_t)y0 + 1685671 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-331170929 * (int64_t)x4 - 92828700 * (int64_t)x5 + 18026413 * (int64_t)y0 - 10115164 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-92828700 * (int64_t)x6 + 331170929 * (int64_t)x7 + 35176648 * (int64_t)y1 + 1685671 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-331170929 * (int64_t)x6 - 92828700 * (int64_t)x7 + 18026413 * (int64_t)y1 - 10115164 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-150712476 * (int64_t)x8 + 503926622 * (int64_t)x9 - 8442077 * (int64_t)y0 + 3921914 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503926622 * (int64_t)x8 - 150712476 * (int64_t)x9 - 7846435 * (int64_t)y0 + 5917785 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-150712476 * (int64_t)x10 + 503926622 * (int64_t)x11 - 8442077 * (int64_t)y1 + 3921914 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503926622 * (int64_t)x10 - 150712476 * (int64_t)x11 - 7846435 * (int64_t)y1 + 5917785 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(768619093 * (int64_t)x12 + 541849299 * (int64_t)x13 + 91299617 * (int64_t)y0 + 29664658 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-541849299 * (int64_t)x12 + 768619093 * (int64_t)x13 + 52179261 * (int64_t)y0 - 19880771 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(768619093 * (int64_t)x14 + 541849299 * (int64_t)x15 + 91299617 * (int64_t)y1 + 29664658 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-541849299 * (int64_t)x14 + 768619093 * (int64_t)x15 + 52179261 * (int64_t)y1 - 19880771 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(606475934 * (int64_t)x16 + 794443190 * (int64_t)x17 + 28450793 * (int64_t)y0 - 46964953 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-794443190 * (int64_t)x16 + 606475934 * (int64_t)x17 - 25521521 * (int64_t)y0 + 9384441 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(606475934 * (int64_t)x18 + 794443190 * (int64_t)x19 + 28450793 * (int64_t)y1 - 46964953 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-794443190 * (int64_t)x18 + 606475934 * (int64_t)x19 - 25521521 * (int64_t)y1 + 9384441 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(388472680 * (int64_t)x20 + 814879213 * (int64_t)x21 + 36841477 * (int64_t)y0 - 17530910 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-814879213 * (int64_t)x20 + 388472680 * (int64_t)x21 + 4985697 * (int64_t)y0 - 111647549 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(388472680 * (int64_t)x22 + 814879213 * (int64_t)x23 + 36841477 * (int64_t)y1 - 17530910 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-814879213 * (int64_t)x22 + 388472680 * (int64_t)x23 + 4985697 * (int64_t)y1 - 111647549 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(172446993 * (int64_t)x24 + 709163902 * (int64_t)x25 - 310440131 * (int64_t)y0 - 40732728 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-1418327805 * (int64_t)x24 + 344893985 * (int64_t)x25 + 35956214 * (int64_t)y0 - 110658717 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(172446993 * (int64_t)x26 + 709163902 * (int64_t)x27 - 310440131 * (int64_t)y1 - 40732728 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-1418327805 * (int64_t)x26 + 344893985 * (int64_t)x27 + 35956214 * (int64_t)y1 - 110658717 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(126538633 * (int64_t)x28 + 955645198 * (int64_t)x29 + 3187075 * (int64_t)y0 + 59882626 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-955645198 * (int64_t)x28 + 126538633 * (int64_t)x29 + 22267472 * (int64_t)y0 + 94809049 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(126538633 * (int64_t)x30 + 955645198 * (int64_t)x31 + 3187075 * (int64_t)y1 + 59882626 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-955645198 * (int64_t)x30 + 126538633 * (int64_t)x31 + 22267472 * (int64_t)y1 + 94809049 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-321081113 * (int64_t)x32 + 386533202 * (int64_t)x33 + 228208727 * (int64_t)y0 - 430151312 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-773066404 * (int64_t)x32 - 642162226 * (int64_t)x33 - 214270620 * (int64_t)y0 - 138875242 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-321081113 * (int64_t)x34 + 386533202 * (int64_t)x35 + 228208727 * (int64_t)y1 - 430151312 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-773066404 * (int64_t)x34 - 642162226 * (int64_t)x35 - 214270620 * (int64_t)y1 - 138875242 * (int64_t)y3, 31);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142230775 * (int64_t)x36 + 1678522 * (int64_t)y0 - 2283921 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142230775 * (int64_t)x37 + 1678522 * (int64_t)y1 - 2283921 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 679594929 * (int64_t)e[0] + 861418575 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], -641194715 * (int64_t)e[0] - 789870159 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 679594929 * (int64_t)e[1] + 861418575 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], -641194715 * (int64_t)e[1] - 789870159 * (int64_t)e[3], 19);
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
        {734315365, 0, 338541283, 0, 87682350, 0, 4907991, 0},
        {-1093827730, 0, -44374841, 0, -64917511, 0, 54126208, 0},
        {0, 734315365, 0, 338541282, 0, 87682350, 0, 4907991},
        {0, -1093827730, 0, -44374841, 0, -64917511, 0, 54126208},
        {1206832125, 0, -462938247, 0, -11243093, 0, 4003612, 0},
        {-1483957339, 0, -224562461, 0, -2819149, 0, 990209, 0},
        {0, 1206832125, 0, -462938247, 0, -11243093, 0, 4003612},
        {0, -1483957339, 0, -224562461, 0, -2819149, 0, 990209},
        {-673169453, 0, 443302066, 0, -2003466, 0, 712438, 0},
        {1523348874, 0, -537447824, 0, -237254, 0, 86967, 0},
        {0, -673169453, 0, 443302066, 0, -2003466, 0, 712438},
        {0, 1523348874, 0, -537447824, 0, -237254, 0, 86967},
        {1311794434, 0, -36888661, 0, 5403177, 0, -1921139, 0},
        {-738956822, 0, -490669307, 0, 507789, 0, -178731, 0},
        {0, 1311794434, 0, -36888661, 0, 5403177, 0, -1921139},
        {0, -738956822, 0, -490669307, 0, 507789, 0, -178731},
        {-518967615, 0, -1170785105, 0, 3803552, 0, -1351656, 0},
        {-691871646, 0, 843179205, 0, 537718, 0, -191608, 0},
        {0, -518967615, 0, -1170785105, 0, 3803552, 0, -1351656},
        {0, -691871646, 0, 843179205, 0, 537718, 0, -191608},
        {399965400, 0, -1562894820, 0, -3660437, 0, 1299467, 0},
        {-385631462, 0, -941358046, 0, 1441291, 0, -510084, 0},
        {0, 399965400, 0, -1562894820, 0, -3660437, 0, 1299467},
        {0, -385631462, 0, -941358046, 0, 1441291, 0, -510084},
        {-865414640, 0, -247531498, 0, 546932, 0, -193735, 0},
        {1167057306, 0, -132899847, 0, -31523234, 0, 11230899, 0},
        {0, -865414640, 0, -247531498, 0, 546932, 0, -193735},
        {0, 1167057306, 0, -132899847, 0, -31523234, 0, 11230899},
        {237565430, 0, 1400332082, 0, 547139, 0, -190546, 0},
        {611322570, 0, 1227903922, 0, -6016684, 0, 2125972, 0},
        {0, 237565430, 0, 1400332082, 0, 547139, 0, -190546},
        {0, 611322570, 0, 1227903922, 0, -6016684, 0, 2125972},
        {408488492, 0, -1287509385, 0, -13260239, 0, 4716575, 0},
        {-889801678, 0, 285100041, 0, 7061030, 0, -2513041, 0},
        {0, 408488492, 0, -1287509385, 0, -13260239, 0, 4716575},
        {0, -889801678, 0, 285100041, 0, 7061030, 0, -2513041},
        {655129820, 0, -1182532332, 0, -16960871, 0, 6018889, 0},
        {0, 655129820, 0, -1182532332, 0, -16960871, 0, 6018889},
    };
    static const int16_t shift[38] = {
        26, 26, 26, 26, 34, 34, 34, 34, 35, 37, 35, 37, 33, 33, 33, 33, 36, 34, 36, 34, 34, 34, 34, 34, 32, 33, 32, 33, 34, 36, 34, 36, 32, 33, 32, 33, 41, 41};
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
