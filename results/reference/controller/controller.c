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
static const float paper_tool_f32_output_guard = 0x1.927238p23f;

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
        float u0 = -0x1.5f6276p7f * v, u2 = 0x1.2babdep6f * v;
        v = x[1]; u0 += -0x1.0ad98ap4f * v; u2 += 0x1.36da0cp8f * v;
        v = x[4]; u0 += -0x1.4da3bap8f * v; u2 += -0x1.05282cp7f * v;
        v = x[5]; u0 += 0x1.cb5bc6p6f * v; u2 += 0x1.8ae29ap9f * v;
        v = x[8]; u0 += -0x1.e17be2p8f * v; u2 += 0x1.91c164p10f * v;
        v = x[9]; u0 += 0x1.f7aab8p10f * v; u2 += -0x1.4f35acp10f * v;
        v = x[12]; u0 += -0x1.fc3100p9f * v; u2 += -0x1.31a656p10f * v;
        v = x[13]; u0 += -0x1.c54daap8f * v; u2 += 0x1.ff5730p8f * v;
        v = x[16]; u0 += 0x1.667cf8p10f * v; u2 += -0x1.a8f808p9f * v;
        v = x[17]; u0 += -0x1.1f7242p9f * v; u2 += 0x1.9a8018p10f * v;
        v = x[20]; u0 += 0x1.90128ep10f * v; u2 += -0x1.314cdap11f * v;
        v = x[21]; u0 += 0x1.8958e0p8f * v; u2 += -0x1.22a174p9f * v;
        v = x[24]; u0 += 0x1.4bb5acp9f * v; u2 += 0x1.79fe34p5f * v;
        v = x[25]; u0 += 0x1.9e4532p9f * v; u2 += -0x1.0f2f12p9f * v;
        v = x[28]; u0 += 0x1.8b3bc4p6f * v; u2 += -0x1.a29a3ep7f * v;
        v = x[29]; u0 += 0x1.bca918p7f * v; u2 += -0x1.252528p8f * v;
        v = x[32]; u0 += -0x1.56a83ep6f * v; u2 += -0x1.5cf552p4f * v;
        v = x[33]; u0 += -0x1.86a140p4f * v; u2 += 0x1.279c6cp5f * v;
        v = y0; u0 += -0x1.22d248p18f * v; u2 += 0x1.76163cp18f * v;
        v = y2; u0 += 0x1.40f5bap17f * v; u2 += -0x1.e6df32p18f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = -0x1.5f6276p7f * v, u3 = 0x1.2babdep6f * v;
        v = x[3]; u1 += -0x1.0ad98ap4f * v; u3 += 0x1.36da0cp8f * v;
        v = x[6]; u1 += -0x1.4da3bap8f * v; u3 += -0x1.05282cp7f * v;
        v = x[7]; u1 += 0x1.cb5bc6p6f * v; u3 += 0x1.8ae29ap9f * v;
        v = x[10]; u1 += -0x1.e17be2p8f * v; u3 += 0x1.91c164p10f * v;
        v = x[11]; u1 += 0x1.f7aab8p10f * v; u3 += -0x1.4f35acp10f * v;
        v = x[14]; u1 += -0x1.fc3100p9f * v; u3 += -0x1.31a656p10f * v;
        v = x[15]; u1 += -0x1.c54daap8f * v; u3 += 0x1.ff5730p8f * v;
        v = x[18]; u1 += 0x1.667cf8p10f * v; u3 += -0x1.a8f808p9f * v;
        v = x[19]; u1 += -0x1.1f7242p9f * v; u3 += 0x1.9a8018p10f * v;
        v = x[22]; u1 += 0x1.90128ep10f * v; u3 += -0x1.314cdap11f * v;
        v = x[23]; u1 += 0x1.8958e0p8f * v; u3 += -0x1.22a174p9f * v;
        v = x[26]; u1 += 0x1.4bb5acp9f * v; u3 += 0x1.79fe34p5f * v;
        v = x[27]; u1 += 0x1.9e4532p9f * v; u3 += -0x1.0f2f12p9f * v;
        v = x[30]; u1 += 0x1.8b3bc4p6f * v; u3 += -0x1.a29a3ep7f * v;
        v = x[31]; u1 += 0x1.bca918p7f * v; u3 += -0x1.252528p8f * v;
        v = x[34]; u1 += -0x1.56a83ep6f * v; u3 += -0x1.5cf552p4f * v;
        v = x[35]; u1 += -0x1.86a140p4f * v; u3 += 0x1.279c6cp5f * v;
        v = y1; u1 += -0x1.22d248p18f * v; u3 += 0x1.76163cp18f * v;
        v = y3; u1 += 0x1.40f5bap17f * v; u3 += -0x1.e6df32p18f * v;
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
        x[0] = -0x1.0847fap-8f * x0 + 0x1.3f3a26p3f * y0 + 0x1.803c3cp1f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.e032dep-9f * x1 + 0x1.927b02p0f * y0 - 0x1.379286p3f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.0847fap-8f * x2 + 0x1.3f3a26p3f * y1 + 0x1.803c3cp1f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.e032dep-9f * x3 + 0x1.927b02p0f * y1 - 0x1.379286p3f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.1841a0p-4f * x4 + 0x1.35e776p-2f * x5 - 0x1.b80040p4f * y0 + 0x1.e3d996p4f * y2
            + x4;
        x[5] = -0x1.35e776p-2f * x4 - 0x1.1841a0p-4f * x5 + 0x1.30047ap6f * y0 - 0x1.43612ep4f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.1841a0p-4f * x6 + 0x1.35e776p-2f * x7 - 0x1.b80040p4f * y1 + 0x1.e3d996p4f * y3
            + x6;
        x[7] = -0x1.35e776p-2f * x6 - 0x1.1841a0p-4f * x7 + 0x1.30047ap6f * y1 - 0x1.43612ep4f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1c8706p-3f * x8 + 0x1.c796acp-2f * x9 + 0x1.be2efcp5f * y0 + 0x1.e24c76p2f * y2
            + x8;
        x[9] = -0x1.c796acp-2f * x8 - 0x1.1c8706p-3f * x9 - 0x1.b0f3a4p5f * y0 + 0x1.ae7652p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1c8706p-3f * x10 + 0x1.c796acp-2f * x11 + 0x1.be2efcp5f * y1 + 0x1.e24c76p2f * y3
            + x10;
        x[11] = -0x1.c796acp-2f * x10 - 0x1.1c8706p-3f * x11 - 0x1.b0f3a4p5f * y1 + 0x1.ae7652p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = -0x1.e1469cp-3f * x12 + 0x1.ebd00ep-2f * x13 + 0x1.901e78p7f * y0 + 0x1.dec7cep5f * y2
            + x12;
        x[13] = -0x1.ebd00ep-2f * x12 - 0x1.e1469cp-3f * x13 - 0x1.f92e08p6f * y0 - 0x1.24b948p7f * y2
            + x13;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = -0x1.e1469cp-3f * x14 + 0x1.ebd00ep-2f * x15 + 0x1.901e78p7f * y1 + 0x1.dec7cep5f * y3
            + x14;
        x[15] = -0x1.ebd00ep-2f * x14 - 0x1.e1469cp-3f * x15 - 0x1.f92e08p6f * y1 - 0x1.24b948p7f * y3
            + x15;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.344840p-1f * x16 + 0x1.6f474cp-1f * x17 + 0x1.4400c4p6f * y0 - 0x1.d099eap6f * y2;
        x[17] = -0x1.6f474cp-1f * x16 + 0x1.344840p-1f * x17 - 0x1.b36bfep3f * y0 - 0x1.8a1b60p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.344840p-1f * x18 + 0x1.6f474cp-1f * x19 + 0x1.4400c4p6f * y1 - 0x1.d099eap6f * y3;
        x[19] = -0x1.6f474cp-1f * x18 + 0x1.344840p-1f * x19 - 0x1.b36bfep3f * y1 - 0x1.8a1b60p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.451cc4p-2f * x20 + 0x1.a694fap-1f * x21 - 0x1.3799c6p6f * y0 - 0x1.806758p7f * y2;
        x[21] = -0x1.a694fap-1f * x20 + 0x1.451cc4p-2f * x21 + 0x1.bb663ep7f * y0 - 0x1.93f39ap7f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.451cc4p-2f * x22 + 0x1.a694fap-1f * x23 - 0x1.3799c6p6f * y1 - 0x1.806758p7f * y3;
        x[23] = -0x1.a694fap-1f * x22 + 0x1.451cc4p-2f * x23 + 0x1.bb663ep7f * y1 - 0x1.93f39ap7f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.ded4dap-4f * x24 + 0x1.e29978p-1f * x25 - 0x1.bab70ep5f * y0 - 0x1.56eebcp7f * y2;
        x[25] = -0x1.e29978p-1f * x24 + 0x1.ded4dap-4f * x25 + 0x1.fbdd40p4f * y0 - 0x1.156ffep6f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.ded4dap-4f * x26 + 0x1.e29978p-1f * x27 - 0x1.bab70ep5f * y1 - 0x1.56eebcp7f * y3;
        x[27] = -0x1.e29978p-1f * x26 + 0x1.ded4dap-4f * x27 + 0x1.fbdd40p4f * y1 - 0x1.156ffep6f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = -0x1.47d834p-4f * x28 + 0x1.6ead8cp-1f * x29 - 0x1.606386p7f * y0 + 0x1.571324p9f * y2;
        x[29] = -0x1.6ead8cp-3f * x28 - 0x1.47d834p-4f * x29 - 0x1.504090p9f * y0 + 0x1.644be6p10f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = -0x1.47d834p-4f * x30 + 0x1.6ead8cp-1f * x31 - 0x1.606386p7f * y1 + 0x1.571324p9f * y3;
        x[31] = -0x1.6ead8cp-3f * x30 - 0x1.47d834p-4f * x31 - 0x1.504090p9f * y1 + 0x1.644be6p10f * y3;
    }
    {
        const float x32 = x[32];
        x[32] = -0x1.af4e72p-2f * x32 - 0x1.f077b4p9f * y0 - 0x1.c9cefap7f * y2;
    }
    {
        const float x33 = x[33];
        x[33] = -0x1.feb0d6p-1f * x33 + 0x1.0a7a40p2f * y0 - 0x1.515e1ep2f * y2;
    }
    {
        const float x34 = x[34];
        x[34] = -0x1.af4e72p-2f * x34 - 0x1.f077b4p9f * y1 - 0x1.c9cefap7f * y3;
    }
    {
        const float x35 = x[35];
        x[35] = -0x1.feb0d6p-1f * x35 + 0x1.0a7a40p2f * y1 - 0x1.515e1ep2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += -0x1.07ec1ep-10f * e[0];
        x[0] += -0x1.cc7352p-15f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += 0x1.fdd4b4p-13f * e[0];
        x[1] += 0x1.2b9f94p-11f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += -0x1.07ec1ep-10f * e[1];
        x[2] += -0x1.cc7352p-15f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += 0x1.fdd4b4p-13f * e[1];
        x[3] += 0x1.2b9f94p-11f * e[3];
        x[3] = paper_tool_f32_clamp(x[3], 1.0f);
    }

}

void paper_tool_f32_step(paper_tool_f32 *c, const float y_m[4], float u_a[4])
{
    paper_tool_f32_output(c, y_m, u_a);
    paper_tool_f32_update(c);
}

void paper_tool_f32_hand_over(paper_tool_f32 *c, const float y_m[4], const float u_a[4])
{
    static const float map[36][8] = {
        {-0x1.07faeep9f, 0.0f, -0x1.17732cp7f, 0.0f, -0x1.7f4cccp-8f, 0.0f, -0x1.488710p-12f, 0.0f},
        {-0x1.51c49ap6f, 0.0f, 0x1.c8f5cap8f, 0.0f, 0x1.70ea3cp-10f, 0.0f, 0x1.b21a7cp-9f, 0.0f},
        {0.0f, -0x1.07faeep9f, 0.0f, -0x1.17732cp7f, 0.0f, -0x1.7f4cccp-8f, 0.0f, -0x1.488710p-12f},
        {0.0f, -0x1.51c49ap6f, 0.0f, 0x1.c8f5cap8f, 0.0f, 0x1.70ea3cp-10f, 0.0f, 0x1.b21a7cp-9f},
        {0x1.b5f046p7f, 0.0f, -0x1.43be68p5f, 0.0f, 0x1.e29030p-22f, 0.0f, 0x1.c9b20ep-20f, 0.0f},
        {0x1.19e2dcp7f, 0.0f, -0x1.b83e26p6f, 0.0f, 0x1.832f5ep-22f, 0.0f, -0x1.9140dap-21f, 0.0f},
        {0.0f, 0x1.b5f046p7f, 0.0f, -0x1.43be68p5f, 0.0f, 0x1.e29030p-22f, 0.0f, 0x1.c9b20ep-20f},
        {0.0f, 0x1.19e2dcp7f, 0.0f, -0x1.b83e26p6f, 0.0f, 0x1.832f5ep-22f, 0.0f, -0x1.9140dap-21f},
        {-0x1.2b8370p6f, 0.0f, 0x1.de5ad0p5f, 0.0f, 0x1.b5bbbap-22f, 0.0f, -0x1.8a8ddcp-23f, 0.0f},
        {-0x1.29a2e4p7f, 0.0f, 0x1.ab5ef4p0f, 0.0f, -0x1.e3a34ap-25f, 0.0f, -0x1.ceea28p-24f, 0.0f},
        {0.0f, -0x1.2b8370p6f, 0.0f, 0x1.de5ad0p5f, 0.0f, 0x1.b5bbbap-22f, 0.0f, -0x1.8a8ddcp-23f},
        {0.0f, -0x1.29a2e4p7f, 0.0f, 0x1.ab5ef4p0f, 0.0f, -0x1.e3a34ap-25f, 0.0f, -0x1.ceea28p-24f},
        {-0x1.7b9c72p5f, 0.0f, -0x1.871686p7f, 0.0f, 0x1.5ff3dap-20f, 0.0f, 0x1.2c9d4cp-20f, 0.0f},
        {-0x1.b7986ep8f, 0.0f, -0x1.b95eb0p7f, 0.0f, 0x1.533566p-21f, 0.0f, 0x1.bcbadap-24f, 0.0f},
        {0.0f, -0x1.7b9c72p5f, 0.0f, -0x1.871686p7f, 0.0f, 0x1.5ff3dap-20f, 0.0f, 0x1.2c9d4cp-20f},
        {0.0f, -0x1.b7986ep8f, 0.0f, -0x1.b95eb0p7f, 0.0f, 0x1.533566p-21f, 0.0f, 0x1.bcbadap-24f},
        {0x1.0a0052p5f, 0.0f, -0x1.16a3d2p8f, 0.0f, -0x1.5a7c32p-23f, 0.0f, 0x1.31c58ap-23f, 0.0f},
        {-0x1.7a689ep6f, 0.0f, 0x1.defdeep2f, 0.0f, -0x1.db5928p-23f, 0.0f, 0x1.e7842ep-23f, 0.0f},
        {0.0f, 0x1.0a0052p5f, 0.0f, -0x1.16a3d2p8f, 0.0f, -0x1.5a7c32p-23f, 0.0f, 0x1.31c58ap-23f},
        {0.0f, -0x1.7a689ep6f, 0.0f, 0x1.defdeep2f, 0.0f, -0x1.db5928p-23f, 0.0f, 0x1.e7842ep-23f},
        {0x1.c501c4p6f, 0.0f, -0x1.03cfb6p8f, 0.0f, 0x1.b88f5cp-25f, 0.0f, -0x1.1bebd8p-23f, 0.0f},
        {0x1.777f1ap7f, 0.0f, 0x1.26414cp4f, 0.0f, -0x1.8cfbc0p-23f, 0.0f, 0x1.5a962ep-22f, 0.0f},
        {0.0f, 0x1.c501c4p6f, 0.0f, -0x1.03cfb6p8f, 0.0f, 0x1.b88f5cp-25f, 0.0f, -0x1.1bebd8p-23f},
        {0.0f, 0x1.777f1ap7f, 0.0f, 0x1.26414cp4f, 0.0f, -0x1.8cfbc0p-23f, 0.0f, 0x1.5a962ep-22f},
        {-0x1.6a780cp3f, 0.0f, -0x1.0429c8p7f, 0.0f, -0x1.5d3318p-25f, 0.0f, -0x1.30241cp-23f, 0.0f},
        {0x1.7f9ab2p5f, 0.0f, 0x1.e1bc7cp5f, 0.0f, -0x1.5d9618p-23f, 0.0f, 0x1.5802a6p-24f, 0.0f},
        {0.0f, -0x1.6a780cp3f, 0.0f, -0x1.0429c8p7f, 0.0f, -0x1.5d3318p-25f, 0.0f, -0x1.30241cp-23f},
        {0.0f, 0x1.7f9ab2p5f, 0.0f, 0x1.e1bc7cp5f, 0.0f, -0x1.5d9618p-23f, 0.0f, 0x1.5802a6p-24f},
        {-0x1.04cf82p9f, 0.0f, 0x1.557e10p10f, 0.0f, -0x1.7df25ep-21f, 0.0f, 0x1.8e4a3ap-18f, 0.0f},
        {-0x1.0f3c7ep9f, 0.0f, 0x1.137d0ep10f, 0.0f, -0x1.1c9c50p-18f, 0.0f, 0x1.3a316cp-17f, 0.0f},
        {0.0f, -0x1.04cf82p9f, 0.0f, 0x1.557e10p10f, 0.0f, -0x1.7df25ep-21f, 0.0f, 0x1.8e4a3ap-18f},
        {0.0f, -0x1.0f3c7ep9f, 0.0f, 0x1.137d0ep10f, 0.0f, -0x1.1c9c50p-18f, 0.0f, 0x1.3a316cp-17f},
        {-0x1.5be9d6p9f, 0.0f, -0x1.365b0ep7f, 0.0f, 0x1.3631c6p-17f, 0.0f, 0x1.713296p-18f, 0.0f},
        {0x1.0e68e4p1f, 0.0f, -0x1.5783cep1f, 0.0f, 0x1.0ce732p-26f, 0.0f, -0x1.bb3a88p-25f, 0.0f},
        {0.0f, -0x1.5be9d6p9f, 0.0f, -0x1.365b0ep7f, 0.0f, 0x1.3631c6p-17f, 0.0f, 0x1.713296p-18f},
        {0.0f, 0x1.0e68e4p1f, 0.0f, -0x1.5783cep1f, 0.0f, 0x1.0ce732p-26f, 0.0f, -0x1.bb3a88p-25f},
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
/* Over the test vectors Q31 stays within 3.609e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = -30704456 * (int64_t)v, u2 = 6546420 * (int64_t)v;
        v = x[1]; u0 += -2914711 * (int64_t)v; u2 += 27162639 * (int64_t)v;
        v = x[4]; u0 += -58307741 * (int64_t)v; u2 += -11410120 * (int64_t)v;
        v = x[5]; u0 += 20069679 * (int64_t)v; u2 += 69011182 * (int64_t)v;
        v = x[8]; u0 += -84145411 * (int64_t)v; u2 += 140423696 * (int64_t)v;
        v = x[9]; u0 += 352088667 * (int64_t)v; u2 += -117164265 * (int64_t)v;
        v = x[12]; u0 += -177625776 * (int64_t)v; u2 += -106832336 * (int64_t)v;
        v = x[13]; u0 += -79220506 * (int64_t)v; u2 += 44681622 * (int64_t)v;
        v = x[16]; u0 += 250601382 * (int64_t)v; u2 += -74268695 * (int64_t)v;
        v = x[17]; u0 += -100469767 * (int64_t)v; u2 += 143480280 * (int64_t)v;
        v = x[20]; u0 += 279670924 * (int64_t)v; u2 += -213420313 * (int64_t)v;
        v = x[21]; u0 += 68742399 * (int64_t)v; u2 += -50791393 * (int64_t)v;
        v = x[24]; u0 += 115940933 * (int64_t)v; u2 += 4128691 * (int64_t)v;
        v = x[25]; u0 += 144797965 * (int64_t)v; u2 += -47392817 * (int64_t)v;
        v = x[28]; u0 += 17268014 * (int64_t)v; u2 += -18289022 * (int64_t)v;
        v = x[29]; u0 += 38855029 * (int64_t)v; u2 += -25615412 * (int64_t)v;
        v = x[32]; u0 += -14970921 * (int64_t)v; u2 += -1905778 * (int64_t)v;
        v = x[33]; u0 += -4266720 * (int64_t)v; u2 += 3228861 * (int64_t)v;
        v = y0; u0 += -13219308 * (int64_t)v; u2 += 8502072 * (int64_t)v;
        v = y2; u0 += 7294626 * (int64_t)v; u2 += -11065397 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = -30704456 * (int64_t)v, u3 = 6546420 * (int64_t)v;
        v = x[3]; u1 += -2914711 * (int64_t)v; u3 += 27162639 * (int64_t)v;
        v = x[6]; u1 += -58307741 * (int64_t)v; u3 += -11410120 * (int64_t)v;
        v = x[7]; u1 += 20069679 * (int64_t)v; u3 += 69011182 * (int64_t)v;
        v = x[10]; u1 += -84145411 * (int64_t)v; u3 += 140423696 * (int64_t)v;
        v = x[11]; u1 += 352088667 * (int64_t)v; u3 += -117164265 * (int64_t)v;
        v = x[14]; u1 += -177625776 * (int64_t)v; u3 += -106832336 * (int64_t)v;
        v = x[15]; u1 += -79220506 * (int64_t)v; u3 += 44681622 * (int64_t)v;
        v = x[18]; u1 += 250601382 * (int64_t)v; u3 += -74268695 * (int64_t)v;
        v = x[19]; u1 += -100469767 * (int64_t)v; u3 += 143480280 * (int64_t)v;
        v = x[22]; u1 += 279670924 * (int64_t)v; u3 += -213420313 * (int64_t)v;
        v = x[23]; u1 += 68742399 * (int64_t)v; u3 += -50791393 * (int64_t)v;
        v = x[26]; u1 += 115940933 * (int64_t)v; u3 += 4128691 * (int64_t)v;
        v = x[27]; u1 += 144797965 * (int64_t)v; u3 += -47392817 * (int64_t)v;
        v = x[30]; u1 += 17268014 * (int64_t)v; u3 += -18289022 * (int64_t)v;
        v = x[31]; u1 += 38855029 * (int64_t)v; u3 += -25615412 * (int64_t)v;
        v = x[34]; u1 += -14970921 * (int64_t)v; u3 += -1905778 * (int64_t)v;
        v = x[35]; u1 += -4266720 * (int64_t)v; u3 += 3228861 * (int64_t)v;
        v = y1; u1 += -13219308 * (int64_t)v; u3 += 8502072 * (int64_t)v;
        v = y3; u1 += 7294626 * (int64_t)v; u3 += -11065397 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-4329983 * (int64_t)x0 + 2720717 * (int64_t)y0 + 818693 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-3933788 * (int64_t)x1 + 428784 * (int64_t)y0 - 2655477 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-4329983 * (int64_t)x2 + 2720717 * (int64_t)y1 + 818693 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-3933788 * (int64_t)x3 + 428784 * (int64_t)y1 - 2655477 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-73467519 * (int64_t)x4 + 324958050 * (int64_t)x5 - 7500104 * (int64_t)y0 + 8247538 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-324958050 * (int64_t)x4 - 73467519 * (int64_t)x5 + 20728705 * (int64_t)y0 - 5512216 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-73467519 * (int64_t)x6 + 324958050 * (int64_t)x7 - 7500104 * (int64_t)y1 + 8247538 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-324958050 * (int64_t)x6 - 73467519 * (int64_t)x7 + 20728705 * (int64_t)y1 - 5512216 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149174314 * (int64_t)x8 + 477719217 * (int64_t)x9 + 15210978 * (int64_t)y0 + 2055274 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-477719217 * (int64_t)x8 - 149174314 * (int64_t)x9 - 14759888 * (int64_t)y0 + 7337508 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149174314 * (int64_t)x10 + 477719217 * (int64_t)x11 + 15210978 * (int64_t)y1 + 2055274 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-477719217 * (int64_t)x10 - 149174314 * (int64_t)x11 - 14759888 * (int64_t)y1 + 7337508 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(-252327135 * (int64_t)x12 + 515703002 * (int64_t)x13 + 54562314 * (int64_t)y0 + 16322250 * (int64_t)y2
            + 1073741824 * (int64_t)x12, 30);
        x[13] = paper_tool_q31_round(-515703002 * (int64_t)x12 - 252327135 * (int64_t)x13 - 34444476 * (int64_t)y0 - 39917337 * (int64_t)y2
            + 1073741824 * (int64_t)x13, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(-252327135 * (int64_t)x14 + 515703002 * (int64_t)x15 + 54562314 * (int64_t)y1 + 16322250 * (int64_t)y3
            + 1073741824 * (int64_t)x14, 30);
        x[15] = paper_tool_q31_round(-515703002 * (int64_t)x14 - 252327135 * (int64_t)x15 - 34444476 * (int64_t)y1 - 39917337 * (int64_t)y3
            + 1073741824 * (int64_t)x15, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(646514711 * (int64_t)x16 + 770238868 * (int64_t)x17 + 22091367 * (int64_t)y0 - 31677722 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-770238868 * (int64_t)x16 + 646514711 * (int64_t)x17 - 3711025 * (int64_t)y0 - 53742476 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(646514711 * (int64_t)x18 + 770238868 * (int64_t)x19 + 22091367 * (int64_t)y1 - 31677722 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-770238868 * (int64_t)x18 + 646514711 * (int64_t)x19 - 3711025 * (int64_t)y1 - 53742476 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(340905036 * (int64_t)x20 + 886218550 * (int64_t)x21 - 21245746 * (int64_t)y0 - 52419290 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-886218550 * (int64_t)x20 + 340905036 * (int64_t)x21 + 60464251 * (int64_t)y0 - 55084942 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(340905036 * (int64_t)x22 + 886218550 * (int64_t)x23 - 21245746 * (int64_t)y1 - 52419290 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-886218550 * (int64_t)x22 + 340905036 * (int64_t)x23 + 60464251 * (int64_t)y1 - 55084942 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(125522794 * (int64_t)x24 + 1012084500 * (int64_t)x25 - 15092733 * (int64_t)y0 - 46764071 * (int64_t)y2, 30);
        x[25] = paper_tool_q31_round(-1012084500 * (int64_t)x24 + 125522794 * (int64_t)x25 + 8656877 * (int64_t)y0 - 18916409 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(125522794 * (int64_t)x26 + 1012084500 * (int64_t)x27 - 15092733 * (int64_t)y1 - 46764071 * (int64_t)y3, 30);
        x[27] = paper_tool_q31_round(-1012084500 * (int64_t)x26 + 125522794 * (int64_t)x27 + 8656877 * (int64_t)y1 - 18916409 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(-85942480 * (int64_t)x28 + 768979318 * (int64_t)x29 - 48053568 * (int64_t)y0 + 187133854 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-384489659 * (int64_t)x28 - 171884960 * (int64_t)x29 - 366824814 * (int64_t)y0 + 777383133 * (int64_t)y2, 31);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(-85942480 * (int64_t)x30 + 768979318 * (int64_t)x31 - 48053568 * (int64_t)y1 + 187133854 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-384489659 * (int64_t)x30 - 171884960 * (int64_t)x31 - 366824814 * (int64_t)y1 + 777383133 * (int64_t)y3, 31);
    }
    {
        const int32_t x32 = x[32];
        x[32] = paper_tool_q31_round(-904515116 * (int64_t)x32 - 541607252 * (int64_t)y0 - 124858308 * (int64_t)y2, 31);
    }
    {
        const int32_t x33 = x[33];
        x[33] = paper_tool_q31_round(-2141992291 * (int64_t)x33 + 2271142 * (int64_t)y0 - 2875326 * (int64_t)y2, 31);
    }
    {
        const int32_t x34 = x[34];
        x[34] = paper_tool_q31_round(-904515116 * (int64_t)x34 - 541607252 * (int64_t)y1 - 124858308 * (int64_t)y3, 31);
    }
    {
        const int32_t x35 = x[35];
        x[35] = paper_tool_q31_round(-2141992291 * (int64_t)x35 + 2271142 * (int64_t)y1 - 2875326 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], -1660455779 * (int64_t)e[0] - 90528244 * (int64_t)e[2], 26);
        x[1] = paper_tool_q31_correct(x[1], 400947320 * (int64_t)e[0] + 942533552 * (int64_t)e[2], 26);
        x[2] = paper_tool_q31_correct(x[2], -1660455779 * (int64_t)e[1] - 90528244 * (int64_t)e[3], 26);
        x[3] = paper_tool_q31_correct(x[3], 400947320 * (int64_t)e[1] + 942533552 * (int64_t)e[3], 26);
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
        {-1151926908, 0, -304857953, 0, -150719687, 0, -8073894, 0},
        {-184239207, 0, 997015382, 0, 36265818, 0, 85348214, 0},
        {0, -1151926908, 0, -304857953, 0, -150719687, 0, -8073894},
        {0, -184239207, 0, 997015382, 0, 36265818, 0, 85348214},
        {955513358, 0, -176589559, 0, 23163, 0, 87878, 0},
        {615031481, 0, -480270381, 0, 18585, 0, -38520, 0},
        {0, 955513358, 0, -176589559, 0, 23163, 0, 87878},
        {0, 615031481, 0, -480270381, 0, 18585, 0, -38520},
        {-653491400, 0, 521847556, 0, 42022, 0, -18939, 0},
        {-1298791562, 0, 14569632, 0, -5804, 0, -11110, 0},
        {0, -653491400, 0, 521847556, 0, 42022, 0, -18939},
        {0, -1298791562, 0, 14569632, 0, -5804, 0, -11110},
        {-414125985, 0, -1706585409, 0, 135150, 0, 115436, 0},
        {-959128369, 0, -481499980, 0, 16282, 0, 2668, 0},
        {0, -414125985, 0, -1706585409, 0, 135150, 0, 115436},
        {0, -959128369, 0, -481499980, 0, 16282, 0, 2668},
        {145093260, 0, -1215897396, 0, -8316, 0, 7339, 0},
        {-1651256860, 0, 130635665, 0, -45633, 0, 46802, 0},
        {0, 145093260, 0, -1215897396, 0, -8316, 0, 7339},
        {0, -1651256860, 0, 130635665, 0, -45633, 0, 46802},
        {494195038, 0, -1133735428, 0, 2643, 0, -6814, 0},
        {1638549074, 0, 160504621, 0, -19055, 0, 33272, 0},
        {0, 494195038, 0, -1133735428, 0, 2643, 0, -6814},
        {0, 1638549074, 0, 160504621, 0, -19055, 0, 33272},
        {-98856309, 0, -1135270756, 0, -4190, 0, -14599, 0},
        {836964435, 0, 1051073058, 0, -33560, 0, 16512, 0},
        {0, -98856309, 0, -1135270756, 0, -4190, 0, -14599},
        {0, 836964435, 0, 1051073058, 0, -33560, 0, 16512},
        {-569047861, 0, 1490166041, 0, -9167, 0, 76472, 0},
        {-591795125, 0, 1202145518, 0, -54645, 0, 120650, 0},
        {0, -569047861, 0, 1490166041, 0, -9167, 0, 76472},
        {0, -591795125, 0, 1202145518, 0, -54645, 0, 120650},
        {-1518185136, 0, -338573743, 0, 238229, 0, 141772, 0},
        {589991661, 0, -749495630, 0, 51629, 0, -170200, 0},
        {0, -1518185136, 0, -338573743, 0, 238229, 0, 141772},
        {0, 589991661, 0, -749495630, 0, 51629, 0, -170200},
    };
    static const int16_t shift[36] = {
        33, 33, 33, 33, 34, 34, 34, 34, 35, 35, 35, 35, 35, 33, 35, 33, 34, 36, 34, 36, 34, 35, 34, 35, 35, 36, 35, 36, 32, 32, 32, 32, 33, 40, 33, 40};
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
