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
static const float paper_tool_f32_output_guard = 0x1.cd4e42p23f;

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
        float u0 = 0x1.16b5c4p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.0ab764p0f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += -0x1.d3bb3ep6f * v; u2 += 0x1.73998ep8f * v;
        v = x[5]; u0 += 0x1.eda1fap8f * v; u2 += 0x1.c5b93cp8f * v;
        v = x[8]; u0 += 0x1.353374p9f * v; u2 += -0x1.1e5638p10f * v;
        v = x[9]; u0 += 0x1.04a660p10f * v; u2 += -0x1.f6c662p11f * v;
        v = x[12]; u0 += 0x1.cc1446p8f * v; u2 += -0x1.097d42p10f * v;
        v = x[13]; u0 += -0x1.badbc4p10f * v; u2 += -0x1.f62610p8f * v;
        v = x[16]; u0 += 0x1.8283dap7f * v; u2 += 0x1.f52548p10f * v;
        v = x[17]; u0 += -0x1.1d76a8p12f * v; u2 += 0x1.2f589ap11f * v;
        v = x[20]; u0 += -0x1.5d29e4p7f * v; u2 += 0x1.6951c8p9f * v;
        v = x[21]; u0 += 0x1.a3a31ep10f * v; u2 += -0x1.0e1e02p10f * v;
        v = x[24]; u0 += -0x1.4939dap8f * v; u2 += 0x1.27b22cp4f * v;
        v = x[25]; u0 += -0x1.53fdbap7f * v; u2 += -0x1.a11a36p6f * v;
        v = x[28]; u0 += 0x1.69cc78p7f * v; u2 += -0x1.7add24p7f * v;
        v = x[29]; u0 += -0x1.d5eb04p8f * v; u2 += -0x1.dfe744p6f * v;
        v = x[32]; u0 += -0x1.e21acap8f * v; u2 += 0x1.b8cce8p6f * v;
        v = x[33]; u0 += 0x1.595288p8f * v; u2 += -0x1.25adc6p6f * v;
        v = x[36]; u0 += -0x1.d13314p4f * v; u2 += 0x1.70a790p5f * v;
        v = y0; u0 += -0x1.00464ap20f * v; u2 += 0x1.d7cfecp19f * v;
        v = y2; u0 += 0x1.cd6adcp15f * v; u2 += -0x1.b6aaf6p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.16b5c4p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.0ab764p0f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += -0x1.d3bb3ep6f * v; u3 += 0x1.73998ep8f * v;
        v = x[7]; u1 += 0x1.eda1fap8f * v; u3 += 0x1.c5b93cp8f * v;
        v = x[10]; u1 += 0x1.353374p9f * v; u3 += -0x1.1e5638p10f * v;
        v = x[11]; u1 += 0x1.04a660p10f * v; u3 += -0x1.f6c662p11f * v;
        v = x[14]; u1 += 0x1.cc1446p8f * v; u3 += -0x1.097d42p10f * v;
        v = x[15]; u1 += -0x1.badbc4p10f * v; u3 += -0x1.f62610p8f * v;
        v = x[18]; u1 += 0x1.8283dap7f * v; u3 += 0x1.f52548p10f * v;
        v = x[19]; u1 += -0x1.1d76a8p12f * v; u3 += 0x1.2f589ap11f * v;
        v = x[22]; u1 += -0x1.5d29e4p7f * v; u3 += 0x1.6951c8p9f * v;
        v = x[23]; u1 += 0x1.a3a31ep10f * v; u3 += -0x1.0e1e02p10f * v;
        v = x[26]; u1 += -0x1.4939dap8f * v; u3 += 0x1.27b22cp4f * v;
        v = x[27]; u1 += -0x1.53fdbap7f * v; u3 += -0x1.a11a36p6f * v;
        v = x[30]; u1 += 0x1.69cc78p7f * v; u3 += -0x1.7add24p7f * v;
        v = x[31]; u1 += -0x1.d5eb04p8f * v; u3 += -0x1.dfe744p6f * v;
        v = x[34]; u1 += -0x1.e21acap8f * v; u3 += 0x1.b8cce8p6f * v;
        v = x[35]; u1 += 0x1.595288p8f * v; u3 += -0x1.25adc6p6f * v;
        v = x[37]; u1 += -0x1.d13314p4f * v; u3 += 0x1.70a790p5f * v;
        v = y1; u1 += -0x1.00464ap20f * v; u3 += 0x1.d7cfecp19f * v;
        v = y3; u1 += 0x1.cd6adcp15f * v; u3 += -0x1.b6aaf6p17f * v;
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
        x[0] = -0x1.aa8588p-10f * x0 + 0x1.f8dcb4p7f * y0 - 0x1.a595aep6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.0ff960p-9f * x1 - 0x1.4e75d2p8f * y0 - 0x1.9f2e24p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.aa8588p-10f * x2 + 0x1.f8dcb4p7f * y1 - 0x1.a595aep6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.0ff960p-9f * x3 - 0x1.4e75d2p8f * y1 - 0x1.9f2e24p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.626356p-4f * x4 + 0x1.3b9732p-2f * x5 + 0x1.01c7a0p7f * y0 + 0x1.8d5beap2f * y2
            + x4;
        x[5] = -0x1.3b9732p-2f * x4 - 0x1.626356p-4f * x5 + 0x1.074e28p6f * y0 - 0x1.2a6b34p5f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.626356p-4f * x6 + 0x1.3b9732p-2f * x7 + 0x1.01c7a0p7f * y1 + 0x1.8d5beap2f * y3
            + x6;
        x[7] = -0x1.3b9732p-2f * x6 - 0x1.626356p-4f * x7 + 0x1.074e28p6f * y1 - 0x1.2a6b34p5f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1f7f42p-3f * x8 + 0x1.e09f74p-2f * x9 - 0x1.ef6646p4f * y0 + 0x1.caf384p3f * y2
            + x8;
        x[9] = -0x1.e09f74p-2f * x8 - 0x1.1f7f42p-3f * x9 - 0x1.ccdea4p4f * y0 + 0x1.5b1e00p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1f7f42p-3f * x10 + 0x1.e09f74p-2f * x11 - 0x1.ef6646p4f * y1 + 0x1.caf384p3f * y3
            + x10;
        x[11] = -0x1.e09f74p-2f * x10 - 0x1.1f7f42p-3f * x11 - 0x1.ccdea4p4f * y1 + 0x1.5b1e00p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6eab3ep-1f * x12 + 0x1.023e2ap-1f * x13 + 0x1.4eb9f0p8f * y0 + 0x1.b28916p6f * y2;
        x[13] = -0x1.023e2ap-1f * x12 + 0x1.6eab3ep-1f * x13 + 0x1.7d8cdep7f * y0 - 0x1.2422f2p6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6eab3ep-1f * x14 + 0x1.023e2ap-1f * x15 + 0x1.4eb9f0p8f * y1 + 0x1.b28916p6f * y3;
        x[15] = -0x1.023e2ap-1f * x14 + 0x1.6eab3ep-1f * x15 + 0x1.7d8cdep7f * y1 - 0x1.2422f2p6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.212486p-1f * x16 + 0x1.7acdbap-1f * x17 + 0x1.a12544p6f * y0 - 0x1.588d56p7f * y2;
        x[17] = -0x1.7acdbap-1f * x16 + 0x1.212486p-1f * x17 - 0x1.76fd8ap6f * y0 + 0x1.12acdap5f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.212486p-1f * x18 + 0x1.7acdbap-1f * x19 + 0x1.a12544p6f * y1 - 0x1.588d56p7f * y3;
        x[19] = -0x1.7acdbap-1f * x18 + 0x1.212486p-1f * x19 - 0x1.76fd8ap6f * y1 + 0x1.12acdap5f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.728624p-2f * x20 + 0x1.84a2d6p-1f * x21 + 0x1.0ee5b6p7f * y0 - 0x1.023cbep6f * y2;
        x[21] = -0x1.84a2d6p-1f * x20 + 0x1.728624p-2f * x21 + 0x1.236908p4f * y0 - 0x1.994832p8f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.728624p-2f * x22 + 0x1.84a2d6p-1f * x23 + 0x1.0ee5b6p7f * y1 - 0x1.023cbep6f * y3;
        x[23] = -0x1.84a2d6p-1f * x22 + 0x1.728624p-2f * x23 + 0x1.236908p4f * y1 - 0x1.994832p8f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.48dc2ap-3f * x24 + 0x1.523436p-1f * x25 - 0x1.1cb4e6p10f * y0 - 0x1.28b33ep7f * y2;
        x[25] = -0x1.523436p-1f * x24 + 0x1.48dc2ap-3f * x25 + 0x1.0dca3ep6f * y0 - 0x1.95d3aep7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.48dc2ap-3f * x26 + 0x1.523436p-1f * x27 - 0x1.1cb4e6p10f * y1 - 0x1.28b33ep7f * y3;
        x[27] = -0x1.523436p-1f * x26 + 0x1.48dc2ap-3f * x27 + 0x1.0dca3ep6f * y1 - 0x1.95d3aep7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.e298bap-4f * x28 + 0x1.c7b1e8p-1f * x29 + 0x1.69b4eap3f * y0 + 0x1.b77dcap7f * y2;
        x[29] = -0x1.c7b1e8p-1f * x28 + 0x1.e298bap-4f * x29 + 0x1.47935ap6f * y0 + 0x1.5b94e8p8f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.e298bap-4f * x30 + 0x1.c7b1e8p-1f * x31 + 0x1.69b4eap3f * y1 + 0x1.b77dcap7f * y3;
        x[31] = -0x1.c7b1e8p-1f * x30 + 0x1.e298bap-4f * x31 + 0x1.47935ap6f * y1 + 0x1.5b94e8p8f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.32af1cp-2f * x32 + 0x1.709802p-2f * x33 + 0x1.a37fccp9f * y0 - 0x1.8a33e8p10f * y2;
        x[33] = -0x1.709802p-2f * x32 - 0x1.32af1cp-2f * x33 - 0x1.897c0ap8f * y0 - 0x1.fd55dcp7f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.32af1cp-2f * x34 + 0x1.709802p-2f * x35 + 0x1.a37fccp9f * y1 - 0x1.8a33e8p10f * y3;
        x[35] = -0x1.709802p-2f * x34 - 0x1.32af1cp-2f * x35 - 0x1.897c0ap8f * y1 - 0x1.fd55dcp7f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.febf62p-1f * x36 + 0x1.89e506p1f * y0 - 0x1.0bfa00p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.febf62p-1f * x37 + 0x1.89e506p1f * y1 - 0x1.0bfa00p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.afa724p-5f * e[0];
        x[0] += 0x1.10fe98p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.973bd2p-5f * e[0];
        x[1] += -0x1.f48744p-5f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.afa724p-5f * e[1];
        x[2] += 0x1.10fe98p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.973bd2p-5f * e[1];
        x[3] += -0x1.f48744p-5f * e[3];
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
        {0x1.52079ep15f, 0.0f, 0x1.36c850p14f, 0.0f, 0x1.bf2e7ep-2f, 0.0f, 0x1.89ac84p-6f, 0.0f},
        {-0x1.f701f8p15f, 0.0f, -0x1.4fb02ep11f, 0.0f, -0x1.4b6df4p-2f, 0.0f, 0x1.13af52p-2f, 0.0f},
        {0.0f, 0x1.52079ep15f, 0.0f, 0x1.36c850p14f, 0.0f, 0x1.bf2e7ep-2f, 0.0f, 0x1.89ac84p-6f},
        {0.0f, -0x1.f701f8p15f, 0.0f, -0x1.4fb02ep11f, 0.0f, -0x1.4b6df4p-2f, 0.0f, 0x1.13af52p-2f},
        {0x1.13b752p8f, 0.0f, -0x1.ab24cap6f, 0.0f, -0x1.cd7e5cp-13f, 0.0f, 0x1.488ea8p-14f, 0.0f},
        {-0x1.5452cap8f, 0.0f, -0x1.9e8be8p5f, 0.0f, -0x1.d6858ep-15f, 0.0f, 0x1.4a8706p-16f, 0.0f},
        {0.0f, 0x1.13b752p8f, 0.0f, -0x1.ab24cap6f, 0.0f, -0x1.cd7e5cp-13f, 0.0f, 0x1.488ea8p-14f},
        {0.0f, -0x1.5452cap8f, 0.0f, -0x1.9e8be8p5f, 0.0f, -0x1.d6858ep-15f, 0.0f, 0x1.4a8706p-16f},
        {-0x1.34c54ap6f, -0.0f, 0x1.961224p5f, 0.0f, -0x1.4518ecp-16f, -0.0f, 0x1.ce4490p-18f, 0.0f},
        {0x1.5cfe76p5f, 0.0f, -0x1.ea489ap3f, 0.0f, -0x1.46cdeap-21f, 0.0f, 0x1.de35e6p-23f, 0.0f},
        {0.0f, -0x1.34c54ap6f, 0.0f, 0x1.961224p5f, 0.0f, -0x1.4518ecp-16f, 0.0f, 0x1.ce4490p-18f},
        {0.0f, 0x1.5cfe76p5f, 0.0f, -0x1.ea489ap3f, 0.0f, -0x1.46cdeap-21f, 0.0f, 0x1.de35e6p-23f},
        {0x1.2c5d5ep9f, 0.0f, -0x1.145cf0p4f, 0.0f, 0x1.b86672p-13f, 0.0f, -0x1.3911dcp-14f, 0.0f},
        {-0x1.538532p8f, 0.0f, -0x1.c1e3c2p7f, 0.0f, 0x1.4444b2p-16f, 0.0f, -0x1.c8577cp-18f, 0.0f},
        {0.0f, 0x1.2c5d5ep9f, 0.0f, -0x1.145cf0p4f, 0.0f, 0x1.b86672p-13f, 0.0f, -0x1.3911dcp-14f},
        {0.0f, -0x1.538532p8f, 0.0f, -0x1.c1e3c2p7f, 0.0f, 0x1.4444b2p-16f, 0.0f, -0x1.c8577cp-18f},
        {-0x1.de7252p4f, 0.0f, -0x1.0cd8ccp6f, 0.0f, 0x1.355500p-16f, 0.0f, -0x1.b78f54p-18f, 0.0f},
        {-0x1.3d4138p7f, 0.0f, 0x1.827d56p7f, 0.0f, 0x1.5c2fc4p-17f, 0.0f, -0x1.f01ecep-19f, 0.0f},
        {0.0f, -0x1.de7252p4f, 0.0f, -0x1.0cd8ccp6f, 0.0f, 0x1.355500p-16f, 0.0f, -0x1.b78f54p-18f},
        {0.0f, -0x1.3d4138p7f, 0.0f, 0x1.827d56p7f, 0.0f, 0x1.5c2fc4p-17f, 0.0f, -0x1.f01ecep-19f},
        {0x1.6f4ac2p6f, 0.0f, -0x1.6647d6p8f, 0.0f, -0x1.29b2bcp-14f, 0.0f, 0x1.a6999ep-16f, 0.0f},
        {-0x1.628c9ep6f, 0.0f, -0x1.aec634p7f, 0.0f, 0x1.dcc5f0p-16f, 0.0f, -0x1.516554p-17f, 0.0f},
        {0.0f, 0x1.6f4ac2p6f, 0.0f, -0x1.6647d6p8f, 0.0f, -0x1.29b2bcp-14f, 0.0f, 0x1.a6999ep-16f},
        {0.0f, -0x1.628c9ep6f, 0.0f, -0x1.aec634p7f, 0.0f, 0x1.dcc5f0p-16f, 0.0f, -0x1.516554p-17f},
        {-0x1.8c3f4ap9f, 0.0f, -0x1.c45f4cp7f, 0.0f, 0x1.7133c6p-15f, 0.0f, -0x1.0590f0p-16f, 0.0f},
        {0x1.0c885cp9f, 0.0f, -0x1.ed369cp5f, 0.0f, -0x1.3f1f1ep-10f, 0.0f, 0x1.c6a00ep-12f, 0.0f},
        {0.0f, -0x1.8c3f4ap9f, 0.0f, -0x1.c45f4cp7f, 0.0f, 0x1.7133c6p-15f, 0.0f, -0x1.0590f0p-16f},
        {0.0f, 0x1.0c885cp9f, 0.0f, -0x1.ed369cp5f, 0.0f, -0x1.3f1f1ep-10f, 0.0f, 0x1.c6a00ep-12f},
        {0x1.b30caep5f, 0.0f, 0x1.40f900p8f, 0.0f, 0x1.67b2fap-17f, 0.0f, -0x1.f50ee6p-19f, 0.0f},
        {0x1.1a2b3ep5f, 0.0f, 0x1.18de70p6f, 0.0f, -0x1.f60fd6p-16f, 0.0f, 0x1.62c3b8p-17f, 0.0f},
        {0.0f, 0x1.b30caep5f, 0.0f, 0x1.40f900p8f, 0.0f, 0x1.67b2fap-17f, 0.0f, -0x1.f50ee6p-19f},
        {0.0f, 0x1.1a2b3ep5f, 0.0f, 0x1.18de70p6f, 0.0f, -0x1.f60fd6p-16f, 0.0f, 0x1.62c3b8p-17f},
        {0x1.782e2ap8f, 0.0f, -0x1.26ebe8p10f, 0.0f, -0x1.0ce838p-10f, 0.0f, 0x1.7e7734p-12f, 0.0f},
        {-0x1.98807ap8f, 0.0f, 0x1.04ccd0p7f, 0.0f, 0x1.1f59d8p-12f, 0.0f, -0x1.98f034p-14f, 0.0f},
        {0.0f, 0x1.782e2ap8f, 0.0f, -0x1.26ebe8p10f, 0.0f, -0x1.0ce838p-10f, 0.0f, 0x1.7e7734p-12f},
        {0.0f, -0x1.98807ap8f, 0.0f, 0x1.04ccd0p7f, 0.0f, 0x1.1f59d8p-12f, 0.0f, -0x1.98f034p-14f},
        {0x1.2cbfdep0f, 0.0f, -0x1.0f0874p1f, 0.0f, -0x1.571400p-19f, -0.0f, 0x1.e6d37ep-21f, 0.0f},
        {0.0f, 0x1.2cbfdep0f, 0.0f, -0x1.0f0874p1f, 0.0f, -0x1.571400p-19f, 0.0f, 0x1.e6d37ep-21f},
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
/* Over the test vectors Q31 stays within 5.224e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 95133 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 91039 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += -10217749 * (int64_t)v; u2 += 32470888 * (int64_t)v;
        v = x[5]; u0 += 43134286 * (int64_t)v; u2 += 39646970 * (int64_t)v;
        v = x[8]; u0 += 54036791 * (int64_t)v; u2 += -100081961 * (int64_t)v;
        v = x[9]; u0 += 91103749 * (int64_t)v; u2 += -351465153 * (int64_t)v;
        v = x[12]; u0 += 40202333 * (int64_t)v; u2 += -92795234 * (int64_t)v;
        v = x[13]; u0 += -154790252 * (int64_t)v; u2 += -43878420 * (int64_t)v;
        v = x[16]; u0 += 16887100 * (int64_t)v; u2 += 175163092 * (int64_t)v;
        v = x[17]; u0 += -399106910 * (int64_t)v; u2 += 212054300 * (int64_t)v;
        v = x[20]; u0 += -15255192 * (int64_t)v; u2 += 63145150 * (int64_t)v;
        v = x[21]; u0 += 146673820 * (int64_t)v; u2 += -94412811 * (int64_t)v;
        v = x[24]; u0 += -28768206 * (int64_t)v; u2 += 1614894 * (int64_t)v;
        v = x[25]; u0 += -14854438 * (int64_t)v; u2 += -9111741 * (int64_t)v;
        v = x[28]; u0 += 15807227 * (int64_t)v; u2 += -16552813 * (int64_t)v;
        v = x[29]; u0 += -41062065 * (int64_t)v; u2 += -10483649 * (int64_t)v;
        v = x[32]; u0 += -42126945 * (int64_t)v; u2 += 9629432 * (int64_t)v;
        v = x[33]; u0 += 30174729 * (int64_t)v; u2 += -6415511 * (int64_t)v;
        v = x[36]; u0 += -2540610 * (int64_t)v; u2 += 4026691 * (int64_t)v;
        v = y0; u0 += -23297958 * (int64_t)v; u2 += 21446257 * (int64_t)v;
        v = y2; u0 += 1310860 * (int64_t)v; u2 += -4984919 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 18);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 95133 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 91039 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += -10217749 * (int64_t)v; u3 += 32470888 * (int64_t)v;
        v = x[7]; u1 += 43134286 * (int64_t)v; u3 += 39646970 * (int64_t)v;
        v = x[10]; u1 += 54036791 * (int64_t)v; u3 += -100081961 * (int64_t)v;
        v = x[11]; u1 += 91103749 * (int64_t)v; u3 += -351465153 * (int64_t)v;
        v = x[14]; u1 += 40202333 * (int64_t)v; u3 += -92795234 * (int64_t)v;
        v = x[15]; u1 += -154790252 * (int64_t)v; u3 += -43878420 * (int64_t)v;
        v = x[18]; u1 += 16887100 * (int64_t)v; u3 += 175163092 * (int64_t)v;
        v = x[19]; u1 += -399106910 * (int64_t)v; u3 += 212054300 * (int64_t)v;
        v = x[22]; u1 += -15255192 * (int64_t)v; u3 += 63145150 * (int64_t)v;
        v = x[23]; u1 += 146673820 * (int64_t)v; u3 += -94412811 * (int64_t)v;
        v = x[26]; u1 += -28768206 * (int64_t)v; u3 += 1614894 * (int64_t)v;
        v = x[27]; u1 += -14854438 * (int64_t)v; u3 += -9111741 * (int64_t)v;
        v = x[30]; u1 += 15807227 * (int64_t)v; u3 += -16552813 * (int64_t)v;
        v = x[31]; u1 += -41062065 * (int64_t)v; u3 += -10483649 * (int64_t)v;
        v = x[34]; u1 += -42126945 * (int64_t)v; u3 += 9629432 * (int64_t)v;
        v = x[35]; u1 += 30174729 * (int64_t)v; u3 += -6415511 * (int64_t)v;
        v = x[37]; u1 += -2540610 * (int64_t)v; u3 += 4026691 * (int64_t)v;
        v = y1; u1 += -23297958 * (int64_t)v; u3 += 21446257 * (int64_t)v;
        v = y3; u1 += 1310860 * (int64_t)v; u3 += -4984919 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1747032 * (int64_t)x0 + 68845629 * (int64_t)y0 - 28744742 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2228012 * (int64_t)x1 - 91217485 * (int64_t)y0 - 113232284 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1747032 * (int64_t)x2 + 68845629 * (int64_t)y1 - 28744742 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2228012 * (int64_t)x3 - 91217485 * (int64_t)y1 - 113232284 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-92900693 * (int64_t)x4 + 330920726 * (int64_t)x5 + 35152196 * (int64_t)y0 + 1693311 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-330920726 * (int64_t)x4 - 92900693 * (int64_t)x5 + 17952841 * (int64_t)y0 - 10173484 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-92900693 * (int64_t)x6 + 330920726 * (int64_t)x7 + 35152196 * (int64_t)y1 + 1693311 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-330920726 * (int64_t)x6 - 92900693 * (int64_t)x7 + 17952841 * (int64_t)y1 - 10173484 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-150731282 * (int64_t)x8 + 503969595 * (int64_t)x9 - 8444407 * (int64_t)y0 + 3911561 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503969595 * (int64_t)x8 - 150731282 * (int64_t)x9 - 7855824 * (int64_t)y0 + 5916839 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-150731282 * (int64_t)x10 + 503969595 * (int64_t)x11 - 8444407 * (int64_t)y1 + 3911561 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503969595 * (int64_t)x10 - 150731282 * (int64_t)x11 - 7855824 * (int64_t)y1 + 5916839 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(768960478 * (int64_t)x12 + 541574448 * (int64_t)x13 + 91290054 * (int64_t)y0 + 29627762 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-541574448 * (int64_t)x12 + 768960478 * (int64_t)x13 + 52030181 * (int64_t)y0 - 19918628 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(768960478 * (int64_t)x14 + 541574448 * (int64_t)x15 + 91290054 * (int64_t)y1 + 29627762 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-541574448 * (int64_t)x14 + 768960478 * (int64_t)x15 + 52030181 * (int64_t)y1 - 19918628 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(606376121 * (int64_t)x16 + 794408770 * (int64_t)x17 + 28442071 * (int64_t)y0 - 46984918 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-794408770 * (int64_t)x16 + 606376121 * (int64_t)x17 - 25567822 * (int64_t)y0 + 9364035 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(606376121 * (int64_t)x18 + 794408770 * (int64_t)x19 + 28442071 * (int64_t)y1 - 46984918 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-794408770 * (int64_t)x18 + 606376121 * (int64_t)x19 - 25567822 * (int64_t)y1 + 9364035 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(388522571 * (int64_t)x20 + 815028944 * (int64_t)x21 + 36940968 * (int64_t)y0 - 17607289 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-815028944 * (int64_t)x20 + 388522571 * (int64_t)x21 + 4967278 * (int64_t)y0 - 111623654 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(388522571 * (int64_t)x22 + 815028944 * (int64_t)x23 + 36940968 * (int64_t)y1 - 17607289 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-815028944 * (int64_t)x22 + 388522571 * (int64_t)x23 + 4967278 * (int64_t)y1 - 111623654 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(172417356 * (int64_t)x24 + 709265083 * (int64_t)x25 - 310592651 * (int64_t)y0 - 40459583 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-1418530166 * (int64_t)x24 + 344834712 * (int64_t)x25 + 36789972 * (int64_t)y0 - 110681339 * (int64_t)y2, 31);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(172417356 * (int64_t)x26 + 709265083 * (int64_t)x27 - 310592651 * (int64_t)y1 - 40459583 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-1418530166 * (int64_t)x26 + 344834712 * (int64_t)x27 + 36789972 * (int64_t)y1 - 110681339 * (int64_t)y3, 31);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(126509797 * (int64_t)x28 + 955661561 * (int64_t)x29 + 3082763 * (int64_t)y0 + 59931334 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-955661561 * (int64_t)x28 + 126509797 * (int64_t)x29 + 22334957 * (int64_t)y0 + 94796097 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(126509797 * (int64_t)x30 + 955661561 * (int64_t)x31 + 3082763 * (int64_t)y1 + 59931334 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-955661561 * (int64_t)x30 + 126509797 * (int64_t)x31 + 22334957 * (int64_t)y1 + 94796097 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-321581491 * (int64_t)x32 + 386498584 * (int64_t)x33 + 228820399 * (int64_t)y0 - 430044342 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-772997169 * (int64_t)x32 - 643162982 * (int64_t)x33 - 214630399 * (int64_t)y0 - 138911258 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-321581491 * (int64_t)x34 + 386498584 * (int64_t)x35 + 228820399 * (int64_t)y1 - 430044342 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-772997169 * (int64_t)x34 - 643162982 * (int64_t)x35 - 214630399 * (int64_t)y1 - 138911258 * (int64_t)y3, 31);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142230605 * (int64_t)x36 + 1678548 * (int64_t)y0 - 2283918 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142230605 * (int64_t)x37 + 1678548 * (int64_t)y1 - 2283918 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 678931305 * (int64_t)e[0] + 858766448 * (int64_t)e[2], 19);
        x[1] = paper_tool_q31_correct(x[1], -640523202 * (int64_t)e[0] - 787263094 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 678931305 * (int64_t)e[1] + 858766448 * (int64_t)e[3], 19);
        x[3] = paper_tool_q31_correct(x[3], -640523202 * (int64_t)e[1] - 787263094 * (int64_t)e[3], 19);
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
        {737528016, 0, 339039338, 0, 87919483, 0, 4837465, 0},
        {-1097483978, 0, -45776193, 0, -65161693, 0, 54201845, 0},
        {0, 737528016, 0, 339039339, 0, 87919483, 0, 4837465},
        {0, -1097483978, 0, -45776193, 0, -65161693, 0, 54201845},
        {1203138641, 0, -465980332, 0, -11341667, 0, 4037312, 0},
        {-1485064753, 0, -226118895, 0, -2890885, 0, 1015380, 0},
        {0, 1203138641, 0, -465980332, 0, -11341667, 0, 4037312},
        {0, -1485064753, 0, -226118895, 0, -2890885, 0, 1015380},
        {-673689231, 0, 442991526, 0, -1997398, 0, 710043, 0},
        {1522900512, 0, -534861006, 0, -250986, 0, 91816, 0},
        {0, -673689231, 0, 442991526, 0, -1997398, 0, 710043},
        {0, 1522900512, 0, -534861006, 0, -250986, 0, 91816},
        {1310697523, 0, -37686302, 0, 5411637, 0, -1923501, 0},
        {-740780115, 0, -490794414, 0, 498076, 0, -175235, 0},
        {0, 1310697523, 0, -37686302, 0, 5411637, 0, -1923501},
        {0, -740780115, 0, -490794414, 0, 498076, 0, -175235},
        {-521947721, 0, -1173163499, 0, 3801072, 0, -1350328, 0},
        {-692200189, 0, 843259768, 0, 534815, 0, -190510, 0},
        {0, -521947721, 0, -1173163499, 0, 3801072, 0, -1350328},
        {0, -692200189, 0, 843259768, 0, 534815, 0, -190510},
        {400686819, 0, -1563424347, 0, -3658115, 0, 1298227, 0},
        {-386785515, 0, -939881889, 0, 1464647, 0, -518240, 0},
        {0, 400686819, 0, -1563424347, 0, -3658115, 0, 1298227},
        {0, -386785515, 0, -939881889, 0, 1464647, 0, -518240},
        {-864549407, 0, -246751360, 0, 567095, 0, -200883, 0},
        {1171792428, 0, -134514281, 0, -31370925, 0, 11172869, 0},
        {0, -864549407, 0, -246751360, 0, 567095, 0, -200883},
        {0, 1171792428, 0, -134514281, 0, -31370925, 0, 11172869},
        {237302490, 0, 1400624139, 0, 552498, 0, -192406, 0},
        {615648385, 0, 1225623902, 0, -6169336, 0, 2179673, 0},
        {0, 237302490, 0, 1400624139, 0, 552498, 0, -192406},
        {0, 615648385, 0, 1225623902, 0, -6169336, 0, 2179673},
        {410383271, 0, -1286945099, 0, -13217322, 0, 4699738, 0},
        {-891287107, 0, 284512417, 0, 7061937, 0, -2512517, 0},
        {0, 410383271, 0, -1286945099, 0, -13217322, 0, 4699738},
        {0, -891287107, 0, 284512417, 0, 7061937, 0, -2512517},
        {656188288, 0, -1182703148, 0, -16862976, 0, 5982120, 0},
        {0, 656188288, 0, -1182703148, 0, -16862976, 0, 5982120},
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
