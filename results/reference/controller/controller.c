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
static const float paper_tool_f32_output_guard = 0x1.72d7d6p23f;

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
        float u0 = 0x1.60a844p-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.612b84p0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.5d5efap9f * v; u2 += -0x1.7b1fbcp9f * v;
        v = x[5]; u0 += 0x1.d86e92p7f * v; u2 += 0x1.9b0380p9f * v;
        v = x[8]; u0 += 0x1.0d5ceap9f * v; u2 += -0x1.d62c0ap10f * v;
        v = x[9]; u0 += -0x1.2ae1f8p9f * v; u2 += 0x1.36eca2p9f * v;
        v = x[12]; u0 += 0x1.6e0468p10f * v; u2 += 0x1.f91694p8f * v;
        v = x[13]; u0 += 0x1.1514eap6f * v; u2 += -0x1.b7fbeep9f * v;
        v = x[16]; u0 += 0x1.8bf140p11f * v; u2 += -0x1.6a0ab0p11f * v;
        v = x[17]; u0 += 0x1.b8e6f0p9f * v; u2 += 0x1.392176p10f * v;
        v = x[20]; u0 += 0x1.41fa62p9f * v; u2 += -0x1.933466p9f * v;
        v = x[21]; u0 += -0x1.5f65c0p6f * v; u2 += -0x1.15e2cap7f * v;
        v = x[24]; u0 += -0x1.342834p8f * v; u2 += -0x1.83211ep5f * v;
        v = x[25]; u0 += 0x1.afefbap-4f * v; u2 += -0x1.a01430p4f * v;
        v = x[28]; u0 += 0x1.e60f98p6f * v; u2 += -0x1.ff1e8cp8f * v;
        v = x[29]; u0 += -0x1.e5de68p9f * v; u2 += -0x1.39643cp6f * v;
        v = x[32]; u0 += 0x1.06be18p8f * v; u2 += -0x1.38fe2ap7f * v;
        v = x[33]; u0 += -0x1.2b7126p7f * v; u2 += 0x1.044bb2p7f * v;
        v = x[36]; u0 += -0x1.da9a9cp4f * v; u2 += 0x1.7a4814p5f * v;
        v = y0; u0 += -0x1.c161acp19f * v; u2 += 0x1.9e6b24p19f * v;
        v = y2; u0 += 0x1.399204p17f * v; u2 += -0x1.48d8cep18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.60a844p-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.612b84p0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.5d5efap9f * v; u3 += -0x1.7b1fbcp9f * v;
        v = x[7]; u1 += 0x1.d86e92p7f * v; u3 += 0x1.9b0380p9f * v;
        v = x[10]; u1 += 0x1.0d5ceap9f * v; u3 += -0x1.d62c0ap10f * v;
        v = x[11]; u1 += -0x1.2ae1f8p9f * v; u3 += 0x1.36eca2p9f * v;
        v = x[14]; u1 += 0x1.6e0468p10f * v; u3 += 0x1.f91694p8f * v;
        v = x[15]; u1 += 0x1.1514eap6f * v; u3 += -0x1.b7fbeep9f * v;
        v = x[18]; u1 += 0x1.8bf140p11f * v; u3 += -0x1.6a0ab0p11f * v;
        v = x[19]; u1 += 0x1.b8e6f0p9f * v; u3 += 0x1.392176p10f * v;
        v = x[22]; u1 += 0x1.41fa62p9f * v; u3 += -0x1.933466p9f * v;
        v = x[23]; u1 += -0x1.5f65c0p6f * v; u3 += -0x1.15e2cap7f * v;
        v = x[26]; u1 += -0x1.342834p8f * v; u3 += -0x1.83211ep5f * v;
        v = x[27]; u1 += 0x1.afefbap-4f * v; u3 += -0x1.a01430p4f * v;
        v = x[30]; u1 += 0x1.e60f98p6f * v; u3 += -0x1.ff1e8cp8f * v;
        v = x[31]; u1 += -0x1.e5de68p9f * v; u3 += -0x1.39643cp6f * v;
        v = x[34]; u1 += 0x1.06be18p8f * v; u3 += -0x1.38fe2ap7f * v;
        v = x[35]; u1 += -0x1.2b7126p7f * v; u3 += 0x1.044bb2p7f * v;
        v = x[37]; u1 += -0x1.da9a9cp4f * v; u3 += 0x1.7a4814p5f * v;
        v = y1; u1 += -0x1.c161acp19f * v; u3 += 0x1.9e6b24p19f * v;
        v = y3; u1 += 0x1.399204p17f * v; u3 += -0x1.48d8cep18f * v;
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
        x[0] = -0x1.59b4c0p-10f * x0 + 0x1.6991cap7f * y0 - 0x1.ab6ca6p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.643ce0p-9f * x1 - 0x1.15d136p8f * y0 - 0x1.0859eap9f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.59b4c0p-10f * x2 + 0x1.6991cap7f * y1 - 0x1.ab6ca6p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.643ce0p-9f * x3 - 0x1.15d136p8f * y1 - 0x1.0859eap9f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.251c98p-4f * x4 + 0x1.3ee3f8p-2f * x5 - 0x1.17ce72p5f * y0 + 0x1.1aa7d4p4f * y2
            + x4;
        x[5] = -0x1.3ee3f8p-2f * x4 - 0x1.251c98p-4f * x5 + 0x1.a19e4ap5f * y0 - 0x1.71f684p2f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.251c98p-4f * x6 + 0x1.3ee3f8p-2f * x7 - 0x1.17ce72p5f * y1 + 0x1.1aa7d4p4f * y3
            + x6;
        x[7] = -0x1.3ee3f8p-2f * x6 - 0x1.251c98p-4f * x7 + 0x1.a19e4ap5f * y1 - 0x1.71f684p2f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.268524p-3f * x8 + 0x1.dd83f8p-2f * x9 - 0x1.0a1f86p6f * y0 + 0x1.2211d8p5f * y2
            + x8;
        x[9] = -0x1.dd83f8p-2f * x8 - 0x1.268524p-3f * x9 + 0x1.94efacp5f * y0 - 0x1.6dd0cap5f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.268524p-3f * x10 + 0x1.dd83f8p-2f * x11 - 0x1.0a1f86p6f * y1 + 0x1.2211d8p5f * y3
            + x10;
        x[11] = -0x1.dd83f8p-2f * x10 - 0x1.268524p-3f * x11 + 0x1.94efacp5f * y1 - 0x1.6dd0cap5f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.72caa0p-1f * x12 + 0x1.070930p-1f * x13 - 0x1.ef1ca8p7f * y0 + 0x1.48a62ap5f * y2;
        x[13] = -0x1.070930p-1f * x12 + 0x1.72caa0p-1f * x13 + 0x1.2af87ep8f * y0 + 0x1.b68624p6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.72caa0p-1f * x14 + 0x1.070930p-1f * x15 - 0x1.ef1ca8p7f * y1 + 0x1.48a62ap5f * y3;
        x[15] = -0x1.070930p-1f * x14 + 0x1.72caa0p-1f * x15 + 0x1.2af87ep8f * y1 + 0x1.b68624p6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.29b588p-1f * x16 + 0x1.7b4ffap-1f * x17 + 0x1.646e50p5f * y0 + 0x1.81e982p4f * y2;
        x[17] = -0x1.7b4ffap-1f * x16 + 0x1.29b588p-1f * x17 + 0x1.dcd45cp6f * y0 - 0x1.70d916p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.29b588p-1f * x18 + 0x1.7b4ffap-1f * x19 + 0x1.646e50p5f * y1 + 0x1.81e982p4f * y3;
        x[19] = -0x1.7b4ffap-1f * x18 + 0x1.29b588p-1f * x19 + 0x1.dcd45cp6f * y1 - 0x1.70d916p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.66c85ap-2f * x20 + 0x1.874bc0p-1f * x21 + 0x1.4ed14ep1f * y0 - 0x1.962346p9f * y2;
        x[21] = -0x1.874bc0p-1f * x20 + 0x1.66c85ap-2f * x21 + 0x1.52fa9ap4f * y0 + 0x1.732456p7f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.66c85ap-2f * x22 + 0x1.874bc0p-1f * x23 + 0x1.4ed14ep1f * y1 - 0x1.962346p9f * y3;
        x[23] = -0x1.874bc0p-1f * x22 + 0x1.66c85ap-2f * x23 + 0x1.52fa9ap4f * y1 + 0x1.732456p7f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.8b98b8p-3f * x24 + 0x1.3b2396p-2f * x25 - 0x1.a2e682p9f * y0 - 0x1.bfb980p7f * y2;
        x[25] = -0x1.3b2396p0f * x24 + 0x1.8b98b8p-3f * x25 + 0x1.8cd17cp9f * y0 + 0x1.19a00ap7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.8b98b8p-3f * x26 + 0x1.3b2396p-2f * x27 - 0x1.a2e682p9f * y1 - 0x1.bfb980p7f * y3;
        x[27] = -0x1.3b2396p0f * x26 + 0x1.8b98b8p-3f * x27 + 0x1.8cd17cp9f * y1 + 0x1.19a00ap7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.deaaf6p-4f * x28 + 0x1.d1205cp-1f * x29 + 0x1.5314fep6f * y0 + 0x1.d4b772p6f * y2;
        x[29] = -0x1.d1205cp-1f * x28 + 0x1.deaaf6p-4f * x29 + 0x1.34684cp3f * y0 + 0x1.2cdb58p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.deaaf6p-4f * x30 + 0x1.d1205cp-1f * x31 + 0x1.5314fep6f * y1 + 0x1.d4b772p6f * y3;
        x[31] = -0x1.d1205cp-1f * x30 + 0x1.deaaf6p-4f * x31 + 0x1.34684cp3f * y1 + 0x1.2cdb58p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.858966p-3f * x32 + 0x1.25070ep-3f * x33 - 0x1.74a14ap8f * y0 + 0x1.5910b0p10f * y2;
        x[33] = -0x1.25070ep-1f * x32 - 0x1.858966p-3f * x33 + 0x1.36ff38p9f * y0 - 0x1.0649e0p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.858966p-3f * x34 + 0x1.25070ep-3f * x35 - 0x1.74a14ap8f * y1 + 0x1.5910b0p10f * y3;
        x[35] = -0x1.25070ep-1f * x34 - 0x1.858966p-3f * x35 + 0x1.36ff38p9f * y1 - 0x1.0649e0p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.feb0f0p-1f * x36 + 0x1.8d3126p1f * y0 - 0x1.14d2b8p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.feb0f0p-1f * x37 + 0x1.8d3126p1f * y1 - 0x1.14d2b8p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += -0x1.d38cf0p-5f * e[0];
        x[0] += 0x1.343f90p-5f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.c6b332p-5f * e[0];
        x[1] += -0x1.686906p-6f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.d38cf0p-5f * e[1];
        x[2] += 0x1.343f90p-5f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.c6b332p-5f * e[1];
        x[3] += -0x1.686906p-6f * e[3];
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
        {-0x1.8afb8cp17f, 0.0f, 0x1.eb1310p15f, 0.0f, -0x1.3dafa6p0f, 0.0f, 0x1.345194p-1f, 0.0f},
        {0x1.51de72p17f, 0.0f, -0x1.ab065ep14f, 0.0f, 0x1.430aeep0f, 0.0f, -0x1.197d58p-2f, 0.0f},
        {0.0f, -0x1.8afb8cp17f, 0.0f, 0x1.eb1310p15f, 0.0f, -0x1.3dafa6p0f, 0.0f, 0x1.345194p-1f},
        {0.0f, 0x1.51de72p17f, 0.0f, -0x1.ab065ep14f, 0.0f, 0x1.430aeep0f, 0.0f, -0x1.197d58p-2f},
        {0x1.0e2ffcp7f, 0.0f, -0x1.250fe6p2f, 0.0f, 0x1.aca26ep-20f, 0.0f, -0x1.9bc4fep-23f, 0.0f},
        {0x1.1d7e1ap7f, 0.0f, -0x1.cf441ep5f, 0.0f, -0x1.dcb800p-19f, 0.0f, 0x1.2d758ep-20f, 0.0f},
        {0.0f, 0x1.0e2ffcp7f, 0.0f, -0x1.250fe6p2f, 0.0f, 0x1.aca26ep-20f, 0.0f, -0x1.9bc4fep-23f},
        {0.0f, 0x1.1d7e1ap7f, 0.0f, -0x1.cf441ep5f, 0.0f, -0x1.dcb800p-19f, 0.0f, 0x1.2d758ep-20f},
        {0x1.da582ep5f, 0.0f, -0x1.0e3c80p6f, 0.0f, 0x1.2d6a78p-19f, 0.0f, -0x1.649932p-21f, 0.0f},
        {0x1.443fecp7f, 0.0f, -0x1.89c218p6f, 0.0f, 0x1.18c38ap-17f, 0.0f, -0x1.5596e6p-19f, 0.0f},
        {0.0f, 0x1.da582ep5f, 0.0f, -0x1.0e3c80p6f, 0.0f, 0x1.2d6a78p-19f, 0.0f, -0x1.649932p-21f},
        {0.0f, 0x1.443fecp7f, 0.0f, -0x1.89c218p6f, 0.0f, 0x1.18c38ap-17f, 0.0f, -0x1.5596e6p-19f},
        {0x1.f46abep7f, 0.0f, 0x1.8c6290p7f, 0.0f, -0x1.f78334p-19f, 0.0f, 0x1.b583a6p-21f, 0.0f},
        {0x1.369e34p9f, 0.0f, 0x1.b53016p4f, 0.0f, 0x1.01e206p-15f, 0.0f, -0x1.3c6ba4p-17f, 0.0f},
        {0.0f, 0x1.f46abep7f, 0.0f, 0x1.8c6290p7f, 0.0f, -0x1.f78334p-19f, 0.0f, 0x1.b583a6p-21f},
        {0.0f, 0x1.369e34p9f, 0.0f, 0x1.b53016p4f, 0.0f, 0x1.01e206p-15f, 0.0f, -0x1.3c6ba4p-17f},
        {0x1.26a3bcp7f, 0.0f, -0x1.5d94a2p7f, 0.0f, -0x1.7121bcp-19f, 0.0f, 0x1.c9630ap-21f, 0.0f},
        {0x1.7a0fccp4f, 0.0f, -0x1.066a7ep7f, 0.0f, 0x1.0664aep-19f, 0.0f, -0x1.352044p-21f, 0.0f},
        {0.0f, 0x1.26a3bcp7f, 0.0f, -0x1.5d94a2p7f, 0.0f, -0x1.7121bcp-19f, 0.0f, 0x1.c9630ap-21f},
        {0.0f, 0x1.7a0fccp4f, 0.0f, -0x1.066a7ep7f, 0.0f, 0x1.0664aep-19f, 0.0f, -0x1.352044p-21f},
        {0x1.0c3b10p4f, 0.0f, -0x1.7f0258p8f, 0.0f, -0x1.00a706p-17f, 0.0f, 0x1.61b166p-19f, 0.0f},
        {0x1.f9f48ap3f, 0.0f, 0x1.70eed6p9f, 0.0f, 0x1.b9277cp-16f, 0.0f, -0x1.0521ecp-17f, 0.0f},
        {0.0f, 0x1.0c3b10p4f, 0.0f, -0x1.7f0258p8f, 0.0f, -0x1.00a706p-17f, 0.0f, 0x1.61b166p-19f},
        {0.0f, 0x1.f9f48ap3f, 0.0f, 0x1.70eed6p9f, 0.0f, 0x1.b9277cp-16f, 0.0f, -0x1.0521ecp-17f},
        {-0x1.ba0838p8f, -0.0f, -0x1.05a16ep7f, 0.0f, -0x1.4b575ap-13f, -0.0f, 0x1.a9960ap-15f, 0.0f},
        {0x1.8692a4p10f, 0.0f, 0x1.766810p8f, 0.0f, -0x1.aa7ab6p-12f, 0.0f, 0x1.084770p-13f, 0.0f},
        {0.0f, -0x1.ba0838p8f, 0.0f, -0x1.05a16ep7f, 0.0f, -0x1.4b575ap-13f, 0.0f, 0x1.a9960ap-15f},
        {0.0f, 0x1.8692a4p10f, 0.0f, 0x1.766810p8f, 0.0f, -0x1.aa7ab6p-12f, 0.0f, 0x1.084770p-13f},
        {0x1.a22e20p5f, 0.0f, 0x1.2b8134p7f, 0.0f, 0x1.09b65cp-20f, 0.0f, -0x1.03117ep-22f, 0.0f},
        {-0x1.4fc7e4p5f, 0.0f, 0x1.04acc2p4f, 0.0f, 0x1.4cf402p-18f, 0.0f, -0x1.b4e206p-20f, 0.0f},
        {0.0f, 0x1.a22e20p5f, 0.0f, 0x1.2b8134p7f, 0.0f, 0x1.09b65cp-20f, 0.0f, -0x1.03117ep-22f},
        {0.0f, -0x1.4fc7e4p5f, 0.0f, 0x1.04acc2p4f, 0.0f, 0x1.4cf402p-18f, 0.0f, -0x1.b4e206p-20f},
        {-0x1.82c8a0p7f, 0.0f, 0x1.f5d3eap9f, 0.0f, 0x1.263286p-12f, 0.0f, -0x1.62c76ep-14f, 0.0f},
        {0x1.342c06p9f, 0.0f, -0x1.54e804p10f, 0.0f, -0x1.11c446p-13f, 0.0f, 0x1.4b8606p-15f, 0.0f},
        {0.0f, -0x1.82c8a0p7f, 0.0f, 0x1.f5d3eap9f, 0.0f, 0x1.263286p-12f, 0.0f, -0x1.62c76ep-14f},
        {0.0f, 0x1.342c06p9f, 0.0f, -0x1.54e804p10f, -0.0f, -0x1.11c446p-13f, 0.0f, 0x1.4b8606p-15f},
        {0x1.713b66p0f, 0.0f, -0x1.184f54p1f, 0.0f, -0x1.7ef06ep-21f, -0.0f, 0x1.c8f6e4p-23f, 0.0f},
        {0.0f, 0x1.713b66p0f, 0.0f, -0x1.184f54p1f, 0.0f, -0x1.7ef06ep-21f, 0.0f, 0x1.c8f6e4p-23f},
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
/* Over the test vectors Q31 stays within 2.963e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 120374 * (int64_t)v, u2 = 524288 * (int64_t)v;
        v = x[1]; u0 += 241097 * (int64_t)v; u2 += 524288 * (int64_t)v;
        v = x[4]; u0 += -122114012 * (int64_t)v; u2 += -132513428 * (int64_t)v;
        v = x[5]; u0 += 41281730 * (int64_t)v; u2 += 143659691 * (int64_t)v;
        v = x[8]; u0 += 94149175 * (int64_t)v; u2 += -328674078 * (int64_t)v;
        v = x[9]; u0 += -104467074 * (int64_t)v; u2 += 108675941 * (int64_t)v;
        v = x[12]; u0 += 255864567 * (int64_t)v; u2 += 88270561 * (int64_t)v;
        v = x[13]; u0 += 12105884 * (int64_t)v; u2 += -153785595 * (int64_t)v;
        v = x[16]; u0 += 553567589 * (int64_t)v; u2 += -506171063 * (int64_t)v;
        v = x[17]; u0 += 154106452 * (int64_t)v; u2 += 218894228 * (int64_t)v;
        v = x[20]; u0 += 112539486 * (int64_t)v; u2 += -140930255 * (int64_t)v;
        v = x[21]; u0 += -15352789 * (int64_t)v; u2 += -24282039 * (int64_t)v;
        v = x[24]; u0 += -53854346 * (int64_t)v; u2 += -8456970 * (int64_t)v;
        v = x[25]; u0 += 18429 * (int64_t)v; u2 += -4544691 * (int64_t)v;
        v = x[28]; u0 += 21236325 * (int64_t)v; u2 += -89324574 * (int64_t)v;
        v = x[29]; u0 += -169823446 * (int64_t)v; u2 += -13692285 * (int64_t)v;
        v = x[32]; u0 += 45917590 * (int64_t)v; u2 += -27349730 * (int64_t)v;
        v = x[33]; u0 += -26165640 * (int64_t)v; u2 += 22744985 * (int64_t)v;
        v = x[36]; u0 += -5183941 * (int64_t)v; u2 += 8263687 * (int64_t)v;
        v = y0; u0 += -40853337 * (int64_t)v; u2 += 37674847 * (int64_t)v;
        v = y2; u0 += 7126682 * (int64_t)v; u2 += -14947759 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 19);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 120374 * (int64_t)v, u3 = 524288 * (int64_t)v;
        v = x[3]; u1 += 241097 * (int64_t)v; u3 += 524288 * (int64_t)v;
        v = x[6]; u1 += -122114012 * (int64_t)v; u3 += -132513428 * (int64_t)v;
        v = x[7]; u1 += 41281730 * (int64_t)v; u3 += 143659691 * (int64_t)v;
        v = x[10]; u1 += 94149175 * (int64_t)v; u3 += -328674078 * (int64_t)v;
        v = x[11]; u1 += -104467074 * (int64_t)v; u3 += 108675941 * (int64_t)v;
        v = x[14]; u1 += 255864567 * (int64_t)v; u3 += 88270561 * (int64_t)v;
        v = x[15]; u1 += 12105884 * (int64_t)v; u3 += -153785595 * (int64_t)v;
        v = x[18]; u1 += 553567589 * (int64_t)v; u3 += -506171063 * (int64_t)v;
        v = x[19]; u1 += 154106452 * (int64_t)v; u3 += 218894228 * (int64_t)v;
        v = x[22]; u1 += 112539486 * (int64_t)v; u3 += -140930255 * (int64_t)v;
        v = x[23]; u1 += -15352789 * (int64_t)v; u3 += -24282039 * (int64_t)v;
        v = x[26]; u1 += -53854346 * (int64_t)v; u3 += -8456970 * (int64_t)v;
        v = x[27]; u1 += 18429 * (int64_t)v; u3 += -4544691 * (int64_t)v;
        v = x[30]; u1 += 21236325 * (int64_t)v; u3 += -89324574 * (int64_t)v;
        v = x[31]; u1 += -169823446 * (int64_t)v; u3 += -13692285 * (int64_t)v;
        v = x[34]; u1 += 45917590 * (int64_t)v; u3 += -27349730 * (int64_t)v;
        v = x[35]; u1 += -26165640 * (int64_t)v; u3 += 22744985 * (int64_t)v;
        v = x[37]; u1 += -5183941 * (int64_t)v; u3 += 8263687 * (int64_t)v;
        v = y1; u1 += -40853337 * (int64_t)v; u3 += 37674847 * (int64_t)v;
        v = y3; u1 += 7126682 * (int64_t)v; u3 += -14947759 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1416012 * (int64_t)x0 + 49305499 * (int64_t)y0 - 29142909 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2918300 * (int64_t)x1 - 75769212 * (int64_t)y0 - 144193249 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1416012 * (int64_t)x2 + 49305499 * (int64_t)y1 - 29142909 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2918300 * (int64_t)x3 - 75769212 * (int64_t)y1 - 144193249 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-76837472 * (int64_t)x4 + 334380922 * (int64_t)x5 - 9538965 * (int64_t)y0 + 4818048 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-334380922 * (int64_t)x4 - 76837472 * (int64_t)x5 + 14237153 * (int64_t)y0 - 1576565 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-76837472 * (int64_t)x6 + 334380922 * (int64_t)x7 - 9538965 * (int64_t)y1 + 4818048 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-334380922 * (int64_t)x6 - 76837472 * (int64_t)x7 + 14237153 * (int64_t)y1 - 1576565 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-154413343 * (int64_t)x8 + 500711292 * (int64_t)x9 - 18144968 * (int64_t)y0 + 9888854 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-500711292 * (int64_t)x8 - 154413343 * (int64_t)x9 + 13804803 * (int64_t)y0 - 12471130 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-154413343 * (int64_t)x10 + 500711292 * (int64_t)x11 - 18144968 * (int64_t)y1 + 9888854 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-500711292 * (int64_t)x10 - 154413343 * (int64_t)x11 + 13804803 * (int64_t)y1 - 12471130 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(777606157 * (int64_t)x12 + 551626224 * (int64_t)x13 - 67516045 * (int64_t)y0 + 11204075 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-551626224 * (int64_t)x12 + 777606157 * (int64_t)x13 + 81538398 * (int64_t)y0 + 29899708 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(777606157 * (int64_t)x14 + 551626224 * (int64_t)x15 - 67516045 * (int64_t)y1 + 11204075 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-551626224 * (int64_t)x14 + 777606157 * (int64_t)x15 + 81538398 * (int64_t)y1 + 29899708 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(624341249 * (int64_t)x16 + 795475769 * (int64_t)x17 + 12151194 * (int64_t)y0 + 6578124 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-795475769 * (int64_t)x16 + 624341249 * (int64_t)x17 + 32511480 * (int64_t)y0 - 50298033 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(624341249 * (int64_t)x18 + 795475769 * (int64_t)x19 + 12151194 * (int64_t)y1 + 6578124 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-795475769 * (int64_t)x18 + 624341249 * (int64_t)x19 + 32511480 * (int64_t)y1 - 50298033 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(376210840 * (int64_t)x20 + 820606966 * (int64_t)x21 + 713398 * (int64_t)y0 - 221532258 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-820606966 * (int64_t)x20 + 376210840 * (int64_t)x21 + 5778117 * (int64_t)y0 + 50610850 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(376210840 * (int64_t)x22 + 820606966 * (int64_t)x23 + 713398 * (int64_t)y1 - 221532258 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-820606966 * (int64_t)x22 + 376210840 * (int64_t)x23 + 5778117 * (int64_t)y1 + 50610850 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(414813063 * (int64_t)x24 + 660894409 * (int64_t)x25 - 456987557 * (int64_t)y0 - 122108124 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-1321788818 * (int64_t)x24 + 207406532 * (int64_t)x25 + 216448847 * (int64_t)y0 + 38403872 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(414813063 * (int64_t)x26 + 660894409 * (int64_t)x27 - 456987557 * (int64_t)y1 - 122108124 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-1321788818 * (int64_t)x26 + 207406532 * (int64_t)x27 + 216448847 * (int64_t)y1 + 38403872 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(125479900 * (int64_t)x28 + 975440782 * (int64_t)x29 + 23119495 * (int64_t)y0 + 31958318 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-975440782 * (int64_t)x28 + 125479900 * (int64_t)x29 + 2628503 * (int64_t)y0 + 41026403 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(125479900 * (int64_t)x30 + 975440782 * (int64_t)x31 + 23119495 * (int64_t)y1 + 31958318 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-975440782 * (int64_t)x30 + 125479900 * (int64_t)x31 + 2628503 * (int64_t)y1 + 41026403 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-408458850 * (int64_t)x32 + 307261667 * (int64_t)x33 - 203255095 * (int64_t)y0 + 752878160 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-614523334 * (int64_t)x32 - 204229425 * (int64_t)x33 + 169636652 * (int64_t)y0 - 286136311 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-408458850 * (int64_t)x34 + 307261667 * (int64_t)x35 - 203255095 * (int64_t)y1 + 752878160 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-614523334 * (int64_t)x34 - 204229425 * (int64_t)x35 + 169636652 * (int64_t)y1 - 286136311 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2141993953 * (int64_t)x36 + 1692599 * (int64_t)y0 - 2359315 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2141993953 * (int64_t)x37 + 1692599 * (int64_t)y1 - 2359315 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], -735393431 * (int64_t)e[0] + 484832638 * (int64_t)e[2], 20);
        x[1] = paper_tool_q31_correct(x[1], 1430362455 * (int64_t)e[0] - 566876328 * (int64_t)e[2], 21);
        x[2] = paper_tool_q31_correct(x[2], -735393431 * (int64_t)e[1] + 484832638 * (int64_t)e[3], 20);
        x[3] = paper_tool_q31_correct(x[3], 1430362455 * (int64_t)e[1] - 566876328 * (int64_t)e[3], 21);
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
        {-861790176, 0, 267861886, 0, -62459632, 0, 30308957, 0},
        {1474354128, 0, -232925353, 0, 127025554, 0, -27671556, 0},
        {0, -861790176, 0, 267861886, 0, -62459632, 0, 30308957},
        {0, 1474354128, 0, -232925353, 0, 127025554, 0, -27671556},
        {1179013340, 0, -39963477, 0, 164596, 0, -19765, 0},
        {1245800190, 0, -505387031, 0, -366120, 0, 115760, 0},
        {0, 1179013340, 0, -39963477, 0, 164596, 0, -19765},
        {0, 1245800190, 0, -505387031, 0, -366120, 0, 115760},
        {517472643, 0, -589613377, 0, 231487, 0, -68467, 0},
        {707462029, 0, -429559332, 0, 431253, 0, -131170, 0},
        {0, 517472643, 0, -589613377, 0, 231487, 0, -68467},
        {0, 707462029, 0, -429559332, 0, 431253, 0, -131170},
        {1091831455, 0, 864849988, 0, -193349, 0, 42001, 0},
        {1355439582, 0, 59617211, 0, 792216, 0, -243011, 0},
        {0, 1091831455, 0, 864849988, 0, -193349, 0, 42001},
        {0, 1355439582, 0, 59617211, 0, 792216, 0, -243011},
        {642857427, 0, -762730118, 0, -141747, 0, 43909, 0},
        {206217851, 0, -1145101133, 0, 201518, 0, -59352, 0},
        {0, 642857427, 0, -762730118, 0, -141747, 0, 43909},
        {0, 206217851, 0, -1145101133, 0, 201518, 0, -59352},
        {73154679, 0, -1671332034, 0, -394218, 0, 135818, 0},
        {34497346, 0, 1609907804, 0, 677613, 0, -200550, 0},
        {0, 73154679, 0, -1671332034, 0, -394218, 0, 135818},
        {0, 34497346, 0, 1609907804, 0, 677613, 0, -200550},
        {-964444854, 0, -285418482, 0, -4071521, 0, 1307400, 0},
        {1704337360, 0, 408448163, 0, -5240578, 0, 1623731, 0},
        {0, -964444854, 0, -285418482, 0, -4071521, 0, 1307400},
        {0, 1704337360, 0, 408448163, 0, -5240578, 0, 1623731},
        {456201838, 0, 1306944733, 0, 102034, 0, -24871, 0},
        {-1465242318, 0, 568751655, 0, 2045664, 0, -671052, 0},
        {0, 456201838, 0, 1306944733, 0, 102034, 0, -24871},
        {0, -1465242318, 0, 568751655, 0, 2045664, 0, -671052},
        {-210975355, 0, 1094909658, 0, 3615097, 0, -1089881, 0},
        {336191482, 0, -743804175, 0, -841011, 0, 254610, 0},
        {0, -210975355, 0, 1094909658, 0, 3615097, 0, -1089881},
        {0, 336191482, 0, -743804175, 0, -841011, 0, 254610},
        {805606474, 0, -1223184538, 0, -4705557, 0, 1403795, 0},
        {0, 805606474, 0, -1223184538, 0, -4705557, 0, 1403795},
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
