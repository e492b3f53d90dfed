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
static const float paper_tool_f32_output_guard = 0x1.c02b46p23f;

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
        float u0 = 0x1.13f8bap0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.01552cp0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a3e7dcp8f * v; u2 += 0x1.0ca212p9f * v;
        v = x[5]; u0 += 0x1.33ae48p5f * v; u2 += -0x1.7da94ep9f * v;
        v = x[8]; u0 += 0x1.067818p10f * v; u2 += -0x1.cbbb32p11f * v;
        v = x[9]; u0 += -0x1.5ff7c2p9f * v; u2 += 0x1.587ff0p10f * v;
        v = x[12]; u0 += -0x1.b9110ap10f * v; u2 += -0x1.1444fap9f * v;
        v = x[13]; u0 += -0x1.c5ccfcp8f * v; u2 += 0x1.0b8d2ap10f * v;
        v = x[16]; u0 += -0x1.efbce2p11f * v; u2 += 0x1.1ccb4cp11f * v;
        v = x[17]; u0 += 0x1.df7330p5f * v; u2 += -0x1.cc28f0p10f * v;
        v = x[20]; u0 += 0x1.bd69eap9f * v; u2 += -0x1.6128eep9f * v;
        v = x[21]; u0 += 0x1.2e18a2p6f * v; u2 += -0x1.ebbdecp8f * v;
        v = x[24]; u0 += -0x1.491f60p7f * v; u2 += -0x1.80670ap6f * v;
        v = x[25]; u0 += 0x1.4027d4p8f * v; u2 += -0x1.d746f0p4f * v;
        v = x[28]; u0 += -0x1.d0a010p8f * v; u2 += -0x1.ef7b54p6f * v;
        v = x[29]; u0 += -0x1.4a98dap7f * v; u2 += 0x1.ab90d6p7f * v;
        v = x[32]; u0 += 0x1.28a806p7f * v; u2 += -0x1.d2157ap5f * v;
        v = x[33]; u0 += 0x1.c30104p8f * v; u2 += -0x1.545e46p7f * v;
        v = x[36]; u0 += -0x1.d0f6dep4f * v; u2 += 0x1.708520p5f * v;
        v = y0; u0 += -0x1.041820p20f * v; u2 += 0x1.ca0d7ap19f * v;
        v = y2; u0 += 0x1.e6aadep15f * v; u2 += -0x1.e5cf96p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.13f8bap0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.01552cp0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a3e7dcp8f * v; u3 += 0x1.0ca212p9f * v;
        v = x[7]; u1 += 0x1.33ae48p5f * v; u3 += -0x1.7da94ep9f * v;
        v = x[10]; u1 += 0x1.067818p10f * v; u3 += -0x1.cbbb32p11f * v;
        v = x[11]; u1 += -0x1.5ff7c2p9f * v; u3 += 0x1.587ff0p10f * v;
        v = x[14]; u1 += -0x1.b9110ap10f * v; u3 += -0x1.1444fap9f * v;
        v = x[15]; u1 += -0x1.c5ccfcp8f * v; u3 += 0x1.0b8d2ap10f * v;
        v = x[18]; u1 += -0x1.efbce2p11f * v; u3 += 0x1.1ccb4cp11f * v;
        v = x[19]; u1 += 0x1.df7330p5f * v; u3 += -0x1.cc28f0p10f * v;
        v = x[22]; u1 += 0x1.bd69eap9f * v; u3 += -0x1.6128eep9f * v;
        v = x[23]; u1 += 0x1.2e18a2p6f * v; u3 += -0x1.ebbdecp8f * v;
        v = x[26]; u1 += -0x1.491f60p7f * v; u3 += -0x1.80670ap6f * v;
        v = x[27]; u1 += 0x1.4027d4p8f * v; u3 += -0x1.d746f0p4f * v;
        v = x[30]; u1 += -0x1.d0a010p8f * v; u3 += -0x1.ef7b54p6f * v;
        v = x[31]; u1 += -0x1.4a98dap7f * v; u3 += 0x1.ab90d6p7f * v;
        v = x[34]; u1 += 0x1.28a806p7f * v; u3 += -0x1.d2157ap5f * v;
        v = x[35]; u1 += 0x1.c30104p8f * v; u3 += -0x1.545e46p7f * v;
        v = x[37]; u1 += -0x1.d0f6dep4f * v; u3 += 0x1.708520p5f * v;
        v = y1; u1 += -0x1.041820p20f * v; u3 += 0x1.ca0d7ap19f * v;
        v = y3; u1 += 0x1.e6aadep15f * v; u3 += -0x1.e5cf96p17f * v;
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
        x[0] = -0x1.97c2c6p-10f * x0 + 0x1.e7bbd4p7f * y0 - 0x1.aa95e6p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.17eb1cp-9f * x1 - 0x1.62bebap8f * y0 - 0x1.bcb52ap8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.97c2c6p-10f * x2 + 0x1.e7bbd4p7f * y1 - 0x1.aa95e6p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.17eb1cp-9f * x3 - 0x1.62bebap8f * y1 - 0x1.bcb52ap8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.42f2b0p-4f * x4 + 0x1.3c06f6p-1f * x5 + 0x1.31ee46p6f * y0 - 0x1.38cfecp5f * y2
            + x4;
        x[5] = -0x1.3c06f6p-3f * x4 - 0x1.42f2b0p-4f * x5 - 0x1.d8dc00p5f * y0 + 0x1.109182p0f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.42f2b0p-4f * x6 + 0x1.3c06f6p-1f * x7 + 0x1.31ee46p6f * y1 - 0x1.38cfecp5f * y3
            + x6;
        x[7] = -0x1.3c06f6p-3f * x6 - 0x1.42f2b0p-4f * x7 - 0x1.d8dc00p5f * y1 + 0x1.109182p0f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1cabe2p-3f * x8 + 0x1.e0a9d2p-2f * x9 - 0x1.0de974p5f * y0 + 0x1.4b534ap4f * y2
            + x8;
        x[9] = -0x1.e0a9d2p-2f * x8 - 0x1.1cabe2p-3f * x9 + 0x1.cfe632p4f * y0 - 0x1.106b54p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1cabe2p-3f * x10 + 0x1.e0a9d2p-2f * x11 - 0x1.0de974p5f * y1 + 0x1.4b534ap4f * y3
            + x10;
        x[11] = -0x1.e0a9d2p-2f * x10 - 0x1.1cabe2p-3f * x11 + 0x1.cfe632p4f * y1 - 0x1.106b54p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6bf418p-1f * x12 + 0x1.01c27ap-1f * x13 + 0x1.c71a98p7f * y0 - 0x1.2630f4p6f * y2;
        x[13] = -0x1.01c27ap-1f * x12 + 0x1.6bf418p-1f * x13 - 0x1.45ade6p8f * y0 - 0x1.0050b4p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6bf418p-1f * x14 + 0x1.01c27ap-1f * x15 + 0x1.c71a98p7f * y1 - 0x1.2630f4p6f * y3;
        x[15] = -0x1.01c27ap-1f * x14 + 0x1.6bf418p-1f * x15 - 0x1.45ade6p8f * y1 - 0x1.0050b4p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.2398dcp-1f * x16 + 0x1.797446p-1f * x17 - 0x1.b81adep6f * y0 + 0x1.372d2cp5f * y2;
        x[17] = -0x1.797446p-1f * x16 + 0x1.2398dcp-1f * x17 - 0x1.a8c670p6f * y0 + 0x1.83d9cep7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.2398dcp-1f * x18 + 0x1.797446p-1f * x19 - 0x1.b81adep6f * y1 + 0x1.372d2cp5f * y3;
        x[19] = -0x1.797446p-1f * x18 + 0x1.2398dcp-1f * x19 - 0x1.a8c670p6f * y1 + 0x1.83d9cep7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6e5aeep-2f * x20 + 0x1.85b694p-1f * x21 + 0x1.645b38p5f * y0 - 0x1.61739cp9f * y2;
        x[21] = -0x1.85b694p-1f * x20 + 0x1.6e5aeep-2f * x21 - 0x1.a43984p7f * y0 + 0x1.150f7cp5f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6e5aeep-2f * x22 + 0x1.85b694p-1f * x23 + 0x1.645b38p5f * y1 - 0x1.61739cp9f * y3;
        x[23] = -0x1.85b694p-1f * x22 + 0x1.6e5aeep-2f * x23 - 0x1.a43984p7f * y1 + 0x1.150f7cp5f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.5d334ap-3f * x24 + 0x1.4ceffep-1f * x25 + 0x1.d068cep5f * y0 - 0x1.1444bep7f * y2;
        x[25] = -0x1.4ceffep-1f * x24 + 0x1.5d334ap-3f * x25 + 0x1.054afap10f * y0 + 0x1.a47120p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.5d334ap-3f * x26 + 0x1.4ceffep-1f * x27 + 0x1.d068cep5f * y1 - 0x1.1444bep7f * y3;
        x[27] = -0x1.4ceffep-1f * x26 + 0x1.5d334ap-3f * x27 + 0x1.054afap10f * y1 + 0x1.a47120p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.eb53a6p-4f * x28 + 0x1.c95102p-1f * x29 + 0x1.01099ep6f * y0 + 0x1.67615ap8f * y2;
        x[29] = -0x1.c95102p-1f * x28 + 0x1.eb53a6p-4f * x29 - 0x1.464400p5f * y0 - 0x1.8f5258p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.eb53a6p-4f * x30 + 0x1.c95102p-1f * x31 + 0x1.01099ep6f * y1 + 0x1.67615ap8f * y3;
        x[31] = -0x1.c95102p-1f * x30 + 0x1.eb53a6p-4f * x31 - 0x1.464400p5f * y1 - 0x1.8f5258p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.019e76p-2f * x32 + 0x1.5dd692p-1f * x33 - 0x1.0fde78p9f * y0 - 0x1.e43f50p7f * y2;
        x[33] = -0x1.5dd692p-3f * x32 - 0x1.019e76p-2f * x33 - 0x1.bca14ap9f * y0 + 0x1.706cc4p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.019e76p-2f * x34 + 0x1.5dd692p-1f * x35 - 0x1.0fde78p9f * y1 - 0x1.e43f50p7f * y3;
        x[35] = -0x1.5dd692p-3f * x34 - 0x1.019e76p-2f * x35 - 0x1.bca14ap9f * y1 + 0x1.706cc4p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fec076p-1f * x36 + 0x1.89368cp1f * y0 - 0x1.0c0f48p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fec076p-1f * x37 + 0x1.89368cp1f * y1 - 0x1.0c0f48p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.81f9cep-4f * e[0];
        x[0] += 0x1.461cd8p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.705e20p-4f * e[0];
        x[1] += -0x1.29a612p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.81f9cep-4f * e[1];
        x[2] += 0x1.461cd8p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.705e20p-4f * e[1];
        x[3] += -0x1.29a612p-4f * e[3];
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
        {0x1.8f5bc4p16f, 0.0f, 0x1.2caed6p15f, 0.0f, 0x1.862e92p-1f, 0.0f, -0x1.4672a4p-4f, 0.0f},
        {-0x1.df7f36p16f, 0.0f, -0x1.77973ap13f, 0.0f, -0x1.487e58p-1f, 0.0f, 0x1.7c2d5ap-2f, 0.0f},
        {0.0f, 0x1.8f5bc4p16f, 0.0f, 0x1.2caed6p15f, 0.0f, 0x1.862e92p-1f, 0.0f, -0x1.4672a4p-4f},
        {0.0f, -0x1.df7f36p16f, 0.0f, -0x1.77973ap13f, 0.0f, -0x1.487e58p-1f, 0.0f, 0x1.7c2d5ap-2f},
        {-0x1.3078e0p8f, 0.0f, -0x1.98e122p4f, 0.0f, -0x1.a6f9e8p-16f, 0.0f, 0x1.19f4f2p-17f, 0.0f},
        {-0x1.381638p7f, 0.0f, 0x1.e409b6p5f, 0.0f, 0x1.48b95ap-15f, 0.0f, -0x1.cc3ceep-17f, 0.0f},
        {0.0f, -0x1.3078e0p8f, 0.0f, -0x1.98e122p4f, 0.0f, -0x1.a6f9e8p-16f, 0.0f, 0x1.19f4f2p-17f},
        {0.0f, -0x1.381638p7f, 0.0f, 0x1.e409b6p5f, 0.0f, 0x1.48b95ap-15f, 0.0f, -0x1.cc3ceep-17f},
        {0x1.2b40b6p5f, 0.0f, -0x1.54b17ap4f, 0.0f, 0x1.2e7448p-20f, 0.0f, -0x1.9c0b8ap-22f, 0.0f},
        {0x1.595152p6f, 0.0f, -0x1.9170e0p5f, 0.0f, 0x1.681810p-16f, 0.0f, -0x1.f5c602p-18f, 0.0f},
        {0.0f, 0x1.2b40b6p5f, 0.0f, -0x1.54b17ap4f, 0.0f, 0x1.2e7448p-20f, 0.0f, -0x1.9c0b8ap-22f},
        {0.0f, 0x1.595152p6f, 0.0f, -0x1.9170e0p5f, 0.0f, 0x1.681810p-16f, 0.0f, -0x1.f5c602p-18f},
        {-0x1.1aaec8p8f, 0.0f, -0x1.fa9cfep7f, 0.0f, 0x1.b9c074p-15f, 0.0f, -0x1.310f22p-16f, 0.0f},
        {-0x1.457ef0p9f, 0.0f, -0x1.3a563ap1f, 0.0f, -0x1.a031dcp-13f, 0.0f, 0x1.21f01ep-14f, 0.0f},
        {0.0f, -0x1.1aaec8p8f, 0.0f, -0x1.fa9cfep7f, 0.0f, 0x1.b9c074p-15f, 0.0f, -0x1.310f22p-16f},
        {0.0f, -0x1.457ef0p9f, 0.0f, -0x1.3a563ap1f, 0.0f, -0x1.a031dcp-13f, 0.0f, 0x1.21f01ep-14f},
        {-0x1.54d2eep7f, 0.0f, 0x1.b67b36p7f, 0.0f, 0x1.a5ab32p-17f, 0.0f, -0x1.26b758p-18f, 0.0f},
        {0x1.6a0136p5f, 0.0f, 0x1.2ba612p6f, 0.0f, -0x1.5bb58cp-16f, 0.0f, 0x1.e3be66p-18f, 0.0f},
        {0.0f, -0x1.54d2eep7f, 0.0f, 0x1.b67b36p7f, 0.0f, 0x1.a5ab32p-17f, 0.0f, -0x1.26b758p-18f},
        {0.0f, 0x1.6a0136p5f, 0.0f, 0x1.2ba612p6f, 0.0f, -0x1.5bb58cp-16f, 0.0f, 0x1.e3be66p-18f},
        {-0x1.09b2bep7f, 0.0f, -0x1.aeb5ccp8f, 0.0f, -0x1.d2296ap-19f, 0.0f, 0x1.69e666p-20f, 0.0f},
        {-0x1.2f1496p7f, 0.0f, 0x1.1b76fep9f, 0.0f, 0x1.e6f8ecp-14f, 0.0f, -0x1.51d1fcp-15f, 0.0f},
        {0.0f, -0x1.09b2bep7f, 0.0f, -0x1.aeb5ccp8f, 0.0f, -0x1.d2296ap-19f, 0.0f, 0x1.69e666p-20f},
        {0.0f, -0x1.2f1496p7f, 0.0f, 0x1.1b76fep9f, 0.0f, 0x1.e6f8ecp-14f, 0.0f, -0x1.51d1fcp-15f},
        {0x1.a6acbep8f, 0.0f, 0x1.d6caf8p2f, 0.0f, -0x1.7efd90p-10f, 0.0f, 0x1.0b86acp-11f, 0.0f},
        {0x1.766dbcp9f, 0.0f, 0x1.da3a26p7f, 0.0f, 0x1.1428f2p-16f, 0.0f, -0x1.921540p-18f, 0.0f},
        {0.0f, 0x1.a6acbep8f, 0.0f, 0x1.d6caf8p2f, 0.0f, -0x1.7efd90p-10f, 0.0f, 0x1.0b86acp-11f},
        {0.0f, 0x1.766dbcp9f, 0.0f, 0x1.da3a26p7f, 0.0f, 0x1.1428f2p-16f, 0.0f, -0x1.921540p-18f},
        {0x1.064782p4f, 0.0f, 0x1.5e3408p6f, 0.0f, 0x1.83c496p-16f, 0.0f, -0x1.12698cp-17f, 0.0f},
        {-0x1.e52966p5f, 0.0f, -0x1.3c88f0p8f, 0.0f, -0x1.f55d8ep-18f, 0.0f, 0x1.498f20p-19f, -0.0f},
        {0.0f, 0x1.064782p4f, 0.0f, 0x1.5e3408p6f, 0.0f, 0x1.83c496p-16f, 0.0f, -0x1.12698cp-17f},
        {0.0f, -0x1.e52966p5f, 0.0f, -0x1.3c88f0p8f, 0.0f, -0x1.f55d8ep-18f, 0.0f, 0x1.498f20p-19f},
        {-0x1.5cbe28p9f, 0.0f, 0x1.a65edep8f, 0.0f, 0x1.be3496p-12f, 0.0f, -0x1.37616ap-13f, 0.0f},
        {-0x1.8b006ap8f, 0.0f, 0x1.1c1abep10f, 0.0f, 0x1.5a0052p-10f, 0.0f, -0x1.e20260p-12f, 0.0f},
        {0.0f, -0x1.5cbe28p9f, 0.0f, 0x1.a65edep8f, 0.0f, 0x1.be3496p-12f, 0.0f, -0x1.37616ap-13f},
        {0.0f, -0x1.8b006ap8f, 0.0f, 0x1.1c1abep10f, 0.0f, 0x1.5a0052p-10f, 0.0f, -0x1.e20260p-12f},
        {0x1.1b13b0p0f, 0.0f, -0x1.1273c0p1f, -0.0f, -0x1.67c93cp-19f, -0.0f, 0x1.f3243cp-21f, 0.0f},
        {0.0f, 0x1.1b13b0p0f, 0.0f, -0x1.1273c0p1f, 0.0f, -0x1.67c93cp-19f, 0.0f, 0x1.f3243cp-21f},
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
/* Over the test vectors Q31 stays within 6.112e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 188397 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 175672 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73383840 * (int64_t)v; u2 += 46947034 * (int64_t)v;
        v = x[5]; u0 += 6721390 * (int64_t)v; u2 += -66700156 * (int64_t)v;
        v = x[8]; u0 += 183479215 * (int64_t)v; u2 += -321375427 * (int64_t)v;
        v = x[9]; u0 += -123021662 * (int64_t)v; u2 += 120411395 * (int64_t)v;
        v = x[12]; u0 += -308327868 * (int64_t)v; u2 += -48281583 * (int64_t)v;
        v = x[13]; u0 += -79307424 * (int64_t)v; u2 += 93516005 * (int64_t)v;
        v = x[16]; u0 += -693091711 * (int64_t)v; u2 += 199085529 * (int64_t)v;
        v = x[17]; u0 += 10473744 * (int64_t)v; u2 += -160837551 * (int64_t)v;
        v = x[20]; u0 += 155683382 * (int64_t)v; u2 += -61719160 * (int64_t)v;
        v = x[21]; u0 += 13198785 * (int64_t)v; u2 += -42969062 * (int64_t)v;
        v = x[24]; u0 += -28759167 * (int64_t)v; u2 += -8397400 * (int64_t)v;
        v = x[25]; u0 += 55951241 * (int64_t)v; u2 += -2573801 * (int64_t)v;
        v = x[28]; u0 += -81199145 * (int64_t)v; u2 += -10823964 * (int64_t)v;
        v = x[29]; u0 += -28888013 * (int64_t)v; u2 += 18680633 * (int64_t)v;
        v = x[32]; u0 += 25922228 * (int64_t)v; u2 += -5090879 * (int64_t)v;
        v = x[33]; u0 += 78818657 * (int64_t)v; u2 += -14870916 * (int64_t)v;
        v = x[36]; u0 += -5078650 * (int64_t)v; u2 += 4025221 * (int64_t)v;
        v = y0; u0 += -47290407 * (int64_t)v; u2 += 20820815 * (int64_t)v;
        v = y2; u0 += 2765188 * (int64_t)v; u2 += -5520642 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 188397 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 175672 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73383840 * (int64_t)v; u3 += 46947034 * (int64_t)v;
        v = x[7]; u1 += 6721390 * (int64_t)v; u3 += -66700156 * (int64_t)v;
        v = x[10]; u1 += 183479215 * (int64_t)v; u3 += -321375427 * (int64_t)v;
        v = x[11]; u1 += -123021662 * (int64_t)v; u3 += 120411395 * (int64_t)v;
        v = x[14]; u1 += -308327868 * (int64_t)v; u3 += -48281583 * (int64_t)v;
        v = x[15]; u1 += -79307424 * (int64_t)v; u3 += 93516005 * (int64_t)v;
        v = x[18]; u1 += -693091711 * (int64_t)v; u3 += 199085529 * (int64_t)v;
        v = x[19]; u1 += 10473744 * (int64_t)v; u3 += -160837551 * (int64_t)v;
        v = x[22]; u1 += 155683382 * (int64_t)v; u3 += -61719160 * (int64_t)v;
        v = x[23]; u1 += 13198785 * (int64_t)v; u3 += -42969062 * (int64_t)v;
        v = x[26]; u1 += -28759167 * (int64_t)v; u3 += -8397400 * (int64_t)v;
        v = x[27]; u1 += 55951241 * (int64_t)v; u3 += -2573801 * (int64_t)v;
        v = x[30]; u1 += -81199145 * (int64_t)v; u3 += -10823964 * (int64_t)v;
        v = x[31]; u1 += -28888013 * (int64_t)v; u3 += 18680633 * (int64_t)v;
        v = x[34]; u1 += 25922228 * (int64_t)v; u3 += -5090879 * (int64_t)v;
        v = x[35]; u1 += 78818657 * (int64_t)v; u3 += -14870916 * (int64_t)v;
        v = x[37]; u1 += -5078650 * (int64_t)v; u3 += 4025221 * (int64_t)v;
        v = y1; u1 += -47290407 * (int64_t)v; u3 += 20820815 * (int64_t)v;
        v = y3; u1 += 2765188 * (int64_t)v; u3 += -5520642 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1670188 * (int64_t)x0 + 66509911 * (int64_t)y0 - 29085713 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2293092 * (int64_t)x1 - 96749759 * (int64_t)y0 - 121285309 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1670188 * (int64_t)x2 + 66509911 * (int64_t)y1 - 29085713 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2293092 * (int64_t)x3 - 96749759 * (int64_t)y1 - 121285309 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-84658882 * (int64_t)x4 + 662757027 * (int64_t)x5 + 20859155 * (int64_t)y0 - 10664175 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165689257 * (int64_t)x4 - 84658882 * (int64_t)x5 - 16120392 * (int64_t)y0 + 290382 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-84658882 * (int64_t)x6 + 662757027 * (int64_t)x7 + 20859155 * (int64_t)y1 - 10664175 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165689257 * (int64_t)x6 - 84658882 * (int64_t)x7 - 16120392 * (int64_t)y1 + 290382 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149249805 * (int64_t)x8 + 504012063 * (int64_t)x9 - 9201649 * (int64_t)y0 + 5647657 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504012063 * (int64_t)x8 - 149249805 * (int64_t)x9 + 7907464 * (int64_t)y0 - 4643564 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149249805 * (int64_t)x10 + 504012063 * (int64_t)x11 - 9201649 * (int64_t)y1 + 5647657 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504012063 * (int64_t)x10 - 149249805 * (int64_t)x11 + 7907464 * (int64_t)y1 - 4643564 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763265818 * (int64_t)x12 + 540561203 * (int64_t)x13 + 62060336 * (int64_t)y0 - 20058725 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-540561203 * (int64_t)x12 + 763265818 * (int64_t)x13 - 88822650 * (int64_t)y0 - 34952481 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763265818 * (int64_t)x14 + 540561203 * (int64_t)x15 + 62060336 * (int64_t)y1 - 20058725 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-540561203 * (int64_t)x14 + 763265818 * (int64_t)x15 - 88822650 * (int64_t)y1 - 34952481 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611523445 * (int64_t)x16 + 791578811 * (int64_t)x17 - 30007503 * (int64_t)y0 + 10608410 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791578811 * (int64_t)x16 + 611523445 * (int64_t)x17 - 28962276 * (int64_t)y0 + 52889355 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611523445 * (int64_t)x18 + 791578811 * (int64_t)x19 - 30007503 * (int64_t)y1 + 10608410 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791578811 * (int64_t)x18 + 611523445 * (int64_t)x19 - 28962276 * (int64_t)y1 + 52889355 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(384151273 * (int64_t)x20 + 817287802 * (int64_t)x21 + 12148651 * (int64_t)y0 - 192794006 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817287802 * (int64_t)x20 + 384151273 * (int64_t)x21 - 57304025 * (int64_t)y0 + 9445353 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(384151273 * (int64_t)x22 + 817287802 * (int64_t)x23 + 12148651 * (int64_t)y1 - 192794006 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817287802 * (int64_t)x22 + 384151273 * (int64_t)x23 - 57304025 * (int64_t)y1 + 9445353 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(366163102 * (int64_t)x24 + 1396440997 * (int64_t)x25 + 31664643 * (int64_t)y0 - 75346830 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-698220499 * (int64_t)x24 + 183081551 * (int64_t)x25 + 285050059 * (int64_t)y0 + 57333649 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(366163102 * (int64_t)x26 + 1396440997 * (int64_t)x27 + 31664643 * (int64_t)y1 - 75346830 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-698220499 * (int64_t)x26 + 183081551 * (int64_t)x27 + 285050059 * (int64_t)y1 + 57333649 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128798357 * (int64_t)x28 + 959062096 * (int64_t)x29 + 17525491 * (int64_t)y0 + 98013935 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-959062096 * (int64_t)x28 + 128798357 * (int64_t)x29 - 11122821 * (int64_t)y0 - 54453581 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128798357 * (int64_t)x30 + 959062096 * (int64_t)x31 + 17525491 * (int64_t)y1 + 98013935 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-959062096 * (int64_t)x30 + 128798357 * (int64_t)x31 - 11122821 * (int64_t)y1 - 54453581 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-270133078 * (int64_t)x32 + 733663839 * (int64_t)x33 - 148293900 * (int64_t)y0 - 66034489 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-183415960 * (int64_t)x32 - 270133078 * (int64_t)x33 - 242528281 * (int64_t)y0 + 401922674 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-270133078 * (int64_t)x34 + 733663839 * (int64_t)x35 - 148293900 * (int64_t)y1 - 66034489 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-183415960 * (int64_t)x34 - 270133078 * (int64_t)x35 - 242528281 * (int64_t)y1 + 401922674 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142248297 * (int64_t)x36 + 1675643 * (int64_t)y0 - 2284626 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142248297 * (int64_t)x37 + 1675643 * (int64_t)y1 - 2284626 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 607087432 * (int64_t)e[0] + 512930878 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1158784535 * (int64_t)e[0] - 936321905 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 607087432 * (int64_t)e[1] + 512930878 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1158784535 * (int64_t)e[1] - 936321905 * (int64_t)e[3], 19);
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
        {871337596, 0, 328021546, 0, 76712889, 0, -8022782, 0},
        {-1046187188, 0, -102435019, 0, -64584458, 0, 37372935, 0},
        {0, 871337596, 0, 328021546, 0, 76712889, 0, -8022782},
        {0, -1046187188, 0, -102435019, 0, -64584458, 0, 37372935},
        {-1328621123, 0, -111513855, 0, -1299383, 0, 433086, 0},
        {-1361848971, 0, 528047482, 0, 4039361, 0, -1413851, 0},
        {0, -1328621123, 0, -111513855, 0, -1299383, 0, 433086},
        {0, -1361848971, 0, 528047482, 0, 4039361, 0, -1413851},
        {1305845373, 0, -743339381, 0, 464570, 0, -158225, 0},
        {753429057, 0, -437940596, 0, 2212418, 0, -770724, 0},
        {0, 1305845373, 0, -743339381, 0, 464570, 0, -158225},
        {0, 753429057, 0, -437940596, 0, 2212418, 0, -770724},
        {-616769465, 0, -552675375, 0, 1357061, 0, -468571, 0},
        {-1420361910, 0, -5358076, 0, -5114201, 0, 1781379, 0},
        {0, -616769465, 0, -552675375, 0, 1357061, 0, -468571},
        {0, -1420361910, 0, -5358076, 0, -5114201, 0, 1781379},
        {-743624494, 0, 956697508, 0, 647683, 0, -226342, 0},
        {789837633, 0, 1307573099, 0, -4272650, 0, 1486061, 0},
        {0, -743624494, 0, 956697508, 0, 647683, 0, -226342},
        {0, 789837633, 0, 1307573099, 0, -4272650, 0, 1486061},
        {-289855956, 0, -939742112, 0, -89503, 0, 34742, 0},
        {-330636993, 0, 1236951633, 0, 2991958, 0, -1037784, 0},
        {0, -289855956, 0, -939742112, 0, -89503, 0, 34742},
        {0, -330636993, 0, 1236951633, 0, 2991958, 0, -1037784},
        {1844420296, 0, 32099883, 0, -75298995, 0, 26298882, 0},
        {816944662, 0, 258672335, 0, 212091, 0, -77200, 0},
        {0, 1844420296, 0, 32099883, 0, -75298995, 0, 26298882},
        {0, 816944662, 0, 258672335, 0, 212091, 0, -77200},
        {286126221, 0, 1528177335, 0, 4764892, 0, -1685989, 0},
        {-264636712, 0, -1381259242, 0, -385049, 0, 126551, 0},
        {0, 286126221, 0, 1528177335, 0, 4764892, 0, -1685989},
        {0, -264636712, 0, -1381259242, 0, -385049, 0, 126551},
        {-760902140, 0, 460773218, 0, 5482972, 0, -1913122, 0},
        {-430915833, 0, 1239742869, 0, 17006653, 0, -5922930, 0},
        {0, -760902140, 0, 460773218, 0, 5482972, 0, -1913122},
        {0, -430915833, 0, 1239742869, 0, 17006653, 0, -5922930},
        {617629503, 0, -1197623270, 0, -17684205, 0, 6133451, 0},
        {0, 617629503, 0, -1197623270, 0, -17684205, 0, 6133451},
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
