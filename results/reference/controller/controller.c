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
static const float paper_tool_f32_output_guard = 0x1.be73d6p23f;

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
        float u0 = 0x1.10c072p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.fc34aap-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a22da2p8f * v; u2 += 0x1.0b7c86p9f * v;
        v = x[5]; u0 += 0x1.5f7146p5f * v; u2 += -0x1.7b4020p9f * v;
        v = x[8]; u0 += 0x1.0799bcp10f * v; u2 += -0x1.c9ff60p11f * v;
        v = x[9]; u0 += -0x1.5c9d62p9f * v; u2 += 0x1.5dda90p10f * v;
        v = x[12]; u0 += -0x1.bd3614p10f * v; u2 += -0x1.10d6e2p9f * v;
        v = x[13]; u0 += -0x1.bdcd52p8f * v; u2 += 0x1.11897ap10f * v;
        v = x[16]; u0 += -0x1.e78a3cp11f * v; u2 += 0x1.1aca1cp11f * v;
        v = x[17]; u0 += 0x1.d1e3c8p5f * v; u2 += -0x1.c19d80p10f * v;
        v = x[20]; u0 += 0x1.b7c3bcp9f * v; u2 += -0x1.5d949cp9f * v;
        v = x[21]; u0 += 0x1.13d0c4p6f * v; u2 += -0x1.e6d4f2p8f * v;
        v = x[24]; u0 += -0x1.4721b4p7f * v; u2 += -0x1.7c1948p6f * v;
        v = x[25]; u0 += 0x1.40327ep8f * v; u2 += -0x1.c904cap4f * v;
        v = x[28]; u0 += -0x1.cfadd8p8f * v; u2 += -0x1.f1c190p6f * v;
        v = x[29]; u0 += -0x1.5671f2p7f * v; u2 += 0x1.aa54aap7f * v;
        v = x[32]; u0 += 0x1.26e36cp7f * v; u2 += -0x1.d7cf26p5f * v;
        v = x[33]; u0 += 0x1.c08f0cp8f * v; u2 += -0x1.53b78ap7f * v;
        v = x[36]; u0 += -0x1.c6cde6p4f * v; u2 += 0x1.687748p5f * v;
        v = y0; u0 += -0x1.039ff4p20f * v; u2 += 0x1.ca5fc2p19f * v;
        v = y2; u0 += 0x1.f16948p15f * v; u2 += -0x1.e82b30p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.10c072p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.fc34aap-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a22da2p8f * v; u3 += 0x1.0b7c86p9f * v;
        v = x[7]; u1 += 0x1.5f7146p5f * v; u3 += -0x1.7b4020p9f * v;
        v = x[10]; u1 += 0x1.0799bcp10f * v; u3 += -0x1.c9ff60p11f * v;
        v = x[11]; u1 += -0x1.5c9d62p9f * v; u3 += 0x1.5dda90p10f * v;
        v = x[14]; u1 += -0x1.bd3614p10f * v; u3 += -0x1.10d6e2p9f * v;
        v = x[15]; u1 += -0x1.bdcd52p8f * v; u3 += 0x1.11897ap10f * v;
        v = x[18]; u1 += -0x1.e78a3cp11f * v; u3 += 0x1.1aca1cp11f * v;
        v = x[19]; u1 += 0x1.d1e3c8p5f * v; u3 += -0x1.c19d80p10f * v;
        v = x[22]; u1 += 0x1.b7c3bcp9f * v; u3 += -0x1.5d949cp9f * v;
        v = x[23]; u1 += 0x1.13d0c4p6f * v; u3 += -0x1.e6d4f2p8f * v;
        v = x[26]; u1 += -0x1.4721b4p7f * v; u3 += -0x1.7c1948p6f * v;
        v = x[27]; u1 += 0x1.40327ep8f * v; u3 += -0x1.c904cap4f * v;
        v = x[30]; u1 += -0x1.cfadd8p8f * v; u3 += -0x1.f1c190p6f * v;
        v = x[31]; u1 += -0x1.5671f2p7f * v; u3 += 0x1.aa54aap7f * v;
        v = x[34]; u1 += 0x1.26e36cp7f * v; u3 += -0x1.d7cf26p5f * v;
        v = x[35]; u1 += 0x1.c08f0cp8f * v; u3 += -0x1.53b78ap7f * v;
        v = x[37]; u1 += -0x1.c6cde6p4f * v; u3 += 0x1.687748p5f * v;
        v = y1; u1 += -0x1.039ff4p20f * v; u3 += 0x1.ca5fc2p19f * v;
        v = y3; u1 += 0x1.f16948p15f * v; u3 += -0x1.e82b30p17f * v;
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
        x[0] = -0x1.92ea12p-10f * x0 + 0x1.f6e6dep7f * y0 - 0x1.b38b0ap6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.157c30p-9f * x1 - 0x1.6b4a2ep8f * y0 - 0x1.bb2672p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.92ea12p-10f * x2 + 0x1.f6e6dep7f * y1 - 0x1.b38b0ap6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.157c30p-9f * x3 - 0x1.6b4a2ep8f * y1 - 0x1.bb2672p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.445dc4p-4f * x4 + 0x1.3c1e76p-1f * x5 + 0x1.38a8b6p6f * y0 - 0x1.3c7312p5f * y2
            + x4;
        x[5] = -0x1.3c1e76p-3f * x4 - 0x1.445dc4p-4f * x5 - 0x1.d984aap5f * y0 + 0x1.77b13cp-1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.445dc4p-4f * x6 + 0x1.3c1e76p-1f * x7 + 0x1.38a8b6p6f * y1 - 0x1.3c7312p5f * y3
            + x6;
        x[7] = -0x1.3c1e76p-3f * x6 - 0x1.445dc4p-4f * x7 - 0x1.d984aap5f * y1 + 0x1.77b13cp-1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1c8d88p-3f * x8 + 0x1.e0d096p-2f * x9 - 0x1.102538p5f * y0 + 0x1.47c51cp4f * y2
            + x8;
        x[9] = -0x1.e0d096p-2f * x8 - 0x1.1c8d88p-3f * x9 + 0x1.cf2bfap4f * y0 - 0x1.0ee3a4p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1c8d88p-3f * x10 + 0x1.e0d096p-2f * x11 - 0x1.102538p5f * y1 + 0x1.47c51cp4f * y3
            + x10;
        x[11] = -0x1.e0d096p-2f * x10 - 0x1.1c8d88p-3f * x11 + 0x1.cf2bfap4f * y1 - 0x1.0ee3a4p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6c03d8p-1f * x12 + 0x1.014ddep-1f * x13 + 0x1.bed1f0p7f * y0 - 0x1.26eeb2p6f * y2;
        x[13] = -0x1.014ddep-1f * x12 + 0x1.6c03d8p-1f * x13 - 0x1.44d348p8f * y0 - 0x1.fd67dep6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6c03d8p-1f * x14 + 0x1.014ddep-1f * x15 + 0x1.bed1f0p7f * y1 - 0x1.26eeb2p6f * y3;
        x[15] = -0x1.014ddep-1f * x14 + 0x1.6c03d8p-1f * x15 - 0x1.44d348p8f * y1 - 0x1.fd67dep6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.239902p-1f * x16 + 0x1.796394p-1f * x17 - 0x1.c12476p6f * y0 + 0x1.39936ep5f * y2;
        x[17] = -0x1.796394p-1f * x16 + 0x1.239902p-1f * x17 - 0x1.ace76ap6f * y0 + 0x1.89bbbep7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.239902p-1f * x18 + 0x1.796394p-1f * x19 - 0x1.c12476p6f * y1 + 0x1.39936ep5f * y3;
        x[19] = -0x1.796394p-1f * x18 + 0x1.239902p-1f * x19 - 0x1.ace76ap6f * y1 + 0x1.89bbbep7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6e0c0ep-2f * x20 + 0x1.8604c2p-1f * x21 + 0x1.529190p5f * y0 - 0x1.63d04ap9f * y2;
        x[21] = -0x1.8604c2p-1f * x20 + 0x1.6e0c0ep-2f * x21 - 0x1.af5442p7f * y0 + 0x1.194eacp5f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6e0c0ep-2f * x22 + 0x1.8604c2p-1f * x23 + 0x1.529190p5f * y1 - 0x1.63d04ap9f * y3;
        x[23] = -0x1.8604c2p-1f * x22 + 0x1.6e0c0ep-2f * x23 - 0x1.af5442p7f * y1 + 0x1.194eacp5f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.5ab9fep-3f * x24 + 0x1.4cc84ap-1f * x25 + 0x1.d3193ep5f * y0 - 0x1.17e77ep7f * y2;
        x[25] = -0x1.4cc84ap-1f * x24 + 0x1.5ab9fep-3f * x25 + 0x1.0478dcp10f * y0 + 0x1.9f1d94p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.5ab9fep-3f * x26 + 0x1.4cc84ap-1f * x27 + 0x1.d3193ep5f * y1 - 0x1.17e77ep7f * y3;
        x[27] = -0x1.4cc84ap-1f * x26 + 0x1.5ab9fep-3f * x27 + 0x1.0478dcp10f * y1 + 0x1.9f1d94p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.eb301cp-4f * x28 + 0x1.c97ecep-1f * x29 + 0x1.05d3d2p6f * y0 + 0x1.69e554p8f * y2;
        x[29] = -0x1.c97ecep-1f * x28 + 0x1.eb301cp-4f * x29 - 0x1.413b60p5f * y0 - 0x1.885822p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.eb301cp-4f * x30 + 0x1.c97ecep-1f * x31 + 0x1.05d3d2p6f * y1 + 0x1.69e554p8f * y3;
        x[31] = -0x1.c97ecep-1f * x30 + 0x1.eb301cp-4f * x31 - 0x1.413b60p5f * y1 - 0x1.885822p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.04406ap-2f * x32 + 0x1.5d1650p-1f * x33 - 0x1.1078d4p9f * y0 - 0x1.a5b98ep7f * y2;
        x[33] = -0x1.5d1650p-3f * x32 - 0x1.04406ap-2f * x33 - 0x1.bf8632p9f * y0 + 0x1.6f0b76p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.04406ap-2f * x34 + 0x1.5d1650p-1f * x35 - 0x1.1078d4p9f * y1 - 0x1.a5b98ep7f * y3;
        x[35] = -0x1.5d1650p-3f * x34 - 0x1.04406ap-2f * x35 - 0x1.bf8632p9f * y1 + 0x1.6f0b76p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fece80p-1f * x36 + 0x1.809986p1f * y0 - 0x1.063578p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fece80p-1f * x37 + 0x1.809986p1f * y1 - 0x1.063578p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.834974p-4f * e[0];
        x[0] += 0x1.481620p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.71b298p-4f * e[0];
        x[1] += -0x1.2b7a8ap-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.834974p-4f * e[1];
        x[2] += 0x1.481620p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.71b298p-4f * e[1];
        x[3] += -0x1.2b7a8ap-4f * e[3];
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
        {0x1.95ea3ap16f, 0.0f, 0x1.32d9e8p15f, 0.0f, 0x1.8c7ea6p-1f, 0.0f, -0x1.49ca18p-4f, 0.0f},
        {-0x1.e67066p16f, 0.0f, -0x1.903c74p13f, 0.0f, -0x1.4f0648p-1f, 0.0f, 0x1.7dade4p-2f, 0.0f},
        {0.0f, 0x1.95ea3ap16f, 0.0f, 0x1.32d9e8p15f, 0.0f, 0x1.8c7ea6p-1f, 0.0f, -0x1.49ca18p-4f},
        {0.0f, -0x1.e67066p16f, 0.0f, -0x1.903c74p13f, 0.0f, -0x1.4f0648p-1f, 0.0f, 0x1.7dade4p-2f},
        {-0x1.2f22bep8f, 0.0f, -0x1.c0d2c4p4f, 0.0f, -0x1.a27b62p-16f, 0.0f, 0x1.132c3ep-17f, 0.0f},
        {-0x1.3d39c8p7f, 0.0f, 0x1.e744bcp5f, 0.0f, 0x1.4f9040p-15f, 0.0f, -0x1.d038d8p-17f, 0.0f},
        {0.0f, -0x1.2f22bep8f, 0.0f, -0x1.c0d2c4p4f, 0.0f, -0x1.a27b62p-16f, 0.0f, 0x1.132c3ep-17f},
        {0.0f, -0x1.3d39c8p7f, 0.0f, 0x1.e744bcp5f, 0.0f, 0x1.4f9040p-15f, 0.0f, -0x1.d038d8p-17f},
        {0x1.293598p5f, 0.0f, -0x1.53d7e2p4f, 0.0f, 0x1.1babb2p-20f, 0.0f, -0x1.7d3ff2p-22f, 0.0f},
        {0x1.5b3482p6f, 0.0f, -0x1.8d54e0p5f, 0.0f, 0x1.66fe08p-16f, 0.0f, -0x1.ee3d70p-18f, 0.0f},
        {0.0f, 0x1.293598p5f, 0.0f, -0x1.53d7e2p4f, 0.0f, 0x1.1babb2p-20f, 0.0f, -0x1.7d3ff2p-22f},
        {0.0f, 0x1.5b3482p6f, 0.0f, -0x1.8d54e0p5f, 0.0f, 0x1.66fe08p-16f, 0.0f, -0x1.ee3d70p-18f},
        {-0x1.1d9d00p8f, 0.0f, -0x1.f94d5cp7f, 0.0f, 0x1.9bc1b2p-15f, 0.0f, -0x1.18b93ep-16f, 0.0f},
        {-0x1.426f1cp9f, 0.0f, -0x1.b34524p0f, 0.0f, -0x1.9df148p-13f, 0.0f, 0x1.1ce45cp-14f, 0.0f},
        {0.0f, -0x1.1d9d00p8f, 0.0f, -0x1.f94d5cp7f, 0.0f, 0x1.9bc1b2p-15f, 0.0f, -0x1.18b93ep-16f},
        {0.0f, -0x1.426f1cp9f, 0.0f, -0x1.b34524p0f, 0.0f, -0x1.9df148p-13f, 0.0f, 0x1.1ce45cp-14f},
        {-0x1.598eb4p7f, 0.0f, 0x1.bcd80cp7f, 0.0f, 0x1.af0074p-17f, 0.0f, -0x1.29a51cp-18f, 0.0f},
        {0x1.773d72p5f, 0.0f, 0x1.3173aep6f, 0.0f, -0x1.5e30ccp-16f, 0.0f, 0x1.e15478p-18f, 0.0f},
        {0.0f, -0x1.598eb4p7f, 0.0f, 0x1.bcd80cp7f, 0.0f, 0x1.af0074p-17f, 0.0f, -0x1.29a51cp-18f},
        {0.0f, 0x1.773d72p5f, 0.0f, 0x1.3173aep6f, 0.0f, -0x1.5e30ccp-16f, 0.0f, 0x1.e15478p-18f},
        {-0x1.15397ap7f, 0.0f, -0x1.b0fcf8p8f, 0.0f, -0x1.20c49cp-18f, 0.0f, 0x1.b39410p-20f, 0.0f},
        {-0x1.32f0f6p7f, 0.0f, 0x1.1d4fbap9f, 0.0f, 0x1.e3a160p-14f, 0.0f, -0x1.4b73f6p-15f, 0.0f},
        {0.0f, -0x1.15397ap7f, 0.0f, -0x1.b0fcf8p8f, 0.0f, -0x1.20c49cp-18f, 0.0f, 0x1.b39410p-20f},
        {0.0f, -0x1.32f0f6p7f, 0.0f, 0x1.1d4fbap9f, 0.0f, 0x1.e3a160p-14f, 0.0f, -0x1.4b73f6p-15f},
        {0x1.a1983ep8f, 0.0f, 0x1.bd8fb0p1f, 0.0f, -0x1.83be46p-10f, 0.0f, 0x1.0b96fap-11f, 0.0f},
        {0x1.75b2f0p9f, 0.0f, 0x1.d83028p7f, 0.0f, 0x1.8bcfb2p-16f, 0.0f, -0x1.195b98p-17f, 0.0f},
        {0.0f, 0x1.a1983ep8f, 0.0f, 0x1.bd8fb0p1f, 0.0f, -0x1.83be46p-10f, 0.0f, 0x1.0b96fap-11f},
        {0.0f, 0x1.75b2f0p9f, 0.0f, 0x1.d83028p7f, 0.0f, 0x1.8bcfb2p-16f, 0.0f, -0x1.195b98p-17f},
        {0x1.182470p4f, 0.0f, 0x1.6b8838p6f, 0.0f, 0x1.8fbc24p-16f, 0.0f, -0x1.1761f8p-17f, 0.0f},
        {-0x1.e473d4p5f, 0.0f, -0x1.3bedfcp8f, 0.0f, -0x1.4af052p-18f, 0.0f, 0x1.a03fe2p-20f, -0.0f},
        {0.0f, 0x1.182470p4f, 0.0f, 0x1.6b8838p6f, 0.0f, 0x1.8fbc24p-16f, 0.0f, -0x1.1761f8p-17f},
        {0.0f, -0x1.e473d4p5f, 0.0f, -0x1.3bedfcp8f, 0.0f, -0x1.4af052p-18f, 0.0f, 0x1.a03fe2p-20f},
        {-0x1.5d3064p9f, 0.0f, 0x1.b86348p8f, 0.0f, 0x1.bd749ep-12f, 0.0f, -0x1.331e74p-13f, 0.0f},
        {-0x1.8f4b4ep8f, 0.0f, 0x1.19f5e8p10f, 0.0f, 0x1.59a94cp-10f, 0.0f, -0x1.dbc094p-12f, 0.0f},
        {0.0f, -0x1.5d3064p9f, 0.0f, 0x1.b86348p8f, 0.0f, 0x1.bd749ep-12f, 0.0f, -0x1.331e74p-13f},
        {0.0f, -0x1.8f4b4ep8f, 0.0f, 0x1.19f5e8p10f, 0.0f, 0x1.59a94cp-10f, 0.0f, -0x1.dbc094p-12f},
        {0x1.146b16p0f, 0.0f, -0x1.0c92aep1f, -0.0f, -0x1.62409ep-19f, -0.0f, 0x1.e59772p-21f, 0.0f},
        {0.0f, 0x1.146b16p0f, 0.0f, -0x1.0c92aep1f, 0.0f, -0x1.62409ep-19f, 0.0f, 0x1.e59772p-21f},
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
/* Over the test vectors Q31 stays within 5.456e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 186199 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 173468 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73081949 * (int64_t)v; u2 += 46746638 * (int64_t)v;
        v = x[5]; u0 += 7677378 * (int64_t)v; u2 += -66278828 * (int64_t)v;
        v = x[8]; u0 += 184270121 * (int64_t)v; u2 += -320163507 * (int64_t)v;
        v = x[9]; u0 += -121849698 * (int64_t)v; u2 += 122282752 * (int64_t)v;
        v = x[12]; u0 += -311225220 * (int64_t)v; u2 += -47682139 * (int64_t)v;
        v = x[13]; u0 += -77909553 * (int64_t)v; u2 += 95608122 * (int64_t)v;
        v = x[16]; u0 += -681630295 * (int64_t)v; u2 += 197684188 * (int64_t)v;
        v = x[17]; u0 += 10177517 * (int64_t)v; u2 += -157151912 * (int64_t)v;
        v = x[20]; u0 += 153708863 * (int64_t)v; u2 += -61093623 * (int64_t)v;
        v = x[21]; u0 += 12050562 * (int64_t)v; u2 += -42540012 * (int64_t)v;
        v = x[24]; u0 += -28585199 * (int64_t)v; u2 += -8303384 * (int64_t)v;
        v = x[25]; u0 += 55958523 * (int64_t)v; u2 += -2495932 * (int64_t)v;
        v = x[28]; u0 += -81033794 * (int64_t)v; u2 += -10873648 * (int64_t)v;
        v = x[29]; u0 += -29923308 * (int64_t)v; u2 += 18626674 * (int64_t)v;
        v = x[32]; u0 += 25767740 * (int64_t)v; u2 += -5153414 * (int64_t)v;
        v = x[33]; u0 += 78391327 * (int64_t)v; u2 += -14842460 * (int64_t)v;
        v = x[36]; u0 += -4967676 * (int64_t)v; u2 += 3937249 * (int64_t)v;
        v = y0; u0 += -47205060 * (int64_t)v; u2 += 20835424 * (int64_t)v;
        v = y2; u0 += 2826233 * (int64_t)v; u2 += -5547436 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 186199 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 173468 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73081949 * (int64_t)v; u3 += 46746638 * (int64_t)v;
        v = x[7]; u1 += 7677378 * (int64_t)v; u3 += -66278828 * (int64_t)v;
        v = x[10]; u1 += 184270121 * (int64_t)v; u3 += -320163507 * (int64_t)v;
        v = x[11]; u1 += -121849698 * (int64_t)v; u3 += 122282752 * (int64_t)v;
        v = x[14]; u1 += -311225220 * (int64_t)v; u3 += -47682139 * (int64_t)v;
        v = x[15]; u1 += -77909553 * (int64_t)v; u3 += 95608122 * (int64_t)v;
        v = x[18]; u1 += -681630295 * (int64_t)v; u3 += 197684188 * (int64_t)v;
        v = x[19]; u1 += 10177517 * (int64_t)v; u3 += -157151912 * (int64_t)v;
        v = x[22]; u1 += 153708863 * (int64_t)v; u3 += -61093623 * (int64_t)v;
        v = x[23]; u1 += 12050562 * (int64_t)v; u3 += -42540012 * (int64_t)v;
        v = x[26]; u1 += -28585199 * (int64_t)v; u3 += -8303384 * (int64_t)v;
        v = x[27]; u1 += 55958523 * (int64_t)v; u3 += -2495932 * (int64_t)v;
        v = x[30]; u1 += -81033794 * (int64_t)v; u3 += -10873648 * (int64_t)v;
        v = x[31]; u1 += -29923308 * (int64_t)v; u3 += 18626674 * (int64_t)v;
        v = x[34]; u1 += 25767740 * (int64_t)v; u3 += -5153414 * (int64_t)v;
        v = x[35]; u1 += 78391327 * (int64_t)v; u3 += -14842460 * (int64_t)v;
        v = x[37]; u1 += -4967676 * (int64_t)v; u3 += 3937249 * (int64_t)v;
        v = y1; u1 += -47205060 * (int64_t)v; u3 += 20835424 * (int64_t)v;
        v = y3; u1 += 2826233 * (int64_t)v; u3 += -5547436 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1650337 * (int64_t)x0 + 68578313 * (int64_t)y0 - 29696464 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2273158 * (int64_t)x1 - 99080171 * (int64_t)y0 - 120860533 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1650337 * (int64_t)x2 + 68578313 * (int64_t)y1 - 29696464 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2273158 * (int64_t)x3 - 99080171 * (int64_t)y1 - 120860533 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-85030668 * (int64_t)x4 + 662949578 * (int64_t)x5 + 21317906 * (int64_t)y0 - 10788176 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165737395 * (int64_t)x4 - 85030668 * (int64_t)x5 - 16142853 * (int64_t)y0 + 200123 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-85030668 * (int64_t)x6 + 662949578 * (int64_t)x7 + 21317906 * (int64_t)y1 - 10788176 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165737395 * (int64_t)x6 - 85030668 * (int64_t)x7 - 16142853 * (int64_t)y1 + 200123 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149187652 * (int64_t)x8 + 504170841 * (int64_t)x9 - 9277791 * (int64_t)y0 + 5587052 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504170841 * (int64_t)x8 - 149187652 * (int64_t)x9 + 7895065 * (int64_t)y0 - 4617483 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149187652 * (int64_t)x10 + 504170841 * (int64_t)x11 - 9277791 * (int64_t)y1 + 5587052 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504170841 * (int64_t)x10 - 149187652 * (int64_t)x11 + 7895065 * (int64_t)y1 - 4617483 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763394785 * (int64_t)x12 + 539605921 * (int64_t)x13 + 60930711 * (int64_t)y0 - 20109259 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-539605921 * (int64_t)x12 + 763394785 * (int64_t)x13 - 88589748 * (int64_t)y0 - 34732610 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763394785 * (int64_t)x14 + 539605921 * (int64_t)x15 + 60930711 * (int64_t)y1 - 20109259 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-539605921 * (int64_t)x14 + 763394785 * (int64_t)x15 - 88589748 * (int64_t)y1 - 34732610 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611524672 * (int64_t)x16 + 791442056 * (int64_t)x17 - 30623701 * (int64_t)y0 + 10690211 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791442056 * (int64_t)x16 + 611524672 * (int64_t)x17 - 29243791 * (int64_t)y0 + 53691534 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611524672 * (int64_t)x18 + 791442056 * (int64_t)x19 - 30623701 * (int64_t)y1 + 10690211 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791442056 * (int64_t)x18 + 611524672 * (int64_t)x19 - 29243791 * (int64_t)y1 + 53691534 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(383828182 * (int64_t)x20 + 817928260 * (int64_t)x21 + 11542245 * (int64_t)y0 - 194082396 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-817928260 * (int64_t)x20 + 383828182 * (int64_t)x21 - 58818289 * (int64_t)y0 + 9590133 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(383828182 * (int64_t)x22 + 817928260 * (int64_t)x23 + 11542245 * (int64_t)y1 - 194082396 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-817928260 * (int64_t)x22 + 383828182 * (int64_t)x23 - 58818289 * (int64_t)y1 + 9590133 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(363569122 * (int64_t)x24 + 1395790523 * (int64_t)x25 + 31848000 * (int64_t)y0 - 76338406 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-697895262 * (int64_t)x24 + 181784561 * (int64_t)x25 + 284154662 * (int64_t)y0 + 56607319 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(363569122 * (int64_t)x26 + 1395790523 * (int64_t)x27 + 31848000 * (int64_t)y1 - 76338406 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-697895262 * (int64_t)x26 + 181784561 * (int64_t)x27 + 284154662 * (int64_t)y1 + 56607319 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128761966 * (int64_t)x28 + 959437280 * (int64_t)x29 + 17852076 * (int64_t)y0 + 98700001 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-959437280 * (int64_t)x28 + 128761966 * (int64_t)x29 - 10951215 * (int64_t)y0 - 53502111 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128761966 * (int64_t)x30 + 959437280 * (int64_t)x31 + 17852076 * (int64_t)y1 + 98700001 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-959437280 * (int64_t)x30 + 128761966 * (int64_t)x31 - 10951215 * (int64_t)y1 - 53502111 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-272893603 * (int64_t)x32 + 732088861 * (int64_t)x33 - 148622804 * (int64_t)y0 - 57508595 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-183022215 * (int64_t)x32 - 272893603 * (int64_t)x33 - 244106929 * (int64_t)y0 + 400417116 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-272893603 * (int64_t)x34 + 732088861 * (int64_t)x35 - 148622804 * (int64_t)y1 - 57508595 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-183022215 * (int64_t)x34 - 272893603 * (int64_t)x35 - 244106929 * (int64_t)y1 + 400417116 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142478396 * (int64_t)x36 + 1638938 * (int64_t)y0 - 2234760 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142478396 * (int64_t)x37 + 1638938 * (int64_t)y1 - 2234760 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 609149644 * (int64_t)e[0] + 516035335 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1162968219 * (int64_t)e[0] - 942078474 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 609149644 * (int64_t)e[1] + 516035335 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1162968219 * (int64_t)e[1] - 942078474 * (int64_t)e[3], 19);
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
        {885642871, 0, 334750625, 0, 77954037, 0, -8104905, 0},
        {-1061333812, 0, -109156571, 0, -65868503, 0, 37520598, 0},
        {0, 885642871, 0, 334750625, 0, 77954037, 0, -8104905},
        {0, -1061333812, 0, -109156571, 0, -65868503, 0, 37520598},
        {-1322789245, 0, -122407768, 0, -1285577, 0, 422665, 0},
        {-1384273668, 0, 531571764, 0, 4123404, 0, -1426090, 0},
        {0, -1322789245, 0, -122407768, 0, -1285577, 0, 422665},
        {0, -1384273668, 0, 531571764, 0, 4123404, 0, -1426090},
        {1296928472, 0, -741484858, 0, 435718, 0, -146400, 0},
        {757547199, 0, -433457588, 0, 2205649, 0, -759153, 0},
        {0, 1296928472, 0, -741484858, 0, 435718, 0, -146400},
        {0, 757547199, 0, -433457588, 0, 2205649, 0, -759153},
        {-623163440, 0, -551245125, 0, 1264916, 0, -431191, 0},
        {-1407001073, 0, -3709731, 0, -5086525, 0, 1750377, 0},
        {0, -623163440, 0, -551245125, 0, 1264916, 0, -431191},
        {0, -1407001073, 0, -3709731, 0, -5086525, 0, 1750377},
        {-753952226, 0, 970579774, 0, 662019, 0, -228591, 0},
        {409357484, 0, 666448138, 0, -2151571, 0, 739323, 0},
        {0, -753952226, 0, 970579774, 0, 662019, 0, -228591},
        {0, 409357484, 0, 666448138, 0, -2151571, 0, 739323},
        {-302430255, 0, -944712377, 0, -110887, 0, 41816, 0},
        {-334848888, 0, 1245009714, 0, 2971425, 0, -1018224, 0},
        {0, -302430255, 0, -944712377, 0, -110887, 0, 41816},
        {0, -334848888, 0, 1245009714, 0, 2971425, 0, -1018224},
        {1822252473, 0, 15189764, 0, -76233424, 0, 26305144, 0},
        {1630705213, 0, 515120258, 0, 607966, 0, -216083, 0},
        {0, 1822252473, 0, 15189764, 0, -76233424, 0, 26305144},
        {0, 1630705213, 0, 515120258, 0, 607966, 0, -216083},
        {305613358, 0, 1586340242, 0, 4911943, 0, -1716527, 0},
        {-264249845, 0, -1378617967, 0, -254161, 0, 79920, 0},
        {0, 305613358, 0, 1586340242, 0, 4911943, 0, -1716527},
        {0, -264249845, 0, -1378617967, 0, -254161, 0, 79920},
        {-761875772, 0, 480428612, 0, 5473757, 0, -1886939, 0},
        {-435598660, 0, 1230387617, 0, 16989944, 0, -5846044, 0},
        {0, -761875772, 0, 480428612, 0, 5473757, 0, -1886939},
        {0, -435598660, 0, 1230387617, 0, 16989944, 0, -5846044},
        {603101450, 0, -1171968245, 0, -17412215, 0, 5966949, 0},
        {0, 603101450, 0, -1171968245, 0, -17412215, 0, 5966949},
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
