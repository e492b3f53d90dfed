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
static const float paper_tool_f32_output_guard = 0x1.c03124p23f;

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
        float u0 = 0x1.13f5dcp0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.01507ap0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a3de5ep8f * v; u2 += 0x1.0ca488p9f * v;
        v = x[5]; u0 += 0x1.33d64cp5f * v; u2 += -0x1.7d8696p9f * v;
        v = x[8]; u0 += 0x1.0669e6p10f * v; u2 += -0x1.cbb93ap11f * v;
        v = x[9]; u0 += -0x1.5fcc4ap9f * v; u2 += 0x1.58a8a6p10f * v;
        v = x[12]; u0 += -0x1.b938cep10f * v; u2 += -0x1.14471ep9f * v;
        v = x[13]; u0 += -0x1.c5d8f0p8f * v; u2 += 0x1.0b9c58p10f * v;
        v = x[16]; u0 += -0x1.efcea2p11f * v; u2 += 0x1.1ccd40p11f * v;
        v = x[17]; u0 += 0x1.e1d728p5f * v; u2 += -0x1.cc2c4ap10f * v;
        v = x[20]; u0 += 0x1.bd61b8p9f * v; u2 += -0x1.612be4p9f * v;
        v = x[21]; u0 += 0x1.2dbae6p6f * v; u2 += -0x1.ebae3ep8f * v;
        v = x[24]; u0 += -0x1.492256p7f * v; u2 += -0x1.806d46p6f * v;
        v = x[25]; u0 += 0x1.402b6ep8f * v; u2 += -0x1.d7998ap4f * v;
        v = x[28]; u0 += -0x1.d09cdep8f * v; u2 += -0x1.ef7744p6f * v;
        v = x[29]; u0 += -0x1.4a9e50p7f * v; u2 += 0x1.ab9294p7f * v;
        v = x[32]; u0 += 0x1.28943cp7f * v; u2 += -0x1.d2593cp5f * v;
        v = x[33]; u0 += 0x1.c301b4p8f * v; u2 += -0x1.5468b4p7f * v;
        v = x[36]; u0 += -0x1.d0f6dcp4f * v; u2 += 0x1.708520p5f * v;
        v = y0; u0 += -0x1.0419dap20f * v; u2 += 0x1.ca0a9ap19f * v;
        v = y2; u0 += 0x1.e65132p15f * v; u2 += -0x1.e5df66p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.13f5dcp0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.01507ap0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a3de5ep8f * v; u3 += 0x1.0ca488p9f * v;
        v = x[7]; u1 += 0x1.33d64cp5f * v; u3 += -0x1.7d8696p9f * v;
        v = x[10]; u1 += 0x1.0669e6p10f * v; u3 += -0x1.cbb93ap11f * v;
        v = x[11]; u1 += -0x1.5fcc4ap9f * v; u3 += 0x1.58a8a6p10f * v;
        v = x[14]; u1 += -0x1.b938cep10f * v; u3 += -0x1.14471ep9f * v;
        v = x[15]; u1 += -0x1.c5d8f0p8f * v; u3 += 0x1.0b9c58p10f * v;
        v = x[18]; u1 += -0x1.efcea2p11f * v; u3 += 0x1.1ccd40p11f * v;
        v = x[19]; u1 += 0x1.e1d728p5f * v; u3 += -0x1.cc2c4ap10f * v;
        v = x[22]; u1 += 0x1.bd61b8p9f * v; u3 += -0x1.612be4p9f * v;
        v = x[23]; u1 += 0x1.2dbae6p6f * v; u3 += -0x1.ebae3ep8f * v;
        v = x[26]; u1 += -0x1.492256p7f * v; u3 += -0x1.806d46p6f * v;
        v = x[27]; u1 += 0x1.402b6ep8f * v; u3 += -0x1.d7998ap4f * v;
        v = x[30]; u1 += -0x1.d09cdep8f * v; u3 += -0x1.ef7744p6f * v;
        v = x[31]; u1 += -0x1.4a9e50p7f * v; u3 += 0x1.ab9294p7f * v;
        v = x[34]; u1 += 0x1.28943cp7f * v; u3 += -0x1.d2593cp5f * v;
        v = x[35]; u1 += 0x1.c301b4p8f * v; u3 += -0x1.5468b4p7f * v;
        v = x[37]; u1 += -0x1.d0f6dcp4f * v; u3 += 0x1.708520p5f * v;
        v = y1; u1 += -0x1.0419dap20f * v; u3 += 0x1.ca0a9ap19f * v;
        v = y3; u1 += 0x1.e65132p15f * v; u3 += -0x1.e5df66p17f * v;
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
        x[0] = -0x1.97be6cp-10f * x0 + 0x1.e7b166p7f * y0 - 0x1.aa8e74p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.17ed3ep-9f * x1 - 0x1.62c2a4p8f * y0 - 0x1.bcb21cp8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.97be6cp-10f * x2 + 0x1.e7b166p7f * y1 - 0x1.aa8e74p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.17ed3ep-9f * x3 - 0x1.62c2a4p8f * y1 - 0x1.bcb21cp8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.42f26cp-4f * x4 + 0x1.3c0782p-1f * x5 + 0x1.31f77ep6f * y0 - 0x1.38d1acp5f * y2
            + x4;
        x[5] = -0x1.3c0782p-3f * x4 - 0x1.42f26cp-4f * x5 - 0x1.d8e30cp5f * y0 + 0x1.0ffef0p0f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.42f26cp-4f * x6 + 0x1.3c0782p-1f * x7 + 0x1.31f77ep6f * y1 - 0x1.38d1acp5f * y3
            + x6;
        x[7] = -0x1.3c0782p-3f * x6 - 0x1.42f26cp-4f * x7 - 0x1.d8e30cp5f * y1 + 0x1.0ffef0p0f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1ca6b6p-3f * x8 + 0x1.e0ab28p-2f * x9 - 0x1.0dcb8ap5f * y0 + 0x1.4b442cp4f * y2
            + x8;
        x[9] = -0x1.e0ab28p-2f * x8 - 0x1.1ca6b6p-3f * x9 + 0x1.cfe982p4f * y0 - 0x1.106a24p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1ca6b6p-3f * x10 + 0x1.e0ab28p-2f * x11 - 0x1.0dcb8ap5f * y1 + 0x1.4b442cp4f * y3
            + x10;
        x[11] = -0x1.e0ab28p-2f * x10 - 0x1.1ca6b6p-3f * x11 + 0x1.cfe982p4f * y1 - 0x1.106a24p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6befa6p-1f * x12 + 0x1.01c46ap-1f * x13 + 0x1.c6fac4p7f * y0 - 0x1.263a54p6f * y2;
        x[13] = -0x1.01c46ap-1f * x12 + 0x1.6befa6p-1f * x13 - 0x1.459d2cp8f * y0 - 0x1.005cf6p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6befa6p-1f * x14 + 0x1.01c46ap-1f * x15 + 0x1.c6fac4p7f * y1 - 0x1.263a54p6f * y3;
        x[15] = -0x1.01c46ap-1f * x14 + 0x1.6befa6p-1f * x15 - 0x1.459d2cp8f * y1 - 0x1.005cf6p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.23990ep-1f * x16 + 0x1.7973fep-1f * x17 - 0x1.b81b3cp6f * y0 + 0x1.37409cp5f * y2;
        x[17] = -0x1.7973fep-1f * x16 + 0x1.23990ep-1f * x17 - 0x1.a8a6ecp6f * y0 + 0x1.83cf9ap7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.23990ep-1f * x18 + 0x1.7973fep-1f * x19 - 0x1.b81b3cp6f * y1 + 0x1.37409cp5f * y3;
        x[19] = -0x1.7973fep-1f * x18 + 0x1.23990ep-1f * x19 - 0x1.a8a6ecp6f * y1 + 0x1.83cf9ap7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6e58acp-2f * x20 + 0x1.85b714p-1f * x21 + 0x1.63d38ap5f * y0 - 0x1.6172f6p9f * y2;
        x[21] = -0x1.85b714p-1f * x20 + 0x1.6e58acp-2f * x21 - 0x1.a45b80p7f * y0 + 0x1.1551f4p5f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6e58acp-2f * x22 + 0x1.85b714p-1f * x23 + 0x1.63d38ap5f * y1 - 0x1.6172f6p9f * y3;
        x[23] = -0x1.85b714p-1f * x22 + 0x1.6e58acp-2f * x23 - 0x1.a45b80p7f * y1 + 0x1.1551f4p5f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.5d30c6p-3f * x24 + 0x1.4cef08p-1f * x25 + 0x1.cf9486p5f * y0 - 0x1.14318cp7f * y2;
        x[25] = -0x1.4cef08p-1f * x24 + 0x1.5d30c6p-3f * x25 + 0x1.054d9ep10f * y0 + 0x1.a4a5b8p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.5d30c6p-3f * x26 + 0x1.4cef08p-1f * x27 + 0x1.cf9486p5f * y1 - 0x1.14318cp7f * y3;
        x[27] = -0x1.4cef08p-1f * x26 + 0x1.5d30c6p-3f * x27 + 0x1.054d9ep10f * y1 + 0x1.a4a5b8p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.eb5688p-4f * x28 + 0x1.c9512ap-1f * x29 + 0x1.011884p6f * y0 + 0x1.67595ep8f * y2;
        x[29] = -0x1.c9512ap-1f * x28 + 0x1.eb5688p-4f * x29 - 0x1.465b52p5f * y0 - 0x1.8f4662p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.eb5688p-4f * x30 + 0x1.c9512ap-1f * x31 + 0x1.011884p6f * y1 + 0x1.67595ep8f * y3;
        x[31] = -0x1.c9512ap-1f * x30 + 0x1.eb5688p-4f * x31 - 0x1.465b52p5f * y1 - 0x1.8f4662p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.019c46p-2f * x32 + 0x1.5dd706p-1f * x33 - 0x1.0fd412p9f * y0 - 0x1.e45902p7f * y2;
        x[33] = -0x1.5dd706p-3f * x32 - 0x1.019c46p-2f * x33 - 0x1.bcac64p9f * y0 + 0x1.705acap10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.019c46p-2f * x34 + 0x1.5dd706p-1f * x35 - 0x1.0fd412p9f * y1 - 0x1.e45902p7f * y3;
        x[35] = -0x1.5dd706p-3f * x34 - 0x1.019c46p-2f * x35 - 0x1.bcac64p9f * y1 + 0x1.705acap10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fec076p-1f * x36 + 0x1.893680p1f * y0 - 0x1.0c0f4cp2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fec076p-1f * x37 + 0x1.893680p1f * y1 - 0x1.0c0f4cp2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.81e556p-4f * e[0];
        x[0] += 0x1.46022ep-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.7049cap-4f * e[0];
        x[1] += -0x1.298bacp-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.81e556p-4f * e[1];
        x[2] += 0x1.46022ep-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.7049cap-4f * e[1];
        x[3] += -0x1.298bacp-4f * e[3];
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
        {0x1.8f644cp16f, 0.0f, 0x1.2cb626p15f, 0.0f, 0x1.86329cp-1f, 0.0f, -0x1.467162p-4f, 0.0f},
        {-0x1.df89a4p16f, 0.0f, -0x1.77aedcp13f, 0.0f, -0x1.4883f0p-1f, 0.0f, 0x1.7c2ea8p-2f, 0.0f},
        {0.0f, 0x1.8f644cp16f, 0.0f, 0x1.2cb626p15f, 0.0f, 0x1.86329cp-1f, 0.0f, -0x1.467162p-4f},
        {0.0f, -0x1.df89a4p16f, 0.0f, -0x1.77aedcp13f, 0.0f, -0x1.4883f0p-1f, 0.0f, 0x1.7c2ea8p-2f},
        {-0x1.307b38p8f, 0.0f, -0x1.991948p4f, 0.0f, -0x1.a68fdap-16f, 0.0f, 0x1.19aa30p-17f, 0.0f},
        {-0x1.381dd0p7f, 0.0f, 0x1.e408a2p5f, 0.0f, 0x1.48ba06p-15f, 0.0f, -0x1.cc372ep-17f, 0.0f},
        {0.0f, -0x1.307b38p8f, 0.0f, -0x1.991948p4f, 0.0f, -0x1.a68fdap-16f, 0.0f, 0x1.19aa30p-17f},
        {0.0f, -0x1.381dd0p7f, 0.0f, 0x1.e408a2p5f, 0.0f, 0x1.48ba06p-15f, 0.0f, -0x1.cc372ep-17f},
        {0x1.2b5938p5f, 0.0f, -0x1.54bc14p4f, 0.0f, 0x1.2ed2fap-20f, 0.0f, -0x1.9c8ccap-22f, 0.0f},
        {0x1.5930b4p6f, 0.0f, -0x1.916056p5f, 0.0f, 0x1.67d188p-16f, 0.0f, -0x1.f55cdep-18f, 0.0f},
        {0.0f, 0x1.2b5938p5f, 0.0f, -0x1.54bc14p4f, 0.0f, 0x1.2ed2fap-20f, 0.0f, -0x1.9c8ccap-22f},
        {0.0f, 0x1.5930b4p6f, 0.0f, -0x1.916056p5f, 0.0f, 0x1.67d188p-16f, 0.0f, -0x1.f55cdep-18f},
        {-0x1.1a9926p8f, 0.0f, -0x1.faac6cp7f, 0.0f, 0x1.b9d4a6p-15f, 0.0f, -0x1.3119cap-16f, 0.0f},
        {-0x1.4567cep9f, 0.0f, -0x1.3c8f1ep1f, 0.0f, -0x1.a0096ap-13f, 0.0f, 0x1.21cff8p-14f, 0.0f},
        {0.0f, -0x1.1a9926p8f, 0.0f, -0x1.faac6cp7f, 0.0f, 0x1.b9d4a6p-15f, 0.0f, -0x1.3119cap-16f},
        {0.0f, -0x1.4567cep9f, 0.0f, -0x1.3c8f1ep1f, 0.0f, -0x1.a0096ap-13f, 0.0f, 0x1.21cff8p-14f},
        {-0x1.54c3a2p7f, 0.0f, 0x1.b67424p7f, 0.0f, 0x1.a58c10p-17f, 0.0f, -0x1.269d66p-18f, 0.0f},
        {0x1.6a2892p5f, 0.0f, 0x1.2b9038p6f, 0.0f, -0x1.5ba604p-16f, 0.0f, 0x1.e3a248p-18f, 0.0f},
        {0.0f, -0x1.54c3a2p7f, 0.0f, 0x1.b67424p7f, 0.0f, 0x1.a58c10p-17f, 0.0f, -0x1.269d66p-18f},
        {0.0f, 0x1.6a2892p5f, 0.0f, 0x1.2b9038p6f, 0.0f, -0x1.5ba604p-16f, 0.0f, 0x1.e3a248p-18f},
        {-0x1.09e21cp7f, 0.0f, -0x1.aeae3ap8f, 0.0f, -0x1.d2a26ep-19f, 0.0f, 0x1.6a2facp-20f, 0.0f},
        {-0x1.2f13d2p7f, 0.0f, 0x1.1b7866p9f, 0.0f, 0x1.e6c444p-14f, 0.0f, -0x1.51a8fep-15f, 0.0f},
        {0.0f, -0x1.09e21cp7f, 0.0f, -0x1.aeae3ap8f, 0.0f, -0x1.d2a26ep-19f, 0.0f, 0x1.6a2facp-20f},
        {0.0f, -0x1.2f13d2p7f, 0.0f, 0x1.1b7866p9f, 0.0f, 0x1.e6c444p-14f, 0.0f, -0x1.51a8fep-15f},
        {0x1.a68f76p8f, 0.0f, 0x1.db3818p2f, 0.0f, -0x1.7f1274p-10f, 0.0f, 0x1.0b915ep-11f, 0.0f},
        {0x1.7675b2p9f, 0.0f, 0x1.da5538p7f, 0.0f, 0x1.107548p-16f, 0.0f, -0x1.8ce220p-18f, 0.0f},
        {0.0f, 0x1.a68f76p8f, 0.0f, 0x1.db3818p2f, 0.0f, -0x1.7f1274p-10f, 0.0f, 0x1.0b915ep-11f},
        {0.0f, 0x1.7675b2p9f, 0.0f, 0x1.da5538p7f, 0.0f, 0x1.107548p-16f, 0.0f, -0x1.8ce220p-18f},
        {0x1.065386p4f, 0.0f, 0x1.5e2f5cp6f, 0.0f, 0x1.83e8bep-16f, 0.0f, -0x1.127e24p-17f, 0.0f},
        {-0x1.e53b14p5f, 0.0f, -0x1.3c8110p8f, 0.0f, -0x1.f2c6c2p-18f, 0.0f, 0x1.47c1fep-19f, -0.0f},
        {0.0f, 0x1.065386p4f, 0.0f, 0x1.5e2f5cp6f, 0.0f, 0x1.83e8bep-16f, 0.0f, -0x1.127e24p-17f},
        {0.0f, -0x1.e53b14p5f, 0.0f, -0x1.3c8110p8f, 0.0f, -0x1.f2c6c2p-18f, 0.0f, 0x1.47c1fep-19f},
        {-0x1.5cbf98p9f, 0.0f, 0x1.a63b08p8f, 0.0f, 0x1.be01dap-12f, 0.0f, -0x1.37398ep-13f, 0.0f},
        {-0x1.8b07b0p8f, 0.0f, 0x1.1c0ef8p10f, 0.0f, 0x1.5a11aap-10f, 0.0f, -0x1.e21400p-12f, 0.0f},
        {0.0f, -0x1.5cbf98p9f, 0.0f, 0x1.a63b08p8f, 0.0f, 0x1.be01dap-12f, 0.0f, -0x1.37398ep-13f},
        {0.0f, -0x1.8b07b0p8f, 0.0f, 0x1.1c0ef8p10f, 0.0f, 0x1.5a11aap-10f, 0.0f, -0x1.e21400p-12f},
        {0x1.1af80ap0f, 0.0f, -0x1.127542p1f, -0.0f, -0x1.682164p-19f, -0.0f, 0x1.f39916p-21f, 0.0f},
        {0.0f, 0x1.1af80ap0f, 0.0f, -0x1.127542p1f, 0.0f, -0x1.682164p-19f, 0.0f, 0x1.f39916p-21f},
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
/* Over the test vectors Q31 stays within 4.891e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 188389 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 175660 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73377360 * (int64_t)v; u2 += 46948716 * (int64_t)v;
        v = x[5]; u0 += 6724804 * (int64_t)v; u2 += -66676455 * (int64_t)v;
        v = x[8]; u0 += 183440449 * (int64_t)v; u2 += -321370049 * (int64_t)v;
        v = x[9]; u0 += -122962312 * (int64_t)v; u2 += 120466976 * (int64_t)v;
        v = x[12]; u0 += -308436456 * (int64_t)v; u2 += -48283046 * (int64_t)v;
        v = x[13]; u0 += -79315583 * (int64_t)v; u2 += 93536728 * (int64_t)v;
        v = x[16]; u0 += -693188634 * (int64_t)v; u2 += 199090868 * (int64_t)v;
        v = x[17]; u0 += 10525965 * (int64_t)v; u2 += -160842124 * (int64_t)v;
        v = x[20]; u0 += 155672197 * (int64_t)v; u2 += -61721182 * (int64_t)v;
        v = x[21]; u0 += 13182788 * (int64_t)v; u2 += -42963710 * (int64_t)v;
        v = x[24]; u0 += -28760178 * (int64_t)v; u2 += -8397933 * (int64_t)v;
        v = x[25]; u0 += 55953700 * (int64_t)v; u2 += -2575564 * (int64_t)v;
        v = x[28]; u0 += -81196967 * (int64_t)v; u2 += -10823617 * (int64_t)v;
        v = x[29]; u0 += -28889878 * (int64_t)v; u2 += 18680931 * (int64_t)v;
        v = x[32]; u0 += 25915473 * (int64_t)v; u2 += -5093770 * (int64_t)v;
        v = x[33]; u0 += 78819125 * (int64_t)v; u2 += -14872696 * (int64_t)v;
        v = x[36]; u0 += -5078650 * (int64_t)v; u2 += 4025221 * (int64_t)v;
        v = y0; u0 += -47291636 * (int64_t)v; u2 += 20820305 * (int64_t)v;
        v = y2; u0 += 2763198 * (int64_t)v; u2 += -5521344 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 188389 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 175660 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73377360 * (int64_t)v; u3 += 46948716 * (int64_t)v;
        v = x[7]; u1 += 6724804 * (int64_t)v; u3 += -66676455 * (int64_t)v;
        v = x[10]; u1 += 183440449 * (int64_t)v; u3 += -321370049 * (int64_t)v;
        v = x[11]; u1 += -122962312 * (int64_t)v; u3 += 120466976 * (int64_t)v;
        v = x[14]; u1 += -308436456 * (int64_t)v; u3 += -48283046 * (int64_t)v;
        v = x[15]; u1 += -79315583 * (int64_t)v; u3 += 93536728 * (int64_t)v;
        v = x[18]; u1 += -693188634 * (int64_t)v; u3 += 199090868 * (int64_t)v;
        v = x[19]; u1 += 10525965 * (int64_t)v; u3 += -160842124 * (int64_t)v;
        v = x[22]; u1 += 155672197 * (int64_t)v; u3 += -61721182 * (int64_t)v;
        v = x[23]; u1 += 13182788 * (int64_t)v; u3 += -42963710 * (int64_t)v;
        v = x[26]; u1 += -28760178 * (int64_t)v; u3 += -8397933 * (int64_t)v;
        v = x[27]; u1 += 55953700 * (int64_t)v; u3 += -2575564 * (int64_t)v;
        v = x[30]; u1 += -81196967 * (int64_t)v; u3 += -10823617 * (int64_t)v;
        v = x[31]; u1 += -28889878 * (int64_t)v; u3 += 18680931 * (int64_t)v;
        v = x[34]; u1 += 25915473 * (int64_t)v; u3 += -5093770 * (int64_t)v;
        v = x[35]; u1 += 78819125 * (int64_t)v; u3 += -14872696 * (int64_t)v;
        v = x[37]; u1 += -5078650 * (int64_t)v; u3 += 4025221 * (int64_t)v;
        v = y1; u1 += -47291636 * (int64_t)v; u3 += 20820305 * (int64_t)v;
        v = y3; u1 += 2763198 * (int64_t)v; u3 += -5521344 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1670119 * (int64_t)x0 + 66504353 * (int64_t)y0 - 29083731 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2293160 * (int64_t)x1 - 96753932 * (int64_t)y0 - 121282061 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1670119 * (int64_t)x2 + 66504353 * (int64_t)y1 - 29083731 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2293160 * (int64_t)x3 - 96753932 * (int64_t)y1 - 121282061 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-84658607 * (int64_t)x4 + 662761535 * (int64_t)x5 + 20861611 * (int64_t)y0 - 10664408 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165690384 * (int64_t)x4 - 84658607 * (int64_t)x5 - 16121331 * (int64_t)y0 + 289772 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-84658607 * (int64_t)x6 + 662761535 * (int64_t)x7 + 20861611 * (int64_t)y1 - 10664408 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165690384 * (int64_t)x6 - 84658607 * (int64_t)x7 - 16121331 * (int64_t)y1 + 289772 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149239222 * (int64_t)x8 + 504017550 * (int64_t)x9 - 9197666 * (int64_t)y0 + 5646650 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504017550 * (int64_t)x8 - 149239222 * (int64_t)x9 + 7907685 * (int64_t)y0 - 4643484 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149239222 * (int64_t)x10 + 504017550 * (int64_t)x11 - 9197666 * (int64_t)y1 + 5646650 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504017550 * (int64_t)x10 - 149239222 * (int64_t)x11 + 7907685 * (int64_t)y1 - 4643484 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763229347 * (int64_t)x12 + 540577079 * (int64_t)x13 + 62043384 * (int64_t)y0 - 20061221 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-540577079 * (int64_t)x12 + 763229347 * (int64_t)x13 - 88804833 * (int64_t)y0 - 34959013 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763229347 * (int64_t)x14 + 540577079 * (int64_t)x15 + 62043384 * (int64_t)y1 - 20061221 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-540577079 * (int64_t)x14 + 763229347 * (int64_t)x15 - 88804833 * (int64_t)y1 - 34959013 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611525030 * (int64_t)x16 + 791576538 * (int64_t)x17 - 30007601 * (int64_t)y0 + 10610999 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791576538 * (int64_t)x16 + 611525030 * (int64_t)x17 - 28953882 * (int64_t)y0 + 52883919 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611525030 * (int64_t)x18 + 791576538 * (int64_t)x19 - 30007601 * (int64_t)y1 + 10610999 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791576538 * (int64_t)x18 + 611525030 * (int64_t)x19 - 28953882 * (int64_t)y1 + 52883919 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(384142018 * (int64_t)x20 + 817291921 * (int64_t)x21 + 12130583 * (int64_t)y0 - 192792622 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817291921 * (int64_t)x20 + 384142018 * (int64_t)x21 - 57322131 * (int64_t)y0 + 9454205 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(384142018 * (int64_t)x22 + 817291921 * (int64_t)x23 + 12130583 * (int64_t)y1 - 192792622 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817291921 * (int64_t)x22 + 384142018 * (int64_t)x23 - 57322131 * (int64_t)y1 + 9454205 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(366152784 * (int64_t)x24 + 1396425211 * (int64_t)x25 + 31608103 * (int64_t)y0 - 75326383 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-698212606 * (int64_t)x24 + 183076392 * (int64_t)x25 + 285061318 * (int64_t)y0 + 57361662 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(366152784 * (int64_t)x26 + 1396425211 * (int64_t)x27 + 31608103 * (int64_t)y1 - 75326383 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-698212606 * (int64_t)x26 + 183076392 * (int64_t)x27 + 285061318 * (int64_t)y1 + 57361662 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128801312 * (int64_t)x28 + 959063356 * (int64_t)x29 + 17529460 * (int64_t)y0 + 98005431 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-959063356 * (int64_t)x28 + 128801312 * (int64_t)x29 - 11125925 * (int64_t)y0 - 54447211 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128801312 * (int64_t)x30 + 959063356 * (int64_t)x31 + 17529460 * (int64_t)y1 + 98005431 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-959063356 * (int64_t)x30 + 128801312 * (int64_t)x31 - 11125925 * (int64_t)y1 - 54447211 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-270124125 * (int64_t)x32 + 733667518 * (int64_t)x33 - 148271755 * (int64_t)y0 - 66048174 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-183416879 * (int64_t)x32 - 270124125 * (int64_t)x33 - 242551934 * (int64_t)y0 + 401846066 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-270124125 * (int64_t)x34 + 733667518 * (int64_t)x35 - 148271755 * (int64_t)y1 - 66048174 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-183416879 * (int64_t)x34 - 270124125 * (int64_t)x35 - 242551934 * (int64_t)y1 + 401846066 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142248298 * (int64_t)x36 + 1675643 * (int64_t)y0 - 2284626 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142248298 * (int64_t)x37 + 1675643 * (int64_t)y1 - 2284626 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 606961659 * (int64_t)e[0] + 512767034 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1158534626 * (int64_t)e[0] - 935997488 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 606961659 * (int64_t)e[1] + 512767034 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1158534626 * (int64_t)e[1] - 935997488 * (int64_t)e[3], 19);
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
        {871410321, 0, 328052733, 0, 76715990, 0, -8022661, 0},
        {-1046276051, 0, -102460196, 0, -64588753, 0, 37373436, 0},
        {0, 871410321, 0, 328052733, 0, 76715990, 0, -8022661},
        {0, -1046276051, 0, -102460196, 0, -64588753, 0, 37373436},
        {-1328661174, 0, -111573680, 0, -1298110, 0, 432637, 0},
        {-1361978496, 0, 528042881, 0, 4039393, 0, -1413782, 0},
        {0, -1328661174, 0, -111573680, 0, -1298110, 0, 432637},
        {0, -1361978496, 0, 528042881, 0, 4039393, 0, -1413782},
        {1306263128, 0, -743429695, 0, 465138, 0, -158419, 0},
        {753151040, 0, -437870116, 0, 2210725, 0, -770093, 0},
        {0, 1306263128, 0, -743429695, 0, 465138, 0, -158419},
        {0, 753151040, 0, -437870116, 0, 2210725, 0, -770093},
        {-616585124, 0, -552741125, 0, 1357304, 0, -468635, 0},
        {-1419967585, 0, -5395955, 0, -5112260, 0, 1780607, 0},
        {0, -616585124, 0, -552741125, 0, 1357304, 0, -468635},
        {0, -1419967585, 0, -5395955, 0, -5112260, 0, 1780607},
        {-743494109, 0, 956637250, 0, 647496, 0, -226264, 0},
        {790173051, 0, 1307200620, 0, -4271905, 0, 1485723, 0},
        {0, -743494109, 0, 956637250, 0, 647496, 0, -226264},
        {0, 790173051, 0, 1307200620, 0, -4271905, 0, 1485723},
        {-290057785, 0, -939677551, 0, -89594, 0, 34770, 0},
        {-330633752, 0, 1236975573, 0, 2990694, 0, -1037292, 0},
        {0, -290057785, 0, -939677551, 0, -89594, 0, 34770},
        {0, -330633752, 0, 1236975573, 0, 2990694, 0, -1037292},
        {1843921166, 0, 32401677, 0, -75315037, 0, 26302989, 0},
        {817012545, 0, 258730023, 0, 209248, 0, -76202, 0},
        {0, 1843921166, 0, 32401677, 0, -75315037, 0, 26302989},
        {0, 817012545, 0, 258730023, 0, 209248, 0, -76202},
        {286177424, 0, 1528097630, 0, 4766628, 0, -1686483, 0},
        {-264674393, 0, -1381124995, 0, -383060, 0, 125859, 0},
        {0, 286177424, 0, 1528097630, 0, 4766628, 0, -1686483},
        {0, -264674393, 0, -1381124995, 0, -383060, 0, 125859},
        {-760914427, 0, 460620508, 0, 5480537, 0, -1912165, 0},
        {-430946842, 0, 1239542174, 0, 17009983, 0, -5923776, 0},
        {0, -760914427, 0, 460620508, 0, 5480537, 0, -1912165},
        {0, -430946842, 0, 1239542174, 0, 17009983, 0, -5923776},
        {617393805, 0, -1197648970, 0, -17701131, 0, 6139060, 0},
        {0, 617393805, 0, -1197648970, 0, -17701131, 0, 6139060},
    };
    static const int16_t shift[38] = {
        25, 25, 25, 25, 34, 35, 34, 35, 37, 35, 37, 35, 33, 33, 33, 33, 34, 36, 34, 36, 33, 33, 33, 33, 34, 32, 34, 32, 36, 34, 36, 34, 32, 32, 32, 32, 41, 41};
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
