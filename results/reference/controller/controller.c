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
static const float paper_tool_f32_output_guard = 0x1.d02988p23f;

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
        float u0 = 0x1.b59bb4p-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.e4a40ep-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.8af734p9f * v; u2 += 0x1.c7aa4cp9f * v;
        v = x[5]; u0 += -0x1.b6d336p6f * v; u2 += -0x1.ae47fcp9f * v;
        v = x[8]; u0 += 0x1.f982fep9f * v; u2 += -0x1.bfa5f0p11f * v;
        v = x[9]; u0 += -0x1.7d2a82p9f * v; u2 += 0x1.677332p10f * v;
        v = x[12]; u0 += -0x1.9faa06p10f * v; u2 += -0x1.10de80p9f * v;
        v = x[13]; u0 += -0x1.80e830p8f * v; u2 += 0x1.fb4854p9f * v;
        v = x[16]; u0 += -0x1.c21758p11f * v; u2 += 0x1.37e13ep11f * v;
        v = x[17]; u0 += 0x1.6ce208p2f * v; u2 += -0x1.cf7d68p10f * v;
        v = x[20]; u0 += 0x1.3ece5cp9f * v; u2 += -0x1.8ae43ap9f * v;
        v = x[21]; u0 += -0x1.1979e8p5f * v; u2 += -0x1.2d870ap8f * v;
        v = x[24]; u0 += -0x1.2916d0p6f * v; u2 += -0x1.e6fca2p4f * v;
        v = x[25]; u0 += 0x1.2708a8p8f * v; u2 += 0x1.2b4736p3f * v;
        v = x[28]; u0 += -0x1.d51b8cp8f * v; u2 += -0x1.08f0f8p7f * v;
        v = x[29]; u0 += -0x1.283d46p7f * v; u2 += 0x1.cf1400p7f * v;
        v = x[32]; u0 += 0x1.73dfd8p6f * v; u2 += -0x1.4f8afcp6f * v;
        v = x[33]; u0 += 0x1.662214p8f * v; u2 += -0x1.c939e0p7f * v;
        v = x[36]; u0 += -0x1.c70860p4f * v; u2 += 0x1.689742p5f * v;
        v = y0; u0 += -0x1.f6c5bap19f * v; u2 += 0x1.a6f29ep19f * v;
        v = y2; u0 += 0x1.6648f8p16f * v; u2 += -0x1.1db972p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.b59bb4p-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.e4a40ep-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.8af734p9f * v; u3 += 0x1.c7aa4cp9f * v;
        v = x[7]; u1 += -0x1.b6d336p6f * v; u3 += -0x1.ae47fcp9f * v;
        v = x[10]; u1 += 0x1.f982fep9f * v; u3 += -0x1.bfa5f0p11f * v;
        v = x[11]; u1 += -0x1.7d2a82p9f * v; u3 += 0x1.677332p10f * v;
        v = x[14]; u1 += -0x1.9faa06p10f * v; u3 += -0x1.10de80p9f * v;
        v = x[15]; u1 += -0x1.80e830p8f * v; u3 += 0x1.fb4854p9f * v;
        v = x[18]; u1 += -0x1.c21758p11f * v; u3 += 0x1.37e13ep11f * v;
        v = x[19]; u1 += 0x1.6ce208p2f * v; u3 += -0x1.cf7d68p10f * v;
        v = x[22]; u1 += 0x1.3ece5cp9f * v; u3 += -0x1.8ae43ap9f * v;
        v = x[23]; u1 += -0x1.1979e8p5f * v; u3 += -0x1.2d870ap8f * v;
        v = x[26]; u1 += -0x1.2916d0p6f * v; u3 += -0x1.e6fca2p4f * v;
        v = x[27]; u1 += 0x1.2708a8p8f * v; u3 += 0x1.2b4736p3f * v;
        v = x[30]; u1 += -0x1.d51b8cp8f * v; u3 += -0x1.08f0f8p7f * v;
        v = x[31]; u1 += -0x1.283d46p7f * v; u3 += 0x1.cf1400p7f * v;
        v = x[34]; u1 += 0x1.73dfd8p6f * v; u3 += -0x1.4f8afcp6f * v;
        v = x[35]; u1 += 0x1.662214p8f * v; u3 += -0x1.c939e0p7f * v;
        v = x[37]; u1 += -0x1.c70860p4f * v; u3 += 0x1.689742p5f * v;
        v = y1; u1 += -0x1.f6c5bap19f * v; u3 += 0x1.a6f29ep19f * v;
        v = y3; u1 += 0x1.6648f8p16f * v; u3 += -0x1.1db972p18f * v;
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
        x[0] = -0x1.6c9b3ep-10f * x0 + 0x1.80f3e4p7f * y0 - 0x1.c37648p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.3310fep-9f * x1 - 0x1.470c94p8f * y0 - 0x1.feb630p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.6c9b3ep-10f * x2 + 0x1.80f3e4p7f * y1 - 0x1.c37648p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.3310fep-9f * x3 - 0x1.470c94p8f * y1 - 0x1.feb630p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.32aa4ap-4f * x4 + 0x1.3d48bap-2f * x5 + 0x1.313be4p5f * y0 - 0x1.36f894p4f * y2
            + x4;
        x[5] = -0x1.3d48bap-2f * x4 - 0x1.32aa4ap-4f * x5 - 0x1.a2035ap5f * y0 + 0x1.490270p1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.32aa4ap-4f * x6 + 0x1.3d48bap-2f * x7 + 0x1.313be4p5f * y1 - 0x1.36f894p4f * y3
            + x6;
        x[7] = -0x1.3d48bap-2f * x6 - 0x1.32aa4ap-4f * x7 - 0x1.a2035ap5f * y1 + 0x1.490270p1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1d7216p-3f * x8 + 0x1.e06c94p-2f * x9 - 0x1.05b51ap5f * y0 + 0x1.3d693ep4f * y2
            + x8;
        x[9] = -0x1.e06c94p-2f * x8 - 0x1.1d7216p-3f * x9 + 0x1.9cf990p4f * y0 - 0x1.3c5f86p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1d7216p-3f * x10 + 0x1.e06c94p-2f * x11 - 0x1.05b51ap5f * y1 + 0x1.3d693ep4f * y3
            + x10;
        x[11] = -0x1.e06c94p-2f * x10 - 0x1.1d7216p-3f * x11 + 0x1.9cf990p4f * y1 - 0x1.3c5f86p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6acc86p-1f * x12 + 0x1.04427ap-1f * x13 + 0x1.061184p8f * y0 - 0x1.9463d8p5f * y2;
        x[13] = -0x1.04427ap-1f * x12 + 0x1.6acc86p-1f * x13 - 0x1.25375cp8f * y0 - 0x1.164a06p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6acc86p-1f * x14 + 0x1.04427ap-1f * x15 + 0x1.061184p8f * y1 - 0x1.9463d8p5f * y3;
        x[15] = -0x1.04427ap-1f * x14 + 0x1.6acc86p-1f * x15 - 0x1.25375cp8f * y1 - 0x1.164a06p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.27d704p-1f * x16 + 0x1.7a23e2p-1f * x17 - 0x1.670050p6f * y0 + 0x1.068b60p5f * y2;
        x[17] = -0x1.7a23e2p-1f * x16 + 0x1.27d704p-1f * x17 - 0x1.87fc06p6f * y0 + 0x1.71fe06p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.27d704p-1f * x18 + 0x1.7a23e2p-1f * x19 - 0x1.670050p6f * y1 + 0x1.068b60p5f * y3;
        x[19] = -0x1.7a23e2p-1f * x18 + 0x1.27d704p-1f * x19 - 0x1.87fc06p6f * y1 + 0x1.71fe06p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.68b564p-2f * x20 + 0x1.8a2b86p-1f * x21 - 0x1.2058eep1f * y0 - 0x1.7eb1e8p9f * y2;
        x[21] = -0x1.8a2b86p-1f * x20 + 0x1.68b564p-2f * x21 - 0x1.a09a18p6f * y0 + 0x1.70b0f8p6f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.68b564p-2f * x22 + 0x1.8a2b86p-1f * x23 - 0x1.2058eep1f * y1 - 0x1.7eb1e8p9f * y3;
        x[23] = -0x1.8a2b86p-1f * x22 + 0x1.68b564p-2f * x23 - 0x1.a09a18p6f * y1 + 0x1.70b0f8p6f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.766b4ep-3f * x24 + 0x1.4312d8p0f * x25 - 0x1.10387cp4f * y0 - 0x1.65d3eap7f * y2;
        x[25] = -0x1.4312d8p-2f * x24 + 0x1.766b4ep-3f * x25 + 0x1.e56f52p9f * y0 + 0x1.1e73e0p8f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.766b4ep-3f * x26 + 0x1.4312d8p0f * x27 - 0x1.10387cp4f * y1 - 0x1.65d3eap7f * y3;
        x[27] = -0x1.4312d8p-2f * x26 + 0x1.766b4ep-3f * x27 + 0x1.e56f52p9f * y1 + 0x1.1e73e0p8f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e30caap-4f * x28 + 0x1.cb2654p-1f * x29 + 0x1.c9e3c0p5f * y0 + 0x1.7358fcp8f * y2;
        x[29] = -0x1.cb2654p-1f * x28 + 0x1.e30caap-4f * x29 - 0x1.099ffap7f * y0 - 0x1.5162b2p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e30caap-4f * x30 + 0x1.cb2654p-1f * x31 + 0x1.c9e3c0p5f * y1 + 0x1.7358fcp8f * y3;
        x[31] = -0x1.cb2654p-1f * x30 + 0x1.e30caap-4f * x31 - 0x1.099ffap7f * y1 - 0x1.5162b2p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.c1fee8p-3f * x32 + 0x1.41b73ep-1f * x33 - 0x1.23a3c8p8f * y0 - 0x1.ec3f06p5f * y2;
        x[33] = -0x1.41b73ep-3f * x32 - 0x1.c1fee8p-3f * x33 - 0x1.763f3ap9f * y0 + 0x1.561200p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.c1fee8p-3f * x34 + 0x1.41b73ep-1f * x35 - 0x1.23a3c8p8f * y1 - 0x1.ec3f06p5f * y3;
        x[35] = -0x1.41b73ep-3f * x34 - 0x1.c1fee8p-3f * x35 - 0x1.763f3ap9f * y1 + 0x1.561200p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.feced8p-1f * x36 + 0x1.80a8c2p1f * y0 - 0x1.06583ap2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.feced8p-1f * x37 + 0x1.80a8c2p1f * y1 - 0x1.06583ap2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += -0x1.7b4630p-7f * e[0];
        x[0] += 0x1.4e13dep-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.90a6dep-7f * e[0];
        x[1] += -0x1.24c1b4p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.7b4630p-7f * e[1];
        x[2] += 0x1.4e13dep-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.90a6dep-7f * e[1];
        x[3] += -0x1.24c1b4p-4f * e[3];
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
        {-0x1.1cb5bap17f, 0.0f, 0x1.28cef0p15f, 0.0f, -0x1.b18ffap-1f, 0.0f, 0x1.ca5eccp-2f, 0.0f},
        {0x1.ef6b84p16f, 0.0f, -0x1.9d056ep12f, 0.0f, 0x1.edbe66p-1f, 0.0f, -0x1.313e74p-3f, 0.0f},
        {0.0f, -0x1.1cb5bap17f, 0.0f, 0x1.28cef0p15f, 0.0f, -0x1.b18ffap-1f, 0.0f, 0x1.ca5eccp-2f},
        {0.0f, 0x1.ef6b84p16f, 0.0f, -0x1.9d056ep12f, 0.0f, 0x1.edbe66p-1f, 0.0f, -0x1.313e74p-3f},
        {-0x1.053904p7f, 0.0f, -0x1.c865c0p2f, 0.0f, 0x1.5c3396p-18f, 0.0f, -0x1.cabcb0p-20f, 0.0f},
        {-0x1.2c3a72p7f, 0.0f, 0x1.eac75ap5f, 0.0f, 0x1.0552aap-15f, 0.0f, -0x1.37f550p-17f, 0.0f},
        {0.0f, -0x1.053904p7f, 0.0f, -0x1.c865c0p2f, 0.0f, 0x1.5c3396p-18f, 0.0f, -0x1.cabcb0p-20f},
        {0.0f, -0x1.2c3a72p7f, 0.0f, 0x1.eac75ap5f, 0.0f, 0x1.0552aap-15f, 0.0f, -0x1.37f550p-17f},
        {0x1.ffa428p4f, 0.0f, -0x1.b1f8b6p4f, 0.0f, 0x1.8b3240p-19f, 0.0f, -0x1.d26d54p-21f, 0.0f},
        {0x1.4a1b32p6f, 0.0f, -0x1.90c5aep5f, 0.0f, 0x1.77c6d2p-16f, 0.0f, -0x1.bed64ap-18f, 0.0f},
        {0.0f, 0x1.ffa428p4f, 0.0f, -0x1.b1f8b6p4f, 0.0f, 0x1.8b3240p-19f, 0.0f, -0x1.d26d54p-21f},
        {0.0f, 0x1.4a1b32p6f, 0.0f, -0x1.90c5aep5f, 0.0f, 0x1.77c6d2p-16f, 0.0f, -0x1.bed64ap-18f},
        {-0x1.9af2c4p7f, 0.0f, -0x1.ef71e4p7f, 0.0f, 0x1.49c108p-15f, 0.0f, -0x1.8245b6p-17f, 0.0f},
        {-0x1.4d3c12p9f, 0.0f, -0x1.6b39a2p5f, 0.0f, -0x1.946590p-13f, 0.0f, 0x1.e11660p-15f, 0.0f},
        {0.0f, -0x1.9af2c4p7f, 0.0f, -0x1.ef71e4p7f, 0.0f, 0x1.49c108p-15f, 0.0f, -0x1.8245b6p-17f},
        {0.0f, -0x1.4d3c12p9f, 0.0f, -0x1.6b39a2p5f, 0.0f, -0x1.946590p-13f, 0.0f, 0x1.e11660p-15f},
        {-0x1.2c77f2p7f, 0.0f, 0x1.a019c2p7f, 0.0f, 0x1.d4d838p-17f, 0.0f, -0x1.178e74p-18f, 0.0f},
        {0x1.fd7620p4f, 0.0f, 0x1.28c248p6f, 0.0f, -0x1.1936dap-16f, 0.0f, 0x1.4db94cp-18f, 0.0f},
        {0.0f, -0x1.2c77f2p7f, 0.0f, 0x1.a019c2p7f, 0.0f, 0x1.d4d838p-17f, 0.0f, -0x1.178e74p-18f},
        {0.0f, 0x1.fd7620p4f, 0.0f, 0x1.28c248p6f, 0.0f, -0x1.1936dap-16f, 0.0f, 0x1.4db94cp-18f},
        {-0x1.703efep6f, 0.0f, -0x1.a3de2cp8f, 0.0f, -0x1.3cedf6p-14f, 0.0f, 0x1.7b95a2p-16f, 0.0f},
        {-0x1.7fefd0p5f, 0.0f, 0x1.41806ep9f, 0.0f, 0x1.caa47ap-14f, 0.0f, -0x1.0f75e6p-15f, 0.0f},
        {0.0f, -0x1.703efep6f, 0.0f, -0x1.a3de2cp8f, 0.0f, -0x1.3cedf6p-14f, 0.0f, 0x1.7b95a2p-16f},
        {0.0f, -0x1.7fefd0p5f, 0.0f, 0x1.41806ep9f, 0.0f, 0x1.caa47ap-14f, 0.0f, -0x1.0f75e6p-15f},
        {0x1.1889e0p9f, 0.0f, 0x1.4d2130p7f, 0.0f, -0x1.ed8e24p-9f, 0.0f, 0x1.25faa0p-10f, 0.0f},
        {0x1.9ec418p9f, 0.0f, 0x1.1348c6p8f, 0.0f, 0x1.1541aep-11f, 0.0f, -0x1.4b649cp-13f, 0.0f},
        {0.0f, 0x1.1889e0p9f, 0.0f, 0x1.4d2130p7f, 0.0f, -0x1.ed8e24p-9f, 0.0f, 0x1.25faa0p-10f},
        {0.0f, 0x1.9ec418p9f, 0.0f, 0x1.1348c6p8f, 0.0f, 0x1.1541aep-11f, 0.0f, -0x1.4b649cp-13f},
        {-0x1.ae2146p4f, 0.0f, 0x1.c08896p6f, 0.0f, 0x1.c69f58p-14f, 0.0f, -0x1.0f5e4ap-15f, 0.0f},
        {-0x1.901848p6f, 0.0f, -0x1.308240p8f, 0.0f, 0x1.683df2p-15f, 0.0f, -0x1.b04384p-17f, 0.0f},
        {0.0f, -0x1.ae2146p4f, 0.0f, 0x1.c08896p6f, 0.0f, 0x1.c69f58p-14f, 0.0f, -0x1.0f5e4ap-15f},
        {0.0f, -0x1.901848p6f, 0.0f, -0x1.308240p8f, 0.0f, 0x1.683df2p-15f, 0.0f, -0x1.b04384p-17f},
        {-0x1.09502cp9f, 0.0f, 0x1.ecfcf4p8f, 0.0f, -0x1.0932d4p-14f, 0.0f, 0x1.37e0d8p-16f, 0.0f},
        {-0x1.387d48p8f, 0.0f, 0x1.0d87c4p10f, 0.0f, 0x1.8f189ap-10f, 0.0f, -0x1.da0990p-12f, 0.0f},
        {0.0f, -0x1.09502cp9f, 0.0f, 0x1.ecfcf4p8f, 0.0f, -0x1.0932d4p-14f, 0.0f, 0x1.37e0d8p-16f},
        {0.0f, -0x1.387d48p8f, 0.0f, 0x1.0d87c4p10f, 0.0f, 0x1.8f189ap-10f, 0.0f, -0x1.da0990p-12f},
        {0x1.f6c460p-1f, 0.0f, -0x1.0d78d0p1f, 0.0f, -0x1.c5b94ap-19f, -0.0f, 0x1.0cff7ep-20f, 0.0f},
        {0.0f, 0x1.f6c460p-1f, 0.0f, -0x1.0d78d0p1f, 0.0f, -0x1.c5b94ap-19f, 0.0f, 0x1.0cff7ep-20f},
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
/* Over the test vectors Q31 stays within 5.157e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 149370 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 165424 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 138050498 * (int64_t)v; u2 += 79633268 * (int64_t)v;
        v = x[5]; u0 += -19172559 * (int64_t)v; u2 += -75197090 * (int64_t)v;
        v = x[8]; u0 += 176689146 * (int64_t)v; u2 += -312928773 * (int64_t)v;
        v = x[9]; u0 += -133227189 * (int64_t)v; u2 += 125636879 * (int64_t)v;
        v = x[12]; u0 += -290570297 * (int64_t)v; u2 += -47687337 * (int64_t)v;
        v = x[13]; u0 += -67267372 * (int64_t)v; u2 += 88654049 * (int64_t)v;
        v = x[16]; u0 += -629273092 * (int64_t)v; u2 += 218019809 * (int64_t)v;
        v = x[17]; u0 += 996374 * (int64_t)v; u2 += -162001453 * (int64_t)v;
        v = x[20]; u0 += 111430809 * (int64_t)v; u2 += -69012294 * (int64_t)v;
        v = x[21]; u0 += -6148941 * (int64_t)v; u2 += -26347873 * (int64_t)v;
        v = x[24]; u0 += -12980022 * (int64_t)v; u2 += -2659597 * (int64_t)v;
        v = x[25]; u0 += 51560894 * (int64_t)v; u2 += 817229 * (int64_t)v;
        v = x[28]; u0 += -81982497 * (int64_t)v; u2 += -11575462 * (int64_t)v;
        v = x[29]; u0 += -25885789 * (int64_t)v; u2 += 20232192 * (int64_t)v;
        v = x[32]; u0 += 16247440 * (int64_t)v; u2 += -7330046 * (int64_t)v;
        v = x[33]; u0 += 62588300 * (int64_t)v; u2 += -19976512 * (int64_t)v;
        v = x[36]; u0 += -4970171 * (int64_t)v; u2 += 3938614 * (int64_t)v;
        v = y0; u0 += -45707108 * (int64_t)v; u2 += 19225118 * (int64_t)v;
        v = y2; u0 += 4071468 * (int64_t)v; u2 += -6493811 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 149370 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 165424 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 138050498 * (int64_t)v; u3 += 79633268 * (int64_t)v;
        v = x[7]; u1 += -19172559 * (int64_t)v; u3 += -75197090 * (int64_t)v;
        v = x[10]; u1 += 176689146 * (int64_t)v; u3 += -312928773 * (int64_t)v;
        v = x[11]; u1 += -133227189 * (int64_t)v; u3 += 125636879 * (int64_t)v;
        v = x[14]; u1 += -290570297 * (int64_t)v; u3 += -47687337 * (int64_t)v;
        v = x[15]; u1 += -67267372 * (int64_t)v; u3 += 88654049 * (int64_t)v;
        v = x[18]; u1 += -629273092 * (int64_t)v; u3 += 218019809 * (int64_t)v;
        v = x[19]; u1 += 996374 * (int64_t)v; u3 += -162001453 * (int64_t)v;
        v = x[22]; u1 += 111430809 * (int64_t)v; u3 += -69012294 * (int64_t)v;
        v = x[23]; u1 += -6148941 * (int64_t)v; u3 += -26347873 * (int64_t)v;
        v = x[26]; u1 += -12980022 * (int64_t)v; u3 += -2659597 * (int64_t)v;
        v = x[27]; u1 += 51560894 * (int64_t)v; u3 += 817229 * (int64_t)v;
        v = x[30]; u1 += -81982497 * (int64_t)v; u3 += -11575462 * (int64_t)v;
        v = x[31]; u1 += -25885789 * (int64_t)v; u3 += 20232192 * (int64_t)v;
        v = x[34]; u1 += 16247440 * (int64_t)v; u3 += -7330046 * (int64_t)v;
        v = x[35]; u1 += 62588300 * (int64_t)v; u3 += -19976512 * (int64_t)v;
        v = x[37]; u1 += -4970171 * (int64_t)v; u3 += 3938614 * (int64_t)v;
        v = y1; u1 += -45707108 * (int64_t)v; u3 += 19225118 * (int64_t)v;
        v = y3; u1 += 4071468 * (int64_t)v; u3 += -6493811 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1493428 * (int64_t)x0 + 52494157 * (int64_t)y0 - 30781858 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2515488 * (int64_t)x1 - 89196250 * (int64_t)y0 - 139286611 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1493428 * (int64_t)x2 + 52494157 * (int64_t)y1 - 30781858 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2515488 * (int64_t)x3 - 89196250 * (int64_t)y1 - 139286611 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-80390440 * (int64_t)x4 + 332696488 * (int64_t)x5 + 10405822 * (int64_t)y0 - 5300704 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-332696488 * (int64_t)x4 - 80390440 * (int64_t)x5 - 14250611 * (int64_t)y0 + 701023 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-80390440 * (int64_t)x6 + 332696488 * (int64_t)x7 + 10405822 * (int64_t)y1 - 5300704 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-332696488 * (int64_t)x6 - 80390440 * (int64_t)x7 - 14250611 * (int64_t)y1 + 701023 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149655726 * (int64_t)x8 + 503761225 * (int64_t)x9 - 8921947 * (int64_t)y0 + 5410479 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503761225 * (int64_t)x8 - 149655726 * (int64_t)x9 + 7039426 * (int64_t)y0 - 5392786 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149655726 * (int64_t)x10 + 503761225 * (int64_t)x11 - 8921947 * (int64_t)y1 + 5410479 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503761225 * (int64_t)x10 - 149655726 * (int64_t)x11 + 7039426 * (int64_t)y1 - 5392786 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(760844462 * (int64_t)x12 + 545804122 * (int64_t)x13 + 71474029 * (int64_t)y0 - 13786182 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-545804122 * (int64_t)x12 + 760844462 * (int64_t)x13 - 79968993 * (int64_t)y0 - 37948960 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(760844462 * (int64_t)x14 + 545804122 * (int64_t)x15 + 71474029 * (int64_t)y1 - 13786182 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-545804122 * (int64_t)x14 + 760844462 * (int64_t)x15 - 79968993 * (int64_t)y1 - 37948960 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(620421268 * (int64_t)x16 + 793017418 * (int64_t)x17 - 24477640 * (int64_t)y0 + 8950482 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-793017418 * (int64_t)x16 + 620421268 * (int64_t)x17 - 26726522 * (int64_t)y0 + 50454077 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(620421268 * (int64_t)x18 + 793017418 * (int64_t)x19 - 24477640 * (int64_t)y1 + 8950482 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-793017418 * (int64_t)x18 + 620421268 * (int64_t)x19 - 26726522 * (int64_t)y1 + 50454077 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(378230333 * (int64_t)x20 + 826634449 * (int64_t)x21 - 614384 * (int64_t)y0 - 208745109 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-826634449 * (int64_t)x20 + 378230333 * (int64_t)x21 - 28405005 * (int64_t)y0 + 25138332 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(378230333 * (int64_t)x22 + 826634449 * (int64_t)x23 - 614384 * (int64_t)y1 - 208745109 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-826634449 * (int64_t)x22 + 378230333 * (int64_t)x23 - 28405005 * (int64_t)y1 + 25138332 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(196303467 * (int64_t)x24 + 1355068894 * (int64_t)x25 - 4640178 * (int64_t)y0 - 48795261 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-677534447 * (int64_t)x24 + 392606934 * (int64_t)x25 + 529571396 * (int64_t)y0 + 156248704 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(196303467 * (int64_t)x26 + 1355068894 * (int64_t)x27 - 4640178 * (int64_t)y1 - 48795261 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-677534447 * (int64_t)x26 + 392606934 * (int64_t)x27 + 529571396 * (int64_t)y1 + 156248704 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(126628519 * (int64_t)x28 + 962906766 * (int64_t)x29 + 15610055 * (int64_t)y0 + 101277790 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-962906766 * (int64_t)x28 + 126628519 * (int64_t)x29 - 36221997 * (int64_t)y0 - 46007650 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(126628519 * (int64_t)x30 + 962906766 * (int64_t)x31 + 15610055 * (int64_t)y1 + 101277790 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-962906766 * (int64_t)x30 + 126628519 * (int64_t)x31 - 36221997 * (int64_t)y1 - 46007650 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-471854712 * (int64_t)x32 + 1349373852 * (int64_t)x33 - 159078078 * (int64_t)y0 - 33562627 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-337343463 * (int64_t)x32 - 471854712 * (int64_t)x33 - 408274142 * (int64_t)y0 + 746343832 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-471854712 * (int64_t)x34 + 1349373852 * (int64_t)x35 - 159078078 * (int64_t)y1 - 33562627 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-337343463 * (int64_t)x34 - 471854712 * (int64_t)x35 - 408274142 * (int64_t)y1 + 746343832 * (int64_t)y3, 31);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142484002 * (int64_t)x36 + 1639192 * (int64_t)y0 - 2235918 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142484002 * (int64_t)x37 + 1639192 * (int64_t)y1 - 2235918 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], -149136671 * (int64_t)e[0] + 1050917298 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], 157542703 * (int64_t)e[0] - 920932832 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], -149136671 * (int64_t)e[1] + 1050917298 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], 157542703 * (int64_t)e[1] - 920932832 * (int64_t)e[3], 19);
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
        {-1242384690, 0, 323794653, 0, -85241838, 0, 45059634, 0},
        {1080928784, 0, -56321724, 0, 97073971, 0, -15003351, 0},
        {0, -1242384690, 0, 323794653, 0, -85241838, 0, 45059634},
        {0, 1080928784, 0, -56321724, 0, 97073971, 0, -15003351},
        {-1139894089, 0, -62236736, 0, 534837, 0, -176155, 0},
        {-1310102226, 0, 535401162, 0, 3211136, 0, -958336, 0},
        {0, -1139894089, 0, -62236736, 0, 534837, 0, -176155},
        {0, -1310102226, 0, 535401162, 0, 3211136, 0, -958336},
        {1116321032, 0, -946857901, 0, 1214043, 0, -358216, 0},
        {720240066, 0, -437211076, 0, 2308772, 0, -686342, 0},
        {0, 1116321032, 0, -946857901, 0, 1214043, 0, -358216},
        {0, 720240066, 0, -437211076, 0, 2308772, 0, -686342},
        {-896624818, 0, -1080983176, 0, 2026009, 0, -593314, 0},
        {-1454131567, 0, -99062543, 0, -4969227, 0, 1477900, 0},
        {0, -896624818, 0, -1080983176, 0, 2026009, 0, -593314},
        {0, -1454131567, 0, -99062543, 0, -4969227, 0, 1477900},
        {-655575316, 0, 907866367, 0, 720145, 0, -214699, 0},
        {555782510, 0, 1294962892, 0, -3455561, 0, 1025200, 0},
        {0, -655575316, 0, 907866367, 0, 720145, 0, -214699},
        {0, 555782510, 0, 1294962892, 0, -3455561, 0, 1025200},
        {-200863802, 0, -916085880, 0, -1947215, 0, 583042, 0},
        {-104711239, 0, 1402932683, 0, 2817899, 0, -833927, 0},
        {0, -200863802, 0, -916085880, 0, -1947215, 0, 583042},
        {0, -104711239, 0, 1402932683, 0, 2817899, 0, -833927},
        {1224182424, 0, 363418360, 0, -97036910, 0, 28899311, 0},
        {904954459, 0, 300313570, 0, 6813857, 0, -2036079, 0},
        {0, 1224182424, 0, 363418360, 0, -97036910, 0, 28899311},
        {0, 904954459, 0, 300313570, 0, 6813857, 0, -2036079},
        {-234619052, 0, 978629943, 0, 11172801, 0, -3334574, 0},
        {-436472143, 0, -1328781003, 0, 2213327, 0, -663957, 0},
        {0, -234619052, 0, 978629943, 0, 11172801, 0, -3334574},
        {0, -436472143, 0, -1328781003, 0, 2213327, 0, -663957},
        {-578871773, 0, 537811409, 0, -814690, 0, 239523, 0},
        {-340901453, 0, 1176145928, 0, 19616371, 0, -5824971, 0},
        {0, -578871773, 0, 537811409, 0, -814690, 0, 239523},
        {0, -340901453, 0, 1176145928, 0, 19616371, 0, -5824971},
        {548479533, 0, -1175891043, 0, -22301431, 0, 6610895, 0},
        {0, 548479533, 0, -1175891043, 0, -22301431, 0, 6610895},
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
