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
static const float paper_tool_f32_output_guard = 0x1.bdf8c2p23f;

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
        float u0 = 0x1.113f7cp0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.fd065ep-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a2b6b6p8f * v; u2 += 0x1.0c3b88p9f * v;
        v = x[5]; u0 += 0x1.74e82ep5f * v; u2 += -0x1.79fb48p9f * v;
        v = x[8]; u0 += 0x1.069d4ap10f * v; u2 += -0x1.c857dap11f * v;
        v = x[9]; u0 += -0x1.5a3f5ep9f * v; u2 += 0x1.5e8264p10f * v;
        v = x[12]; u0 += -0x1.bf7616p10f * v; u2 += -0x1.1013dcp9f * v;
        v = x[13]; u0 += -0x1.bd0110p8f * v; u2 += 0x1.142ee4p10f * v;
        v = x[16]; u0 += -0x1.e62abcp11f * v; u2 += 0x1.19a824p11f * v;
        v = x[17]; u0 += 0x1.b64364p5f * v; u2 += -0x1.c080e2p10f * v;
        v = x[20]; u0 += 0x1.b7a296p9f * v; u2 += -0x1.5cb920p9f * v;
        v = x[21]; u0 += 0x1.1723fcp6f * v; u2 += -0x1.e6ba6ap8f * v;
        v = x[24]; u0 += -0x1.46a76cp7f * v; u2 += -0x1.7f015ap6f * v;
        v = x[25]; u0 += 0x1.40e0ccp8f * v; u2 += -0x1.dbb16ap4f * v;
        v = x[28]; u0 += -0x1.d0635ap8f * v; u2 += -0x1.f2c862p6f * v;
        v = x[29]; u0 += -0x1.54c214p7f * v; u2 += 0x1.a80d7ap7f * v;
        v = x[32]; u0 += 0x1.280a3ep7f * v; u2 += -0x1.e87978p5f * v;
        v = x[33]; u0 += 0x1.c1cea4p8f * v; u2 += -0x1.521bacp7f * v;
        v = x[36]; u0 += -0x1.c6ce6ep4f * v; u2 += 0x1.6877bcp5f * v;
        v = y0; u0 += -0x1.038d98p20f * v; u2 += 0x1.cab500p19f * v;
        v = y2; u0 += 0x1.f3e842p15f * v; u2 += -0x1.e8c188p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.113f7cp0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.fd065ep-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a2b6b6p8f * v; u3 += 0x1.0c3b88p9f * v;
        v = x[7]; u1 += 0x1.74e82ep5f * v; u3 += -0x1.79fb48p9f * v;
        v = x[10]; u1 += 0x1.069d4ap10f * v; u3 += -0x1.c857dap11f * v;
        v = x[11]; u1 += -0x1.5a3f5ep9f * v; u3 += 0x1.5e8264p10f * v;
        v = x[14]; u1 += -0x1.bf7616p10f * v; u3 += -0x1.1013dcp9f * v;
        v = x[15]; u1 += -0x1.bd0110p8f * v; u3 += 0x1.142ee4p10f * v;
        v = x[18]; u1 += -0x1.e62abcp11f * v; u3 += 0x1.19a824p11f * v;
        v = x[19]; u1 += 0x1.b64364p5f * v; u3 += -0x1.c080e2p10f * v;
        v = x[22]; u1 += 0x1.b7a296p9f * v; u3 += -0x1.5cb920p9f * v;
        v = x[23]; u1 += 0x1.1723fcp6f * v; u3 += -0x1.e6ba6ap8f * v;
        v = x[26]; u1 += -0x1.46a76cp7f * v; u3 += -0x1.7f015ap6f * v;
        v = x[27]; u1 += 0x1.40e0ccp8f * v; u3 += -0x1.dbb16ap4f * v;
        v = x[30]; u1 += -0x1.d0635ap8f * v; u3 += -0x1.f2c862p6f * v;
        v = x[31]; u1 += -0x1.54c214p7f * v; u3 += 0x1.a80d7ap7f * v;
        v = x[34]; u1 += 0x1.280a3ep7f * v; u3 += -0x1.e87978p5f * v;
        v = x[35]; u1 += 0x1.c1cea4p8f * v; u3 += -0x1.521bacp7f * v;
        v = x[37]; u1 += -0x1.c6ce6ep4f * v; u3 += 0x1.6877bcp5f * v;
        v = y1; u1 += -0x1.038d98p20f * v; u3 += 0x1.cab500p19f * v;
        v = y3; u1 += 0x1.f3e842p15f * v; u3 += -0x1.e8c188p17f * v;
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
        x[0] = -0x1.934dd0p-10f * x0 + 0x1.f416d2p7f * y0 - 0x1.b18202p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.15b0e0p-9f * x1 - 0x1.69c65ep8f * y0 - 0x1.baf3acp8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.934dd0p-10f * x2 + 0x1.f416d2p7f * y1 - 0x1.b18202p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.15b0e0p-9f * x3 - 0x1.69c65ep8f * y1 - 0x1.baf3acp8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.444d3ap-4f * x4 + 0x1.3c29fep-1f * x5 + 0x1.39cfeap6f * y0 - 0x1.3bf3bep5f * y2
            + x4;
        x[5] = -0x1.3c29fep-3f * x4 - 0x1.444d3ap-4f * x5 - 0x1.d9f41cp5f * y0 + 0x1.665eb4p-1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.444d3ap-4f * x6 + 0x1.3c29fep-1f * x7 + 0x1.39cfeap6f * y1 - 0x1.3bf3bep5f * y3
            + x6;
        x[7] = -0x1.3c29fep-3f * x6 - 0x1.444d3ap-4f * x7 - 0x1.d9f41cp5f * y1 + 0x1.665eb4p-1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1c8f50p-3f * x8 + 0x1.e0d830p-2f * x9 - 0x1.117b40p5f * y0 + 0x1.489cd2p4f * y2
            + x8;
        x[9] = -0x1.e0d830p-2f * x8 - 0x1.1c8f50p-3f * x9 + 0x1.d208d4p4f * y0 - 0x1.0f9870p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1c8f50p-3f * x10 + 0x1.e0d830p-2f * x11 - 0x1.117b40p5f * y1 + 0x1.489cd2p4f * y3
            + x10;
        x[11] = -0x1.e0d830p-2f * x10 - 0x1.1c8f50p-3f * x11 + 0x1.d208d4p4f * y1 - 0x1.0f9870p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6c0d02p-1f * x12 + 0x1.012276p-1f * x13 + 0x1.b95808p7f * y0 - 0x1.28360ep6f * y2;
        x[13] = -0x1.012276p-1f * x12 + 0x1.6c0d02p-1f * x13 - 0x1.445cc6p8f * y0 - 0x1.f832b6p6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6c0d02p-1f * x14 + 0x1.012276p-1f * x15 + 0x1.b95808p7f * y1 - 0x1.28360ep6f * y3;
        x[15] = -0x1.012276p-1f * x14 + 0x1.6c0d02p-1f * x15 - 0x1.445cc6p8f * y1 - 0x1.f832b6p6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.23aeaap-1f * x16 + 0x1.7959fep-1f * x17 - 0x1.c1b00cp6f * y0 + 0x1.3c23cep5f * y2;
        x[17] = -0x1.7959fep-1f * x16 + 0x1.23aeaap-1f * x17 - 0x1.abe35cp6f * y0 + 0x1.8a8ea2p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.23aeaap-1f * x18 + 0x1.7959fep-1f * x19 - 0x1.c1b00cp6f * y1 + 0x1.3c23cep5f * y3;
        x[19] = -0x1.7959fep-1f * x18 + 0x1.23aeaap-1f * x19 - 0x1.abe35cp6f * y1 + 0x1.8a8ea2p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6e7b48p-2f * x20 + 0x1.860ae8p-1f * x21 + 0x1.49c7e2p5f * y0 - 0x1.634060p9f * y2;
        x[21] = -0x1.860ae8p-1f * x20 + 0x1.6e7b48p-2f * x21 - 0x1.af59dcp7f * y0 + 0x1.157268p5f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6e7b48p-2f * x22 + 0x1.860ae8p-1f * x23 + 0x1.49c7e2p5f * y1 - 0x1.634060p9f * y3;
        x[23] = -0x1.860ae8p-1f * x22 + 0x1.6e7b48p-2f * x23 - 0x1.af59dcp7f * y1 + 0x1.157268p5f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.596d5ap-3f * x24 + 0x1.4ccca4p-1f * x25 + 0x1.d0aa1cp5f * y0 - 0x1.1ba586p7f * y2;
        x[25] = -0x1.4ccca4p-1f * x24 + 0x1.596d5ap-3f * x25 + 0x1.043024p10f * y0 + 0x1.8d0d5ep7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.596d5ap-3f * x26 + 0x1.4ccca4p-1f * x27 + 0x1.d0aa1cp5f * y1 - 0x1.1ba586p7f * y3;
        x[27] = -0x1.4ccca4p-1f * x26 + 0x1.596d5ap-3f * x27 + 0x1.043024p10f * y1 + 0x1.8d0d5ep7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.eb4578p-4f * x28 + 0x1.c97370p-1f * x29 + 0x1.05ab1cp6f * y0 + 0x1.69eeacp8f * y2;
        x[29] = -0x1.c97370p-1f * x28 + 0x1.eb4578p-4f * x29 - 0x1.39f62cp5f * y0 - 0x1.892544p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.eb4578p-4f * x30 + 0x1.c97370p-1f * x31 + 0x1.05ab1cp6f * y1 + 0x1.69eeacp8f * y3;
        x[31] = -0x1.c97370p-1f * x30 + 0x1.eb4578p-4f * x31 - 0x1.39f62cp5f * y1 - 0x1.892544p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.050c26p-2f * x32 + 0x1.5d9e58p-1f * x33 - 0x1.1595d8p9f * y0 - 0x1.b3cb2cp7f * y2;
        x[33] = -0x1.5d9e58p-3f * x32 - 0x1.050c26p-2f * x33 - 0x1.bd99f8p9f * y0 + 0x1.6f2874p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.050c26p-2f * x34 + 0x1.5d9e58p-1f * x35 - 0x1.1595d8p9f * y1 - 0x1.b3cb2cp7f * y3;
        x[35] = -0x1.5d9e58p-3f * x34 - 0x1.050c26p-2f * x35 - 0x1.bd99f8p9f * y1 + 0x1.6f2874p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fece78p-1f * x36 + 0x1.809c06p1f * y0 - 0x1.06350cp2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fece78p-1f * x37 + 0x1.809c06p1f * y1 - 0x1.06350cp2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.8355f2p-4f * e[0];
        x[0] += 0x1.46a4c6p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.71bfe0p-4f * e[0];
        x[1] += -0x1.2a18f2p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.8355f2p-4f * e[1];
        x[2] += 0x1.46a4c6p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.71bfe0p-4f * e[1];
        x[3] += -0x1.2a18f2p-4f * e[3];
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
        {0x1.99701ep16f, 0.0f, 0x1.3417d2p15f, 0.0f, 0x1.8f2880p-1f, 0.0f, -0x1.52a156p-4f, 0.0f},
        {-0x1.ea4020p16f, 0.0f, -0x1.993148p13f, 0.0f, -0x1.51cfe0p-1f, 0.0f, 0x1.7fe78ap-2f, 0.0f},
        {0.0f, 0x1.99701ep16f, 0.0f, 0x1.3417d2p15f, 0.0f, 0x1.8f2880p-1f, 0.0f, -0x1.52a156p-4f},
        {0.0f, -0x1.ea4020p16f, 0.0f, -0x1.993148p13f, 0.0f, -0x1.51cfe0p-1f, 0.0f, 0x1.7fe78ap-2f},
        {-0x1.2f501ap8f, 0.0f, -0x1.c32ff0p4f, 0.0f, -0x1.aaded8p-16f, 0.0f, 0x1.1948cap-17f, 0.0f},
        {-0x1.3e1fcap7f, 0.0f, 0x1.e64ad8p5f, 0.0f, 0x1.4f3a80p-15f, 0.0f, -0x1.d09d9cp-17f, 0.0f},
        {0.0f, -0x1.2f501ap8f, 0.0f, -0x1.c32ff0p4f, 0.0f, -0x1.aaded8p-16f, 0.0f, 0x1.1948cap-17f},
        {0.0f, -0x1.3e1fcap7f, 0.0f, 0x1.e64ad8p5f, 0.0f, 0x1.4f3a80p-15f, 0.0f, -0x1.d09d9cp-17f},
        {0x1.2b2b00p5f, 0.0f, -0x1.54bad8p4f, 0.0f, 0x1.0eec9cp-20f, 0.0f, -0x1.6c20b8p-22f, 0.0f},
        {0x1.5cee2cp6f, 0.0f, -0x1.8e4ef4p5f, 0.0f, 0x1.6752b2p-16f, 0.0f, -0x1.ef8edcp-18f, 0.0f},
        {0.0f, 0x1.2b2b00p5f, 0.0f, -0x1.54bad8p4f, 0.0f, 0x1.0eec9cp-20f, 0.0f, -0x1.6c20b8p-22f},
        {0.0f, 0x1.5cee2cp6f, 0.0f, -0x1.8e4ef4p5f, 0.0f, 0x1.6752b2p-16f, 0.0f, -0x1.ef8edcp-18f},
        {-0x1.1f7030p8f, 0.0f, -0x1.f640e6p7f, 0.0f, 0x1.95d300p-15f, 0.0f, -0x1.151a9ap-16f, 0.0f},
        {-0x1.4059d2p9f, 0.0f, -0x1.66c35ep-3f, 0.0f, -0x1.9cbad6p-13f, 0.0f, 0x1.1c8b90p-14f, 0.0f},
        {0.0f, -0x1.1f7030p8f, 0.0f, -0x1.f640e6p7f, 0.0f, 0x1.95d300p-15f, 0.0f, -0x1.151a9ap-16f},
        {0.0f, -0x1.4059d2p9f, 0.0f, -0x1.66c35ep-3f, 0.0f, -0x1.9cbad6p-13f, 0.0f, 0x1.1c8b90p-14f},
        {-0x1.5941b8p7f, 0.0f, 0x1.be2742p7f, 0.0f, 0x1.ae3132p-17f, 0.0f, -0x1.29a284p-18f, 0.0f},
        {0x1.79dd08p5f, 0.0f, 0x1.310f96p6f, 0.0f, -0x1.5ce47ep-16f, 0.0f, 0x1.e05cbap-18f, 0.0f},
        {0.0f, -0x1.5941b8p7f, 0.0f, 0x1.be2742p7f, 0.0f, 0x1.ae3132p-17f, 0.0f, -0x1.29a284p-18f},
        {0.0f, 0x1.79dd08p5f, 0.0f, 0x1.310f96p6f, 0.0f, -0x1.5ce47ep-16f, 0.0f, 0x1.e05cbap-18f},
        {-0x1.16791ep7f, 0.0f, -0x1.b0838cp8f, 0.0f, -0x1.a2a7e0p-19f, 0.0f, 0x1.47bc96p-20f, 0.0f},
        {-0x1.31c70ep7f, 0.0f, 0x1.1cdd94p9f, 0.0f, 0x1.dc60c2p-14f, 0.0f, -0x1.47031ap-15f, 0.0f},
        {0.0f, -0x1.16791ep7f, 0.0f, -0x1.b0838cp8f, 0.0f, -0x1.a2a7e0p-19f, 0.0f, 0x1.47bc96p-20f},
        {0.0f, -0x1.31c70ep7f, 0.0f, 0x1.1cdd94p9f, 0.0f, 0x1.dc60c2p-14f, 0.0f, -0x1.47031ap-15f},
        {0x1.9f8364p8f, 0.0f, -0x1.c3b608p1f, 0.0f, -0x1.846e44p-10f, 0.0f, 0x1.0c8accp-11f, 0.0f},
        {0x1.73e354p9f, 0.0f, 0x1.cc56acp7f, 0.0f, 0x1.8aa8d8p-18f, 0.0f, -0x1.327268p-19f, 0.0f},
        {0.0f, 0x1.9f8364p8f, 0.0f, -0x1.c3b608p1f, 0.0f, -0x1.846e44p-10f, 0.0f, 0x1.0c8accp-11f},
        {0.0f, 0x1.73e354p9f, 0.0f, 0x1.cc56acp7f, 0.0f, 0x1.8aa8d8p-18f, 0.0f, -0x1.327268p-19f},
        {0x1.1c6cecp4f, 0.0f, 0x1.6ab4f2p6f, 0.0f, 0x1.774adap-16f, 0.0f, -0x1.071a72p-17f, 0.0f},
        {-0x1.dee5d2p5f, 0.0f, -0x1.3c2d26p8f, 0.0f, -0x1.0516e0p-18f, 0.0f, 0x1.402226p-20f, -0.0f},
        {0.0f, 0x1.1c6cecp4f, 0.0f, 0x1.6ab4f2p6f, 0.0f, 0x1.774adap-16f, 0.0f, -0x1.071a72p-17f},
        {0.0f, -0x1.dee5d2p5f, 0.0f, -0x1.3c2d26p8f, 0.0f, -0x1.0516e0p-18f, 0.0f, 0x1.402226p-20f},
        {-0x1.5fa29ep9f, 0.0f, 0x1.b3bd38p8f, 0.0f, 0x1.c2ecf4p-12f, 0.0f, -0x1.3767bcp-13f, 0.0f},
        {-0x1.8aaf2ep8f, 0.0f, 0x1.1a0d3ap10f, 0.0f, 0x1.59c6d0p-10f, 0.0f, -0x1.dcc308p-12f, 0.0f},
        {0.0f, -0x1.5fa29ep9f, 0.0f, 0x1.b3bd38p8f, 0.0f, 0x1.c2ecf4p-12f, 0.0f, -0x1.3767bcp-13f},
        {0.0f, -0x1.8aaf2ep8f, 0.0f, 0x1.1a0d3ap10f, 0.0f, 0x1.59c6d0p-10f, 0.0f, -0x1.dcc308p-12f},
        {0x1.0d5010p0f, 0.0f, -0x1.0cd554p1f, -0.0f, -0x1.797482p-19f, -0.0f, 0x1.033c42p-20f, 0.0f},
        {0.0f, 0x1.0d5010p0f, 0.0f, -0x1.0cd554p1f, 0.0f, -0x1.797482p-19f, 0.0f, 0x1.033c42p-20f},
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
/* Over the test vectors Q31 stays within 4.998e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 186537 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 173747 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73175524 * (int64_t)v; u2 += 46877035 * (int64_t)v;
        v = x[5]; u0 += 8146277 * (int64_t)v; u2 += -66057064 * (int64_t)v;
        v = x[8]; u0 += 183580786 * (int64_t)v; u2 += -319006996 * (int64_t)v;
        v = x[9]; u0 += -121022288 * (int64_t)v; u2 += 122511897 * (int64_t)v;
        v = x[12]; u0 += -312798104 * (int64_t)v; u2 += -47549005 * (int64_t)v;
        v = x[13]; u0 += -77770112 * (int64_t)v; u2 += 96533011 * (int64_t)v;
        v = x[16]; u0 += -679710620 * (int64_t)v; u2 += 196892369 * (int64_t)v;
        v = x[17]; u0 += 9574007 * (int64_t)v; u2 += -156763321 * (int64_t)v;
        v = x[20]; u0 += 153663608 * (int64_t)v; u2 += -60943786 * (int64_t)v;
        v = x[21]; u0 += 12195837 * (int64_t)v; u2 += -42530958 * (int64_t)v;
        v = x[24]; u0 += -28543461 * (int64_t)v; u2 += -8366878 * (int64_t)v;
        v = x[25]; u0 += 56077517 * (int64_t)v; u2 += -2597918 * (int64_t)v;
        v = x[28]; u0 += -81157700 * (int64_t)v; u2 += -10896076 * (int64_t)v;
        v = x[29]; u0 += -29775898 * (int64_t)v; u2 += 18527143 * (int64_t)v;
        v = x[32]; u0 += 25868371 * (int64_t)v; u2 += -5335444 * (int64_t)v;
        v = x[33]; u0 += 78609501 * (int64_t)v; u2 += -14772168 * (int64_t)v;
        v = x[36]; u0 += -4967698 * (int64_t)v; u2 += 3937269 * (int64_t)v;
        v = y0; u0 += -47192018 * (int64_t)v; u2 += 20850561 * (int64_t)v;
        v = y2; u0 += 2840415 * (int64_t)v; u2 += -5554110 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 186537 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 173747 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73175524 * (int64_t)v; u3 += 46877035 * (int64_t)v;
        v = x[7]; u1 += 8146277 * (int64_t)v; u3 += -66057064 * (int64_t)v;
        v = x[10]; u1 += 183580786 * (int64_t)v; u3 += -319006996 * (int64_t)v;
        v = x[11]; u1 += -121022288 * (int64_t)v; u3 += 122511897 * (int64_t)v;
        v = x[14]; u1 += -312798104 * (int64_t)v; u3 += -47549005 * (int64_t)v;
        v = x[15]; u1 += -77770112 * (int64_t)v; u3 += 96533011 * (int64_t)v;
        v = x[18]; u1 += -679710620 * (int64_t)v; u3 += 196892369 * (int64_t)v;
        v = x[19]; u1 += 9574007 * (int64_t)v; u3 += -156763321 * (int64_t)v;
        v = x[22]; u1 += 153663608 * (int64_t)v; u3 += -60943786 * (int64_t)v;
        v = x[23]; u1 += 12195837 * (int64_t)v; u3 += -42530958 * (int64_t)v;
        v = x[26]; u1 += -28543461 * (int64_t)v; u3 += -8366878 * (int64_t)v;
        v = x[27]; u1 += 56077517 * (int64_t)v; u3 += -2597918 * (int64_t)v;
        v = x[30]; u1 += -81157700 * (int64_t)v; u3 += -10896076 * (int64_t)v;
        v = x[31]; u1 += -29775898 * (int64_t)v; u3 += 18527143 * (int64_t)v;
        v = x[34]; u1 += 25868371 * (int64_t)v; u3 += -5335444 * (int64_t)v;
        v = x[35]; u1 += 78609501 * (int64_t)v; u3 += -14772168 * (int64_t)v;
        v = x[37]; u1 += -4967698 * (int64_t)v; u3 += 3937269 * (int64_t)v;
        v = y1; u1 += -47192018 * (int64_t)v; u3 += 20850561 * (int64_t)v;
        v = y3; u1 += 2840415 * (int64_t)v; u3 += -5554110 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1651933 * (int64_t)x0 + 68194762 * (int64_t)y0 - 29557694 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2274844 * (int64_t)x1 - 98667010 * (int64_t)y0 - 120806442 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1651933 * (int64_t)x2 + 68194762 * (int64_t)y1 - 29557694 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2274844 * (int64_t)x3 - 98667010 * (int64_t)y1 - 120806442 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-85013740 * (int64_t)x4 + 663044004 * (int64_t)x5 + 21396532 * (int64_t)y0 - 10771220 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165761001 * (int64_t)x4 - 85013740 * (int64_t)x5 - 16157694 * (int64_t)y0 + 190895 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-85013740 * (int64_t)x6 + 663044004 * (int64_t)x7 + 21396532 * (int64_t)y1 - 10771220 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165761001 * (int64_t)x6 - 85013740 * (int64_t)x7 - 16157694 * (int64_t)y1 + 190895 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149191300 * (int64_t)x8 + 504201994 * (int64_t)x9 - 9323338 * (int64_t)y0 + 5601416 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504201994 * (int64_t)x8 - 149191300 * (int64_t)x9 + 7943861 * (int64_t)y0 - 4629522 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149191300 * (int64_t)x10 + 504201994 * (int64_t)x11 - 9323338 * (int64_t)y1 + 5601416 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504201994 * (int64_t)x10 - 149191300 * (int64_t)x11 + 7943861 * (int64_t)y1 - 4629522 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763469864 * (int64_t)x12 + 539250384 * (int64_t)x13 + 60183951 * (int64_t)y0 - 20196448 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-539250384 * (int64_t)x12 + 763469864 * (int64_t)x13 - 88463490 * (int64_t)y0 - 34377540 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763469864 * (int64_t)x14 + 539250384 * (int64_t)x15 + 60183951 * (int64_t)y1 - 20196448 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-539250384 * (int64_t)x14 + 763469864 * (int64_t)x15 - 88463490 * (int64_t)y1 - 34377540 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611702073 * (int64_t)x16 + 791363538 * (int64_t)x17 - 30660878 * (int64_t)y0 + 10777620 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791363538 * (int64_t)x16 + 611702073 * (int64_t)x17 - 29174528 * (int64_t)y0 + 53803871 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611702073 * (int64_t)x18 + 791363538 * (int64_t)x19 - 30660878 * (int64_t)y1 + 10777620 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791363538 * (int64_t)x18 + 611702073 * (int64_t)x19 - 29174528 * (int64_t)y1 + 53803871 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(384283786 * (int64_t)x20 + 817978602 * (int64_t)x21 + 11242657 * (int64_t)y0 - 193775771 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817978602 * (int64_t)x20 + 384283786 * (int64_t)x21 - 58821271 * (int64_t)y0 + 9458527 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(384283786 * (int64_t)x22 + 817978602 * (int64_t)x23 + 11242657 * (int64_t)y1 - 193775771 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817978602 * (int64_t)x22 + 384283786 * (int64_t)x23 - 58821271 * (int64_t)y1 + 9458527 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(362206616 * (int64_t)x24 + 1395861760 * (int64_t)x25 + 31682035 * (int64_t)y0 - 77359052 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-697930880 * (int64_t)x24 + 181103308 * (int64_t)x25 + 283844795 * (int64_t)y0 + 54144110 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(362206616 * (int64_t)x26 + 1395861760 * (int64_t)x27 + 31682035 * (int64_t)y1 - 77359052 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-697930880 * (int64_t)x26 + 181103308 * (int64_t)x27 + 283844795 * (int64_t)y1 + 54144110 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128783839 * (int64_t)x28 + 959344143 * (int64_t)x29 + 17841234 * (int64_t)y0 + 98709953 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-959344143 * (int64_t)x28 + 128783839 * (int64_t)x29 - 10703361 * (int64_t)y0 - 53611380 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128783839 * (int64_t)x30 + 959344143 * (int64_t)x31 + 17841234 * (int64_t)y1 + 98709953 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-959344143 * (int64_t)x30 + 128783839 * (int64_t)x31 - 10703361 * (int64_t)y1 - 53611380 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-273728106 * (int64_t)x32 + 733203214 * (int64_t)x33 - 151411933 * (int64_t)y0 - 59427092 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-183300803 * (int64_t)x32 - 273728106 * (int64_t)x33 - 243058134 * (int64_t)y0 + 400540651 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-273728106 * (int64_t)x34 + 733203214 * (int64_t)x35 - 151411933 * (int64_t)y1 - 59427092 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-183300803 * (int64_t)x34 - 273728106 * (int64_t)x35 - 243058134 * (int64_t)y1 + 400540651 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142477862 * (int64_t)x36 + 1638980 * (int64_t)y0 - 2234746 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142477862 * (int64_t)x37 + 1638980 * (int64_t)y1 - 2234746 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 609226409 * (int64_t)e[0] + 513766016 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1163131433 * (int64_t)e[0] - 937733430 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 609226409 * (int64_t)e[1] + 513766016 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1163131433 * (int64_t)e[1] - 937733430 * (int64_t)e[3], 19);
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
        {893329503, 0, 336105394, 0, 78477696, 0, -8322176, 0},
        {-1069649777, 0, -111599248, 0, -66416543, 0, 37739344, 0},
        {0, 893329503, 0, 336105394, 0, 78477696, 0, -8322176},
        {0, -1069649777, 0, -111599248, 0, -66416543, 0, 37739344},
        {-1323562431, 0, -123052491, 0, -1311346, 0, 432053, 0},
        {-1388194312, 0, 530506879, 0, 4119288, 0, -1427299, 0},
        {0, -1323562431, 0, -123052491, 0, -1311346, 0, 432053},
        {0, -1388194312, 0, 530506879, 0, 4119288, 0, -1427299},
        {1305475348, 0, -743419202, 0, 416140, 0, -139825, 0},
        {761311368, 0, -434523281, 0, 2207681, 0, -761177, 0},
        {0, 1305475348, 0, -743419202, 0, 416140, 0, -139825},
        {0, 761311368, 0, -434523281, 0, 2207681, 0, -761177},
        {-627145218, 0, -547919251, 0, 1246692, 0, -425632, 0},
        {-1397910837, 0, -382209, 0, -5071624, 0, 1748245, 0},
        {0, -627145218, 0, -547919251, 0, 1246692, 0, -425632},
        {0, -1397910837, 0, -382209, 0, -5071624, 0, 1748245},
        {-753296062, 0, 973436745, 0, 660775, 0, -228584, 0},
        {412219383, 0, 665595075, 0, -2143596, 0, 737836, 0},
        {0, -753296062, 0, 973436745, 0, 660775, 0, -228584},
        {0, 412219383, 0, 665595075, 0, -2143596, 0, 737836},
        {-303792363, 0, -943677495, 0, -80382, 0, 31463, 0},
        {-333579379, 0, 1243064030, 0, 2926866, 0, -1004581, 0},
        {0, -303792363, 0, -943677495, 0, -80382, 0, 31463},
        {0, -333579379, 0, 1243064030, 0, 2926866, 0, -1004581},
        {1813169641, 0, -15399419, 0, -76368590, 0, 26398770, 0},
        {1622802700, 0, 502193322, 0, 151549, 0, -58838, 0},
        {0, 1813169641, 0, -15399419, 0, -76368590, 0, 26398770},
        {0, 1622802700, 0, 502193322, 0, 151549, 0, -58838},
        {310285913, 0, 1582738887, 0, 4611593, 0, -1616507, 0},
        {-261219965, 0, -1379694538, 0, -200517, 0, 61466, 0},
        {0, 310285913, 0, 1582738887, 0, 4611593, 0, -1616507},
        {0, -261219965, 0, -1379694538, 0, -200517, 0, 61466},
        {-767213017, 0, 475357274, 0, 5540974, 0, -1913274, 0},
        {-430569671, 0, 1230785187, 0, 16995612, 0, -5858450, 0},
        {0, -767213017, 0, 475357274, 0, 5540974, 0, -1913274},
        {0, -430569671, 0, 1230785187, 0, 16995612, 0, -5858450},
        {587598231, 0, -1173104425, 0, -18552673, 0, 6370969, 0},
        {0, 587598231, 0, -1173104425, 0, -18552673, 0, 6370969},
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
