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
static const float paper_tool_f32_output_guard = 0x1.691d1ap23f;

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
        float u0 = 0x1.5c92b2p6f * v, u2 = 0x1.26671ep8f * v;
        v = x[1]; u0 += 0x1.800000p1f * v; u2 += -0x1.f03b22p0f * v;
        v = x[4]; u0 += 0x1.ebc472p8f * v; u2 += 0x1.3651aep8f * v;
        v = x[5]; u0 += -0x1.098cdcp9f * v; u2 += -0x1.09b0d0p10f * v;
        v = x[8]; u0 += 0x1.8bde86p8f * v; u2 += -0x1.9b1ab6p10f * v;
        v = x[9]; u0 += -0x1.98e62ap9f * v; u2 += 0x1.e4479ep9f * v;
        v = x[12]; u0 += 0x1.32e456p10f * v; u2 += -0x1.faaf94p4f * v;
        v = x[13]; u0 += -0x1.24977ap9f * v; u2 += -0x1.d21916p9f * v;
        v = x[16]; u0 += -0x1.08fc92p11f * v; u2 += 0x1.0cc096p8f * v;
        v = x[17]; u0 += 0x1.be3a72p10f * v; u2 += -0x1.aed9d6p11f * v;
        v = x[20]; u0 += 0x1.e23df2p7f * v; u2 += -0x1.bd4048p8f * v;
        v = x[21]; u0 += -0x1.d847f4p8f * v; u2 += 0x1.70c43ep9f * v;
        v = x[24]; u0 += 0x1.a59d08p9f * v; u2 += -0x1.af247ep7f * v;
        v = x[25]; u0 += -0x1.4fc338p6f * v; u2 += -0x1.b9a3c6p8f * v;
        v = x[28]; u0 += 0x1.bacb58p3f * v; u2 += -0x1.f066d8p5f * v;
        v = x[29]; u0 += 0x1.3b16fcp8f * v; u2 += -0x1.416c9ep8f * v;
        v = x[32]; u0 += -0x1.ed53b6p4f * v; u2 += 0x1.75294cp5f * v;
        v = x[33]; u0 += 0x1.c5db86p5f * v; u2 += 0x1.de5800p3f * v;
        v = y0; u0 += -0x1.9c0f3ap19f * v; u2 += 0x1.90a928p19f * v;
        v = y2; u0 += 0x1.3da0b4p17f * v; u2 += -0x1.81bf10p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.5c92b2p6f * v, u3 = 0x1.26671ep8f * v;
        v = x[3]; u1 += 0x1.800000p1f * v; u3 += -0x1.f03b22p0f * v;
        v = x[6]; u1 += 0x1.ebc472p8f * v; u3 += 0x1.3651aep8f * v;
        v = x[7]; u1 += -0x1.098cdcp9f * v; u3 += -0x1.09b0d0p10f * v;
        v = x[10]; u1 += 0x1.8bde86p8f * v; u3 += -0x1.9b1ab6p10f * v;
        v = x[11]; u1 += -0x1.98e62ap9f * v; u3 += 0x1.e4479ep9f * v;
        v = x[14]; u1 += 0x1.32e456p10f * v; u3 += -0x1.faaf94p4f * v;
        v = x[15]; u1 += -0x1.24977ap9f * v; u3 += -0x1.d21916p9f * v;
        v = x[18]; u1 += -0x1.08fc92p11f * v; u3 += 0x1.0cc096p8f * v;
        v = x[19]; u1 += 0x1.be3a72p10f * v; u3 += -0x1.aed9d6p11f * v;
        v = x[22]; u1 += 0x1.e23df2p7f * v; u3 += -0x1.bd4048p8f * v;
        v = x[23]; u1 += -0x1.d847f4p8f * v; u3 += 0x1.70c43ep9f * v;
        v = x[26]; u1 += 0x1.a59d08p9f * v; u3 += -0x1.af247ep7f * v;
        v = x[27]; u1 += -0x1.4fc338p6f * v; u3 += -0x1.b9a3c6p8f * v;
        v = x[30]; u1 += 0x1.bacb58p3f * v; u3 += -0x1.f066d8p5f * v;
        v = x[31]; u1 += 0x1.3b16fcp8f * v; u3 += -0x1.416c9ep8f * v;
        v = x[34]; u1 += -0x1.ed53b6p4f * v; u3 += 0x1.75294cp5f * v;
        v = x[35]; u1 += 0x1.c5db86p5f * v; u3 += 0x1.de5800p3f * v;
        v = y1; u1 += -0x1.9c0f3ap19f * v; u3 += 0x1.90a928p19f * v;
        v = y3; u1 += 0x1.3da0b4p17f * v; u3 += -0x1.81bf10p18f * v;
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
        for (i = 0; i < 36; ++i) {
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
    for (i = 0; i < 36; ++i) {
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
        x[0] = -0x1.aea9cep-9f * x0 - 0x1.3b07dep0f * y0 - 0x1.cd4c0ep2f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.a48092p-10f * x1 - 0x1.369596p6f * y0 - 0x1.c71dcep6f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.aea9cep-9f * x2 - 0x1.3b07dep0f * y1 - 0x1.cd4c0ep2f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.a48092p-10f * x3 - 0x1.369596p6f * y1 - 0x1.c71dcep6f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.20aa74p-4f * x4 + 0x1.3d858cp-2f * x5 + 0x1.065062p3f * y0 - 0x1.9cae48p3f * y2
            + x4;
        x[5] = -0x1.3d858cp-2f * x4 - 0x1.20aa74p-4f * x5 - 0x1.ded0b0p5f * y0 + 0x1.c320a6p3f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.20aa74p-4f * x6 + 0x1.3d858cp-2f * x7 + 0x1.065062p3f * y1 - 0x1.9cae48p3f * y3
            + x6;
        x[7] = -0x1.3d858cp-2f * x6 - 0x1.20aa74p-4f * x7 - 0x1.ded0b0p5f * y1 + 0x1.c320a6p3f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.27f686p-3f * x8 + 0x1.dab2aap-2f * x9 - 0x1.da8660p5f * y0 + 0x1.1b7b96p4f * y2
            + x8;
        x[9] = -0x1.dab2aap-2f * x8 - 0x1.27f686p-3f * x9 + 0x1.ed7f24p5f * y0 - 0x1.b1d422p5f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.27f686p-3f * x10 + 0x1.dab2aap-2f * x11 - 0x1.da8660p5f * y1 + 0x1.1b7b96p4f * y3
            + x10;
        x[11] = -0x1.dab2aap-2f * x10 - 0x1.27f686p-3f * x11 + 0x1.ed7f24p5f * y1 - 0x1.b1d422p5f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.7e82ccp-1f * x12 + 0x1.f5855cp-2f * x13 - 0x1.5a62d2p5f * y0 + 0x1.027df2p6f * y2;
        x[13] = -0x1.f5855cp-2f * x12 + 0x1.7e82ccp-1f * x13 + 0x1.5af820p8f * y0 + 0x1.118826p6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.7e82ccp-1f * x14 + 0x1.f5855cp-2f * x15 - 0x1.5a62d2p5f * y1 + 0x1.027df2p6f * y3;
        x[15] = -0x1.f5855cp-2f * x14 + 0x1.7e82ccp-1f * x15 + 0x1.5af820p8f * y1 + 0x1.118826p6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.2b7250p-1f * x16 + 0x1.799f4ep-1f * x17 - 0x1.eb476cp6f * y0 + 0x1.21f6d8p7f * y2;
        x[17] = -0x1.799f4ep-1f * x16 + 0x1.2b7250p-1f * x17 - 0x1.975304p3f * y0 + 0x1.c59d18p6f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.2b7250p-1f * x18 + 0x1.799f4ep-1f * x19 - 0x1.eb476cp6f * y1 + 0x1.21f6d8p7f * y3;
        x[19] = -0x1.799f4ep-1f * x18 + 0x1.2b7250p-1f * x19 - 0x1.975304p3f * y1 + 0x1.c59d18p6f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.5d9644p-2f * x20 + 0x1.85f248p-1f * x21 + 0x1.5ec5f2p6f * y0 - 0x1.926020p7f * y2;
        x[21] = -0x1.85f248p-1f * x20 + 0x1.5d9644p-2f * x21 - 0x1.26c982p5f * y0 + 0x1.8fbc66p9f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.5d9644p-2f * x22 + 0x1.85f248p-1f * x23 + 0x1.5ec5f2p6f * y1 - 0x1.926020p7f * y3;
        x[23] = -0x1.85f248p-1f * x22 + 0x1.5d9644p-2f * x23 - 0x1.26c982p5f * y1 + 0x1.8fbc66p9f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.c84096p-4f * x24 + 0x1.da8570p-1f * x25 + 0x1.12da8ap4f * y0 - 0x1.bc5f0cp6f * y2;
        x[25] = -0x1.da8570p-1f * x24 + 0x1.c84096p-4f * x25 + 0x1.d5370cp5f * y0 + 0x1.0f9bf8p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.c84096p-4f * x26 + 0x1.da8570p-1f * x27 + 0x1.12da8ap4f * y1 - 0x1.bc5f0cp6f * y3;
        x[27] = -0x1.da8570p-1f * x26 + 0x1.c84096p-4f * x27 + 0x1.d5370cp5f * y1 + 0x1.0f9bf8p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = -0x1.55266cp-3f * x28 + 0x1.5225d4p-1f * x29 - 0x1.490bc6p8f * y0 - 0x1.15dadcp9f * y2;
        x[29] = -0x1.5225d4p-3f * x28 - 0x1.55266cp-3f * x29 - 0x1.8711ecp8f * y0 + 0x1.4d1e00p10f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = -0x1.55266cp-3f * x30 + 0x1.5225d4p-1f * x31 - 0x1.490bc6p8f * y1 - 0x1.15dadcp9f * y3;
        x[31] = -0x1.5225d4p-3f * x30 - 0x1.55266cp-3f * x31 - 0x1.8711ecp8f * y1 + 0x1.4d1e00p10f * y3;
    }
    {
        const float x32 = x[32];
        x[32] = -0x1.feafcep-1f * x32 + 0x1.a78b7ep1f * y0 - 0x1.0b9f34p2f * y2;
    }
    {
        const float x33 = x[33];
        x[33] = -0x1.70221ep-2f * x33 + 0x1.5bb2a8p10f * y0 + 0x1.595f3cp8f * y2;
    }
    {
        const float x34 = x[34];
        x[34] = -0x1.feafcep-1f * x34 + 0x1.a78b7ep1f * y1 - 0x1.0b9f34p2f * y3;
    }
    {
        const float x35 = x[35];
        x[35] = -0x1.70221ep-2f * x35 + 0x1.5bb2a8p10f * y1 + 0x1.595f3cp8f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.aaa884p-14f * e[0];
        x[0] += 0x1.443a18p-13f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.083f98p-6f * e[0];
        x[1] += -0x1.42738ep-8f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.aaa884p-14f * e[1];
        x[2] += 0x1.443a18p-13f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.083f98p-6f * e[1];
        x[3] += -0x1.42738ep-8f * e[3];
        x[3] = paper_tool_f32_clamp(x[3], 1.0f);
    }
    x[1] = paper_tool_f32_clamp(x[1], 1.0f);
    x[3] = paper_tool_f32_clamp(x[3], 1.0f);

}

void paper_tool_f32_step(paper_tool_f32 *c, const float y_m[4], float u_a[4])
{
    paper_tool_f32_output(c, y_m, u_a);
    paper_tool_f32_update(c);
}

void paper_tool_f32_hand_over(paper_tool_f32 *c, const float y_m[4], const float u_a[4])
{
    static const float map[36][8] = {
        {-0x1.bb775ap5f, 0.0f, 0x1.4c9888p8f, 0.0f, 0x1.e4d28cp-10f, 0.0f, 0x1.777d80p-9f, 0.0f},
        {0x1.3ae2f4p15f, 0.0f, -0x1.ce507ep12f, 0.0f, 0x1.1e64e0p-2f, 0.0f, -0x1.54838ep-4f, 0.0f},
        {0.0f, -0x1.bb775ap5f, 0.0f, 0x1.4c9888p8f, 0.0f, 0x1.e4d28cp-10f, 0.0f, 0x1.777d80p-9f},
        {0.0f, 0x1.3ae2f4p15f, 0.0f, -0x1.ce507ep12f, 0.0f, 0x1.1e64e0p-2f, 0.0f, -0x1.54838ep-4f},
        {-0x1.63cf72p7f, 0.0f, 0x1.0bfb3cp5f, 0.0f, -0x1.f0df86p-22f, 0.0f, -0x1.d59df6p-21f, 0.0f},
        {-0x1.0b4e0ep6f, 0.0f, 0x1.8d32bep5f, 0.0f, 0x1.7801bep-23f, 0.0f, 0x1.626410p-22f, 0.0f},
        {0.0f, -0x1.63cf72p7f, 0.0f, 0x1.0bfb3cp5f, 0.0f, -0x1.f0df86p-22f, 0.0f, -0x1.d59df6p-21f},
        {0.0f, -0x1.0b4e0ep6f, 0.0f, 0x1.8d32bep5f, 0.0f, 0x1.7801bep-23f, 0.0f, 0x1.626410p-22f},
        {0x1.53a60cp6f, 0.0f, -0x1.7ed8aep6f, 0.0f, 0x1.80c3e0p-25f, 0.0f, 0x1.a2b0c4p-24f, 0.0f},
        {0x1.34d618p7f, 0.0f, -0x1.0fd284p6f, 0.0f, 0x1.850064p-24f, 0.0f, 0x1.86f8fcp-23f, 0.0f},
        {0.0f, 0x1.53a60cp6f, 0.0f, -0x1.7ed8aep6f, 0.0f, 0x1.80c3e0p-25f, 0.0f, 0x1.a2b0c4p-24f},
        {0.0f, 0x1.34d618p7f, 0.0f, -0x1.0fd284p6f, 0.0f, 0x1.850064p-24f, 0.0f, 0x1.86f8fcp-23f},
        {0x1.058eacp9f, 0.0f, 0x1.46a8ccp7f, 0.0f, -0x1.936c62p-22f, 0.0f, -0x1.6791c4p-21f, 0.0f},
        {0x1.66aa8cp8f, 0.0f, -0x1.732316p5f, 0.0f, 0x1.2c7cb0p-21f, 0.0f, 0x1.1f31eep-20f, 0.0f},
        {0.0f, 0x1.058eacp9f, 0.0f, 0x1.46a8ccp7f, 0.0f, -0x1.936c62p-22f, 0.0f, -0x1.6791c4p-21f},
        {0.0f, 0x1.66aa8cp8f, 0.0f, -0x1.732316p5f, 0.0f, 0x1.2c7cb0p-21f, 0.0f, 0x1.1f31eep-20f},
        {-0x1.512528p6f, 0.0f, 0x1.9179ccp7f, 0.0f, -0x1.399312p-25f, 0.0f, -0x1.37a620p-24f, 0.0f},
        {0x1.dc56b6p6f, 0.0f, -0x1.4e7656p6f, 0.0f, -0x1.7a70c8p-25f, 0.0f, -0x1.78819ap-24f, 0.0f},
        {0.0f, -0x1.512528p6f, 0.0f, 0x1.9179ccp7f, 0.0f, -0x1.399312p-25f, 0.0f, -0x1.37a620p-24f},
        {0.0f, 0x1.dc56b6p6f, 0.0f, -0x1.4e7656p6f, 0.0f, -0x1.7a70c8p-25f, 0.0f, -0x1.78819ap-24f},
        {0x1.d5043ep4f, 0.0f, 0x1.d7048ep8f, 0.0f, 0x1.9d213ap-21f, 0.0f, 0x1.941616p-20f, 0.0f},
        {-0x1.675812p6f, 0.0f, 0x1.4f5a04p9f, 0.0f, 0x1.57bf8cp-23f, 0.0f, 0x1.5b39d2p-22f, 0.0f},
        {0.0f, 0x1.d5043ep4f, 0.0f, 0x1.d7048ep8f, 0.0f, 0x1.9d213ap-21f, 0.0f, 0x1.941616p-20f},
        {0.0f, -0x1.675812p6f, 0.0f, 0x1.4f5a04p9f, 0.0f, 0x1.57bf8cp-23f, 0.0f, 0x1.5b39d2p-22f},
        {0x1.51bb0cp5f, 0.0f, 0x1.076284p4f, 0.0f, 0x1.3c8186p-27f, 0.0f, 0x1.c071f8p-26f, 0.0f},
        {0x1.5f4ea2p4f, 0.0f, 0x1.0f999cp7f, 0.0f, 0x1.b8aa6ap-24f, 0.0f, 0x1.b1ba82p-23f, 0.0f},
        {0.0f, 0x1.51bb0cp5f, 0.0f, 0x1.076284p4f, 0.0f, 0x1.3c8186p-27f, 0.0f, 0x1.c071f8p-26f},
        {0.0f, 0x1.5f4ea2p4f, 0.0f, 0x1.0f999cp7f, 0.0f, 0x1.b8aa6ap-24f, 0.0f, 0x1.b1ba82p-23f},
        {-0x1.b47a6ep8f, 0.0f, 0x1.377d42p7f, 0.0f, -0x1.b5d128p-20f, 0.0f, -0x1.c6a1e8p-19f, 0.0f},
        {-0x1.115616p8f, 0.0f, 0x1.198140p10f, 0.0f, 0x1.1db5ccp-18f, 0.0f, 0x1.18cd44p-17f, 0.0f},
        {0.0f, -0x1.b47a6ep8f, 0.0f, 0x1.377d42p7f, 0.0f, -0x1.b5d128p-20f, 0.0f, -0x1.c6a1e8p-19f},
        {0.0f, -0x1.115616p8f, 0.0f, 0x1.198140p10f, 0.0f, 0x1.1db5ccp-18f, 0.0f, 0x1.18cd44p-17f},
        {0x1.a83a8ap0f, 0.0f, -0x1.0e215ep1f, 0.0f, -0x1.b8e326p-27f, 0.0f, -0x1.a60ee6p-26f, 0.0f},
        {0x1.fe9ba6p9f, 0.0f, 0x1.e05a0ep7f, 0.0f, -0x1.182ddcp-17f, -0.0f, -0x1.0587acp-16f, -0.0f},
        {0.0f, 0x1.a83a8ap0f, 0.0f, -0x1.0e215ep1f, 0.0f, -0x1.b8e326p-27f, 0.0f, -0x1.a60ee6p-26f},
        {0.0f, 0x1.fe9ba6p9f, 0.0f, 0x1.e05a0ep7f, -0.0f, -0x1.182ddcp-17f, -0.0f, -0x1.0587acp-16f},
    };
    int i, j;
    paper_tool_f32_hold(c, y_m);
    for (i = 0; i < 36; ++i) {
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
/* Over the test vectors Q31 stays within 4.041e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
    for (i = 0; i < 36; ++i) {
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
        int64_t u0 = 15229389 * (int64_t)v, u2 = 51450620 * (int64_t)v;
        v = x[1]; u0 += 524288 * (int64_t)v; u2 += -338760 * (int64_t)v;
        v = x[4]; u0 += 85942577 * (int64_t)v; u2 += 54232187 * (int64_t)v;
        v = x[5]; u0 += -92816536 * (int64_t)v; u2 += -185731246 * (int64_t)v;
        v = x[8]; u0 += 69183164 * (int64_t)v; u2 += -287382766 * (int64_t)v;
        v = x[9]; u0 += -142920585 * (int64_t)v; u2 += 169268045 * (int64_t)v;
        v = x[12]; u0 += 214533017 * (int64_t)v; u2 += -5534361 * (int64_t)v;
        v = x[13]; u0 += -102268213 * (int64_t)v; u2 += -162913058 * (int64_t)v;
        v = x[16]; u0 += -370478120 * (int64_t)v; u2 += 46967869 * (int64_t)v;
        v = x[17]; u0 += 311936199 * (int64_t)v; u2 += -602373234 * (int64_t)v;
        v = x[20]; u0 += 42138946 * (int64_t)v; u2 += -77813272 * (int64_t)v;
        v = x[21]; u0 += -82537096 * (int64_t)v; u2 += 128893254 * (int64_t)v;
        v = x[24]; u0 += 147364566 * (int64_t)v; u2 += -37673812 * (int64_t)v;
        v = x[25]; u0 += -14669691 * (int64_t)v; u2 += -77182141 * (int64_t)v;
        v = x[28]; u0 += 2418247 * (int64_t)v; u2 += -10844061 * (int64_t)v;
        v = x[29]; u0 += 55065933 * (int64_t)v; u2 += -56172964 * (int64_t)v;
        v = x[32]; u0 += -5388446 * (int64_t)v; u2 += 8151833 * (int64_t)v;
        v = x[33]; u0 += 9914669 * (int64_t)v; u2 += 2612395 * (int64_t)v;
        v = y0; u0 += -37460385 * (int64_t)v; u2 += 36424127 * (int64_t)v;
        v = y2; u0 += 7218896 * (int64_t)v; u2 += -17534127 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 19);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 15229389 * (int64_t)v, u3 = 51450620 * (int64_t)v;
        v = x[3]; u1 += 524288 * (int64_t)v; u3 += -338760 * (int64_t)v;
        v = x[6]; u1 += 85942577 * (int64_t)v; u3 += 54232187 * (int64_t)v;
        v = x[7]; u1 += -92816536 * (int64_t)v; u3 += -185731246 * (int64_t)v;
        v = x[10]; u1 += 69183164 * (int64_t)v; u3 += -287382766 * (int64_t)v;
        v = x[11]; u1 += -142920585 * (int64_t)v; u3 += 169268045 * (int64_t)v;
        v = x[14]; u1 += 214533017 * (int64_t)v; u3 += -5534361 * (int64_t)v;
        v = x[15]; u1 += -102268213 * (int64_t)v; u3 += -162913058 * (int64_t)v;
        v = x[18]; u1 += -370478120 * (int64_t)v; u3 += 46967869 * (int64_t)v;
        v = x[19]; u1 += 311936199 * (int64_t)v; u3 += -602373234 * (int64_t)v;
        v = x[22]; u1 += 42138946 * (int64_t)v; u3 += -77813272 * (int64_t)v;
        v = x[23]; u1 += -82537096 * (int64_t)v; u3 += 128893254 * (int64_t)v;
        v = x[26]; u1 += 147364566 * (int64_t)v; u3 += -37673812 * (int64_t)v;
        v = x[27]; u1 += -14669691 * (int64_t)v; u3 += -77182141 * (int64_t)v;
        v = x[30]; u1 += 2418247 * (int64_t)v; u3 += -10844061 * (int64_t)v;
        v = x[31]; u1 += 55065933 * (int64_t)v; u3 += -56172964 * (int64_t)v;
        v = x[34]; u1 += -5388446 * (int64_t)v; u3 += 8151833 * (int64_t)v;
        v = x[35]; u1 += 9914669 * (int64_t)v; u3 += 2612395 * (int64_t)v;
        v = y1; u1 += -37460385 * (int64_t)v; u3 += 36424127 * (int64_t)v;
        v = y3; u1 += 7218896 * (int64_t)v; u3 += -17534127 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-3527994 * (int64_t)x0 - 335619 * (int64_t)y0 - 1965777 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-1722377 * (int64_t)x1 - 21176449 * (int64_t)y0 - 31031024 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-3527994 * (int64_t)x2 - 335619 * (int64_t)y1 - 1965777 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-1722377 * (int64_t)x3 - 21176449 * (int64_t)y1 - 31031024 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-75672019 * (int64_t)x4 + 332945592 * (int64_t)x5 + 2235656 * (int64_t)y0 - 3517206 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-332945592 * (int64_t)x4 - 75672019 * (int64_t)x5 - 16323433 * (int64_t)y0 + 3844881 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-75672019 * (int64_t)x6 + 332945592 * (int64_t)x7 + 2235656 * (int64_t)y1 - 3517206 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-332945592 * (int64_t)x6 - 75672019 * (int64_t)x7 - 16323433 * (int64_t)y1 + 3844881 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-155169840 * (int64_t)x8 + 497756836 * (int64_t)x9 - 16177173 * (int64_t)y0 + 4832148 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-497756836 * (int64_t)x8 - 155169840 * (int64_t)x9 + 16823943 * (int64_t)y0 - 14789784 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-155169840 * (int64_t)x10 + 497756836 * (int64_t)x11 - 16177173 * (int64_t)y1 + 4832148 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-497756836 * (int64_t)x10 - 155169840 * (int64_t)x11 + 16823943 * (int64_t)y1 - 14789784 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(802183577 * (int64_t)x12 + 525882818 * (int64_t)x13 - 11808750 * (int64_t)y0 + 17624657 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-525882818 * (int64_t)x12 + 802183577 * (int64_t)x13 + 94629071 * (int64_t)y0 + 18650114 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(802183577 * (int64_t)x14 + 525882818 * (int64_t)x15 - 11808750 * (int64_t)y1 + 17624657 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-525882818 * (int64_t)x14 + 802183577 * (int64_t)x15 + 94629071 * (int64_t)y1 + 18650114 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(627984893 * (int64_t)x16 + 791931305 * (int64_t)x17 - 33496682 * (int64_t)y0 + 39541035 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791931305 * (int64_t)x16 + 627984893 * (int64_t)x17 - 3471554 * (int64_t)y0 + 30928561 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(627984893 * (int64_t)x18 + 791931305 * (int64_t)x19 - 33496682 * (int64_t)y1 + 39541035 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791931305 * (int64_t)x18 + 627984893 * (int64_t)x19 - 3471554 * (int64_t)y1 + 30928561 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(366568502 * (int64_t)x20 + 817776898 * (int64_t)x21 + 23916632 * (int64_t)y0 - 54870017 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817776898 * (int64_t)x20 + 366568502 * (int64_t)x21 - 10049678 * (int64_t)y0 + 218040306 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(366568502 * (int64_t)x22 + 817776898 * (int64_t)x23 + 23916632 * (int64_t)y1 - 54870017 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817776898 * (int64_t)x22 + 366568502 * (int64_t)x23 - 10049678 * (int64_t)y1 + 218040306 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(119603804 * (int64_t)x24 + 995143146 * (int64_t)x25 + 4685060 * (int64_t)y0 - 30298392 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-995143146 * (int64_t)x24 + 119603804 * (int64_t)x25 + 15996152 * (int64_t)y0 + 37038053 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(119603804 * (int64_t)x26 + 995143146 * (int64_t)x27 + 4685060 * (int64_t)y1 - 30298392 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-995143146 * (int64_t)x26 + 119603804 * (int64_t)x27 + 15996152 * (int64_t)y1 + 37038053 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(-178860899 * (int64_t)x28 + 709147247 * (int64_t)x29 - 89740849 * (int64_t)y0 - 151558982 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-354573624 * (int64_t)x28 - 357721797 * (int64_t)x29 - 213313385 * (int64_t)y0 + 726809515 * (int64_t)y2, 31);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(-178860899 * (int64_t)x30 + 709147247 * (int64_t)x31 - 89740849 * (int64_t)y1 - 151558982 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-354573624 * (int64_t)x30 - 357721797 * (int64_t)x31 - 213313385 * (int64_t)y1 + 726809515 * (int64_t)y3, 31);
    }
    {
        const int32_t x32 = x[32];
        x[32] = paper_tool_q31_round(-2141975459 * (int64_t)x32 + 1804900 * (int64_t)y0 - 2280895 * (int64_t)y2, 31);
    }
    {
        const int32_t x33 = x[33];
        x[33] = paper_tool_q31_round(-772031400 * (int64_t)x33 + 758622307 * (int64_t)y0 + 188386912 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        x[34] = paper_tool_q31_round(-2141975459 * (int64_t)x34 + 1804900 * (int64_t)y1 - 2280895 * (int64_t)y3, 31);
    }
    {
        const int32_t x35 = x[35];
        x[35] = paper_tool_q31_round(-772031400 * (int64_t)x35 + 758622307 * (int64_t)y1 + 188386912 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 671075411 * (int64_t)e[0] + 1019929725 * (int64_t)e[2], 29);
        x[1] = paper_tool_q31_correct(x[1], 831253644 * (int64_t)e[0] - 253586076 * (int64_t)e[2], 22);
        x[2] = paper_tool_q31_correct(x[2], 671075411 * (int64_t)e[1] + 1019929725 * (int64_t)e[3], 29);
        x[3] = paper_tool_q31_correct(x[3], 831253644 * (int64_t)e[1] - 253586076 * (int64_t)e[3], 22);
    }
}

void paper_tool_q31_step(paper_tool_q31 *c, const int32_t y[4], int32_t u[4])
{
    paper_tool_q31_output(c, y, u);
    paper_tool_q31_update(c);
}

void paper_tool_q31_hand_over(paper_tool_q31 *c, const int32_t y[4], const int32_t u[4])
{
    static const int32_t map[36][8] = {
        {-241893452, 0, 1451343947, 0, 95319974, 0, 147648771, 0},
        {1374066154, 0, -252174413, 0, 112614717, 0, -33473878, 0},
        {0, -241893452, 0, 1451343947, 0, 95319974, 0, 147648771},
        {0, 1374066154, 0, -252174413, 0, 112614717, 0, -33473878},
        {-1552644785, 0, 292346710, 0, -47700, 0, -90166, 0},
        {-1166434797, 0, 866624311, 0, 36097, 0, 68043, 0},
        {0, -1552644785, 0, 292346710, 0, -47700, 0, -90166},
        {0, -1166434797, 0, 866624311, 0, 36097, 0, 68043},
        {741060075, 0, -835310872, 0, 4617, 0, 10049, 0},
        {1347664874, 0, -593073739, 0, 9336, 0, 18767, 0},
        {0, 741060075, 0, -835310872, 0, 4617, 0, 10049},
        {0, 1347664874, 0, -593073739, 0, 9336, 0, 18767},
        {1141354227, 0, 356359793, 0, -9682, 0, -17259, 0},
        {1565106903, 0, -202440730, 0, 28847, 0, 55141, 0},
        {0, 1141354227, 0, 356359793, 0, -9682, 0, -17259},
        {0, 1565106903, 0, -202440730, 0, 28847, 0, 55141},
        {-367798959, 0, 875957245, 0, -1881, 0, -3740, 0},
        {1039296488, 0, -729744270, 0, -4541, 0, -9036, 0},
        {0, -367798959, 0, 875957245, 0, -1881, 0, -3740},
        {0, 1039296488, 0, -729744270, 0, -4541, 0, -9036},
        {63957542, 0, 1027687043, 0, 19830, 0, 38792, 0},
        {-196008095, 0, 1463369441, 0, 4125, 0, 8333, 0},
        {0, 63957542, 0, 1027687043, 0, 19830, 0, 38792},
        {0, -196008095, 0, 1463369441, 0, 4125, 0, 8333},
        {1473750794, 0, 574664434, 0, 3798, 0, 10763, 0},
        {191624306, 0, 1185177470, 0, 10576, 0, 20819, 0},
        {0, 1473750794, 0, 574664434, 0, 3798, 0, 10763},
        {0, 191624306, 0, 1185177470, 0, 10576, 0, 20819},
        {-952327144, 0, 339810406, 0, -42030, 0, -87289, 0},
        {-298188480, 0, 1228399140, 0, 54856, 0, 107828, 0},
        {0, -952327144, 0, 339810406, 0, -42030, 0, -87289},
        {0, -298188480, 0, 1228399140, 0, 54856, 0, 107828},
        {925600532, 0, -1178764180, 0, -84650, 0, -162070, 0},
        {1114066713, 0, 262013085, 0, -107589, 0, -200855, 0},
        {0, 925600532, 0, -1178764180, 0, -84650, 0, -162070},
        {0, 1114066713, 0, 262013085, 0, -107589, 0, -200855},
    };
    static const int16_t shift[36] = {
        34, 27, 34, 27, 35, 36, 35, 36, 35, 35, 35, 35, 33, 34, 33, 34, 34, 35, 34, 35, 33, 33, 33, 33, 37, 35, 37, 35, 33, 32, 33, 32, 41, 32, 41, 32};
    int i, j;
    for (i = 0; i < 36; ++i) {
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
