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
static const float paper_tool_f32_output_guard = 0x1.d1c656p23f;

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
        float u0 = 0x1.f67358p-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.d1aed2p-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.924992p9f * v; u2 += 0x1.d1d158p9f * v;
        v = x[5]; u0 += -0x1.814730p6f * v; u2 += -0x1.af1f98p9f * v;
        v = x[8]; u0 += 0x1.f7634ep9f * v; u2 += -0x1.c5bc68p11f * v;
        v = x[9]; u0 += -0x1.79d3fap9f * v; u2 += 0x1.5ffb86p10f * v;
        v = x[12]; u0 += -0x1.a1d748p10f * v; u2 += -0x1.1f349cp9f * v;
        v = x[13]; u0 += -0x1.7f04dep8f * v; u2 += 0x1.f5270cp9f * v;
        v = x[16]; u0 += -0x1.cf0998p11f * v; u2 += 0x1.3c5d9cp11f * v;
        v = x[17]; u0 += 0x1.a07e78p2f * v; u2 += -0x1.c7da38p10f * v;
        v = x[20]; u0 += 0x1.3bcab0p9f * v; u2 += -0x1.89b056p9f * v;
        v = x[21]; u0 += -0x1.d71b4ep5f * v; u2 += -0x1.32eb6cp8f * v;
        v = x[24]; u0 += -0x1.2f1916p6f * v; u2 += -0x1.040f2ep5f * v;
        v = x[25]; u0 += 0x1.2840d4p8f * v; u2 += 0x1.c3e0b2p1f * v;
        v = x[28]; u0 += -0x1.d77bc2p8f * v; u2 += -0x1.0b9896p7f * v;
        v = x[29]; u0 += -0x1.136ca4p7f * v; u2 += 0x1.c54bf4p7f * v;
        v = x[32]; u0 += 0x1.872d74p6f * v; u2 += -0x1.47ca3ep6f * v;
        v = x[33]; u0 += 0x1.6f3aeap8f * v; u2 += -0x1.c0379ap7f * v;
        v = x[36]; u0 += -0x1.ce1c30p4f * v; u2 += 0x1.6e3e7ap5f * v;
        v = y0; u0 += -0x1.01188ap20f * v; u2 += 0x1.adde0ep19f * v;
        v = y2; u0 += 0x1.25c6a4p16f * v; u2 += -0x1.0c6592p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.f67358p-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.d1aed2p-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.924992p9f * v; u3 += 0x1.d1d158p9f * v;
        v = x[7]; u1 += -0x1.814730p6f * v; u3 += -0x1.af1f98p9f * v;
        v = x[10]; u1 += 0x1.f7634ep9f * v; u3 += -0x1.c5bc68p11f * v;
        v = x[11]; u1 += -0x1.79d3fap9f * v; u3 += 0x1.5ffb86p10f * v;
        v = x[14]; u1 += -0x1.a1d748p10f * v; u3 += -0x1.1f349cp9f * v;
        v = x[15]; u1 += -0x1.7f04dep8f * v; u3 += 0x1.f5270cp9f * v;
        v = x[18]; u1 += -0x1.cf0998p11f * v; u3 += 0x1.3c5d9cp11f * v;
        v = x[19]; u1 += 0x1.a07e78p2f * v; u3 += -0x1.c7da38p10f * v;
        v = x[22]; u1 += 0x1.3bcab0p9f * v; u3 += -0x1.89b056p9f * v;
        v = x[23]; u1 += -0x1.d71b4ep5f * v; u3 += -0x1.32eb6cp8f * v;
        v = x[26]; u1 += -0x1.2f1916p6f * v; u3 += -0x1.040f2ep5f * v;
        v = x[27]; u1 += 0x1.2840d4p8f * v; u3 += 0x1.c3e0b2p1f * v;
        v = x[30]; u1 += -0x1.d77bc2p8f * v; u3 += -0x1.0b9896p7f * v;
        v = x[31]; u1 += -0x1.136ca4p7f * v; u3 += 0x1.c54bf4p7f * v;
        v = x[34]; u1 += 0x1.872d74p6f * v; u3 += -0x1.47ca3ep6f * v;
        v = x[35]; u1 += 0x1.6f3aeap8f * v; u3 += -0x1.c0379ap7f * v;
        v = x[37]; u1 += -0x1.ce1c30p4f * v; u3 += 0x1.6e3e7ap5f * v;
        v = y1; u1 += -0x1.01188ap20f * v; u3 += 0x1.adde0ep19f * v;
        v = y3; u1 += 0x1.25c6a4p16f * v; u3 += -0x1.0c6592p18f * v;
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
        x[0] = -0x1.7387f8p-10f * x0 + 0x1.7316a8p7f * y0 - 0x1.b1c674p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.294006p-9f * x1 - 0x1.426016p8f * y0 - 0x1.f3ef6cp8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.7387f8p-10f * x2 + 0x1.7316a8p7f * y1 - 0x1.b1c674p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.294006p-9f * x3 - 0x1.426016p8f * y1 - 0x1.f3ef6cp8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.378b46p-4f * x4 + 0x1.3d5938p-2f * x5 + 0x1.2b48ecp5f * y0 - 0x1.33d21ep4f * y2
            + x4;
        x[5] = -0x1.3d5938p-2f * x4 - 0x1.378b46p-4f * x5 - 0x1.ae5f56p5f * y0 + 0x1.25f1d8p1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.378b46p-4f * x6 + 0x1.3d5938p-2f * x7 + 0x1.2b48ecp5f * y1 - 0x1.33d21ep4f * y3
            + x6;
        x[7] = -0x1.3d5938p-2f * x6 - 0x1.378b46p-4f * x7 - 0x1.ae5f56p5f * y1 + 0x1.25f1d8p1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1d2d48p-3f * x8 + 0x1.e07e50p-2f * x9 - 0x1.02b646p5f * y0 + 0x1.443a2cp4f * y2
            + x8;
        x[9] = -0x1.e07e50p-2f * x8 - 0x1.1d2d48p-3f * x9 + 0x1.aac894p4f * y0 - 0x1.33bdd0p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1d2d48p-3f * x10 + 0x1.e07e50p-2f * x11 - 0x1.02b646p5f * y1 + 0x1.443a2cp4f * y3
            + x10;
        x[11] = -0x1.e07e50p-2f * x10 - 0x1.1d2d48p-3f * x11 + 0x1.aac894p4f * y1 - 0x1.33bdd0p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6a63d0p-1f * x12 + 0x1.065268p-1f * x13 + 0x1.07b350p8f * y0 - 0x1.9031a4p5f * y2;
        x[13] = -0x1.065268p-1f * x12 + 0x1.6a63d0p-1f * x13 - 0x1.278e34p8f * y0 - 0x1.1eb8b0p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6a63d0p-1f * x14 + 0x1.065268p-1f * x15 + 0x1.07b350p8f * y1 - 0x1.9031a4p5f * y3;
        x[15] = -0x1.065268p-1f * x14 + 0x1.6a63d0p-1f * x15 - 0x1.278e34p8f * y1 - 0x1.1eb8b0p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.26e6f0p-1f * x16 + 0x1.7ad81cp-1f * x17 - 0x1.66a008p6f * y0 + 0x1.e16f0cp4f * y2;
        x[17] = -0x1.7ad81cp-1f * x16 + 0x1.26e6f0p-1f * x17 - 0x1.9dd30ap6f * y0 + 0x1.6e6b94p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.26e6f0p-1f * x18 + 0x1.7ad81cp-1f * x19 - 0x1.66a008p6f * y1 + 0x1.e16f0cp4f * y3;
        x[19] = -0x1.7ad81cp-1f * x18 + 0x1.26e6f0p-1f * x19 - 0x1.9dd30ap6f * y1 + 0x1.6e6b94p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.683314p-2f * x20 + 0x1.8a4bfcp-1f * x21 + 0x1.4f26ecp3f * y0 - 0x1.7cddd0p9f * y2;
        x[21] = -0x1.8a4bfcp-1f * x20 + 0x1.683314p-2f * x21 - 0x1.f718bep6f * y0 + 0x1.ad6134p6f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.683314p-2f * x22 + 0x1.8a4bfcp-1f * x23 + 0x1.4f26ecp3f * y1 - 0x1.7cddd0p9f * y3;
        x[23] = -0x1.8a4bfcp-1f * x22 + 0x1.683314p-2f * x23 - 0x1.f718bep6f * y1 + 0x1.ad6134p6f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.727c34p-3f * x24 + 0x1.451e74p0f * x25 + 0x1.424bd4p-4f * y0 - 0x1.6aaad8p7f * y2;
        x[25] = -0x1.451e74p-2f * x24 + 0x1.727c34p-3f * x25 + 0x1.eb1fa4p9f * y0 + 0x1.182dd6p8f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.727c34p-3f * x26 + 0x1.451e74p0f * x27 + 0x1.424bd4p-4f * y1 - 0x1.6aaad8p7f * y3;
        x[27] = -0x1.451e74p-2f * x26 + 0x1.727c34p-3f * x27 + 0x1.eb1fa4p9f * y1 + 0x1.182dd6p8f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e60712p-4f * x28 + 0x1.caa002p-1f * x29 + 0x1.a954acp5f * y0 + 0x1.763d9ap8f * y2;
        x[29] = -0x1.caa002p-1f * x28 + 0x1.e60712p-4f * x29 - 0x1.d694e4p6f * y0 - 0x1.5b68d4p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e60712p-4f * x30 + 0x1.caa002p-1f * x31 + 0x1.a954acp5f * y1 + 0x1.763d9ap8f * y3;
        x[31] = -0x1.caa002p-1f * x30 + 0x1.e60712p-4f * x31 - 0x1.d694e4p6f * y1 - 0x1.5b68d4p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.e2270cp-3f * x32 + 0x1.4f3da8p-1f * x33 - 0x1.373e24p8f * y0 - 0x1.befe42p6f * y2;
        x[33] = -0x1.4f3da8p-3f * x32 - 0x1.e2270cp-3f * x33 - 0x1.6f43acp9f * y0 + 0x1.60ad94p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.e2270cp-3f * x34 + 0x1.4f3da8p-1f * x35 - 0x1.373e24p8f * y1 - 0x1.befe42p6f * y3;
        x[35] = -0x1.4f3da8p-3f * x34 - 0x1.e2270cp-3f * x35 - 0x1.6f43acp9f * y1 + 0x1.60ad94p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fec502p-1f * x36 + 0x1.868ee4p1f * y0 - 0x1.0a7dd6p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fec502p-1f * x37 + 0x1.868ee4p1f * y1 - 0x1.0a7dd6p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.e5555ep-5f * e[0];
        x[0] += 0x1.26815cp-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.c31ffep-5f * e[0];
        x[1] += -0x1.05c0a6p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.e5555ep-5f * e[1];
        x[2] += 0x1.26815cp-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.c31ffep-5f * e[1];
        x[3] += -0x1.05c0a6p-4f * e[3];
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
        {0x1.95b970p16f, 0.0f, 0x1.683bf0p15f, 0.0f, 0x1.8f8990p-1f, 0.0f, -0x1.bb8d42p-5f, 0.0f},
        {-0x1.df6e6cp16f, 0.0f, -0x1.ef34a0p13f, 0.0f, -0x1.52e840p-1f, 0.0f, 0x1.6689d2p-2f, 0.0f},
        {0.0f, 0x1.95b970p16f, 0.0f, 0x1.683bf0p15f, 0.0f, 0x1.8f8990p-1f, 0.0f, -0x1.bb8d42p-5f},
        {0.0f, -0x1.df6e6cp16f, 0.0f, -0x1.ef34a0p13f, 0.0f, -0x1.52e840p-1f, 0.0f, 0x1.6689d2p-2f},
        {-0x1.0e39d0p7f, 0.0f, -0x1.01fd86p3f, 0.0f, 0x1.730c00p-18f, 0.0f, -0x1.ffe976p-20f, 0.0f},
        {-0x1.28d306p7f, 0.0f, 0x1.e28bb4p5f, 0.0f, 0x1.336b0ep-15f, 0.0f, -0x1.86b5a0p-17f, 0.0f},
        {0.0f, -0x1.0e39d0p7f, 0.0f, -0x1.01fd86p3f, 0.0f, 0x1.730c00p-18f, 0.0f, -0x1.ffe976p-20f},
        {0.0f, -0x1.28d306p7f, 0.0f, 0x1.e28bb4p5f, 0.0f, 0x1.336b0ep-15f, 0.0f, -0x1.86b5a0p-17f},
        {0x1.10525cp5f, 0.0f, -0x1.9d759ap4f, 0.0f, 0x1.fa6d2ep-19f, 0.0f, -0x1.3f2bc0p-20f, 0.0f},
        {0x1.493dd4p6f, 0.0f, -0x1.95cd1ap5f, 0.0f, 0x1.776bbep-16f, 0.0f, -0x1.dbbb7ap-18f, 0.0f},
        {0.0f, 0x1.10525cp5f, 0.0f, -0x1.9d759ap4f, 0.0f, 0x1.fa6d2ep-19f, 0.0f, -0x1.3f2bc0p-20f},
        {0.0f, 0x1.493dd4p6f, 0.0f, -0x1.95cd1ap5f, 0.0f, 0x1.776bbep-16f, 0.0f, -0x1.dbbb7ap-18f},
        {-0x1.9fc5b2p7f, 0.0f, -0x1.f86cb0p7f, 0.0f, 0x1.357ea4p-15f, 0.0f, -0x1.8320f6p-17f, 0.0f},
        {-0x1.4d7114p9f, 0.0f, -0x1.7f1494p5f, 0.0f, -0x1.9a4cacp-13f, 0.0f, 0x1.040f3ap-14f, 0.0f},
        {0.0f, -0x1.9fc5b2p7f, 0.0f, -0x1.f86cb0p7f, 0.0f, 0x1.357ea4p-15f, 0.0f, -0x1.8320f6p-17f},
        {0.0f, -0x1.4d7114p9f, 0.0f, -0x1.7f1494p5f, 0.0f, -0x1.9a4cacp-13f, 0.0f, 0x1.040f3ap-14f},
        {-0x1.36ecf6p7f, 0.0f, 0x1.97f30ap7f, 0.0f, 0x1.c19fbep-17f, 0.0f, -0x1.1d98f0p-18f, 0.0f},
        {0x1.c2ec40p4f, 0.0f, 0x1.30317cp6f, 0.0f, -0x1.2510fep-16f, 0.0f, 0x1.72caf0p-18f, 0.0f},
        {0.0f, -0x1.36ecf6p7f, 0.0f, 0x1.97f30ap7f, 0.0f, 0x1.c19fbep-17f, 0.0f, -0x1.1d98f0p-18f},
        {0.0f, 0x1.c2ec40p4f, 0.0f, 0x1.30317cp6f, 0.0f, -0x1.2510fep-16f, 0.0f, 0x1.72caf0p-18f},
        {-0x1.88b5c8p6f, 0.0f, -0x1.956dd8p8f, 0.0f, -0x1.0078c8p-14f, 0.0f, 0x1.478728p-16f, 0.0f},
        {-0x1.1e4366p6f, 0.0f, 0x1.447410p9f, 0.0f, 0x1.c43b9ep-14f, 0.0f, -0x1.1d6f80p-15f, 0.0f},
        {0.0f, -0x1.88b5c8p6f, 0.0f, -0x1.956dd8p8f, 0.0f, -0x1.0078c8p-14f, 0.0f, 0x1.478728p-16f},
        {0.0f, -0x1.1e4366p6f, 0.0f, 0x1.447410p9f, 0.0f, 0x1.c43b9ep-14f, 0.0f, -0x1.1d6f80p-15f},
        {0x1.18aa3ep9f, 0.0f, 0x1.61e59ap7f, 0.0f, -0x1.fde674p-9f, 0.0f, 0x1.439444p-10f, 0.0f},
        {0x1.9cee2cp9f, 0.0f, 0x1.0b6934p8f, 0.0f, 0x1.06f33ap-11f, 0.0f, -0x1.4e9a10p-13f, 0.0f},
        {0.0f, 0x1.18aa3ep9f, 0.0f, 0x1.61e59ap7f, 0.0f, -0x1.fde674p-9f, 0.0f, 0x1.439444p-10f},
        {0.0f, 0x1.9cee2cp9f, 0.0f, 0x1.0b6934p8f, 0.0f, 0x1.06f33ap-11f, 0.0f, -0x1.4e9a10p-13f},
        {-0x1.487ecep4f, 0.0f, 0x1.b9e7bap6f, 0.0f, 0x1.c3a08cp-14f, 0.0f, -0x1.1f27e8p-15f, 0.0f},
        {-0x1.645636p6f, 0.0f, -0x1.3575a8p8f, 0.0f, 0x1.740538p-15f, 0.0f, -0x1.db19d2p-17f, 0.0f},
        {0.0f, -0x1.487ecep4f, 0.0f, 0x1.b9e7bap6f, 0.0f, 0x1.c3a08cp-14f, 0.0f, -0x1.1f27e8p-15f},
        {0.0f, -0x1.645636p6f, 0.0f, -0x1.3575a8p8f, 0.0f, 0x1.740538p-15f, 0.0f, -0x1.db19d2p-17f},
        {-0x1.01040ep9f, 0.0f, 0x1.e0db88p8f, 0.0f, 0x1.b17c3ep-14f, 0.0f, -0x1.1402b8p-15f, 0.0f},
        {-0x1.2b0f8ap8f, 0.0f, 0x1.104e24p10f, 0.0f, 0x1.7c9f4ap-10f, 0.0f, -0x1.e1ef90p-12f, 0.0f},
        {0.0f, -0x1.01040ep9f, 0.0f, 0x1.e0db88p8f, 0.0f, 0x1.b17c3ep-14f, 0.0f, -0x1.1402b8p-15f},
        {0.0f, -0x1.2b0f8ap8f, 0.0f, 0x1.104e24p10f, 0.0f, 0x1.7c9f4ap-10f, 0.0f, -0x1.e1ef90p-12f},
        {0x1.fdad38p-1f, 0.0f, -0x1.0f6d2ap1f, 0.0f, -0x1.c9c1c6p-19f, -0.0f, 0x1.214da6p-20f, 0.0f},
        {0.0f, 0x1.fdad38p-1f, 0.0f, -0x1.0f6d2ap1f, 0.0f, -0x1.c9c1c6p-19f, 0.0f, 0x1.214da6p-20f},
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
/* Over the test vectors Q31 stays within 5.101e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 171503 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 158953 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 140609627 * (int64_t)v; u2 += 81407554 * (int64_t)v;
        v = x[5]; u0 += -16833056 * (int64_t)v; u2 += -75344278 * (int64_t)v;
        v = x[8]; u0 += 175946823 * (int64_t)v; u2 += -317184437 * (int64_t)v;
        v = x[9]; u0 += -132060472 * (int64_t)v; u2 += 123026811 * (int64_t)v;
        v = x[12]; u0 += -292091988 * (int64_t)v; u2 += -50192801 * (int64_t)v;
        v = x[13]; u0 += -66937426 * (int64_t)v; u2 += 87582751 * (int64_t)v;
        v = x[16]; u0 += -647373322 * (int64_t)v; u2 += 221155628 * (int64_t)v;
        v = x[17]; u0 += 1137306 * (int64_t)v; u2 += -159331963 * (int64_t)v;
        v = x[20]; u0 += 110377212 * (int64_t)v; u2 += -68802107 * (int64_t)v;
        v = x[21]; u0 += -10291482 * (int64_t)v; u2 += -26819046 * (int64_t)v;
        v = x[24]; u0 += -13242553 * (int64_t)v; u2 += -2840541 * (int64_t)v;
        v = x[25]; u0 += 51774004 * (int64_t)v; u2 += 308482 * (int64_t)v;
        v = x[28]; u0 += -82397700 * (int64_t)v; u2 += -11691449 * (int64_t)v;
        v = x[29]; u0 += -24066949 * (int64_t)v; u2 += 19804834 * (int64_t)v;
        v = x[32]; u0 += 17090808 * (int64_t)v; u2 += -7160682 * (int64_t)v;
        v = x[33]; u0 += 64178116 * (int64_t)v; u2 += -19582908 * (int64_t)v;
        v = x[36]; u0 += -5047475 * (int64_t)v; u2 += 4000362 * (int64_t)v;
        v = y0; u0 += -46745242 * (int64_t)v; u2 += 19539653 * (int64_t)v;
        v = y2; u0 += 3338402 * (int64_t)v; u2 += -6099997 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 171503 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 158953 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 140609627 * (int64_t)v; u3 += 81407554 * (int64_t)v;
        v = x[7]; u1 += -16833056 * (int64_t)v; u3 += -75344278 * (int64_t)v;
        v = x[10]; u1 += 175946823 * (int64_t)v; u3 += -317184437 * (int64_t)v;
        v = x[11]; u1 += -132060472 * (int64_t)v; u3 += 123026811 * (int64_t)v;
        v = x[14]; u1 += -292091988 * (int64_t)v; u3 += -50192801 * (int64_t)v;
        v = x[15]; u1 += -66937426 * (int64_t)v; u3 += 87582751 * (int64_t)v;
        v = x[18]; u1 += -647373322 * (int64_t)v; u3 += 221155628 * (int64_t)v;
        v = x[19]; u1 += 1137306 * (int64_t)v; u3 += -159331963 * (int64_t)v;
        v = x[22]; u1 += 110377212 * (int64_t)v; u3 += -68802107 * (int64_t)v;
        v = x[23]; u1 += -10291482 * (int64_t)v; u3 += -26819046 * (int64_t)v;
        v = x[26]; u1 += -13242553 * (int64_t)v; u3 += -2840541 * (int64_t)v;
        v = x[27]; u1 += 51774004 * (int64_t)v; u3 += 308482 * (int64_t)v;
        v = x[30]; u1 += -82397700 * (int64_t)v; u3 += -11691449 * (int64_t)v;
        v = x[31]; u1 += -24066949 * (int64_t)v; u3 += 19804834 * (int64_t)v;
        v = x[34]; u1 += 17090808 * (int64_t)v; u3 += -7160682 * (int64_t)v;
        v = x[35]; u1 += 64178116 * (int64_t)v; u3 += -19582908 * (int64_t)v;
        v = x[37]; u1 += -5047475 * (int64_t)v; u3 += 4000362 * (int64_t)v;
        v = y1; u1 += -46745242 * (int64_t)v; u3 += 19539653 * (int64_t)v;
        v = y3; u1 += 3338402 * (int64_t)v; u3 += -6099997 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1521791 * (int64_t)x0 + 50603560 * (int64_t)y0 - 29575925 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2435073 * (int64_t)x1 - 87921563 * (int64_t)y0 - 136347550 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1521791 * (int64_t)x2 + 50603560 * (int64_t)y1 - 29575925 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2435073 * (int64_t)x3 - 87921563 * (int64_t)y1 - 136347550 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-81669399 * (int64_t)x4 + 332764045 * (int64_t)x5 + 10203011 * (int64_t)y0 - 5247006 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-332764045 * (int64_t)x4 - 81669399 * (int64_t)x5 - 14671957 * (int64_t)y0 + 626310 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-81669399 * (int64_t)x6 + 332764045 * (int64_t)x7 + 10203011 * (int64_t)y1 - 5247006 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-332764045 * (int64_t)x6 - 81669399 * (int64_t)x7 - 14671957 * (int64_t)y1 + 626310 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149514813 * (int64_t)x8 + 503833863 * (int64_t)x9 - 8819829 * (int64_t)y0 + 5526664 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503833863 * (int64_t)x8 - 149514813 * (int64_t)x9 + 7274803 * (int64_t)y0 - 5245654 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149514813 * (int64_t)x10 + 503833863 * (int64_t)x11 - 8819829 * (int64_t)y1 + 5526664 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503833863 * (int64_t)x10 - 149514813 * (int64_t)x11 + 7274803 * (int64_t)y1 - 5245654 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(759986661 * (int64_t)x12 + 550128926 * (int64_t)x13 + 71919129 * (int64_t)y0 - 13643131 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-550128926 * (int64_t)x12 + 759986661 * (int64_t)x13 - 80606971 * (int64_t)y0 - 39098831 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(759986661 * (int64_t)x14 + 550128926 * (int64_t)x15 + 71919129 * (int64_t)y1 - 13643131 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-550128926 * (int64_t)x14 + 759986661 * (int64_t)x15 - 80606971 * (int64_t)y1 - 39098831 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(618454505 * (int64_t)x16 + 794493843 * (int64_t)x17 - 24451995 * (int64_t)y0 + 8206353 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-794493843 * (int64_t)x16 + 618454505 * (int64_t)x17 - 28215623 * (int64_t)y0 + 49966974 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(618454505 * (int64_t)x18 + 794493843 * (int64_t)x19 - 24451995 * (int64_t)y1 + 8206353 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-794493843 * (int64_t)x18 + 618454505 * (int64_t)x19 - 28215623 * (int64_t)y1 + 49966974 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(377696583 * (int64_t)x20 + 826900381 * (int64_t)x21 + 2856442 * (int64_t)y0 - 207747737 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-826900381 * (int64_t)x20 + 377696583 * (int64_t)x21 - 34302441 * (int64_t)y0 + 29276227 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(377696583 * (int64_t)x22 + 826900381 * (int64_t)x23 + 2856442 * (int64_t)y1 - 207747737 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-826900381 * (int64_t)x22 + 377696583 * (int64_t)x23 - 34302441 * (int64_t)y1 + 29276227 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(194240933 * (int64_t)x24 + 1363647709 * (int64_t)x25 + 21460 * (int64_t)y0 - 49455212 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-681823855 * (int64_t)x24 + 388481866 * (int64_t)x25 + 535777400 * (int64_t)y0 + 152826703 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(194240933 * (int64_t)x26 + 1363647709 * (int64_t)x27 + 21460 * (int64_t)y1 - 49455212 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-681823855 * (int64_t)x26 + 388481866 * (int64_t)x27 + 535777400 * (int64_t)y1 + 152826703 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(127409221 * (int64_t)x28 + 961806377 * (int64_t)x29 + 14500080 * (int64_t)y0 + 102066807 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-961806377 * (int64_t)x28 + 127409221 * (int64_t)x29 - 32085479 * (int64_t)y0 - 47374569 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(127409221 * (int64_t)x30 + 961806377 * (int64_t)x31 + 14500080 * (int64_t)y1 + 102066807 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-961806377 * (int64_t)x30 + 127409221 * (int64_t)x31 - 32085479 * (int64_t)y1 - 47374569 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-505573583 * (int64_t)x32 + 1406102024 * (int64_t)x33 - 169770723 * (int64_t)y0 - 60954323 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-351525506 * (int64_t)x32 - 505573583 * (int64_t)x33 - 400656646 * (int64_t)y0 + 769488227 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-505573583 * (int64_t)x34 + 1406102024 * (int64_t)x35 - 169770723 * (int64_t)y1 - 60954323 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-351525506 * (int64_t)x34 - 505573583 * (int64_t)x35 - 400656646 * (int64_t)y1 + 769488227 * (int64_t)y3, 31);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142322799 * (int64_t)x36 + 1664330 * (int64_t)y0 - 2271261 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142322799 * (int64_t)x37 + 1664330 * (int64_t)y1 - 2271261 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 763363539 * (int64_t)e[0] + 926433597 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], -709558219 * (int64_t)e[0] - 823402297 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 763363539 * (int64_t)e[1] + 926433597 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], -709558219 * (int64_t)e[1] - 823402297 * (int64_t)e[3], 19);
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
        {885227003, 0, 392987219, 0, 78552237, 0, -5450364, 0},
        {-1046044092, 0, -135057627, 0, -66631871, 0, 35245754, 0},
        {0, 885227003, 0, 392987219, 0, 78552237, 0, -5450364},
        {0, -1046044092, 0, -135057627, 0, -66631871, 0, 35245754},
        {-1179180930, 0, -70361814, 0, 569928, 0, -196574, 0},
        {-1295248306, 0, 526419592, 0, 3777555, 0, -1200259, 0},
        {0, -1179180930, 0, -70361814, 0, 569928, 0, -196574},
        {0, -1295248306, 0, 526419592, 0, 3777555, 0, -1200259},
        {1188326682, 0, -902103623, 0, 1555742, 0, -490247, 0},
        {718353427, 0, -442697307, 0, 2306586, 0, -730725, 0},
        {0, 1188326682, 0, -902103623, 0, 1555742, 0, -490247},
        {0, 718353427, 0, -442697307, 0, 2306586, 0, -730725},
        {-907149901, 0, -1100575382, 0, 1901535, 0, -594630, 0},
        {-1455035179, 0, -104477678, 0, -5041760, 0, 1597805, 0},
        {0, -907149901, 0, -1100575382, 0, 1901535, 0, -594630},
        {0, -1455035179, 0, -104477678, 0, -5041760, 0, 1597805},
        {-678391001, 0, 890081657, 0, 690622, 0, -219339, 0},
        {491921534, 0, 1327404252, 0, -3601200, 0, 1139075, 0},
        {0, -678391001, 0, 890081657, 0, 690622, 0, -219339},
        {0, 491921534, 0, 1327404252, 0, -3601200, 0, 1139075},
        {-214207975, 0, -884582781, 0, -1575763, 0, 503083, 0},
        {-156145406, 0, 1415812821, 0, 2778519, 0, -876858, 0},
        {0, -214207975, 0, -884582781, 0, -1575763, 0, 503083},
        {0, -156145406, 0, 1415812821, 0, 2778519, 0, -876858},
        {1224734157, 0, 386073772, 0, -100250462, 0, 31809125, 0},
        {900949382, 0, 291724412, 0, 6462262, 0, -2055793, 0},
        {0, 1224734157, 0, 386073772, 0, -100250462, 0, 31809125},
        {0, 900949382, 0, 291724412, 0, 6462262, 0, -2055793},
        {-179181346, 0, 964167868, 0, 11099188, 0, -3528572, 0},
        {-388735496, 0, -1350384728, 0, 2285693, 0, -729755, 0},
        {0, -179181346, 0, 964167868, 0, 11099188, 0, -3528572},
        {0, -388735496, 0, -1350384728, 0, 2285693, 0, -729755},
        {-560768319, 0, 524577935, 0, 1331667, 0, -423952, 0},
        {-326251790, 0, 1188254787, 0, 18708344, 0, -5922027, 0},
        {0, -560768319, 0, 524577935, 0, 1331667, 0, -423952},
        {0, -326251790, 0, 1188254787, 0, 18708344, 0, -5922027},
        {556017305, 0, -1184419897, 0, -22499668, 0, 7109918, 0},
        {0, 556017305, 0, -1184419897, 0, -22499668, 0, 7109918},
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
