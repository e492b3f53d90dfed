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
static const float paper_tool_f32_output_guard = 0x1.be74e2p23f;

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
        float u0 = 0x1.10c918p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.fc4e1ep-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a253a8p8f * v; u2 += 0x1.0ba032p9f * v;
        v = x[5]; u0 += 0x1.60219ep5f * v; u2 += -0x1.7b222ap9f * v;
        v = x[8]; u0 += 0x1.076d3ap10f * v; u2 += -0x1.c9c164p11f * v;
        v = x[9]; u0 += -0x1.5ca71ep9f * v; u2 += 0x1.5d97ecp10f * v;
        v = x[12]; u0 += -0x1.bd25c0p10f * v; u2 += -0x1.111268p9f * v;
        v = x[13]; u0 += -0x1.bde024p8f * v; u2 += 0x1.11721ep10f * v;
        v = x[16]; u0 += -0x1.e79e16p11f * v; u2 += 0x1.1af128p11f * v;
        v = x[17]; u0 += 0x1.d45a20p5f * v; u2 += -0x1.c1b640p10f * v;
        v = x[20]; u0 += 0x1.b7b654p9f * v; u2 += -0x1.5dd790p9f * v;
        v = x[21]; u0 += 0x1.138a02p6f * v; u2 += -0x1.e7d5a8p8f * v;
        v = x[24]; u0 += -0x1.4728e4p7f * v; u2 += -0x1.7bea50p6f * v;
        v = x[25]; u0 += 0x1.401f5ap8f * v; u2 += -0x1.c84cc0p4f * v;
        v = x[28]; u0 += -0x1.cfb55ap8f * v; u2 += -0x1.f1dca2p6f * v;
        v = x[29]; u0 += -0x1.55eea2p7f * v; u2 += 0x1.aa66d4p7f * v;
        v = x[32]; u0 += 0x1.26e156p7f * v; u2 += -0x1.d50e66p5f * v;
        v = x[33]; u0 += 0x1.c0befap8f * v; u2 += -0x1.541754p7f * v;
        v = x[36]; u0 += -0x1.c6cdd2p4f * v; u2 += 0x1.687732p5f * v;
        v = y0; u0 += -0x1.039e38p20f * v; u2 += 0x1.ca6398p19f * v;
        v = y2; u0 += 0x1.f07d00p15f * v; u2 += -0x1.e83e88p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.10c918p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.fc4e1ep-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a253a8p8f * v; u3 += 0x1.0ba032p9f * v;
        v = x[7]; u1 += 0x1.60219ep5f * v; u3 += -0x1.7b222ap9f * v;
        v = x[10]; u1 += 0x1.076d3ap10f * v; u3 += -0x1.c9c164p11f * v;
        v = x[11]; u1 += -0x1.5ca71ep9f * v; u3 += 0x1.5d97ecp10f * v;
        v = x[14]; u1 += -0x1.bd25c0p10f * v; u3 += -0x1.111268p9f * v;
        v = x[15]; u1 += -0x1.bde024p8f * v; u3 += 0x1.11721ep10f * v;
        v = x[18]; u1 += -0x1.e79e16p11f * v; u3 += 0x1.1af128p11f * v;
        v = x[19]; u1 += 0x1.d45a20p5f * v; u3 += -0x1.c1b640p10f * v;
        v = x[22]; u1 += 0x1.b7b654p9f * v; u3 += -0x1.5dd790p9f * v;
        v = x[23]; u1 += 0x1.138a02p6f * v; u3 += -0x1.e7d5a8p8f * v;
        v = x[26]; u1 += -0x1.4728e4p7f * v; u3 += -0x1.7bea50p6f * v;
        v = x[27]; u1 += 0x1.401f5ap8f * v; u3 += -0x1.c84cc0p4f * v;
        v = x[30]; u1 += -0x1.cfb55ap8f * v; u3 += -0x1.f1dca2p6f * v;
        v = x[31]; u1 += -0x1.55eea2p7f * v; u3 += 0x1.aa66d4p7f * v;
        v = x[34]; u1 += 0x1.26e156p7f * v; u3 += -0x1.d50e66p5f * v;
        v = x[35]; u1 += 0x1.c0befap8f * v; u3 += -0x1.541754p7f * v;
        v = x[37]; u1 += -0x1.c6cdd2p4f * v; u3 += 0x1.687732p5f * v;
        v = y1; u1 += -0x1.039e38p20f * v; u3 += 0x1.ca6398p19f * v;
        v = y3; u1 += 0x1.f07d00p15f * v; u3 += -0x1.e83e88p17f * v;
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
        x[0] = -0x1.92f746p-10f * x0 + 0x1.f6c88cp7f * y0 - 0x1.b3758ap6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.157b64p-9f * x1 - 0x1.6b2fbap8f * y0 - 0x1.bb2b4ap8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.92f746p-10f * x2 + 0x1.f6c88cp7f * y1 - 0x1.b3758ap6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.157b64p-9f * x3 - 0x1.6b2fbap8f * y1 - 0x1.bb2b4ap8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.4461eep-4f * x4 + 0x1.3c1fb8p-1f * x5 + 0x1.38b268p6f * y0 - 0x1.3c58c0p5f * y2
            + x4;
        x[5] = -0x1.3c1fb8p-3f * x4 - 0x1.4461eep-4f * x5 - 0x1.d954eap5f * y0 + 0x1.75b28ap-1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.4461eep-4f * x6 + 0x1.3c1fb8p-1f * x7 + 0x1.38b268p6f * y1 - 0x1.3c58c0p5f * y3
            + x6;
        x[7] = -0x1.3c1fb8p-3f * x6 - 0x1.4461eep-4f * x7 - 0x1.d954eap5f * y1 + 0x1.75b28ap-1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1c8a82p-3f * x8 + 0x1.e0cfccp-2f * x9 - 0x1.1057f4p5f * y0 + 0x1.47e108p4f * y2
            + x8;
        x[9] = -0x1.e0cfccp-2f * x8 - 0x1.1c8a82p-3f * x9 + 0x1.cf2f4cp4f * y0 - 0x1.0f24bcp4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1c8a82p-3f * x10 + 0x1.e0cfccp-2f * x11 - 0x1.1057f4p5f * y1 + 0x1.47e108p4f * y3
            + x10;
        x[11] = -0x1.e0cfccp-2f * x10 - 0x1.1c8a82p-3f * x11 + 0x1.cf2f4cp4f * y1 - 0x1.0f24bcp4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6c0968p-1f * x12 + 0x1.0152fap-1f * x13 + 0x1.bf07eep7f * y0 - 0x1.266b9ap6f * y2;
        x[13] = -0x1.0152fap-1f * x12 + 0x1.6c0968p-1f * x13 - 0x1.44ba28p8f * y0 - 0x1.fd861cp6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6c0968p-1f * x14 + 0x1.0152fap-1f * x15 + 0x1.bf07eep7f * y1 - 0x1.266b9ap6f * y3;
        x[15] = -0x1.0152fap-1f * x14 + 0x1.6c0968p-1f * x15 - 0x1.44ba28p8f * y1 - 0x1.fd861cp6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.239aa4p-1f * x16 + 0x1.79669ep-1f * x17 - 0x1.c0ce48p6f * y0 + 0x1.395280p5f * y2;
        x[17] = -0x1.79669ep-1f * x16 + 0x1.239aa4p-1f * x17 - 0x1.acfca2p6f * y0 + 0x1.8980aep7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.239aa4p-1f * x18 + 0x1.79669ep-1f * x19 - 0x1.c0ce48p6f * y1 + 0x1.395280p5f * y3;
        x[19] = -0x1.79669ep-1f * x18 + 0x1.239aa4p-1f * x19 - 0x1.acfca2p6f * y1 + 0x1.8980aep7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6e0dd6p-2f * x20 + 0x1.860cc2p-1f * x21 + 0x1.545f9cp5f * y0 - 0x1.63680ep9f * y2;
        x[21] = -0x1.860cc2p-1f * x20 + 0x1.6e0dd6p-2f * x21 - 0x1.ae716cp7f * y0 + 0x1.164adap5f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6e0dd6p-2f * x22 + 0x1.860cc2p-1f * x23 + 0x1.545f9cp5f * y1 - 0x1.63680ep9f * y3;
        x[23] = -0x1.860cc2p-1f * x22 + 0x1.6e0dd6p-2f * x23 - 0x1.ae716cp7f * y1 + 0x1.164adap5f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.5ac668p-3f * x24 + 0x1.4cc656p-1f * x25 + 0x1.d5a5c8p5f * y0 - 0x1.1829d0p7f * y2;
        x[25] = -0x1.4cc656p-1f * x24 + 0x1.5ac668p-3f * x25 + 0x1.047d30p10f * y0 + 0x1.9e710ep7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.5ac668p-3f * x26 + 0x1.4cc656p-1f * x27 + 0x1.d5a5c8p5f * y1 - 0x1.1829d0p7f * y3;
        x[27] = -0x1.4cc656p-1f * x26 + 0x1.5ac668p-3f * x27 + 0x1.047d30p10f * y1 + 0x1.9e710ep7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.eb4276p-4f * x28 + 0x1.c97e24p-1f * x29 + 0x1.059a1ep6f * y0 + 0x1.69f66cp8f * y2;
        x[29] = -0x1.c97e24p-1f * x28 + 0x1.eb4276p-4f * x29 - 0x1.41ed94p5f * y0 - 0x1.884a30p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.eb4276p-4f * x30 + 0x1.c97e24p-1f * x31 + 0x1.059a1ep6f * y1 + 0x1.69f66cp8f * y3;
        x[31] = -0x1.c97e24p-1f * x30 + 0x1.eb4276p-4f * x31 - 0x1.41ed94p5f * y1 - 0x1.884a30p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.0419e4p-2f * x32 + 0x1.5d4176p-1f * x33 - 0x1.100d52p9f * y0 - 0x1.a5608ep7f * y2;
        x[33] = -0x1.5d4176p-3f * x32 - 0x1.0419e4p-2f * x33 - 0x1.bf52acp9f * y0 + 0x1.6eb388p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.0419e4p-2f * x34 + 0x1.5d4176p-1f * x35 - 0x1.100d52p9f * y1 - 0x1.a5608ep7f * y3;
        x[35] = -0x1.5d4176p-3f * x34 - 0x1.0419e4p-2f * x35 - 0x1.bf52acp9f * y1 + 0x1.6eb388p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fece82p-1f * x36 + 0x1.809966p1f * y0 - 0x1.06356ep2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fece82p-1f * x37 + 0x1.809966p1f * y1 - 0x1.06356ep2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.83698cp-4f * e[0];
        x[0] += 0x1.484ea6p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.71d25ap-4f * e[0];
        x[1] += -0x1.2bb250p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.83698cp-4f * e[1];
        x[2] += 0x1.484ea6p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.71d25ap-4f * e[1];
        x[3] += -0x1.2bb250p-4f * e[3];
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
        {0x1.95ac00p16f, 0.0f, 0x1.329f24p15f, 0.0f, 0x1.8c4ddcp-1f, 0.0f, -0x1.497792p-4f, 0.0f},
        {-0x1.e62c36p16f, 0.0f, -0x1.8ef322p13f, 0.0f, -0x1.4ed372p-1f, 0.0f, 0x1.7d9634p-2f, 0.0f},
        {0.0f, 0x1.95ac00p16f, 0.0f, 0x1.329f24p15f, 0.0f, 0x1.8c4ddcp-1f, 0.0f, -0x1.497792p-4f},
        {0.0f, -0x1.e62c36p16f, 0.0f, -0x1.8ef322p13f, 0.0f, -0x1.4ed372p-1f, 0.0f, 0x1.7d9634p-2f},
        {-0x1.2ef938p8f, 0.0f, -0x1.c10680p4f, 0.0f, -0x1.a1fdc0p-16f, 0.0f, 0x1.12e204p-17f, 0.0f},
        {-0x1.3d36e4p7f, 0.0f, 0x1.e710f8p5f, 0.0f, 0x1.4f9610p-15f, 0.0f, -0x1.d05388p-17f, 0.0f},
        {0.0f, -0x1.2ef938p8f, 0.0f, -0x1.c10680p4f, 0.0f, -0x1.a1fdc0p-16f, 0.0f, 0x1.12e204p-17f},
        {0.0f, -0x1.3d36e4p7f, 0.0f, 0x1.e710f8p5f, 0.0f, 0x1.4f9610p-15f, 0.0f, -0x1.d05388p-17f},
        {0x1.292412p5f, 0.0f, -0x1.54492cp4f, 0.0f, 0x1.20e0f0p-20f, 0.0f, -0x1.847c42p-22f, 0.0f},
        {0x1.5b699ap6f, 0.0f, -0x1.8d849ep5f, 0.0f, 0x1.6742f2p-16f, 0.0f, -0x1.eeafa2p-18f, 0.0f},
        {0.0f, 0x1.292412p5f, 0.0f, -0x1.54492cp4f, 0.0f, 0x1.20e0f0p-20f, 0.0f, -0x1.847c42p-22f},
        {0.0f, 0x1.5b699ap6f, 0.0f, -0x1.8d849ep5f, 0.0f, 0x1.6742f2p-16f, 0.0f, -0x1.eeafa2p-18f},
        {-0x1.1d702cp8f, 0.0f, -0x1.f929dcp7f, 0.0f, 0x1.9b49cep-15f, 0.0f, -0x1.1871a6p-16f, 0.0f},
        {-0x1.427280p9f, 0.0f, -0x1.e29a2cp0f, 0.0f, -0x1.9de4a6p-13f, 0.0f, 0x1.1ce6fcp-14f, 0.0f},
        {0.0f, -0x1.1d702cp8f, 0.0f, -0x1.f929dcp7f, 0.0f, 0x1.9b49cep-15f, 0.0f, -0x1.1871a6p-16f},
        {0.0f, -0x1.427280p9f, 0.0f, -0x1.e29a2cp0f, 0.0f, -0x1.9de4a6p-13f, 0.0f, 0x1.1ce6fcp-14f},
        {-0x1.597f9ep7f, 0.0f, 0x1.bc919cp7f, 0.0f, 0x1.ae49e4p-17f, 0.0f, -0x1.293274p-18f, 0.0f},
        {0x1.767adep5f, 0.0f, 0x1.314822p6f, 0.0f, -0x1.5e5a8cp-16f, 0.0f, 0x1.e1a12ap-18f, 0.0f},
        {0.0f, -0x1.597f9ep7f, 0.0f, 0x1.bc919cp7f, 0.0f, 0x1.ae49e4p-17f, 0.0f, -0x1.293274p-18f},
        {0.0f, 0x1.767adep5f, 0.0f, 0x1.314822p6f, 0.0f, -0x1.5e5a8cp-16f, 0.0f, 0x1.e1a12ap-18f},
        {-0x1.1442d0p7f, 0.0f, -0x1.b0b576p8f, 0.0f, -0x1.217622p-18f, 0.0f, 0x1.b46e70p-20f, 0.0f},
        {-0x1.32b2a2p7f, 0.0f, 0x1.1cdf70p9f, 0.0f, 0x1.e382a0p-14f, 0.0f, -0x1.4b6bd6p-15f, 0.0f},
        {0.0f, -0x1.1442d0p7f, 0.0f, -0x1.b0b576p8f, 0.0f, -0x1.217622p-18f, 0.0f, 0x1.b46e70p-20f},
        {0.0f, -0x1.32b2a2p7f, 0.0f, 0x1.1cdf70p9f, 0.0f, 0x1.e382a0p-14f, 0.0f, -0x1.4b6bd6p-15f},
        {0x1.a1f33ep8f, 0.0f, 0x1.9e94ecp1f, 0.0f, -0x1.83a886p-10f, 0.0f, 0x1.0b9262p-11f, 0.0f},
        {0x1.75c584p9f, 0.0f, 0x1.d7e1bcp7f, 0.0f, 0x1.a78d2ap-16f, 0.0f, -0x1.2c85cap-17f, 0.0f},
        {0.0f, 0x1.a1f33ep8f, 0.0f, 0x1.9e94ecp1f, 0.0f, -0x1.83a886p-10f, 0.0f, 0x1.0b9262p-11f},
        {0.0f, 0x1.75c584p9f, 0.0f, 0x1.d7e1bcp7f, 0.0f, 0x1.a78d2ap-16f, 0.0f, -0x1.2c85cap-17f},
        {0x1.1778d0p4f, 0.0f, 0x1.6bc00ap6f, 0.0f, 0x1.93ddd4p-16f, 0.0f, -0x1.1a4396p-17f, 0.0f},
        {-0x1.e4bb4ep5f, 0.0f, -0x1.3bf570p8f, 0.0f, -0x1.523b40p-18f, 0.0f, 0x1.aa5098p-20f, -0.0f},
        {0.0f, 0x1.1778d0p4f, 0.0f, 0x1.6bc00ap6f, 0.0f, 0x1.93ddd4p-16f, 0.0f, -0x1.1a4396p-17f},
        {0.0f, -0x1.e4bb4ep5f, 0.0f, -0x1.3bf570p8f, 0.0f, -0x1.523b40p-18f, 0.0f, 0x1.aa5098p-20f},
        {-0x1.5ce2c4p9f, 0.0f, 0x1.b850aep8f, 0.0f, 0x1.bde69ep-12f, 0.0f, -0x1.337a3cp-13f, 0.0f},
        {-0x1.8f6034p8f, 0.0f, 0x1.19b33ep10f, 0.0f, 0x1.5929ccp-10f, 0.0f, -0x1.db22d2p-12f, 0.0f},
        {0.0f, -0x1.5ce2c4p9f, 0.0f, 0x1.b850aep8f, 0.0f, 0x1.bde69ep-12f, 0.0f, -0x1.337a3cp-13f},
        {0.0f, -0x1.8f6034p8f, 0.0f, 0x1.19b33ep10f, 0.0f, 0x1.5929ccp-10f, 0.0f, -0x1.db22d2p-12f},
        {0x1.158bc6p0f, 0.0f, -0x1.0c8758p1f, -0.0f, -0x1.5e8a60p-19f, -0.0f, 0x1.e08b32p-21f, 0.0f},
        {0.0f, 0x1.158bc6p0f, 0.0f, -0x1.0c8758p1f, 0.0f, -0x1.5e8a60p-19f, 0.0f, 0x1.e08b32p-21f},
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
/* Over the test vectors Q31 stays within 4.660e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 186222 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 173501 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73107906 * (int64_t)v; u2 += 46770990 * (int64_t)v;
        v = x[5]; u0 += 7692426 * (int64_t)v; u2 += -66258373 * (int64_t)v;
        v = x[8]; u0 += 184148577 * (int64_t)v; u2 += -319994250 * (int64_t)v;
        v = x[9]; u0 += -121862987 * (int64_t)v; u2 += 122191764 * (int64_t)v;
        v = x[12]; u0 += -311180632 * (int64_t)v; u2 += -47722771 * (int64_t)v;
        v = x[13]; u0 += -77922399 * (int64_t)v; u2 += 95576225 * (int64_t)v;
        v = x[16]; u0 += -681738697 * (int64_t)v; u2 += 197790815 * (int64_t)v;
        v = x[17]; u0 += 10231306 * (int64_t)v; u2 += -157185704 * (int64_t)v;
        v = x[20]; u0 += 153690559 * (int64_t)v; u2 += -61139329 * (int64_t)v;
        v = x[21]; u0 += 12038487 * (int64_t)v; u2 += -42627636 * (int64_t)v;
        v = x[24]; u0 += -28587653 * (int64_t)v; u2 += -8299376 * (int64_t)v;
        v = x[25]; u0 += 55945455 * (int64_t)v; u2 += -2492005 * (int64_t)v;
        v = x[28]; u0 += -81038918 * (int64_t)v; u2 += -10875958 * (int64_t)v;
        v = x[29]; u0 += -29878488 * (int64_t)v; u2 += 18629774 * (int64_t)v;
        v = x[32]; u0 += 25767028 * (int64_t)v; u2 += -5123345 * (int64_t)v;
        v = x[33]; u0 += 78424050 * (int64_t)v; u2 += -14858808 * (int64_t)v;
        v = x[36]; u0 += -4967672 * (int64_t)v; u2 += 3937246 * (int64_t)v;
        v = y0; u0 += -47203827 * (int64_t)v; u2 += 20836106 * (int64_t)v;
        v = y2; u0 += 2820989 * (int64_t)v; u2 += -5548294 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 186222 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 173501 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73107906 * (int64_t)v; u3 += 46770990 * (int64_t)v;
        v = x[7]; u1 += 7692426 * (int64_t)v; u3 += -66258373 * (int64_t)v;
        v = x[10]; u1 += 184148577 * (int64_t)v; u3 += -319994250 * (int64_t)v;
        v = x[11]; u1 += -121862987 * (int64_t)v; u3 += 122191764 * (int64_t)v;
        v = x[14]; u1 += -311180632 * (int64_t)v; u3 += -47722771 * (int64_t)v;
        v = x[15]; u1 += -77922399 * (int64_t)v; u3 += 95576225 * (int64_t)v;
        v = x[18]; u1 += -681738697 * (int64_t)v; u3 += 197790815 * (int64_t)v;
        v = x[19]; u1 += 10231306 * (int64_t)v; u3 += -157185704 * (int64_t)v;
        v = x[22]; u1 += 153690559 * (int64_t)v; u3 += -61139329 * (int64_t)v;
        v = x[23]; u1 += 12038487 * (int64_t)v; u3 += -42627636 * (int64_t)v;
        v = x[26]; u1 += -28587653 * (int64_t)v; u3 += -8299376 * (int64_t)v;
        v = x[27]; u1 += 55945455 * (int64_t)v; u3 += -2492005 * (int64_t)v;
        v = x[30]; u1 += -81038918 * (int64_t)v; u3 += -10875958 * (int64_t)v;
        v = x[31]; u1 += -29878488 * (int64_t)v; u3 += 18629774 * (int64_t)v;
        v = x[34]; u1 += 25767028 * (int64_t)v; u3 += -5123345 * (int64_t)v;
        v = x[35]; u1 += 78424050 * (int64_t)v; u3 += -14858808 * (int64_t)v;
        v = x[37]; u1 += -4967672 * (int64_t)v; u3 += 3937246 * (int64_t)v;
        v = y1; u1 += -47203827 * (int64_t)v; u3 += 20836106 * (int64_t)v;
        v = y3; u1 += 2820989 * (int64_t)v; u3 += -5548294 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1650548 * (int64_t)x0 + 68562162 * (int64_t)y0 - 29690739 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2273132 * (int64_t)x1 - 99051990 * (int64_t)y0 - 120865698 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1650548 * (int64_t)x2 + 68562162 * (int64_t)y1 - 29690739 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2273132 * (int64_t)x3 - 99051990 * (int64_t)y1 - 120865698 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-85034939 * (int64_t)x4 + 662959883 * (int64_t)x5 + 21320489 * (int64_t)y0 - 10784671 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165739971 * (int64_t)x4 - 85034939 * (int64_t)x5 - 16136495 * (int64_t)y0 + 199060 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-85034939 * (int64_t)x6 + 662959883 * (int64_t)x7 + 21320489 * (int64_t)y1 - 10784671 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165739971 * (int64_t)x6 - 85034939 * (int64_t)x7 - 16136495 * (int64_t)y1 + 199060 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149181464 * (int64_t)x8 + 504167610 * (int64_t)x9 - 9284547 * (int64_t)y0 + 5588912 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504167610 * (int64_t)x8 - 149181464 * (int64_t)x9 + 7895286 * (int64_t)y0 - 4621817 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149181464 * (int64_t)x10 + 504167610 * (int64_t)x11 - 9284547 * (int64_t)y1 + 5588912 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504167610 * (int64_t)x10 - 149181464 * (int64_t)x11 + 7895286 * (int64_t)y1 - 4621817 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763440412 * (int64_t)x12 + 539647790 * (int64_t)x13 + 60959472 * (int64_t)y0 - 20074345 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-539647790 * (int64_t)x12 + 763440412 * (int64_t)x13 - 88562977 * (int64_t)y0 - 34740666 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763440412 * (int64_t)x14 + 539647790 * (int64_t)x15 + 60959472 * (int64_t)y1 - 20074345 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-539647790 * (int64_t)x14 + 763440412 * (int64_t)x15 - 88562977 * (int64_t)y1 - 34740666 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611538026 * (int64_t)x16 + 791466966 * (int64_t)x17 - 30600748 * (int64_t)y0 + 10681564 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791466966 * (int64_t)x16 + 611538026 * (int64_t)x17 - 29249442 * (int64_t)y0 + 53660072 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611538026 * (int64_t)x18 + 791466966 * (int64_t)x19 - 30600748 * (int64_t)y1 + 10681564 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791466966 * (int64_t)x18 + 611538026 * (int64_t)x19 - 29249442 * (int64_t)y1 + 53660072 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(383835490 * (int64_t)x20 + 817993762 * (int64_t)x21 + 11603775 * (int64_t)y0 - 193860318 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817993762 * (int64_t)x20 + 383835490 * (int64_t)x21 - 58697457 * (int64_t)y0 + 9487350 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(383835490 * (int64_t)x22 + 817993762 * (int64_t)x23 + 11603775 * (int64_t)y1 - 193860318 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817993762 * (int64_t)x22 + 383835490 * (int64_t)x23 - 58697457 * (int64_t)y1 + 9487350 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(363619978 * (int64_t)x24 + 1395758481 * (int64_t)x25 + 32021797 * (int64_t)y0 - 76409066 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-697879241 * (int64_t)x24 + 181809989 * (int64_t)x25 + 284173117 * (int64_t)y0 + 56515418 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(363619978 * (int64_t)x26 + 1395758481 * (int64_t)x27 + 32021797 * (int64_t)y1 - 76409066 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-697879241 * (int64_t)x26 + 181809989 * (int64_t)x27 + 284173117 * (int64_t)y1 + 56515418 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128780761 * (int64_t)x28 + 959431812 * (int64_t)x29 + 17836708 * (int64_t)y0 + 98718208 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-959431812 * (int64_t)x28 + 128780761 * (int64_t)x29 - 10974946 * (int64_t)y0 - 53494680 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128780761 * (int64_t)x30 + 959431812 * (int64_t)x31 + 17836708 * (int64_t)y1 + 98718208 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-959431812 * (int64_t)x30 + 128780761 * (int64_t)x31 - 10974946 * (int64_t)y1 - 53494680 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-272735822 * (int64_t)x32 + 732442331 * (int64_t)x33 - 148393727 * (int64_t)y0 - 57461187 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-183110583 * (int64_t)x32 - 272735822 * (int64_t)x33 - 243997149 * (int64_t)y0 + 400042399 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-272735822 * (int64_t)x34 + 732442331 * (int64_t)x35 - 148393727 * (int64_t)y1 - 57461187 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-183110583 * (int64_t)x34 - 272735822 * (int64_t)x35 - 243997149 * (int64_t)y1 + 400042399 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142478410 * (int64_t)x36 + 1638936 * (int64_t)y0 - 2234759 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142478410 * (int64_t)x37 + 1638936 * (int64_t)y1 - 2234759 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 609346856 * (int64_t)e[0] + 516382616 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1163358436 * (int64_t)e[0] - 942763788 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 609346856 * (int64_t)e[1] + 516382616 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1163358436 * (int64_t)e[1] - 942763788 * (int64_t)e[3], 19);
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
        {885112474, 0, 334500218, 0, 77916566, 0, -8096983, 0},
        {-1060752683, 0, -108805728, 0, -65829460, 0, 37511503, 0},
        {0, 885112474, 0, 334500218, 0, 77916566, 0, -8096983},
        {0, -1060752683, 0, -108805728, 0, -65829460, 0, 37511503},
        {-1322081462, 0, -122462885, 0, -1284069, 0, 422220, 0},
        {-1384224417, 0, 531351162, 0, 4123683, 0, -1426410, 0},
        {0, -1322081462, 0, -122462885, 0, -1284069, 0, 422220},
        {0, -1384224417, 0, 531351162, 0, 4123683, 0, -1426410},
        {1296629840, 0, -742450398, 0, 443718, 0, -149178, 0},
        {757999660, 0, -433661065, 0, 2207303, 0, -759838, 0},
        {0, 1296629840, 0, -742450398, 0, 443718, 0, -149178},
        {0, 757999660, 0, -433661065, 0, 2207303, 0, -759838},
        {-622781408, 0, -551093822, 0, 1263478, 0, -430762, 0},
        {-1407058835, 0, -4113135, 0, -5085919, 0, 1750440, 0},
        {0, -622781408, 0, -551093822, 0, 1263478, 0, -430762},
        {0, -1407058835, 0, -4113135, 0, -5085919, 0, 1750440},
        {-753823609, 0, 969979490, 0, 660923, 0, -228247, 0},
        {408528290, 0, 666077033, 0, -2152573, 0, 739783, 0},
        {0, -753823609, 0, 969979490, 0, 660923, 0, -228247},
        {0, 408528290, 0, 666077033, 0, -2152573, 0, 739783},
        {-301379108, 0, -944102920, 0, -111153, 0, 41897, 0},
        {-334583252, 0, 1243095672, 0, 2970687, 0, -1018126, 0},
        {0, -301379108, 0, -944102920, 0, -111153, 0, 41897},
        {0, -334583252, 0, 1243095672, 0, 2970687, 0, -1018126},
        {1823803656, 0, 14133631, 0, -76216721, 0, 26303378, 0},
        {1631021947, 0, 514786068, 0, 650575, 0, -230801, 0},
        {0, 1823803656, 0, 14133631, 0, -76216721, 0, 26303378},
        {0, 1631021947, 0, 514786068, 0, 650575, 0, -230801},
        {304881972, 0, 1587291714, 0, 4962712, 0, -1734230, 0},
        {-264402144, 0, -1378744966, 0, -259762, 0, 81852, 0},
        {0, 304881972, 0, 1587291714, 0, 4962712, 0, -1734230},
        {0, -264402144, 0, -1378744966, 0, -259762, 0, 81852},
        {-761214186, 0, 480349345, 0, 5479230, 0, -1889142, 0},
        {-435687702, 0, 1229251249, 0, 16965465, 0, -5838471, 0},
        {0, -761214186, 0, 480349345, 0, 5479230, 0, -1889142},
        {0, -435687702, 0, 1229251249, 0, 16965465, 0, -5838471},
        {605561912, 0, -1171775039, 0, -17229768, 0, 5904921, 0},
        {0, 605561912, 0, -1171775039, 0, -17229768, 0, 5904921},
    };
    static const int16_t shift[38] = {
        25, 25, 25, 25, 34, 35, 34, 35, 37, 35, 37, 35, 33, 33, 33, 33, 34, 35, 34, 35, 33, 33, 33, 33, 34, 33, 34, 33, 36, 34, 36, 34, 32, 32, 32, 32, 41, 41};
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
