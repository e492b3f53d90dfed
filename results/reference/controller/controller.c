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
static const float paper_tool_f32_output_guard = 0x1.d09960p23f;

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
        float u0 = 0x1.e85daep-1f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.d0d2e0p-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.8f5baep9f * v; u2 += 0x1.ce0eb0p9f * v;
        v = x[5]; u0 += -0x1.726d18p6f * v; u2 += -0x1.ad7a64p9f * v;
        v = x[8]; u0 += 0x1.f5cf00p9f * v; u2 += -0x1.c42ecep11f * v;
        v = x[9]; u0 += -0x1.77c406p9f * v; u2 += 0x1.600ea8p10f * v;
        v = x[12]; u0 += -0x1.a3316cp10f * v; u2 += -0x1.1874d6p9f * v;
        v = x[13]; u0 += -0x1.80bb60p8f * v; u2 += 0x1.f5a278p9f * v;
        v = x[16]; u0 += -0x1.cc4642p11f * v; u2 += 0x1.39a600p11f * v;
        v = x[17]; u0 += 0x1.2ea8ccp4f * v; u2 += -0x1.ccf6b0p10f * v;
        v = x[20]; u0 += 0x1.3e9182p9f * v; u2 += -0x1.88d066p9f * v;
        v = x[21]; u0 += -0x1.7a37a6p5f * v; u2 += -0x1.332bbep8f * v;
        v = x[24]; u0 += -0x1.2c4454p6f * v; u2 += -0x1.04d59ep5f * v;
        v = x[25]; u0 += 0x1.28a604p8f * v; u2 += 0x1.e15726p1f * v;
        v = x[28]; u0 += -0x1.d55dd4p8f * v; u2 += -0x1.07cfe2p7f * v;
        v = x[29]; u0 += -0x1.1a1c70p7f * v; u2 += 0x1.c94180p7f * v;
        v = x[32]; u0 += 0x1.7eca86p6f * v; u2 += -0x1.47ff02p6f * v;
        v = x[33]; u0 += 0x1.6d55c0p8f * v; u2 += -0x1.c18c98p7f * v;
        v = x[36]; u0 += -0x1.ce3d2ap4f * v; u2 += 0x1.6e51c2p5f * v;
        v = y0; u0 += -0x1.ffe694p19f * v; u2 += 0x1.abd58ep19f * v;
        v = y2; u0 += 0x1.32d8f2p16f * v; u2 += -0x1.0e8c48p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.e85daep-1f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.d0d2e0p-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.8f5baep9f * v; u3 += 0x1.ce0eb0p9f * v;
        v = x[7]; u1 += -0x1.726d18p6f * v; u3 += -0x1.ad7a64p9f * v;
        v = x[10]; u1 += 0x1.f5cf00p9f * v; u3 += -0x1.c42ecep11f * v;
        v = x[11]; u1 += -0x1.77c406p9f * v; u3 += 0x1.600ea8p10f * v;
        v = x[14]; u1 += -0x1.a3316cp10f * v; u3 += -0x1.1874d6p9f * v;
        v = x[15]; u1 += -0x1.80bb60p8f * v; u3 += 0x1.f5a278p9f * v;
        v = x[18]; u1 += -0x1.cc4642p11f * v; u3 += 0x1.39a600p11f * v;
        v = x[19]; u1 += 0x1.2ea8ccp4f * v; u3 += -0x1.ccf6b0p10f * v;
        v = x[22]; u1 += 0x1.3e9182p9f * v; u3 += -0x1.88d066p9f * v;
        v = x[23]; u1 += -0x1.7a37a6p5f * v; u3 += -0x1.332bbep8f * v;
        v = x[26]; u1 += -0x1.2c4454p6f * v; u3 += -0x1.04d59ep5f * v;
        v = x[27]; u1 += 0x1.28a604p8f * v; u3 += 0x1.e15726p1f * v;
        v = x[30]; u1 += -0x1.d55dd4p8f * v; u3 += -0x1.07cfe2p7f * v;
        v = x[31]; u1 += -0x1.1a1c70p7f * v; u3 += 0x1.c94180p7f * v;
        v = x[34]; u1 += 0x1.7eca86p6f * v; u3 += -0x1.47ff02p6f * v;
        v = x[35]; u1 += 0x1.6d55c0p8f * v; u3 += -0x1.c18c98p7f * v;
        v = x[37]; u1 += -0x1.ce3d2ap4f * v; u3 += 0x1.6e51c2p5f * v;
        v = y1; u1 += -0x1.ffe694p19f * v; u3 += 0x1.abd58ep19f * v;
        v = y3; u1 += 0x1.32d8f2p16f * v; u3 += -0x1.0e8c48p18f * v;
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
        x[0] = -0x1.722af6p-10f * x0 + 0x1.7a1892p7f * y0 - 0x1.b80530p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.2add6ep-9f * x1 - 0x1.4743dcp8f * y0 - 0x1.f65dd0p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.722af6p-10f * x2 + 0x1.7a1892p7f * y1 - 0x1.b80530p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.2add6ep-9f * x3 - 0x1.4743dcp8f * y1 - 0x1.f65dd0p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.362268p-4f * x4 + 0x1.3d438ep-2f * x5 + 0x1.2bef5ap5f * y0 - 0x1.34ff84p4f * y2
            + x4;
        x[5] = -0x1.3d438ep-2f * x4 - 0x1.362268p-4f * x5 - 0x1.a9fcf8p5f * y0 + 0x1.22b882p1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.362268p-4f * x6 + 0x1.3d438ep-2f * x7 + 0x1.2bef5ap5f * y1 - 0x1.34ff84p4f * y3
            + x6;
        x[7] = -0x1.3d438ep-2f * x6 - 0x1.362268p-4f * x7 - 0x1.a9fcf8p5f * y1 + 0x1.22b882p1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1d20fcp-3f * x8 + 0x1.e07b1cp-2f * x9 - 0x1.0273a8p5f * y0 + 0x1.44b6fap4f * y2
            + x8;
        x[9] = -0x1.e07b1cp-2f * x8 - 0x1.1d20fcp-3f * x9 + 0x1.a82af8p4f * y0 - 0x1.350b44p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1d20fcp-3f * x10 + 0x1.e07b1cp-2f * x11 - 0x1.0273a8p5f * y1 + 0x1.44b6fap4f * y3
            + x10;
        x[11] = -0x1.e07b1cp-2f * x10 - 0x1.1d20fcp-3f * x11 + 0x1.a82af8p4f * y1 - 0x1.350b44p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6a651ep-1f * x12 + 0x1.06269ep-1f * x13 + 0x1.068af2p8f * y0 - 0x1.92cc7ap5f * y2;
        x[13] = -0x1.06269ep-1f * x12 + 0x1.6a651ep-1f * x13 - 0x1.26a49ap8f * y0 - 0x1.1cd622p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6a651ep-1f * x14 + 0x1.06269ep-1f * x15 + 0x1.068af2p8f * y1 - 0x1.92cc7ap5f * y3;
        x[15] = -0x1.06269ep-1f * x14 + 0x1.6a651ep-1f * x15 - 0x1.26a49ap8f * y1 - 0x1.1cd622p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.271870p-1f * x16 + 0x1.7a96d6p-1f * x17 - 0x1.69817cp6f * y0 + 0x1.fa128ep4f * y2;
        x[17] = -0x1.7a96d6p-1f * x16 + 0x1.271870p-1f * x17 - 0x1.95ffbap6f * y0 + 0x1.6fe7a0p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.271870p-1f * x18 + 0x1.7a96d6p-1f * x19 - 0x1.69817cp6f * y1 + 0x1.fa128ep4f * y3;
        x[19] = -0x1.7a96d6p-1f * x18 + 0x1.271870p-1f * x19 - 0x1.95ffbap6f * y1 + 0x1.6fe7a0p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6839b0p-2f * x20 + 0x1.8a04f2p-1f * x21 + 0x1.8b08cap2f * y0 - 0x1.7dd472p9f * y2;
        x[21] = -0x1.8a04f2p-1f * x20 + 0x1.6839b0p-2f * x21 - 0x1.e509ecp6f * y0 + 0x1.980412p6f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6839b0p-2f * x22 + 0x1.8a04f2p-1f * x23 + 0x1.8b08cap2f * y1 - 0x1.7dd472p9f * y3;
        x[23] = -0x1.8a04f2p-1f * x22 + 0x1.6839b0p-2f * x23 - 0x1.e509ecp6f * y1 + 0x1.980412p6f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.7270c4p-3f * x24 + 0x1.44cad8p0f * x25 - 0x1.34ececp3f * y0 - 0x1.69f28cp7f * y2;
        x[25] = -0x1.44cad8p-2f * x24 + 0x1.7270c4p-3f * x25 + 0x1.eaaf40p9f * y0 + 0x1.1a84c2p8f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.7270c4p-3f * x26 + 0x1.44cad8p0f * x27 - 0x1.34ececp3f * y1 - 0x1.69f28cp7f * y3;
        x[27] = -0x1.44cad8p-2f * x26 + 0x1.7270c4p-3f * x27 + 0x1.eaaf40p9f * y1 + 0x1.1a84c2p8f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e4b4a2p-4f * x28 + 0x1.caa3d0p-1f * x29 + 0x1.ad8e54p5f * y0 + 0x1.73d23cp8f * y2;
        x[29] = -0x1.caa3d0p-1f * x28 + 0x1.e4b4a2p-4f * x29 - 0x1.e8fc0ap6f * y0 - 0x1.59a712p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e4b4a2p-4f * x30 + 0x1.caa3d0p-1f * x31 + 0x1.ad8e54p5f * y1 + 0x1.73d23cp8f * y3;
        x[31] = -0x1.caa3d0p-1f * x30 + 0x1.e4b4a2p-4f * x31 - 0x1.e8fc0ap6f * y1 - 0x1.59a712p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.d9a4eap-3f * x32 + 0x1.4c1126p-1f * x33 - 0x1.2d9232p8f * y0 - 0x1.6ec2bep6f * y2;
        x[33] = -0x1.4c1126p-3f * x32 - 0x1.d9a4eap-3f * x33 - 0x1.741a24p9f * y0 + 0x1.5d46aap10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.d9a4eap-3f * x34 + 0x1.4c1126p-1f * x35 - 0x1.2d9232p8f * y1 - 0x1.6ec2bep6f * y3;
        x[35] = -0x1.4c1126p-3f * x34 - 0x1.d9a4eap-3f * x35 - 0x1.741a24p9f * y1 + 0x1.5d46aap10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fec4eap-1f * x36 + 0x1.86c1a4p1f * y0 - 0x1.0a82fcp2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fec4eap-1f * x37 + 0x1.86c1a4p1f * y1 - 0x1.0a82fcp2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.9a484cp-5f * e[0];
        x[0] += 0x1.4e827ep-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.7a3aaap-5f * e[0];
        x[1] += -0x1.2ac6a8p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.9a484cp-5f * e[1];
        x[2] += 0x1.4e827ep-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.7a3aaap-5f * e[1];
        x[3] += -0x1.2ac6a8p-4f * e[3];
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
        {0x1.048f34p16f, 0.0f, 0x1.6a1756p15f, 0.0f, 0x1.148234p-1f, 0.0f, 0x1.a1c042p-6f, 0.0f},
        {-0x1.4bc4f0p16f, 0.0f, -0x1.f2e65ep13f, 0.0f, -0x1.ab7baap-2f, 0.0f, 0x1.145414p-2f, 0.0f},
        {0.0f, 0x1.048f34p16f, 0.0f, 0x1.6a1756p15f, 0.0f, 0x1.148234p-1f, 0.0f, 0x1.a1c042p-6f},
        {0.0f, -0x1.4bc4f0p16f, 0.0f, -0x1.f2e65ep13f, 0.0f, -0x1.ab7baap-2f, 0.0f, 0x1.145414p-2f},
        {-0x1.0b2d7ep7f, 0.0f, -0x1.042f98p3f, 0.0f, 0x1.7bad8cp-18f, 0.0f, -0x1.019c36p-19f, 0.0f},
        {-0x1.28392ep7f, 0.0f, 0x1.e4dfcep5f, 0.0f, 0x1.38c5a4p-15f, 0.0f, -0x1.8698a0p-17f, 0.0f},
        {0.0f, -0x1.0b2d7ep7f, 0.0f, -0x1.042f98p3f, 0.0f, 0x1.7bad8cp-18f, 0.0f, -0x1.019c36p-19f},
        {0.0f, -0x1.28392ep7f, 0.0f, 0x1.e4dfcep5f, 0.0f, 0x1.38c5a4p-15f, 0.0f, -0x1.8698a0p-17f},
        {0x1.0da848p5f, 0.0f, -0x1.9fba40p4f, 0.0f, 0x1.dc30e6p-19f, 0.0f, -0x1.26b2b6p-20f, 0.0f},
        {0x1.490bc6p6f, 0.0f, -0x1.966a60p5f, 0.0f, 0x1.841a00p-16f, 0.0f, -0x1.e338d0p-18f, 0.0f},
        {0.0f, 0x1.0da848p5f, 0.0f, -0x1.9fba40p4f, 0.0f, 0x1.dc30e6p-19f, 0.0f, -0x1.26b2b6p-20f},
        {0.0f, 0x1.490bc6p6f, 0.0f, -0x1.966a60p5f, 0.0f, 0x1.841a00p-16f, 0.0f, -0x1.e338d0p-18f},
        {-0x1.9e392ap7f, 0.0f, -0x1.f64c8cp7f, 0.0f, 0x1.489c9ap-15f, 0.0f, -0x1.93f916p-17f, 0.0f},
        {-0x1.4cd248p9f, 0.0f, -0x1.77c4aap5f, 0.0f, -0x1.a6f3d6p-13f, 0.0f, 0x1.07676ep-14f, 0.0f},
        {0.0f, -0x1.9e392ap7f, 0.0f, -0x1.f64c8cp7f, 0.0f, 0x1.489c9ap-15f, 0.0f, -0x1.93f916p-17f},
        {0.0f, -0x1.4cd248p9f, 0.0f, -0x1.77c4aap5f, 0.0f, -0x1.a6f3d6p-13f, 0.0f, 0x1.07676ep-14f},
        {-0x1.33d21cp7f, 0.0f, 0x1.9b9b48p7f, 0.0f, 0x1.d6e142p-17f, 0.0f, -0x1.25e366p-18f, 0.0f},
        {0x1.e044a2p4f, 0.0f, 0x1.2bb2f8p6f, 0.0f, -0x1.2e30b8p-16f, 0.0f, 0x1.77a65ep-18f, 0.0f},
        {0.0f, -0x1.33d21cp7f, 0.0f, 0x1.9b9b48p7f, 0.0f, 0x1.d6e142p-17f, 0.0f, -0x1.25e366p-18f},
        {0.0f, 0x1.e044a2p4f, 0.0f, 0x1.2bb2f8p6f, 0.0f, -0x1.2e30b8p-16f, 0.0f, 0x1.77a65ep-18f},
        {-0x1.8a228cp6f, 0.0f, -0x1.9b39c2p8f, 0.0f, -0x1.1d0694p-14f, 0.0f, 0x1.6578d4p-16f, 0.0f},
        {-0x1.03a98ep6f, 0.0f, 0x1.43a17cp9f, 0.0f, 0x1.d4556cp-14f, 0.0f, -0x1.2269f4p-15f, 0.0f},
        {0.0f, -0x1.8a228cp6f, 0.0f, -0x1.9b39c2p8f, 0.0f, -0x1.1d0694p-14f, 0.0f, 0x1.6578d4p-16f},
        {0.0f, -0x1.03a98ep6f, 0.0f, 0x1.43a17cp9f, 0.0f, 0x1.d4556cp-14f, 0.0f, -0x1.2269f4p-15f},
        {0x1.0c26f2p9f, 0.0f, 0x1.5d234ap7f, 0.0f, -0x1.067ceep-8f, 0.0f, 0x1.475784p-10f, 0.0f},
        {0x1.9f6b96p9f, 0.0f, 0x1.0ddb58p8f, 0.0f, 0x1.0f35a8p-11f, 0.0f, -0x1.53210ap-13f, 0.0f},
        {0.0f, 0x1.0c26f2p9f, 0.0f, 0x1.5d234ap7f, 0.0f, -0x1.067ceep-8f, 0.0f, 0x1.475784p-10f},
        {0.0f, 0x1.9f6b96p9f, 0.0f, 0x1.0ddb58p8f, 0.0f, 0x1.0f35a8p-11f, 0.0f, -0x1.53210ap-13f},
        {-0x1.643350p4f, 0.0f, 0x1.b735f8p6f, 0.0f, 0x1.d4006ep-14f, 0.0f, -0x1.2461dcp-15f, 0.0f},
        {-0x1.6f7016p6f, 0.0f, -0x1.337712p8f, 0.0f, 0x1.795d70p-15f, 0.0f, -0x1.d99d8ep-17f, 0.0f},
        {0.0f, -0x1.643350p4f, 0.0f, 0x1.b735f8p6f, 0.0f, 0x1.d4006ep-14f, 0.0f, -0x1.2461dcp-15f},
        {0.0f, -0x1.6f7016p6f, 0.0f, -0x1.337712p8f, 0.0f, 0x1.795d70p-15f, 0.0f, -0x1.d99d8ep-17f},
        {-0x1.033962p9f, 0.0f, 0x1.e8e9dap8f, 0.0f, 0x1.ceddfep-15f, 0.0f, -0x1.22fb7ep-16f, 0.0f},
        {-0x1.27e46ap8f, 0.0f, 0x1.0eecf0p10f, 0.0f, 0x1.951364p-10f, 0.0f, -0x1.f7f456p-12f, 0.0f},
        {0.0f, -0x1.033962p9f, 0.0f, 0x1.e8e9dap8f, 0.0f, 0x1.ceddfep-15f, 0.0f, -0x1.22fb7ep-16f},
        {0.0f, -0x1.27e46ap8f, 0.0f, 0x1.0eecf0p10f, 0.0f, 0x1.951364p-10f, 0.0f, -0x1.f7f456p-12f},
        {0x1.ef3264p-1f, 0.0f, -0x1.10182ap1f, 0.0f, -0x1.e4299cp-19f, -0.0f, 0x1.2caf62p-20f, 0.0f},
        {0.0f, 0x1.ef3264p-1f, 0.0f, -0x1.10182ap1f, 0.0f, -0x1.e4299cp-19f, 0.0f, 0x1.2caf62p-20f},
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
/* Over the test vectors Q31 stays within 5.490e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 166696 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 158660 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 139585777 * (int64_t)v; u2 += 80750379 * (int64_t)v;
        v = x[5]; u0 += -16184166 * (int64_t)v; u2 += -75056738 * (int64_t)v;
        v = x[8]; u0 += 175394813 * (int64_t)v; u2 += -316098699 * (int64_t)v;
        v = x[9]; u0 += -131339633 * (int64_t)v; u2 += 123052928 * (int64_t)v;
        v = x[12]; u0 += -293037188 * (int64_t)v; u2 += -49013307 * (int64_t)v;
        v = x[13]; u0 += -67236779 * (int64_t)v; u2 += 87667007 * (int64_t)v;
        v = x[16]; u0 += -643510310 * (int64_t)v; u2 += 219256148 * (int64_t)v;
        v = x[17]; u0 += 3305847 * (int64_t)v; u2 += -161118468 * (int64_t)v;
        v = x[20]; u0 += 111347727 * (int64_t)v; u2 += -68649233 * (int64_t)v;
        v = x[21]; u0 += -8262285 * (int64_t)v; u2 += -26841000 * (int64_t)v;
        v = x[24]; u0 += -13118861 * (int64_t)v; u2 += -2849008 * (int64_t)v;
        v = x[25]; u0 += 51843082 * (int64_t)v; u2 += 328595 * (int64_t)v;
        v = x[28]; u0 += -82027745 * (int64_t)v; u2 += -11526124 * (int64_t)v;
        v = x[29]; u0 += -24651242 * (int64_t)v; u2 += 19977814 * (int64_t)v;
        v = x[32]; u0 += 16724398 * (int64_t)v; u2 += -7165185 * (int64_t)v;
        v = x[33]; u0 += 63846911 * (int64_t)v; u2 += -19641104 * (int64_t)v;
        v = x[36]; u0 += -5048882 * (int64_t)v; u2 += 4001184 * (int64_t)v;
        v = y0; u0 += -46536964 * (int64_t)v; u2 += 19447233 * (int64_t)v;
        v = y2; u0 += 3486943 * (int64_t)v; u2 += -6148889 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 166696 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 158660 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 139585777 * (int64_t)v; u3 += 80750379 * (int64_t)v;
        v = x[7]; u1 += -16184166 * (int64_t)v; u3 += -75056738 * (int64_t)v;
        v = x[10]; u1 += 175394813 * (int64_t)v; u3 += -316098699 * (int64_t)v;
        v = x[11]; u1 += -131339633 * (int64_t)v; u3 += 123052928 * (int64_t)v;
        v = x[14]; u1 += -293037188 * (int64_t)v; u3 += -49013307 * (int64_t)v;
        v = x[15]; u1 += -67236779 * (int64_t)v; u3 += 87667007 * (int64_t)v;
        v = x[18]; u1 += -643510310 * (int64_t)v; u3 += 219256148 * (int64_t)v;
        v = x[19]; u1 += 3305847 * (int64_t)v; u3 += -161118468 * (int64_t)v;
        v = x[22]; u1 += 111347727 * (int64_t)v; u3 += -68649233 * (int64_t)v;
        v = x[23]; u1 += -8262285 * (int64_t)v; u3 += -26841000 * (int64_t)v;
        v = x[26]; u1 += -13118861 * (int64_t)v; u3 += -2849008 * (int64_t)v;
        v = x[27]; u1 += 51843082 * (int64_t)v; u3 += 328595 * (int64_t)v;
        v = x[30]; u1 += -82027745 * (int64_t)v; u3 += -11526124 * (int64_t)v;
        v = x[31]; u1 += -24651242 * (int64_t)v; u3 += 19977814 * (int64_t)v;
        v = x[34]; u1 += 16724398 * (int64_t)v; u3 += -7165185 * (int64_t)v;
        v = x[35]; u1 += 63846911 * (int64_t)v; u3 += -19641104 * (int64_t)v;
        v = x[37]; u1 += -5048882 * (int64_t)v; u3 += 4001184 * (int64_t)v;
        v = y1; u1 += -46536964 * (int64_t)v; u3 += 19447233 * (int64_t)v;
        v = y3; u1 += 3486943 * (int64_t)v; u3 += -6148889 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1516207 * (int64_t)x0 + 51559137 * (int64_t)y0 - 30001728 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2448302 * (int64_t)x1 - 89255143 * (int64_t)y0 - 137010612 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1516207 * (int64_t)x2 + 51559137 * (int64_t)y1 - 30001728 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2448302 * (int64_t)x3 - 89255143 * (int64_t)y1 - 137010612 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-81299875 * (int64_t)x4 + 332675293 * (int64_t)x5 + 10225174 * (int64_t)y0 - 5267074 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-332675293 * (int64_t)x4 - 81299875 * (int64_t)x5 - 14522492 * (int64_t)y0 + 619441 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-81299875 * (int64_t)x6 + 332675293 * (int64_t)x7 + 10225174 * (int64_t)y1 - 5267074 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-332675293 * (int64_t)x6 - 81299875 * (int64_t)x7 - 14522492 * (int64_t)y1 + 619441 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149489631 * (int64_t)x8 + 503820743 * (int64_t)x9 - 8810958 * (int64_t)y0 + 5534975 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503820743 * (int64_t)x8 - 149489631 * (int64_t)x9 + 7230217 * (int64_t)y0 - 5267857 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149489631 * (int64_t)x10 + 503820743 * (int64_t)x11 - 8810958 * (int64_t)y1 + 5534975 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503820743 * (int64_t)x10 - 149489631 * (int64_t)x11 + 7230217 * (int64_t)y1 - 5267857 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(759997405 * (int64_t)x12 + 549770197 * (int64_t)x13 + 71603400 * (int64_t)y0 - 13731934 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-549770197 * (int64_t)x12 + 759997405 * (int64_t)x13 - 80358103 * (int64_t)y0 - 38841784 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(759997405 * (int64_t)x14 + 549770197 * (int64_t)x15 + 71603400 * (int64_t)y1 - 13731934 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-549770197 * (int64_t)x14 + 759997405 * (int64_t)x15 - 80358103 * (int64_t)y1 - 38841784 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(618860052 * (int64_t)x16 + 793959084 * (int64_t)x17 - 24648407 * (int64_t)y0 + 8626335 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-793959084 * (int64_t)x16 + 618860052 * (int64_t)x17 - 27682065 * (int64_t)y0 + 50169412 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(618860052 * (int64_t)x18 + 793959084 * (int64_t)x19 - 24648407 * (int64_t)y1 + 8626335 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-793959084 * (int64_t)x18 + 618860052 * (int64_t)x19 - 27682065 * (int64_t)y1 + 50169412 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(377723650 * (int64_t)x20 + 826318412 * (int64_t)x21 + 1683404 * (int64_t)y0 - 208273246 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-826318412 * (int64_t)x20 + 377723650 * (int64_t)x21 - 33071207 * (int64_t)y0 + 27819588 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(377723650 * (int64_t)x22 + 826318412 * (int64_t)x23 + 1683404 * (int64_t)y1 - 208273246 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-826318412 * (int64_t)x22 + 377723650 * (int64_t)x23 - 33071207 * (int64_t)y1 + 27819588 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(194217511 * (int64_t)x24 + 1362277943 * (int64_t)x25 - 2632918 * (int64_t)y0 - 49357039 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-681138972 * (int64_t)x24 + 388435022 * (int64_t)x25 + 535298441 * (int64_t)y0 + 154102830 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(194217511 * (int64_t)x26 + 1362277943 * (int64_t)x27 - 2632918 * (int64_t)y1 - 49357039 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-681138972 * (int64_t)x26 + 388435022 * (int64_t)x27 + 535298441 * (int64_t)y1 + 154102830 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(127062667 * (int64_t)x28 + 961837595 * (int64_t)x29 + 14644123 * (int64_t)y0 + 101406959 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-961837595 * (int64_t)x28 + 127062667 * (int64_t)x29 - 33340239 * (int64_t)y0 - 47134992 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(127062667 * (int64_t)x30 + 961837595 * (int64_t)x31 + 14644123 * (int64_t)y1 + 101406959 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-961837595 * (int64_t)x30 + 127062667 * (int64_t)x31 - 33340239 * (int64_t)y1 - 47134992 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-496651932 * (int64_t)x32 + 1392789854 * (int64_t)x33 - 164495213 * (int64_t)y0 - 50013403 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-348197463 * (int64_t)x32 - 496651932 * (int64_t)x33 - 405934273 * (int64_t)y0 + 762065595 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-496651932 * (int64_t)x34 + 1392789854 * (int64_t)x35 - 164495213 * (int64_t)y1 - 50013403 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-348197463 * (int64_t)x34 - 496651932 * (int64_t)x35 - 405934273 * (int64_t)y1 + 762065595 * (int64_t)y3, 31);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142321287 * (int64_t)x36 + 1665174 * (int64_t)y0 - 2271433 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142321287 * (int64_t)x37 + 1665174 * (int64_t)y1 - 2271433 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 645318418 * (int64_t)e[0] + 1052276635 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], -594903027 * (int64_t)e[0] - 939868019 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 645318418 * (int64_t)e[1] + 1052276635 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], -594903027 * (int64_t)e[1] - 939868019 * (int64_t)e[3], 19);
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
        {1136999576, 0, 790026167, 0, 108727603, 0, 5133324, 0},
        {-1447737185, 0, -272130352, 0, -84046591, 0, 54328378, 0},
        {0, 1136999576, 0, 790026168, 0, 108727603, 0, 5133324},
        {0, -1447737185, 0, -272130352, 0, -84046591, 0, 54328378},
        {-1165879823, 0, -70960615, 0, 583185, 0, -197845, 0},
        {-1292625934, 0, 528959835, 0, 3843343, 0, -1199911, 0},
        {0, -1165879823, 0, -70960615, 0, 583185, 0, -197845},
        {0, -1292625934, 0, 528959835, 0, 3843343, 0, -1199911},
        {1176700197, 0, -907052356, 0, 1462859, 0, -452656, 0},
        {717926826, 0, -443367502, 0, 2384496, 0, -742229, 0},
        {0, 1176700197, 0, -907052356, 0, 1462859, 0, -452656},
        {0, 717926826, 0, -443367502, 0, 2384496, 0, -742229},
        {-903770358, 0, -1095937799, 0, 2018990, 0, -620503, 0},
        {-1452328429, 0, -102483427, 0, -5197240, 0, 1618354, 0},
        {0, -903770358, 0, -1095937799, 0, 2018990, 0, -620503},
        {0, -1452328429, 0, -102483427, 0, -5197240, 0, 1618354},
        {-671616667, 0, 898061063, 0, 723272, 0, -225706, 0},
        {523934881, 0, 1307793033, 0, -3713314, 0, 1153996, 0},
        {0, -671616667, 0, 898061063, 0, 723272, 0, -225706},
        {0, 523934881, 0, 1307793033, 0, -3713314, 0, 1153996},
        {-214985182, 0, -897229881, 0, -1751198, 0, 549077, 0},
        {-141635627, 0, 1412223478, 0, 2877442, 0, -892151, 0},
        {0, -214985182, 0, -897229881, 0, -1751198, 0, 549077},
        {0, -141635627, 0, 1412223478, 0, 2877442, 0, -892151},
        {1170131878, 0, 380882055, 0, -103214483, 0, 32179015, 0},
        {906381915, 0, 294392636, 0, 6665247, 0, -2083609, 0},
        {0, 1170131878, 0, 380882055, 0, -103214483, 0, 32179015},
        {0, 906381915, 0, 294392636, 0, 6665247, 0, -2083609},
        {-194293393, 0, 958289229, 0, 11501609, 0, -3592793, 0},
        {-400845913, 0, -1341681423, 0, 2318531, 0, -727473, 0},
        {0, -194293393, 0, 958289229, 0, 11501609, 0, -3592793},
        {0, -400845913, 0, -1341681423, 0, 2318531, 0, -727473},
        {-565586522, 0, 533366322, 0, 710964, 0, -223474, 0},
        {-322795261, 0, 1182234128, 0, 19910282, 0, -6192592, 0},
        {0, -565586522, 0, 533366322, 0, 710964, 0, -223474},
        {0, -322795261, 0, 1182234128, 0, 19910282, 0, -6192592},
        {540220979, 0, -1187334700, 0, -23797558, 0, 7389637, 0},
        {0, 540220979, 0, -1187334700, 0, -23797558, 0, 7389637},
    };
    static const int16_t shift[38] = {
        26, 26, 26, 26, 35, 35, 35, 35, 37, 35, 37, 35, 34, 33, 34, 33, 34, 36, 34, 36, 33, 33, 33, 33, 33, 32, 33, 32, 35, 34, 35, 34, 32, 32, 32, 32, 41, 41};
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
