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
static const float paper_tool_f32_output_guard = 0x1.735d60p23f;

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
        float u0 = 0x1.68768cp-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.5abf6ep0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.5f2b00p9f * v; u2 += -0x1.7fa6dcp9f * v;
        v = x[5]; u0 += 0x1.dab650p7f * v; u2 += 0x1.9ae006p9f * v;
        v = x[8]; u0 += 0x1.0dc5fep9f * v; u2 += -0x1.d80ae8p10f * v;
        v = x[9]; u0 += -0x1.2b8ba4p9f * v; u2 += 0x1.3678f6p9f * v;
        v = x[12]; u0 += 0x1.6e760ep10f * v; u2 += 0x1.01458cp9f * v;
        v = x[13]; u0 += 0x1.1b5fa2p6f * v; u2 += -0x1.ba95bap9f * v;
        v = x[16]; u0 += 0x1.8d6152p11f * v; u2 += -0x1.69b7b4p11f * v;
        v = x[17]; u0 += 0x1.bc65d2p9f * v; u2 += 0x1.374e2ep10f * v;
        v = x[20]; u0 += 0x1.43208ep9f * v; u2 += -0x1.929838p9f * v;
        v = x[21]; u0 += -0x1.5c6ceap6f * v; u2 += -0x1.14fa16p7f * v;
        v = x[24]; u0 += -0x1.34153cp8f * v; u2 += -0x1.815662p5f * v;
        v = x[25]; u0 += 0x1.0cb492p-1f * v; u2 += -0x1.95c94ap4f * v;
        v = x[28]; u0 += 0x1.ec24d4p6f * v; u2 += -0x1.fee9e8p8f * v;
        v = x[29]; u0 += -0x1.e6412ap9f * v; u2 += -0x1.3647a0p6f * v;
        v = x[32]; u0 += 0x1.08e0aep8f * v; u2 += -0x1.379a2cp7f * v;
        v = x[33]; u0 += -0x1.2e3bd6p7f * v; u2 += 0x1.03d0a4p7f * v;
        v = x[36]; u0 += -0x1.da99bap4f * v; u2 += 0x1.7a47b8p5f * v;
        v = y0; u0 += -0x1.c122c4p19f * v; u2 += 0x1.9d9ad2p19f * v;
        v = y2; u0 += 0x1.36608cp17f * v; u2 += -0x1.4e7366p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.68768cp-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.5abf6ep0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.5f2b00p9f * v; u3 += -0x1.7fa6dcp9f * v;
        v = x[7]; u1 += 0x1.dab650p7f * v; u3 += 0x1.9ae006p9f * v;
        v = x[10]; u1 += 0x1.0dc5fep9f * v; u3 += -0x1.d80ae8p10f * v;
        v = x[11]; u1 += -0x1.2b8ba4p9f * v; u3 += 0x1.3678f6p9f * v;
        v = x[14]; u1 += 0x1.6e760ep10f * v; u3 += 0x1.01458cp9f * v;
        v = x[15]; u1 += 0x1.1b5fa2p6f * v; u3 += -0x1.ba95bap9f * v;
        v = x[18]; u1 += 0x1.8d6152p11f * v; u3 += -0x1.69b7b4p11f * v;
        v = x[19]; u1 += 0x1.bc65d2p9f * v; u3 += 0x1.374e2ep10f * v;
        v = x[22]; u1 += 0x1.43208ep9f * v; u3 += -0x1.929838p9f * v;
        v = x[23]; u1 += -0x1.5c6ceap6f * v; u3 += -0x1.14fa16p7f * v;
        v = x[26]; u1 += -0x1.34153cp8f * v; u3 += -0x1.815662p5f * v;
        v = x[27]; u1 += 0x1.0cb492p-1f * v; u3 += -0x1.95c94ap4f * v;
        v = x[30]; u1 += 0x1.ec24d4p6f * v; u3 += -0x1.fee9e8p8f * v;
        v = x[31]; u1 += -0x1.e6412ap9f * v; u3 += -0x1.3647a0p6f * v;
        v = x[34]; u1 += 0x1.08e0aep8f * v; u3 += -0x1.379a2cp7f * v;
        v = x[35]; u1 += -0x1.2e3bd6p7f * v; u3 += 0x1.03d0a4p7f * v;
        v = x[37]; u1 += -0x1.da99bap4f * v; u3 += 0x1.7a47b8p5f * v;
        v = y1; u1 += -0x1.c122c4p19f * v; u3 += 0x1.9d9ad2p19f * v;
        v = y3; u1 += 0x1.36608cp17f * v; u3 += -0x1.4e7366p18f * v;
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
        x[0] = -0x1.57e09ep-10f * x0 + 0x1.68f67ap7f * y0 - 0x1.a5be7cp6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.5b92bep-9f * x1 - 0x1.138418p8f * y0 - 0x1.01c2e6p9f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.57e09ep-10f * x2 + 0x1.68f67ap7f * y1 - 0x1.a5be7cp6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.5b92bep-9f * x3 - 0x1.138418p8f * y1 - 0x1.01c2e6p9f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.2411a2p-4f * x4 + 0x1.3ef134p-2f * x5 - 0x1.17fd46p5f * y0 + 0x1.19e150p4f * y2
            + x4;
        x[5] = -0x1.3ef134p-2f * x4 - 0x1.2411a2p-4f * x5 + 0x1.a4e358p5f * y0 - 0x1.787c96p2f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.2411a2p-4f * x6 + 0x1.3ef134p-2f * x7 - 0x1.17fd46p5f * y1 + 0x1.19e150p4f * y3
            + x6;
        x[7] = -0x1.3ef134p-2f * x6 - 0x1.2411a2p-4f * x7 + 0x1.a4e358p5f * y1 - 0x1.787c96p2f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.26b7b0p-3f * x8 + 0x1.dd874cp-2f * x9 - 0x1.0bf22cp6f * y0 + 0x1.212c32p5f * y2
            + x8;
        x[9] = -0x1.dd874cp-2f * x8 - 0x1.26b7b0p-3f * x9 + 0x1.9860c8p5f * y0 - 0x1.6cf7e4p5f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.26b7b0p-3f * x10 + 0x1.dd874cp-2f * x11 - 0x1.0bf22cp6f * y1 + 0x1.212c32p5f * y3
            + x10;
        x[11] = -0x1.dd874cp-2f * x10 - 0x1.26b7b0p-3f * x11 + 0x1.9860c8p5f * y1 - 0x1.6cf7e4p5f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.72c506p-1f * x12 + 0x1.06f3b6p-1f * x13 - 0x1.efb4fep7f * y0 + 0x1.4a5af0p5f * y2;
        x[13] = -0x1.06f3b6p-1f * x12 + 0x1.72c506p-1f * x13 + 0x1.2d3ff0p8f * y0 + 0x1.b61790p6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.72c506p-1f * x14 + 0x1.06f3b6p-1f * x15 - 0x1.efb4fep7f * y1 + 0x1.4a5af0p5f * y3;
        x[15] = -0x1.06f3b6p-1f * x14 + 0x1.72c506p-1f * x15 + 0x1.2d3ff0p8f * y1 + 0x1.b61790p6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.29a3bcp-1f * x16 + 0x1.7b229cp-1f * x17 + 0x1.6a216cp5f * y0 + 0x1.80b716p4f * y2;
        x[17] = -0x1.7b229cp-1f * x16 + 0x1.29a3bcp-1f * x17 + 0x1.db102ep6f * y0 - 0x1.71b1b0p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.29a3bcp-1f * x18 + 0x1.7b229cp-1f * x19 + 0x1.6a216cp5f * y1 + 0x1.80b716p4f * y3;
        x[19] = -0x1.7b229cp-1f * x18 + 0x1.29a3bcp-1f * x19 + 0x1.db102ep6f * y1 - 0x1.71b1b0p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6774d0p-2f * x20 + 0x1.875e68p-1f * x21 + 0x1.026766p0f * y0 - 0x1.9721aap9f * y2;
        x[21] = -0x1.875e68p-1f * x20 + 0x1.6774d0p-2f * x21 + 0x1.0c6448p4f * y0 + 0x1.769a32p7f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6774d0p-2f * x22 + 0x1.875e68p-1f * x23 + 0x1.026766p0f * y1 - 0x1.9721aap9f * y3;
        x[23] = -0x1.875e68p-1f * x22 + 0x1.6774d0p-2f * x23 + 0x1.0c6448p4f * y1 + 0x1.769a32p7f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.8a4f40p-3f * x24 + 0x1.3b2c8cp-2f * x25 - 0x1.a33796p9f * y0 - 0x1.be20f8p7f * y2;
        x[25] = -0x1.3b2c8cp0f * x24 + 0x1.8a4f40p-3f * x25 + 0x1.8ab0c4p9f * y0 + 0x1.0ad768p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.8a4f40p-3f * x26 + 0x1.3b2c8cp-2f * x27 - 0x1.a33796p9f * y1 - 0x1.be20f8p7f * y3;
        x[27] = -0x1.3b2c8cp0f * x26 + 0x1.8a4f40p-3f * x27 + 0x1.8ab0c4p9f * y1 + 0x1.0ad768p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.df037ep-4f * x28 + 0x1.d118eap-1f * x29 + 0x1.517858p6f * y0 + 0x1.d5b0ecp6f * y2;
        x[29] = -0x1.d118eap-1f * x28 + 0x1.df037ep-4f * x29 + 0x1.2a84e0p3f * y0 + 0x1.2d4d42p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.df037ep-4f * x30 + 0x1.d118eap-1f * x31 + 0x1.517858p6f * y1 + 0x1.d5b0ecp6f * y3;
        x[31] = -0x1.d118eap-1f * x30 + 0x1.df037ep-4f * x31 + 0x1.2a84e0p3f * y1 + 0x1.2d4d42p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.85087ap-3f * x32 + 0x1.24e7aap-3f * x33 - 0x1.7b1202p8f * y0 + 0x1.59e1c0p10f * y2;
        x[33] = -0x1.24e7aap-1f * x32 - 0x1.85087ap-3f * x33 + 0x1.3d8cb6p9f * y0 - 0x1.05864cp10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.85087ap-3f * x34 + 0x1.24e7aap-3f * x35 - 0x1.7b1202p8f * y1 + 0x1.59e1c0p10f * y3;
        x[35] = -0x1.24e7aap-1f * x34 - 0x1.85087ap-3f * x35 + 0x1.3d8cb6p9f * y1 - 0x1.05864cp10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.feb0f0p-1f * x36 + 0x1.8d30a0p1f * y0 - 0x1.14d266p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.feb0f0p-1f * x37 + 0x1.8d30a0p1f * y1 - 0x1.14d266p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += -0x1.f06e06p-5f * e[0];
        x[0] += 0x1.4407d8p-5f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.e364c0p-5f * e[0];
        x[1] += -0x1.87311ep-6f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.f06e06p-5f * e[1];
        x[2] += 0x1.4407d8p-5f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.e364c0p-5f * e[1];
        x[3] += -0x1.87311ep-6f * e[3];
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
        {-0x1.9ab996p17f, 0.0f, 0x1.fa8ff4p15f, 0.0f, -0x1.4bf45ep0f, 0.0f, 0x1.3d4f22p-1f, 0.0f},
        {0x1.6203bcp17f, 0.0f, -0x1.c5fc6ep14f, 0.0f, 0x1.51bbd6p0f, 0.0f, -0x1.2c0982p-2f, 0.0f},
        {0.0f, -0x1.9ab996p17f, 0.0f, 0x1.fa8ff4p15f, 0.0f, -0x1.4bf45ep0f, 0.0f, 0x1.3d4f22p-1f},
        {0.0f, 0x1.6203bcp17f, 0.0f, -0x1.c5fc6ep14f, 0.0f, 0x1.51bbd6p0f, 0.0f, -0x1.2c0982p-2f},
        {0x1.10d070p7f, 0.0f, -0x1.400b8cp2f, 0.0f, 0x1.770ff8p-20f, 0.0f, -0x1.35eed8p-23f, 0.0f},
        {0x1.1deab2p7f, 0.0f, -0x1.ce8a5cp5f, 0.0f, -0x1.febf54p-19f, 0.0f, 0x1.440d92p-20f, 0.0f},
        {0.0f, 0x1.10d070p7f, 0.0f, -0x1.400b8cp2f, 0.0f, 0x1.770ff8p-20f, 0.0f, -0x1.35eed8p-23f},
        {0.0f, 0x1.1deab2p7f, 0.0f, -0x1.ce8a5cp5f, 0.0f, -0x1.febf54p-19f, 0.0f, 0x1.440d92p-20f},
        {0x1.ded026p5f, 0.0f, -0x1.0d9e2ep6f, 0.0f, 0x1.45561ep-19f, 0.0f, -0x1.84a54ep-21f, 0.0f},
        {0x1.46ca90p7f, 0.0f, -0x1.88bc06p6f, 0.0f, 0x1.346d6ep-17f, 0.0f, -0x1.79a47ep-19f, 0.0f},
        {0.0f, 0x1.ded026p5f, 0.0f, -0x1.0d9e2ep6f, 0.0f, 0x1.45561ep-19f, 0.0f, -0x1.84a54ep-21f},
        {0.0f, 0x1.46ca90p7f, 0.0f, -0x1.88bc06p6f, 0.0f, 0x1.346d6ep-17f, 0.0f, -0x1.79a47ep-19f},
        {0x1.faa2e6p7f, 0.0f, 0x1.8c8672p7f, 0.0f, -0x1.092be0p-18f, 0.0f, 0x1.ddb856p-21f, 0.0f},
        {0x1.38122ap9f, 0.0f, 0x1.adefecp4f, 0.0f, 0x1.1a289cp-15f, 0.0f, -0x1.5c2016p-17f, 0.0f},
        {0.0f, 0x1.faa2e6p7f, 0.0f, 0x1.8c8672p7f, 0.0f, -0x1.092be0p-18f, 0.0f, 0x1.ddb856p-21f},
        {0.0f, 0x1.38122ap9f, 0.0f, 0x1.adefecp4f, 0.0f, 0x1.1a289cp-15f, 0.0f, -0x1.5c2016p-17f},
        {0x1.268768p7f, 0.0f, -0x1.5e86b6p7f, 0.0f, -0x1.9d0d62p-19f, 0.0f, 0x1.0104e8p-20f, 0.0f},
        {0x1.6b9ef0p4f, 0.0f, -0x1.06f4bcp7f, 0.0f, 0x1.1dea26p-19f, 0.0f, -0x1.542916p-21f, 0.0f},
        {0.0f, 0x1.268768p7f, 0.0f, -0x1.5e86b6p7f, 0.0f, -0x1.9d0d62p-19f, 0.0f, 0x1.0104e8p-20f},
        {0.0f, 0x1.6b9ef0p4f, 0.0f, -0x1.06f4bcp7f, 0.0f, 0x1.1dea26p-19f, 0.0f, -0x1.542916p-21f},
        {0x1.86fe78p3f, 0.0f, -0x1.7ea63cp8f, 0.0f, -0x1.25e91cp-17f, 0.0f, 0x1.90db2cp-19f, 0.0f},
        {0x1.d143e8p3f, 0.0f, 0x1.726e0ep9f, 0.0f, 0x1.e309d2p-16f, 0.0f, -0x1.20d0a6p-17f, 0.0f},
        {0.0f, 0x1.86fe78p3f, 0.0f, -0x1.7ea63cp8f, 0.0f, -0x1.25e91cp-17f, 0.0f, 0x1.90db2cp-19f},
        {0.0f, 0x1.d143e8p3f, 0.0f, 0x1.726e0ep9f, 0.0f, 0x1.e309d2p-16f, 0.0f, -0x1.20d0a6p-17f},
        {-0x1.be7f56p8f, -0.0f, -0x1.080134p7f, 0.0f, -0x1.70d234p-13f, -0.0f, 0x1.d9d518p-15f, 0.0f},
        {0x1.8406c6p10f, 0.0f, 0x1.70632cp8f, 0.0f, -0x1.d8472ap-12f, 0.0f, 0x1.25dfbap-13f, 0.0f},
        {0.0f, -0x1.be7f56p8f, 0.0f, -0x1.080134p7f, 0.0f, -0x1.70d234p-13f, 0.0f, 0x1.d9d518p-15f},
        {0.0f, 0x1.8406c6p10f, 0.0f, 0x1.70632cp8f, 0.0f, -0x1.d8472ap-12f, 0.0f, 0x1.25dfbap-13f},
        {0x1.9f165ap5f, 0.0f, 0x1.2c0934p7f, 0.0f, 0x1.17f734p-20f, 0.0f, -0x1.186000p-22f, 0.0f},
        {-0x1.4ea220p5f, 0.0f, 0x1.043e58p4f, 0.0f, 0x1.751342p-18f, 0.0f, -0x1.e82cf6p-20f, 0.0f},
        {0.0f, 0x1.9f165ap5f, 0.0f, 0x1.2c0934p7f, 0.0f, 0x1.17f734p-20f, 0.0f, -0x1.186000p-22f},
        {0.0f, -0x1.4ea220p5f, 0.0f, 0x1.043e58p4f, 0.0f, 0x1.751342p-18f, 0.0f, -0x1.e82cf6p-20f},
        {-0x1.830c54p7f, 0.0f, 0x1.f6f71cp9f, 0.0f, 0x1.417072p-12f, 0.0f, -0x1.8686aep-14f, 0.0f},
        {0x1.39bc94p9f, 0.0f, -0x1.548feep10f, 0.0f, -0x1.2c5daap-13f, 0.0f, 0x1.6e54ecp-15f, 0.0f},
        {0.0f, -0x1.830c54p7f, 0.0f, 0x1.f6f71cp9f, 0.0f, 0x1.417072p-12f, 0.0f, -0x1.8686aep-14f},
        {0.0f, 0x1.39bc94p9f, 0.0f, -0x1.548feep10f, -0.0f, -0x1.2c5daap-13f, 0.0f, 0x1.6e54ecp-15f},
        {0x1.6eee8ap0f, 0.0f, -0x1.18062cp1f, 0.0f, -0x1.a003e8p-21f, -0.0f, 0x1.f491aap-23f, 0.0f},
        {0.0f, 0x1.6eee8ap0f, 0.0f, -0x1.18062cp1f, 0.0f, -0x1.a003e8p-21f, 0.0f, 0x1.f491aap-23f},
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
/* Over the test vectors Q31 stays within 2.844e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 123038 * (int64_t)v, u2 = 524288 * (int64_t)v;
        v = x[1]; u0 += 236713 * (int64_t)v; u2 += 524288 * (int64_t)v;
        v = x[4]; u0 += -122742097 * (int64_t)v; u2 += -134096018 * (int64_t)v;
        v = x[5]; u0 += 41480982 * (int64_t)v; u2 += 143611256 * (int64_t)v;
        v = x[8]; u0 += 94292644 * (int64_t)v; u2 += -329981697 * (int64_t)v;
        v = x[9]; u0 += -104698731 * (int64_t)v; u2 += 108518003 * (int64_t)v;
        v = x[12]; u0 += 256174919 * (int64_t)v; u2 += 89922966 * (int64_t)v;
        v = x[13]; u0 += 12380780 * (int64_t)v; u2 += -154694621 * (int64_t)v;
        v = x[16]; u0 += 555577739 * (int64_t)v; u2 += -505717855 * (int64_t)v;
        v = x[17]; u0 += 155328267 * (int64_t)v; u2 += 217618230 * (int64_t)v;
        v = x[20]; u0 += 112941128 * (int64_t)v; u2 += -140717018 * (int64_t)v;
        v = x[21]; u0 += -15222940 * (int64_t)v; u2 += -24202610 * (int64_t)v;
        v = x[24]; u0 += -53841397 * (int64_t)v; u2 += -8417825 * (int64_t)v;
        v = x[25]; u0 += 91718 * (int64_t)v; u2 += -4432268 * (int64_t)v;
        v = x[28]; u0 += 21502093 * (int64_t)v; u2 += -89288642 * (int64_t)v;
        v = x[29]; u0 += -169958284 * (int64_t)v; u2 += -13556331 * (int64_t)v;
        v = x[32]; u0 += 46290727 * (int64_t)v; u2 += -27228220 * (int64_t)v;
        v = x[33]; u0 += -26409586 * (int64_t)v; u2 += 22702982 * (int64_t)v;
        v = x[36]; u0 += -5183903 * (int64_t)v; u2 += 8263656 * (int64_t)v;
        v = y0; u0 += -40831001 * (int64_t)v; u2 += 37600868 * (int64_t)v;
        v = y2; u0 += 7054107 * (int64_t)v; u2 += -15202484 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 19);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 123038 * (int64_t)v, u3 = 524288 * (int64_t)v;
        v = x[3]; u1 += 236713 * (int64_t)v; u3 += 524288 * (int64_t)v;
        v = x[6]; u1 += -122742097 * (int64_t)v; u3 += -134096018 * (int64_t)v;
        v = x[7]; u1 += 41480982 * (int64_t)v; u3 += 143611256 * (int64_t)v;
        v = x[10]; u1 += 94292644 * (int64_t)v; u3 += -329981697 * (int64_t)v;
        v = x[11]; u1 += -104698731 * (int64_t)v; u3 += 108518003 * (int64_t)v;
        v = x[14]; u1 += 256174919 * (int64_t)v; u3 += 89922966 * (int64_t)v;
        v = x[15]; u1 += 12380780 * (int64_t)v; u3 += -154694621 * (int64_t)v;
        v = x[18]; u1 += 555577739 * (int64_t)v; u3 += -505717855 * (int64_t)v;
        v = x[19]; u1 += 155328267 * (int64_t)v; u3 += 217618230 * (int64_t)v;
        v = x[22]; u1 += 112941128 * (int64_t)v; u3 += -140717018 * (int64_t)v;
        v = x[23]; u1 += -15222940 * (int64_t)v; u3 += -24202610 * (int64_t)v;
        v = x[26]; u1 += -53841397 * (int64_t)v; u3 += -8417825 * (int64_t)v;
        v = x[27]; u1 += 91718 * (int64_t)v; u3 += -4432268 * (int64_t)v;
        v = x[30]; u1 += 21502093 * (int64_t)v; u3 += -89288642 * (int64_t)v;
        v = x[31]; u1 += -169958284 * (int64_t)v; u3 += -13556331 * (int64_t)v;
        v = x[34]; u1 += 46290727 * (int64_t)v; u3 += -27228220 * (int64_t)v;
        v = x[35]; u1 += -26409586 * (int64_t)v; u3 += 22702982 * (int64_t)v;
        v = x[37]; u1 += -5183903 * (int64_t)v; u3 += 8263656 * (int64_t)v;
        v = y1; u1 += -40831001 * (int64_t)v; u3 += 37600868 * (int64_t)v;
        v = y3; u1 += 7054107 * (int64_t)v; u3 += -15202484 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1408522 * (int64_t)x0 + 49222768 * (int64_t)y0 - 28755610 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2847320 * (int64_t)x1 - 75141591 * (int64_t)y0 - 140598701 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1408522 * (int64_t)x2 + 49222768 * (int64_t)y1 - 28755610 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2847320 * (int64_t)x3 - 75141591 * (int64_t)y1 - 140598701 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-76564105 * (int64_t)x4 + 334435130 * (int64_t)x5 - 9545201 * (int64_t)y0 + 4804830 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-334435130 * (int64_t)x4 - 76564105 * (int64_t)x5 + 14348622 * (int64_t)y0 - 1604365 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-76564105 * (int64_t)x6 + 334435130 * (int64_t)x7 - 9545201 * (int64_t)y1 + 4804830 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-334435130 * (int64_t)x6 - 76564105 * (int64_t)x7 + 14348622 * (int64_t)y1 - 1604365 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-154516859 * (int64_t)x8 + 500724939 * (int64_t)x9 - 18269255 * (int64_t)y0 + 9858272 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-500724939 * (int64_t)x8 - 154516859 * (int64_t)x9 + 13922140 * (int64_t)y0 - 12442246 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-154516859 * (int64_t)x10 + 500724939 * (int64_t)x11 - 18269255 * (int64_t)y1 + 9858272 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-500724939 * (int64_t)x10 - 154516859 * (int64_t)x11 + 13922140 * (int64_t)y1 - 12442246 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(777560257 * (int64_t)x12 + 551450294 * (int64_t)x13 - 67597190 * (int64_t)y0 + 11262240 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-551450294 * (int64_t)x12 + 777560257 * (int64_t)x13 + 82159974 * (int64_t)y0 + 29870258 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(777560257 * (int64_t)x14 + 551450294 * (int64_t)x15 - 67597190 * (int64_t)y1 + 11262240 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-551450294 * (int64_t)x14 + 777560257 * (int64_t)x15 + 82159974 * (int64_t)y1 + 29870258 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(624195463 * (int64_t)x16 + 795104148 * (int64_t)x17 + 12345502 * (int64_t)y0 + 6557721 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-795104148 * (int64_t)x16 + 624195463 * (int64_t)x17 + 32391046 * (int64_t)y0 - 50413413 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(624195463 * (int64_t)x18 + 795104148 * (int64_t)x19 + 12345502 * (int64_t)y1 + 6557721 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-795104148 * (int64_t)x18 + 624195463 * (int64_t)x19 + 32391046 * (int64_t)y1 - 50413413 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(376917241 * (int64_t)x20 + 820759783 * (int64_t)x21 + 275291 * (int64_t)y0 - 222074300 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-820759783 * (int64_t)x20 + 376917241 * (int64_t)x21 + 4574912 * (int64_t)y0 + 51082724 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(376917241 * (int64_t)x22 + 820759783 * (int64_t)x23 + 275291 * (int64_t)y1 - 222074300 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-820759783 * (int64_t)x22 + 376917241 * (int64_t)x23 + 4574912 * (int64_t)y1 + 51082724 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(413463545 * (int64_t)x24 + 660967785 * (int64_t)x25 - 457333058 * (int64_t)y0 - 121672889 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-1321935570 * (int64_t)x24 + 206731773 * (int64_t)x25 + 215288207 * (int64_t)y0 + 36387887 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(413463545 * (int64_t)x26 + 660967785 * (int64_t)x27 - 457333058 * (int64_t)y1 - 121672889 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-1321935570 * (int64_t)x26 + 206731773 * (int64_t)x27 + 215288207 * (int64_t)y1 + 36387887 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(125570553 * (int64_t)x28 + 975379803 * (int64_t)x29 + 23009589 * (int64_t)y0 + 32024763 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-975379803 * (int64_t)x28 + 125570553 * (int64_t)x29 + 2544226 * (int64_t)y0 + 41087082 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(125570553 * (int64_t)x30 + 975379803 * (int64_t)x31 + 23009589 * (int64_t)y1 + 32024763 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-975379803 * (int64_t)x30 + 125570553 * (int64_t)x31 + 2544226 * (int64_t)y1 + 41087082 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-407930784 * (int64_t)x32 + 307133088 * (int64_t)x33 - 206768026 * (int64_t)y0 + 754659985 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-614266177 * (int64_t)x32 - 203965392 * (int64_t)x33 + 173210901 * (int64_t)y0 - 285302869 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-407930784 * (int64_t)x34 + 307133088 * (int64_t)x35 - 206768026 * (int64_t)y1 + 754659985 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-614266177 * (int64_t)x34 - 203965392 * (int64_t)x35 + 173210901 * (int64_t)y1 - 285302869 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2141993934 * (int64_t)x36 + 1692590 * (int64_t)y0 - 2359305 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2141993934 * (int64_t)x37 + 1692590 * (int64_t)y1 - 2359305 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], -780816522 * (int64_t)e[0] + 509656128 * (int64_t)e[2], 20);
        x[1] = paper_tool_q31_correct(x[1], 1520624642 * (int64_t)e[0] - 615291579 * (int64_t)e[2], 21);
        x[2] = paper_tool_q31_correct(x[2], -780816522 * (int64_t)e[1] + 509656128 * (int64_t)e[3], 20);
        x[3] = paper_tool_q31_correct(x[3], 1520624642 * (int64_t)e[1] - 615291579 * (int64_t)e[3], 21);
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
        {-896137502, 0, 276309909, 0, -65264921, 0, 31192756, 0},
        {1544808829, 0, -247631618, 0, 132802310, 0, -29494850, 0},
        {0, -896137502, 0, 276309909, 0, -65264921, 0, 31192756},
        {0, 1544808829, 0, -247631618, 0, 132802310, 0, -29494850},
        {1190475710, 0, -43643017, 0, 144024, 0, -14877, 0},
        {1247651310, 0, -504595429, 0, -392254, 0, 124436, 0},
        {0, 1190475710, 0, -43643017, 0, 144024, 0, -14877},
        {0, 1247651310, 0, -504595429, 0, -392254, 0, 124436},
        {522347574, 0, -588264017, 0, 249858, 0, -74620, 0},
        {713007381, 0, -428442536, 0, 473745, 0, -145015, 0},
        {0, 522347574, 0, -588264017, 0, 249858, 0, -74620},
        {0, 713007381, 0, -428442536, 0, 473745, 0, -145015},
        {1105401102, 0, 865155811, 0, -203652, 0, 45861, 0},
        {1361779943, 0, 58628477, 0, 866791, 0, -267360, 0},
        {0, 1105401102, 0, 865155811, 0, -203652, 0, 45861},
        {0, 1361779943, 0, 58628477, 0, 866791, 0, -267360},
        {642616002, 0, -764793270, 0, -158612, 0, 49348, 0},
        {198340943, 0, -1147457653, 0, 219582, 0, -65311, 0},
        {0, 642616002, 0, -764793270, 0, -158612, 0, 49348},
        {0, 198340943, 0, -1147457653, 0, 219582, 0, -65311},
        {53317984, 0, -1669761910, 0, -451447, 0, 153929, 0},
        {31722999, 0, 1616440013, 0, 741947, 0, -221810, 0},
        {0, 53317984, 0, -1669761910, 0, -451447, 0, 153929},
        {0, 31722999, 0, 1616440013, 0, 741947, 0, -221810},
        {-974187405, 0, -288008466, 0, -4532074, 0, 1455613, 0},
        {1693225970, 0, 401881792, 0, -5803352, 0, 1805561, 0},
        {0, -974187405, 0, -288008466, 0, -4532074, 0, 1455613},
        {0, 1693225970, 0, 401881792, 0, -5803352, 0, 1805561},
        {452827752, 0, 1309262861, 0, 107507, 0, -26916, 0},
        {-1460234936, 0, 567810633, 0, 2292174, 0, -749838, 0},
        {0, 452827752, 0, 1309262861, 0, 107507, 0, -26916},
        {0, -1460234936, 0, 567810633, 0, 2292174, 0, -749838},
        {-211119608, 0, 1097391433, 0, 3949845, 0, -1199696, 0},
        {342262088, 0, -743053469, 0, -922724, 0, 281343, 0},
        {0, -211119608, 0, 1097391433, 0, 3949845, 0, -1199696},
        {0, 342262088, 0, -743053469, 0, -922724, 0, 281343},
        {800587722, 0, -1221937455, 0, -5111996, 0, 1537748, 0},
        {0, 800587722, 0, -1221937455, 0, -5111996, 0, 1537748},
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
