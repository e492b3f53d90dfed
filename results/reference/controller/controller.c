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
static const float paper_tool_f32_output_guard = 0x1.c002d8p23f;

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
        float u0 = 0x1.0f38e4p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.f88366p-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.ae6e80p8f * v; u2 += 0x1.1b12ecp9f * v;
        v = x[5]; u0 += 0x1.41063cp6f * v; u2 += -0x1.6cd8ecp9f * v;
        v = x[8]; u0 += 0x1.13565ep10f * v; u2 += -0x1.ddc018p11f * v;
        v = x[9]; u0 += -0x1.5c73eep9f * v; u2 += 0x1.33d312p10f * v;
        v = x[12]; u0 += -0x1.bc5306p10f * v; u2 += -0x1.2f1a58p9f * v;
        v = x[13]; u0 += -0x1.cf2a94p8f * v; u2 += 0x1.0bfdacp10f * v;
        v = x[16]; u0 += -0x1.fd3704p11f * v; u2 += 0x1.1ffbf2p11f * v;
        v = x[17]; u0 += 0x1.743a3ap6f * v; u2 += -0x1.b6b2eap10f * v;
        v = x[20]; u0 += 0x1.cfc492p9f * v; u2 += -0x1.594c52p9f * v;
        v = x[21]; u0 += 0x1.fe7518p5f * v; u2 += -0x1.e87deap8f * v;
        v = x[24]; u0 += -0x1.4e36fcp7f * v; u2 += -0x1.9b444cp6f * v;
        v = x[25]; u0 += 0x1.4b57b4p8f * v; u2 += -0x1.93c1e0p4f * v;
        v = x[28]; u0 += -0x1.d0332cp8f * v; u2 += -0x1.ceadb0p6f * v;
        v = x[29]; u0 += -0x1.509344p7f * v; u2 += 0x1.8e8cf8p7f * v;
        v = x[32]; u0 += 0x1.45ab8ap8f * v; u2 += -0x1.aea63ep6f * v;
        v = x[33]; u0 += 0x1.c5cb66p8f * v; u2 += -0x1.3cfeccp7f * v;
        v = x[36]; u0 += -0x1.d11c8ap4f * v; u2 += 0x1.709b3ep5f * v;
        v = y0; u0 += -0x1.02a814p20f * v; u2 += 0x1.d776a8p19f * v;
        v = y2; u0 += 0x1.004fdep16f * v; u2 += -0x1.f24b3cp17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.0f38e4p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.f88366p-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.ae6e80p8f * v; u3 += 0x1.1b12ecp9f * v;
        v = x[7]; u1 += 0x1.41063cp6f * v; u3 += -0x1.6cd8ecp9f * v;
        v = x[10]; u1 += 0x1.13565ep10f * v; u3 += -0x1.ddc018p11f * v;
        v = x[11]; u1 += -0x1.5c73eep9f * v; u3 += 0x1.33d312p10f * v;
        v = x[14]; u1 += -0x1.bc5306p10f * v; u3 += -0x1.2f1a58p9f * v;
        v = x[15]; u1 += -0x1.cf2a94p8f * v; u3 += 0x1.0bfdacp10f * v;
        v = x[18]; u1 += -0x1.fd3704p11f * v; u3 += 0x1.1ffbf2p11f * v;
        v = x[19]; u1 += 0x1.743a3ap6f * v; u3 += -0x1.b6b2eap10f * v;
        v = x[22]; u1 += 0x1.cfc492p9f * v; u3 += -0x1.594c52p9f * v;
        v = x[23]; u1 += 0x1.fe7518p5f * v; u3 += -0x1.e87deap8f * v;
        v = x[26]; u1 += -0x1.4e36fcp7f * v; u3 += -0x1.9b444cp6f * v;
        v = x[27]; u1 += 0x1.4b57b4p8f * v; u3 += -0x1.93c1e0p4f * v;
        v = x[30]; u1 += -0x1.d0332cp8f * v; u3 += -0x1.ceadb0p6f * v;
        v = x[31]; u1 += -0x1.509344p7f * v; u3 += 0x1.8e8cf8p7f * v;
        v = x[34]; u1 += 0x1.45ab8ap8f * v; u3 += -0x1.aea63ep6f * v;
        v = x[35]; u1 += 0x1.c5cb66p8f * v; u3 += -0x1.3cfeccp7f * v;
        v = x[37]; u1 += -0x1.d11c8ap4f * v; u3 += 0x1.709b3ep5f * v;
        v = y1; u1 += -0x1.02a814p20f * v; u3 += 0x1.d776a8p19f * v;
        v = y3; u1 += 0x1.004fdep16f * v; u3 += -0x1.f24b3cp17f * v;
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
        x[0] = -0x1.961cf2p-10f * x0 + 0x1.f5ee5ep7f * y0 - 0x1.a75f6ep6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.109e34p-9f * x1 - 0x1.5eb902p8f * y0 - 0x1.a4ec6ep8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.961cf2p-10f * x2 + 0x1.f5ee5ep7f * y1 - 0x1.a75f6ep6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.109e34p-9f * x3 - 0x1.5eb902p8f * y1 - 0x1.a4ec6ep8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.47d2c0p-4f * x4 + 0x1.3afea8p-1f * x5 + 0x1.21a9dcp6f * y0 - 0x1.329952p5f * y2
            + x4;
        x[5] = -0x1.3afea8p-3f * x4 - 0x1.47d2c0p-4f * x5 - 0x1.ef597ap5f * y0 + 0x1.106494p0f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.47d2c0p-4f * x6 + 0x1.3afea8p-1f * x7 + 0x1.21a9dcp6f * y1 - 0x1.329952p5f * y3
            + x6;
        x[7] = -0x1.3afea8p-3f * x6 - 0x1.47d2c0p-4f * x7 - 0x1.ef597ap5f * y1 + 0x1.106494p0f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1ee3bap-3f * x8 + 0x1.e09a92p-2f * x9 - 0x1.0a81dep5f * y0 + 0x1.5bbba6p4f * y2
            + x8;
        x[9] = -0x1.e09a92p-2f * x8 - 0x1.1ee3bap-3f * x9 + 0x1.0484cep5f * y0 - 0x1.e4e664p3f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1ee3bap-3f * x10 + 0x1.e09a92p-2f * x11 - 0x1.0a81dep5f * y1 + 0x1.5bbba6p4f * y3
            + x10;
        x[11] = -0x1.e09a92p-2f * x10 - 0x1.1ee3bap-3f * x11 + 0x1.0484cep5f * y1 - 0x1.e4e664p3f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6baa12p-1f * x12 + 0x1.044c0cp-1f * x13 + 0x1.b7cf40p7f * y0 - 0x1.2bfd38p6f * y2;
        x[13] = -0x1.044c0cp-1f * x12 + 0x1.6baa12p-1f * x13 - 0x1.472418p8f * y0 - 0x1.03531ap7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6baa12p-1f * x14 + 0x1.044c0cp-1f * x15 + 0x1.b7cf40p7f * y1 - 0x1.2bfd38p6f * y3;
        x[15] = -0x1.044c0cp-1f * x14 + 0x1.6baa12p-1f * x15 - 0x1.472418p8f * y1 - 0x1.03531ap7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.232b1ap-1f * x16 + 0x1.79d218p-1f * x17 - 0x1.b07b6ep6f * y0 + 0x1.14cb0cp5f * y2;
        x[17] = -0x1.79d218p-1f * x16 + 0x1.232b1ap-1f * x17 - 0x1.a8cad8p6f * y0 + 0x1.8436e4p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.232b1ap-1f * x18 + 0x1.79d218p-1f * x19 - 0x1.b07b6ep6f * y1 + 0x1.14cb0cp5f * y3;
        x[19] = -0x1.79d218p-1f * x18 + 0x1.232b1ap-1f * x19 - 0x1.a8cad8p6f * y1 + 0x1.8436e4p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.729b58p-2f * x20 + 0x1.81cdcap-1f * x21 + 0x1.623fcap5f * y0 - 0x1.669e16p9f * y2;
        x[21] = -0x1.81cdcap-1f * x20 + 0x1.729b58p-2f * x21 - 0x1.d2645cp7f * y0 + 0x1.1aa204p6f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.729b58p-2f * x22 + 0x1.81cdcap-1f * x23 + 0x1.623fcap5f * y1 - 0x1.669e16p9f * y3;
        x[23] = -0x1.81cdcap-1f * x22 + 0x1.729b58p-2f * x23 - 0x1.d2645cp7f * y1 + 0x1.1aa204p6f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.48e00cp-3f * x24 + 0x1.50647ep-1f * x25 + 0x1.e19396p5f * y0 - 0x1.80906ep7f * y2;
        x[25] = -0x1.50647ep-1f * x24 + 0x1.48e00cp-3f * x25 + 0x1.0f3b7ap10f * y0 + 0x1.1b1e02p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.48e00cp-3f * x26 + 0x1.50647ep-1f * x27 + 0x1.e19396p5f * y1 - 0x1.80906ep7f * y3;
        x[27] = -0x1.50647ep-1f * x26 + 0x1.48e00cp-3f * x27 + 0x1.0f3b7ap10f * y1 + 0x1.1b1e02p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.ea62dcp-4f * x28 + 0x1.c778e0p-1f * x29 + 0x1.299fa8p6f * y0 + 0x1.630a16p8f * y2;
        x[29] = -0x1.c778e0p-1f * x28 + 0x1.ea62dcp-4f * x29 - 0x1.e3f7aep3f * y0 - 0x1.a3b3bap7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.ea62dcp-4f * x30 + 0x1.c778e0p-1f * x31 + 0x1.299fa8p6f * y1 + 0x1.630a16p8f * y3;
        x[31] = -0x1.c778e0p-1f * x30 + 0x1.ea62dcp-4f * x31 - 0x1.e3f7aep3f * y1 - 0x1.a3b3bap7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.2ab264p-2f * x32 + 0x1.6c7daep-2f * x33 - 0x1.6205c2p8f * y0 - 0x1.dd80ccp7f * y2;
        x[33] = -0x1.6c7daep-2f * x32 - 0x1.2ab264p-2f * x33 - 0x1.b5f952p9f * y0 + 0x1.773168p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.2ab264p-2f * x34 + 0x1.6c7daep-2f * x35 - 0x1.6205c2p8f * y1 - 0x1.dd80ccp7f * y3;
        x[35] = -0x1.6c7daep-2f * x34 - 0x1.2ab264p-2f * x35 - 0x1.b5f952p9f * y1 + 0x1.773168p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.febfb2p-1f * x36 + 0x1.89b164p1f * y0 - 0x1.0bfd68p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.febfb2p-1f * x37 + 0x1.89b164p1f * y1 - 0x1.0bfd68p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.aa8d92p-4f * e[0];
        x[0] += 0x1.47fe7cp-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.993370p-4f * e[0];
        x[1] += -0x1.2c53f4p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.aa8d92p-4f * e[1];
        x[2] += 0x1.47fe7cp-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.993370p-4f * e[1];
        x[3] += -0x1.2c53f4p-4f * e[3];
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
        {0x1.9ad968p16f, 0.0f, 0x1.2f0c44p15f, 0.0f, 0x1.933c38p-1f, 0.0f, -0x1.5d76d0p-4f, 0.0f},
        {-0x1.f1b1bcp16f, 0.0f, -0x1.bd8c20p13f, 0.0f, -0x1.57bc60p-1f, 0.0f, 0x1.8435b2p-2f, 0.0f},
        {0.0f, 0x1.9ad968p16f, 0.0f, 0x1.2f0c44p15f, 0.0f, 0x1.933c38p-1f, 0.0f, -0x1.5d76d0p-4f},
        {0.0f, -0x1.f1b1bcp16f, 0.0f, -0x1.bd8c20p13f, 0.0f, -0x1.57bc60p-1f, 0.0f, 0x1.8435b2p-2f},
        {-0x1.4387a6p8f, 0.0f, -0x1.98e2f0p4f, 0.0f, -0x1.771e98p-16f, 0.0f, 0x1.e9c5acp-18f, 0.0f},
        {-0x1.303db0p7f, 0.0f, 0x1.dd246ep5f, 0.0f, 0x1.7c90aap-15f, 0.0f, -0x1.0557f2p-16f, 0.0f},
        {0.0f, -0x1.4387a6p8f, 0.0f, -0x1.98e2f0p4f, 0.0f, -0x1.771e98p-16f, 0.0f, 0x1.e9c5acp-18f},
        {0.0f, -0x1.303db0p7f, 0.0f, 0x1.dd246ep5f, 0.0f, 0x1.7c90aap-15f, 0.0f, -0x1.0557f2p-16f},
        {0x1.649e78p5f, 0.0f, -0x1.0e46e4p4f, 0.0f, 0x1.085a52p-19f, 0.0f, -0x1.652b14p-21f, 0.0f},
        {0x1.5f008ep6f, 0.0f, -0x1.98018ap5f, 0.0f, 0x1.76b02ap-16f, 0.0f, -0x1.002c26p-17f, 0.0f},
        {0.0f, 0x1.649e78p5f, 0.0f, -0x1.0e46e4p4f, 0.0f, 0x1.085a52p-19f, 0.0f, -0x1.652b14p-21f},
        {0.0f, 0x1.5f008ep6f, 0.0f, -0x1.98018ap5f, 0.0f, 0x1.76b02ap-16f, 0.0f, -0x1.002c26p-17f},
        {-0x1.24e274p8f, 0.0f, -0x1.fd81dap7f, 0.0f, 0x1.5ea03ap-15f, 0.0f, -0x1.dab988p-17f, 0.0f},
        {-0x1.3d3b14p9f, 0.0f, -0x1.8aca1cp0f, 0.0f, -0x1.9983ccp-13f, 0.0f, 0x1.17faecp-14f, 0.0f},
        {0.0f, -0x1.24e274p8f, 0.0f, -0x1.fd81dap7f, 0.0f, 0x1.5ea03ap-15f, 0.0f, -0x1.dab988p-17f},
        {0.0f, -0x1.3d3b14p9f, 0.0f, -0x1.8aca1cp0f, 0.0f, -0x1.9983ccp-13f, 0.0f, 0x1.17faecp-14f},
        {-0x1.52bc58p7f, 0.0f, 0x1.b14086p7f, 0.0f, 0x1.6e2d52p-17f, 0.0f, -0x1.f62c42p-19f, 0.0f},
        {0x1.575d76p5f, 0.0f, 0x1.3cf9f2p6f, 0.0f, -0x1.790fb2p-16f, 0.0f, 0x1.0179cap-17f, 0.0f},
        {0.0f, -0x1.52bc58p7f, 0.0f, 0x1.b14086p7f, 0.0f, 0x1.6e2d52p-17f, 0.0f, -0x1.f62c42p-19f},
        {0.0f, 0x1.575d76p5f, 0.0f, 0x1.3cf9f2p6f, 0.0f, -0x1.790fb2p-16f, 0.0f, 0x1.0179cap-17f},
        {-0x1.244a4cp7f, 0.0f, -0x1.9dcdaep8f, 0.0f, 0x1.073f02p-15f, 0.0f, -0x1.63a5c0p-17f, 0.0f},
        {-0x1.4d002ep7f, 0.0f, 0x1.2da05ep9f, 0.0f, 0x1.09e17cp-13f, 0.0f, -0x1.6a47e6p-15f, 0.0f},
        {0.0f, -0x1.244a4cp7f, 0.0f, -0x1.9dcdaep8f, 0.0f, 0x1.073f02p-15f, 0.0f, -0x1.63a5c0p-17f},
        {0.0f, -0x1.4d002ep7f, 0.0f, 0x1.2da05ep9f, 0.0f, 0x1.09e17cp-13f, 0.0f, -0x1.6a47e6p-15f},
        {0x1.cb6b90p8f, 0.0f, -0x1.365c96p6f, 0.0f, -0x1.5ea1a0p-10f, 0.0f, 0x1.e0ab4cp-12f, 0.0f},
        {0x1.87200cp9f, 0.0f, 0x1.b1488ap7f, 0.0f, 0x1.9de372p-14f, 0.0f, -0x1.1c9940p-15f, 0.0f},
        {0.0f, 0x1.cb6b90p8f, 0.0f, -0x1.365c96p6f, 0.0f, -0x1.5ea1a0p-10f, 0.0f, 0x1.e0ab4cp-12f},
        {0.0f, 0x1.87200cp9f, 0.0f, 0x1.b1488ap7f, 0.0f, 0x1.9de372p-14f, 0.0f, -0x1.1c9940p-15f},
        {0x1.0ed19ap5f, 0.0f, 0x1.3fd58ap6f, 0.0f, 0x1.309412p-18f, 0.0f, -0x1.c1421ep-20f, 0.0f},
        {-0x1.9daef8p5f, 0.0f, -0x1.4036dep8f, 0.0f, -0x1.5fc326p-18f, 0.0f, 0x1.bbde10p-20f, 0.0f},
        {0.0f, 0x1.0ed19ap5f, 0.0f, 0x1.3fd58ap6f, 0.0f, 0x1.309412p-18f, 0.0f, -0x1.c1421ep-20f},
        {0.0f, -0x1.9daef8p5f, 0.0f, -0x1.4036dep8f, 0.0f, -0x1.5fc326p-18f, 0.0f, 0x1.bbde10p-20f},
        {-0x1.7fc07ep8f, 0.0f, 0x1.03f69cp7f, 0.0f, 0x1.263180p-12f, 0.0f, -0x1.92b26ep-14f, 0.0f},
        {-0x1.82b120p8f, 0.0f, 0x1.1e45bep10f, 0.0f, 0x1.1cf466p-10f, 0.0f, -0x1.859c9ap-12f, 0.0f},
        {0.0f, -0x1.7fc07ep8f, 0.0f, 0x1.03f69cp7f, 0.0f, 0x1.263180p-12f, 0.0f, -0x1.92b26ep-14f},
        {0.0f, -0x1.82b120p8f, 0.0f, 0x1.1e45bep10f, 0.0f, 0x1.1cf466p-10f, 0.0f, -0x1.859c9ap-12f},
        {0x1.1f81fep0f, 0.0f, -0x1.13abf4p1f, -0.0f, -0x1.5bd554p-19f, -0.0f, 0x1.d9ab82p-21f, 0.0f},
        {0.0f, 0x1.1f81fep0f, 0.0f, -0x1.13abf4p1f, 0.0f, -0x1.5bd554p-19f, 0.0f, 0x1.d9ab82p-21f},
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
/* Over the test vectors Q31 stays within 6.222e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 185154 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 172207 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 75223384 * (int64_t)v; u2 += 49470751 * (int64_t)v;
        v = x[5]; u0 += 14025768 * (int64_t)v; u2 += -63761695 * (int64_t)v;
        v = x[8]; u0 += 192474768 * (int64_t)v; u2 += -333971711 * (int64_t)v;
        v = x[9]; u0 += -121793097 * (int64_t)v; u2 += 107592458 * (int64_t)v;
        v = x[12]; u0 += -310605212 * (int64_t)v; u2 += -52971075 * (int64_t)v;
        v = x[13]; u0 += -80944179 * (int64_t)v; u2 += 93669611 * (int64_t)v;
        v = x[16]; u0 += -711934039 * (int64_t)v; u2 += 201315530 * (int64_t)v;
        v = x[17]; u0 += 16262866 * (int64_t)v; u2 += -153336372 * (int64_t)v;
        v = x[20]; u0 += 162098614 * (int64_t)v; u2 += -60345223 * (int64_t)v;
        v = x[21]; u0 += 11151112 * (int64_t)v; u2 += -42685069 * (int64_t)v;
        v = x[24]; u0 += -29204134 * (int64_t)v; u2 += -8984260 * (int64_t)v;
        v = x[25]; u0 += 57906314 * (int64_t)v; u2 += -2205053 * (int64_t)v;
        v = x[28]; u0 += -81124812 * (int64_t)v; u2 += -10107365 * (int64_t)v;
        v = x[29]; u0 += -29410395 * (int64_t)v; u2 += 17412943 * (int64_t)v;
        v = x[32]; u0 += 56914969 * (int64_t)v; u2 += -9407679 * (int64_t)v;
        v = x[33]; u0 += 79306343 * (int64_t)v; u2 += -13849736 * (int64_t)v;
        v = x[36]; u0 += -5080258 * (int64_t)v; u2 += 4026165 * (int64_t)v;
        v = y0; u0 += -47029005 * (int64_t)v; u2 += 21430407 * (int64_t)v;
        v = y2; u0 += 2912670 * (int64_t)v; u2 += -5662496 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 185154 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 172207 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 75223384 * (int64_t)v; u3 += 49470751 * (int64_t)v;
        v = x[7]; u1 += 14025768 * (int64_t)v; u3 += -63761695 * (int64_t)v;
        v = x[10]; u1 += 192474768 * (int64_t)v; u3 += -333971711 * (int64_t)v;
        v = x[11]; u1 += -121793097 * (int64_t)v; u3 += 107592458 * (int64_t)v;
        v = x[14]; u1 += -310605212 * (int64_t)v; u3 += -52971075 * (int64_t)v;
        v = x[15]; u1 += -80944179 * (int64_t)v; u3 += 93669611 * (int64_t)v;
        v = x[18]; u1 += -711934039 * (int64_t)v; u3 += 201315530 * (int64_t)v;
        v = x[19]; u1 += 16262866 * (int64_t)v; u3 += -153336372 * (int64_t)v;
        v = x[22]; u1 += 162098614 * (int64_t)v; u3 += -60345223 * (int64_t)v;
        v = x[23]; u1 += 11151112 * (int64_t)v; u3 += -42685069 * (int64_t)v;
        v = x[26]; u1 += -29204134 * (int64_t)v; u3 += -8984260 * (int64_t)v;
        v = x[27]; u1 += 57906314 * (int64_t)v; u3 += -2205053 * (int64_t)v;
        v = x[30]; u1 += -81124812 * (int64_t)v; u3 += -10107365 * (int64_t)v;
        v = x[31]; u1 += -29410395 * (int64_t)v; u3 += 17412943 * (int64_t)v;
        v = x[34]; u1 += 56914969 * (int64_t)v; u3 += -9407679 * (int64_t)v;
        v = x[35]; u1 += 79306343 * (int64_t)v; u3 += -13849736 * (int64_t)v;
        v = x[37]; u1 += -5080258 * (int64_t)v; u3 += 4026165 * (int64_t)v;
        v = y1; u1 += -47029005 * (int64_t)v; u3 += 21430407 * (int64_t)v;
        v = y3; u1 += 2912670 * (int64_t)v; u3 += -5662496 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1663439 * (int64_t)x0 + 68445944 * (int64_t)y0 - 28866659 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2233287 * (int64_t)x1 - 95652743 * (int64_t)y0 - 114798660 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1663439 * (int64_t)x2 + 68445944 * (int64_t)y1 - 28866659 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2233287 * (int64_t)x3 - 95652743 * (int64_t)y1 - 114798660 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-85936896 * (int64_t)x4 + 660591893 * (int64_t)x5 + 19750014 * (int64_t)y0 - 10452357 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165147973 * (int64_t)x4 - 85936896 * (int64_t)x5 - 16887110 * (int64_t)y0 + 290195 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-85936896 * (int64_t)x6 + 660591893 * (int64_t)x7 + 19750014 * (int64_t)y1 - 10452357 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165147973 * (int64_t)x6 - 85936896 * (int64_t)x7 - 16887110 * (int64_t)y1 + 290195 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-150412754 * (int64_t)x8 + 503949611 * (int64_t)x9 - 9085581 * (int64_t)y0 + 5927335 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503949611 * (int64_t)x8 - 150412754 * (int64_t)x9 + 8881425 * (int64_t)y0 - 4132718 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-150412754 * (int64_t)x10 + 503949611 * (int64_t)x11 - 9085581 * (int64_t)y1 + 5927335 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503949611 * (int64_t)x10 - 150412754 * (int64_t)x11 + 8881425 * (int64_t)y1 - 4132718 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(762659368 * (int64_t)x12 + 545882464 * (int64_t)x13 + 59974724 * (int64_t)y0 - 20454041 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-545882464 * (int64_t)x12 + 762659368 * (int64_t)x13 - 89221301 * (int64_t)y0 - 35362856 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(762659368 * (int64_t)x14 + 545882464 * (int64_t)x15 + 59974724 * (int64_t)y1 - 20454041 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-545882464 * (int64_t)x14 + 762659368 * (int64_t)x15 - 89221301 * (int64_t)y1 - 35362856 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(610624311 * (int64_t)x16 + 792347395 * (int64_t)x17 - 29487759 * (int64_t)y0 + 9436240 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-792347395 * (int64_t)x16 + 610624311 * (int64_t)x17 - 28963451 * (int64_t)y0 + 52938939 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(610624311 * (int64_t)x18 + 792347395 * (int64_t)x19 - 29487759 * (int64_t)y1 + 9436240 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-792347395 * (int64_t)x18 + 610624311 * (int64_t)x19 - 28963451 * (int64_t)y1 + 52938939 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(388609399 * (int64_t)x20 + 809089314 * (int64_t)x21 + 12076816 * (int64_t)y0 - 195611816 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-809089314 * (int64_t)x20 + 388609399 * (int64_t)x21 - 63599648 * (int64_t)y0 + 19270647 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(388609399 * (int64_t)x22 + 809089314 * (int64_t)x23 + 12076816 * (int64_t)y1 - 195611816 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-809089314 * (int64_t)x22 + 388609399 * (int64_t)x23 - 63599648 * (int64_t)y1 + 19270647 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(344850634 * (int64_t)x24 + 1410932559 * (int64_t)x25 + 32835141 * (int64_t)y0 - 104882350 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-705466279 * (int64_t)x24 + 172425317 * (int64_t)x25 + 295893228 * (int64_t)y0 + 38607338 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(344850634 * (int64_t)x26 + 1410932559 * (int64_t)x27 + 32835141 * (int64_t)y1 - 104882350 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-705466279 * (int64_t)x26 + 172425317 * (int64_t)x27 + 295893228 * (int64_t)y1 + 38607338 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128551794 * (int64_t)x28 + 955194391 * (int64_t)x29 + 20292757 * (int64_t)y0 + 96830049 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-955194391 * (int64_t)x28 + 128551794 * (int64_t)x29 - 4124771 * (int64_t)y0 - 57232759 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128551794 * (int64_t)x30 + 955194391 * (int64_t)x31 + 20292757 * (int64_t)y1 + 96830049 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-955194391 * (int64_t)x30 + 128551794 * (int64_t)x31 - 4124771 * (int64_t)y1 - 57232759 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-626412664 * (int64_t)x32 + 764392926 * (int64_t)x33 - 193105414 * (int64_t)y0 - 130229628 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-382196463 * (int64_t)x32 - 313206332 * (int64_t)x33 - 238897619 * (int64_t)y0 + 409306182 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-626412664 * (int64_t)x34 + 764392926 * (int64_t)x35 - 193105414 * (int64_t)y1 - 130229628 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-382196463 * (int64_t)x34 - 313206332 * (int64_t)x35 - 238897619 * (int64_t)y1 + 409306182 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142235816 * (int64_t)x36 + 1677688 * (int64_t)y0 - 2284031 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142235816 * (int64_t)x37 + 1677688 * (int64_t)y1 - 2284031 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 670909874 * (int64_t)e[0] + 515890063 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -643617386 * (int64_t)e[0] - 472375029 * (int64_t)e[2], 18);
        x[2] = paper_tool_q31_correct(x[2], 670909874 * (int64_t)e[1] + 515890063 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -643617386 * (int64_t)e[1] - 472375029 * (int64_t)e[3], 18);
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
        {896408726, 0, 330601549, 0, 79279275, 0, -8588430, 0},
        {-1085890946, 0, -121514321, 0, -67581216, 0, 38162572, 0},
        {0, 896408726, 0, 330601549, 0, 79279275, 0, -8588430},
        {0, -1085890946, 0, -121514321, 0, -67581216, 0, 38162572},
        {-1411783083, 0, -111515783, 0, -1152367, 0, 376145, 0},
        {-1327612235, 0, 520524874, 0, 4676384, 0, -1605695, 0},
        {0, -1411783083, 0, -111515783, 0, -1152367, 0, 376145},
        {0, -1327612235, 0, 520524874, 0, 4676384, 0, -1605695},
        {1556173643, 0, -589701874, 0, 812092, 0, -274305, 0},
        {765831726, 0, -445102614, 0, 2302084, 0, -786962, 0},
        {0, 1556173643, 0, -589701874, 0, 812092, 0, -274305},
        {0, 765831726, 0, -445102614, 0, 2302084, 0, -786962},
        {-639028287, 0, -555832480, 0, 1077123, 0, -364589, 0},
        {-1384295717, 0, -3364722, 0, -5032118, 0, 1720198, 0},
        {0, -639028287, 0, -555832480, 0, 1077123, 0, -364589},
        {0, -1384295717, 0, -3364722, 0, -5032118, 0, 1720198},
        {-739068260, 0, 945288103, 0, 562448, 0, -192834, 0},
        {749168835, 0, 1383185511, 0, -4633329, 0, 1581931, 0},
        {0, -739068260, 0, 945288103, 0, 562448, 0, -192834},
        {0, 749168835, 0, 1383185511, 0, -4633329, 0, 1581931},
        {-318865737, 0, -902854276, 0, 808692, 0, -273137, 0},
        {-363277673, 0, 1316203312, 0, 3267143, 0, -1112927, 0},
        {0, -318865737, 0, -902854276, 0, 808692, 0, -273137},
        {0, -363277673, 0, 1316203312, 0, 3267143, 0, -1112927},
        {1002382834, 0, -169290132, 0, -34468464, 0, 11812924, 0},
        {853373885, 0, 236339101, 0, 1271465, 0, -437143, 0},
        {0, 1002382834, 0, -169290132, 0, -34468464, 0, 11812924},
        {0, 853373885, 0, 236339101, 0, 1271465, 0, -437143},
        {590884090, 0, 1395656034, 0, 935665, 0, -345030, 0},
        {-225648136, 0, -1397315051, 0, -270153, 0, 85223, 0},
        {0, 590884090, 0, 1395656034, 0, 935665, 0, -345030},
        {0, -225648136, 0, -1397315051, 0, -270153, 0, 85223},
        {-837286582, 0, 283599621, 0, 7230096, 0, -2474170, 0},
        {-421850573, 0, 1249203176, 0, 14006093, 0, -4787549, 0},
        {0, -837286582, 0, 283599621, 0, 7230096, 0, -2474170},
        {0, -421850573, 0, 1249203176, 0, 14006093, 0, -4787549},
        {627296946, 0, -1202944897, 0, -17096703, 0, 5820456, 0},
        {0, 627296946, 0, -1202944897, 0, -17096703, 0, 5820456},
    };
    static const int16_t shift[38] = {
        25, 25, 25, 25, 34, 35, 34, 35, 37, 35, 37, 35, 33, 33, 33, 33, 34, 36, 34, 36, 33, 33, 33, 33, 33, 32, 33, 32, 36, 34, 36, 34, 33, 32, 33, 32, 41, 41};
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
