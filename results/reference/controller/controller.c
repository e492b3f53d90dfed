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
static const float paper_tool_f32_output_guard = 0x1.c1e9c4p23f;

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
        float u0 = 0x1.12b5e2p0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.ffeedcp-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.a33242p8f * v; u2 += 0x1.0c5076p9f * v;
        v = x[5]; u0 += 0x1.5cf88ep5f * v; u2 += -0x1.7d3ad8p9f * v;
        v = x[8]; u0 += 0x1.06227cp10f * v; u2 += -0x1.caf86ap11f * v;
        v = x[9]; u0 += -0x1.609c8ap9f * v; u2 += 0x1.60e586p10f * v;
        v = x[12]; u0 += -0x1.bb8212p10f * v; u2 += -0x1.127906p9f * v;
        v = x[13]; u0 += -0x1.be17bap8f * v; u2 += 0x1.113d9ap10f * v;
        v = x[16]; u0 += -0x1.eef66ep11f * v; u2 += 0x1.1ec19ep11f * v;
        v = x[17]; u0 += 0x1.2f3bbap6f * v; u2 += -0x1.cb5350p10f * v;
        v = x[20]; u0 += 0x1.b621a2p9f * v; u2 += -0x1.5f2524p9f * v;
        v = x[21]; u0 += 0x1.163c90p6f * v; u2 += -0x1.eed948p8f * v;
        v = x[24]; u0 += -0x1.4991e0p7f * v; u2 += -0x1.7b28bep6f * v;
        v = x[25]; u0 += 0x1.3f4fd0p8f * v; u2 += -0x1.cf28f8p4f * v;
        v = x[28]; u0 += -0x1.d276cep8f * v; u2 += -0x1.f60116p6f * v;
        v = x[29]; u0 += -0x1.524c06p7f * v; u2 += 0x1.a782f8p7f * v;
        v = x[32]; u0 += 0x1.291b68p7f * v; u2 += -0x1.d8ae70p5f * v;
        v = x[33]; u0 += 0x1.c121acp8f * v; u2 += -0x1.56f2e4p7f * v;
        v = x[36]; u0 += -0x1.c6c926p4f * v; u2 += 0x1.68759ep5f * v;
        v = y0; u0 += -0x1.037924p20f * v; u2 += 0x1.ca5ba0p19f * v;
        v = y2; u0 += 0x1.ef7dacp15f * v; u2 += -0x1.e70a32p17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.12b5e2p0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.ffeedcp-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.a33242p8f * v; u3 += 0x1.0c5076p9f * v;
        v = x[7]; u1 += 0x1.5cf88ep5f * v; u3 += -0x1.7d3ad8p9f * v;
        v = x[10]; u1 += 0x1.06227cp10f * v; u3 += -0x1.caf86ap11f * v;
        v = x[11]; u1 += -0x1.609c8ap9f * v; u3 += 0x1.60e586p10f * v;
        v = x[14]; u1 += -0x1.bb8212p10f * v; u3 += -0x1.127906p9f * v;
        v = x[15]; u1 += -0x1.be17bap8f * v; u3 += 0x1.113d9ap10f * v;
        v = x[18]; u1 += -0x1.eef66ep11f * v; u3 += 0x1.1ec19ep11f * v;
        v = x[19]; u1 += 0x1.2f3bbap6f * v; u3 += -0x1.cb5350p10f * v;
        v = x[22]; u1 += 0x1.b621a2p9f * v; u3 += -0x1.5f2524p9f * v;
        v = x[23]; u1 += 0x1.163c90p6f * v; u3 += -0x1.eed948p8f * v;
        v = x[26]; u1 += -0x1.4991e0p7f * v; u3 += -0x1.7b28bep6f * v;
        v = x[27]; u1 += 0x1.3f4fd0p8f * v; u3 += -0x1.cf28f8p4f * v;
        v = x[30]; u1 += -0x1.d276cep8f * v; u3 += -0x1.f60116p6f * v;
        v = x[31]; u1 += -0x1.524c06p7f * v; u3 += 0x1.a782f8p7f * v;
        v = x[34]; u1 += 0x1.291b68p7f * v; u3 += -0x1.d8ae70p5f * v;
        v = x[35]; u1 += 0x1.c121acp8f * v; u3 += -0x1.56f2e4p7f * v;
        v = x[37]; u1 += -0x1.c6c926p4f * v; u3 += 0x1.68759ep5f * v;
        v = y1; u1 += -0x1.037924p20f * v; u3 += 0x1.ca5ba0p19f * v;
        v = y3; u1 += 0x1.ef7dacp15f * v; u3 += -0x1.e70a32p17f * v;
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
        x[0] = -0x1.967f92p-10f * x0 + 0x1.eda932p7f * y0 - 0x1.af8686p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.17ddaap-9f * x1 - 0x1.684e74p8f * y0 - 0x1.bb7e7cp8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.967f92p-10f * x2 + 0x1.eda932p7f * y1 - 0x1.af8686p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.17ddaap-9f * x3 - 0x1.684e74p8f * y1 - 0x1.bb7e7cp8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.448294p-4f * x4 + 0x1.3c206ep-1f * x5 + 0x1.3700dap6f * y0 - 0x1.3b44c8p5f * y2
            + x4;
        x[5] = -0x1.3c206ep-3f * x4 - 0x1.448294p-4f * x5 - 0x1.d7e98ap5f * y0 + 0x1.7834aep-1f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.448294p-4f * x6 + 0x1.3c206ep-1f * x7 + 0x1.3700dap6f * y1 - 0x1.3b44c8p5f * y3
            + x6;
        x[7] = -0x1.3c206ep-3f * x6 - 0x1.448294p-4f * x7 - 0x1.d7e98ap5f * y1 + 0x1.7834aep-1f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1c9c90p-3f * x8 + 0x1.e0d616p-2f * x9 - 0x1.0f9250p5f * y0 + 0x1.463b88p4f * y2
            + x8;
        x[9] = -0x1.e0d616p-2f * x8 - 0x1.1c9c90p-3f * x9 + 0x1.cfe518p4f * y0 - 0x1.0fcc12p4f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1c9c90p-3f * x10 + 0x1.e0d616p-2f * x11 - 0x1.0f9250p5f * y1 + 0x1.463b88p4f * y3
            + x10;
        x[11] = -0x1.e0d616p-2f * x10 - 0x1.1c9c90p-3f * x11 + 0x1.cfe518p4f * y1 - 0x1.0fcc12p4f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6c46dap-1f * x12 + 0x1.0169f0p-1f * x13 + 0x1.c0f904p7f * y0 - 0x1.239294p6f * y2;
        x[13] = -0x1.0169f0p-1f * x12 + 0x1.6c46dap-1f * x13 - 0x1.44ad40p8f * y0 - 0x1.ff501ep6f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6c46dap-1f * x14 + 0x1.0169f0p-1f * x15 + 0x1.c0f904p7f * y1 - 0x1.239294p6f * y3;
        x[15] = -0x1.0169f0p-1f * x14 + 0x1.6c46dap-1f * x15 - 0x1.44ad40p8f * y1 - 0x1.ff501ep6f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.23b006p-1f * x16 + 0x1.79798ap-1f * x17 - 0x1.b81de0p6f * y0 + 0x1.39ee9ep5f * y2;
        x[17] = -0x1.79798ap-1f * x16 + 0x1.23b006p-1f * x17 - 0x1.a4a5cep6f * y0 + 0x1.820fd8p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.23b006p-1f * x18 + 0x1.79798ap-1f * x19 - 0x1.b81de0p6f * y1 + 0x1.39ee9ep5f * y3;
        x[19] = -0x1.79798ap-1f * x18 + 0x1.23b006p-1f * x19 - 0x1.a4a5cep6f * y1 + 0x1.820fd8p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.6df850p-2f * x20 + 0x1.865524p-1f * x21 + 0x1.61a02cp5f * y0 - 0x1.615d96p9f * y2;
        x[21] = -0x1.865524p-1f * x20 + 0x1.6df850p-2f * x21 - 0x1.a535dep7f * y0 + 0x1.c004b8p4f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.6df850p-2f * x22 + 0x1.865524p-1f * x23 + 0x1.61a02cp5f * y1 - 0x1.615d96p9f * y3;
        x[23] = -0x1.865524p-1f * x22 + 0x1.6df850p-2f * x23 - 0x1.a535dep7f * y1 + 0x1.c004b8p4f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.5ce0cap-3f * x24 + 0x1.4cd980p-1f * x25 + 0x1.cc02eep5f * y0 - 0x1.0e8c5ep7f * y2;
        x[25] = -0x1.4cd980p-1f * x24 + 0x1.5ce0cap-3f * x25 + 0x1.04b728p10f * y0 + 0x1.9e75b8p7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.5ce0cap-3f * x26 + 0x1.4cd980p-1f * x27 + 0x1.cc02eep5f * y1 - 0x1.0e8c5ep7f * y3;
        x[27] = -0x1.4cd980p-1f * x26 + 0x1.5ce0cap-3f * x27 + 0x1.04b728p10f * y1 + 0x1.9e75b8p7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.ecd44ap-4f * x28 + 0x1.c95b62p-1f * x29 + 0x1.059a90p6f * y0 + 0x1.6be38ap8f * y2;
        x[29] = -0x1.c95b62p-1f * x28 + 0x1.ecd44ap-4f * x29 - 0x1.464646p5f * y0 - 0x1.850f8ep7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.ecd44ap-4f * x30 + 0x1.c95b62p-1f * x31 + 0x1.059a90p6f * y1 + 0x1.6be38ap8f * y3;
        x[31] = -0x1.c95b62p-1f * x30 + 0x1.ecd44ap-4f * x31 - 0x1.464646p5f * y1 - 0x1.850f8ep7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.00d52ap-2f * x32 + 0x1.5ca12ap-1f * x33 - 0x1.0f9d4cp9f * y0 - 0x1.a81c50p7f * y2;
        x[33] = -0x1.5ca12ap-3f * x32 - 0x1.00d52ap-2f * x33 - 0x1.bc4b28p9f * y0 + 0x1.6eab20p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.00d52ap-2f * x34 + 0x1.5ca12ap-1f * x35 - 0x1.0f9d4cp9f * y1 - 0x1.a81c50p7f * y3;
        x[35] = -0x1.5ca12ap-3f * x34 - 0x1.00d52ap-2f * x35 - 0x1.bc4b28p9f * y1 + 0x1.6eab20p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.fece7ep-1f * x36 + 0x1.809d7ep1f * y0 - 0x1.06317cp2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.fece7ep-1f * x37 + 0x1.809d7ep1f * y1 - 0x1.06317cp2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.7f1020p-4f * e[0];
        x[0] += 0x1.44df28p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.6d77e8p-4f * e[0];
        x[1] += -0x1.2856eap-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.7f1020p-4f * e[1];
        x[2] += 0x1.44df28p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.6d77e8p-4f * e[1];
        x[3] += -0x1.2856eap-4f * e[3];
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
        {0x1.912268p16f, 0.0f, 0x1.2d533ep15f, 0.0f, 0x1.873f2cp-1f, 0.0f, -0x1.43f8b8p-4f, 0.0f},
        {-0x1.e0c6c4p16f, 0.0f, -0x1.77ddbap13f, 0.0f, -0x1.495a66p-1f, 0.0f, 0x1.7b9f16p-2f, 0.0f},
        {0.0f, 0x1.912268p16f, 0.0f, 0x1.2d533ep15f, 0.0f, 0x1.873f2cp-1f, 0.0f, -0x1.43f8b8p-4f},
        {0.0f, -0x1.e0c6c4p16f, 0.0f, -0x1.77ddbap13f, 0.0f, -0x1.495a66p-1f, 0.0f, 0x1.7b9f16p-2f},
        {-0x1.2e55e2p8f, 0.0f, -0x1.befb9ep4f, 0.0f, -0x1.b03250p-16f, 0.0f, 0x1.1f0cf8p-17f, 0.0f},
        {-0x1.3bca86p7f, 0.0f, 0x1.e549eap5f, 0.0f, 0x1.4b6294p-15f, 0.0f, -0x1.cdb466p-17f, 0.0f},
        {0.0f, -0x1.2e55e2p8f, 0.0f, -0x1.befb9ep4f, 0.0f, -0x1.b03250p-16f, 0.0f, 0x1.1f0cf8p-17f},
        {0.0f, -0x1.3bca86p7f, 0.0f, 0x1.e549eap5f, 0.0f, 0x1.4b6294p-15f, 0.0f, -0x1.cdb466p-17f},
        {0x1.2a5c9ep5f, 0.0f, -0x1.567202p4f, 0.0f, 0x1.3c0456p-20f, 0.0f, -0x1.ad2dbcp-22f, 0.0f},
        {0x1.5ac48ep6f, 0.0f, -0x1.8c235ep5f, 0.0f, 0x1.66ca2ep-16f, 0.0f, -0x1.f187d2p-18f, 0.0f},
        {0.0f, 0x1.2a5c9ep5f, 0.0f, -0x1.567202p4f, 0.0f, 0x1.3c0456p-20f, 0.0f, -0x1.ad2dbcp-22f},
        {0.0f, 0x1.5ac48ep6f, 0.0f, -0x1.8c235ep5f, 0.0f, 0x1.66ca2ep-16f, 0.0f, -0x1.f187d2p-18f},
        {-0x1.1cf1cep8f, 0.0f, -0x1.f95dd4p7f, 0.0f, 0x1.a1c31ep-15f, 0.0f, -0x1.1efde2p-16f, 0.0f},
        {-0x1.4312bcp9f, 0.0f, -0x1.857a56p1f, 0.0f, -0x1.9cc068p-13f, 0.0f, 0x1.1e2114p-14f, 0.0f},
        {0.0f, -0x1.1cf1cep8f, 0.0f, -0x1.f95dd4p7f, 0.0f, 0x1.a1c31ep-15f, 0.0f, -0x1.1efde2p-16f},
        {0.0f, -0x1.4312bcp9f, 0.0f, -0x1.857a56p1f, 0.0f, -0x1.9cc068p-13f, 0.0f, 0x1.1e2114p-14f},
        {-0x1.52c012p7f, 0.0f, 0x1.b52232p7f, 0.0f, 0x1.a4c9c2p-17f, 0.0f, -0x1.24ab78p-18f, 0.0f},
        {0x1.6f6cf8p5f, 0.0f, 0x1.27ff68p6f, 0.0f, -0x1.58c096p-16f, 0.0f, 0x1.dd50b6p-18f, 0.0f},
        {0.0f, -0x1.52c012p7f, 0.0f, 0x1.b52232p7f, 0.0f, 0x1.a4c9c2p-17f, 0.0f, -0x1.24ab78p-18f},
        {0.0f, 0x1.6f6cf8p5f, 0.0f, 0x1.27ff68p6f, 0.0f, -0x1.58c096p-16f, 0.0f, 0x1.dd50b6p-18f},
        {-0x1.0b7ad0p7f, 0.0f, -0x1.b2ede0p8f, 0.0f, -0x1.82b9dap-18f, 0.0f, 0x1.1e3a6ep-19f, 0.0f},
        {-0x1.2f4880p7f, 0.0f, 0x1.19044cp9f, 0.0f, 0x1.dea530p-14f, 0.0f, -0x1.4a6e40p-15f, 0.0f},
        {0.0f, -0x1.0b7ad0p7f, 0.0f, -0x1.b2ede0p8f, 0.0f, -0x1.82b9dap-18f, 0.0f, 0x1.1e3a6ep-19f},
        {0.0f, -0x1.2f4880p7f, 0.0f, 0x1.19044cp9f, 0.0f, 0x1.dea530p-14f, 0.0f, -0x1.4a6e40p-15f},
        {0x1.a19016p8f, 0.0f, 0x1.df0cc6p2f, 0.0f, -0x1.842744p-10f, 0.0f, 0x1.0dc9eap-11f, 0.0f},
        {0x1.75b31cp9f, 0.0f, 0x1.d2504cp7f, 0.0f, 0x1.0213aep-16f, 0.0f, -0x1.776e50p-18f, 0.0f},
        {0.0f, 0x1.a19016p8f, 0.0f, 0x1.df0cc6p2f, 0.0f, -0x1.842744p-10f, 0.0f, 0x1.0dc9eap-11f},
        {0.0f, 0x1.75b31cp9f, 0.0f, 0x1.d2504cp7f, 0.0f, 0x1.0213aep-16f, 0.0f, -0x1.776e50p-18f},
        {0x1.16bab4p4f, 0.0f, 0x1.73d372p6f, 0.0f, 0x1.ae31e6p-16f, 0.0f, -0x1.2e6428p-17f, 0.0f},
        {-0x1.e61192p5f, 0.0f, -0x1.3c42fcp8f, 0.0f, -0x1.0cf982p-18f, 0.0f, 0x1.4e080cp-20f, -0.0f},
        {0.0f, 0x1.16bab4p4f, 0.0f, 0x1.73d372p6f, 0.0f, 0x1.ae31e6p-16f, 0.0f, -0x1.2e6428p-17f},
        {0.0f, -0x1.e61192p5f, 0.0f, -0x1.3c42fcp8f, 0.0f, -0x1.0cf982p-18f, 0.0f, 0x1.4e080cp-20f},
        {-0x1.5c3dcap9f, 0.0f, 0x1.b89cc0p8f, 0.0f, 0x1.bec5eep-12f, 0.0f, -0x1.364068p-13f, 0.0f},
        {-0x1.8ad62cp8f, 0.0f, 0x1.1a4f56p10f, 0.0f, 0x1.5ab110p-10f, 0.0f, -0x1.e09b8cp-12f, 0.0f},
        {0.0f, -0x1.5c3dcap9f, 0.0f, 0x1.b89cc0p8f, 0.0f, 0x1.bec5eep-12f, 0.0f, -0x1.364068p-13f},
        {0.0f, -0x1.8ad62cp8f, 0.0f, 0x1.1a4f56p10f, 0.0f, 0x1.5ab110p-10f, 0.0f, -0x1.e09b8cp-12f},
        {0x1.16d790p0f, 0.0f, -0x1.0c5aacp1f, -0.0f, -0x1.593e3ep-19f, -0.0f, 0x1.dca3f0p-21f, 0.0f},
        {0.0f, 0x1.16d790p0f, 0.0f, -0x1.0c5aacp1f, 0.0f, -0x1.593e3ep-19f, 0.0f, 0x1.dca3f0p-21f},
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
/* Over the test vectors Q31 stays within 5.451e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 187536 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 174740 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 73259869 * (int64_t)v; u2 += 46891325 * (int64_t)v;
        v = x[5]; u0 += 7623386 * (int64_t)v; u2 += -66624747 * (int64_t)v;
        v = x[8]; u0 += 183245450 * (int64_t)v; u2 += -320843535 * (int64_t)v;
        v = x[9]; u0 += -123246644 * (int64_t)v; u2 += 123346297 * (int64_t)v;
        v = x[12]; u0 += -310034632 * (int64_t)v; u2 += -47967592 * (int64_t)v;
        v = x[13]; u0 += -77960349 * (int64_t)v; u2 += 95504517 * (int64_t)v;
        v = x[16]; u0 += -692007886 * (int64_t)v; u2 += 200457204 * (int64_t)v;
        v = x[17]; u0 += 13248465 * (int64_t)v; u2 += -160545876 * (int64_t)v;
        v = x[20]; u0 += 153138018 * (int64_t)v; u2 += -61367052 * (int64_t)v;
        v = x[21]; u0 += 12156342 * (int64_t)v; u2 += -43240545 * (int64_t)v;
        v = x[24]; u0 += -28798250 * (int64_t)v; u2 += -8282858 * (int64_t)v;
        v = x[25]; u0 += 55803775 * (int64_t)v; u2 += -2529471 * (int64_t)v;
        v = x[28]; u0 += -81520508 * (int64_t)v; u2 += -10966450 * (int64_t)v;
        v = x[29]; u0 += -29560839 * (int64_t)v; u2 += 18503503 * (int64_t)v;
        v = x[32]; u0 += 25961611 * (int64_t)v; u2 += -5162941 * (int64_t)v;
        v = x[33]; u0 += 78491423 * (int64_t)v; u2 += -14983662 * (int64_t)v;
        v = x[36]; u0 += -4967473 * (int64_t)v; u2 += 3937178 * (int64_t)v;
        v = y0; u0 += -47177492 * (int64_t)v; u2 += 20834691 * (int64_t)v;
        v = y2; u0 += 2815322 * (int64_t)v; u2 += -5534607 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 187536 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 174740 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 73259869 * (int64_t)v; u3 += 46891325 * (int64_t)v;
        v = x[7]; u1 += 7623386 * (int64_t)v; u3 += -66624747 * (int64_t)v;
        v = x[10]; u1 += 183245450 * (int64_t)v; u3 += -320843535 * (int64_t)v;
        v = x[11]; u1 += -123246644 * (int64_t)v; u3 += 123346297 * (int64_t)v;
        v = x[14]; u1 += -310034632 * (int64_t)v; u3 += -47967592 * (int64_t)v;
        v = x[15]; u1 += -77960349 * (int64_t)v; u3 += 95504517 * (int64_t)v;
        v = x[18]; u1 += -692007886 * (int64_t)v; u3 += 200457204 * (int64_t)v;
        v = x[19]; u1 += 13248465 * (int64_t)v; u3 += -160545876 * (int64_t)v;
        v = x[22]; u1 += 153138018 * (int64_t)v; u3 += -61367052 * (int64_t)v;
        v = x[23]; u1 += 12156342 * (int64_t)v; u3 += -43240545 * (int64_t)v;
        v = x[26]; u1 += -28798250 * (int64_t)v; u3 += -8282858 * (int64_t)v;
        v = x[27]; u1 += 55803775 * (int64_t)v; u3 += -2529471 * (int64_t)v;
        v = x[30]; u1 += -81520508 * (int64_t)v; u3 += -10966450 * (int64_t)v;
        v = x[31]; u1 += -29560839 * (int64_t)v; u3 += 18503503 * (int64_t)v;
        v = x[34]; u1 += 25961611 * (int64_t)v; u3 += -5162941 * (int64_t)v;
        v = x[35]; u1 += 78491423 * (int64_t)v; u3 += -14983662 * (int64_t)v;
        v = x[37]; u1 += -4967473 * (int64_t)v; u3 += 3937178 * (int64_t)v;
        v = y1; u1 += -47177492 * (int64_t)v; u3 += 20834691 * (int64_t)v;
        v = y3; u1 += 2815322 * (int64_t)v; u3 += -5534607 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1665017 * (int64_t)x0 + 67318174 * (int64_t)y0 - 29422532 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2292661 * (int64_t)x1 - 98266533 * (int64_t)y0 - 120954327 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1665017 * (int64_t)x2 + 67318174 * (int64_t)y1 - 29422532 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2292661 * (int64_t)x3 - 98266533 * (int64_t)y1 - 120954327 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-85068372 * (int64_t)x4 + 662965667 * (int64_t)x5 + 21205016 * (int64_t)y0 - 10747920 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165741417 * (int64_t)x4 - 85068372 * (int64_t)x5 - 16088104 * (int64_t)y0 + 200396 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-85068372 * (int64_t)x6 + 662965667 * (int64_t)x7 + 21205016 * (int64_t)y1 - 10747920 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165741417 * (int64_t)x6 - 85068372 * (int64_t)x7 - 16088104 * (int64_t)y1 + 200396 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-149218431 * (int64_t)x8 + 504193380 * (int64_t)x9 - 9258227 * (int64_t)y0 + 5560846 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-504193380 * (int64_t)x8 - 149218431 * (int64_t)x9 + 7907391 * (int64_t)y0 - 4632960 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-149218431 * (int64_t)x10 + 504193380 * (int64_t)x11 - 9258227 * (int64_t)y1 + 5560846 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-504193380 * (int64_t)x10 - 149218431 * (int64_t)x11 + 7907391 * (int64_t)y1 - 4632960 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(763943741 * (int64_t)x12 + 539835877 * (int64_t)x13 + 61224259 * (int64_t)y0 - 19880178 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-539835877 * (int64_t)x12 + 763943741 * (int64_t)x13 - 88549233 * (int64_t)y0 - 34862651 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(763943741 * (int64_t)x14 + 539835877 * (int64_t)x15 + 61224259 * (int64_t)y1 - 19880178 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-539835877 * (int64_t)x14 + 763943741 * (int64_t)x15 - 88549233 * (int64_t)y1 - 34862651 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(611713239 * (int64_t)x16 + 791621972 * (int64_t)x17 - 30008304 * (int64_t)y0 + 10702355 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-791621972 * (int64_t)x16 + 611713239 * (int64_t)x17 - 28680855 * (int64_t)y0 + 52645412 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(611713239 * (int64_t)x18 + 791621972 * (int64_t)x19 - 30008304 * (int64_t)y1 + 10702355 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-791621972 * (int64_t)x18 + 611713239 * (int64_t)x19 - 28680855 * (int64_t)y1 + 52645412 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(383747342 * (int64_t)x20 + 818586777 * (int64_t)x21 + 12055560 * (int64_t)y0 - 192747081 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-818586777 * (int64_t)x20 + 383747342 * (int64_t)x21 - 57438450 * (int64_t)y0 + 7636766 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(383747342 * (int64_t)x22 + 818586777 * (int64_t)x23 + 12055560 * (int64_t)y1 - 192747081 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-818586777 * (int64_t)x22 + 383747342 * (int64_t)x23 - 57438450 * (int64_t)y1 + 7636766 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(365825194 * (int64_t)x24 + 1396072484 * (int64_t)x25 + 31364780 * (int64_t)y0 - 73786754 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-698036242 * (int64_t)x24 + 182912597 * (int64_t)x25 + 284420133 * (int64_t)y0 + 56517904 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(365825194 * (int64_t)x26 + 1396072484 * (int64_t)x27 + 31364780 * (int64_t)y1 - 73786754 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-698036242 * (int64_t)x26 + 182912597 * (int64_t)x27 + 284420133 * (int64_t)y1 + 56517904 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(129192230 * (int64_t)x28 + 959147044 * (int64_t)x29 + 17836825 * (int64_t)y0 + 99243555 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-959147044 * (int64_t)x28 + 129192230 * (int64_t)x29 - 11123123 * (int64_t)y0 - 53054354 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(129192230 * (int64_t)x30 + 959147044 * (int64_t)x31 + 17836825 * (int64_t)y1 + 99243555 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-959147044 * (int64_t)x30 + 129192230 * (int64_t)x31 - 11123123 * (int64_t)y1 - 53054354 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-269308572 * (int64_t)x32 + 731129155 * (int64_t)x33 - 148155039 * (int64_t)y0 - 57833933 * (int64_t)y2, 30);
        x[33] = paper_tool_q31_round(-182782289 * (int64_t)x32 - 269308572 * (int64_t)x33 - 242344758 * (int64_t)y0 + 400006564 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-269308572 * (int64_t)x34 + 731129155 * (int64_t)x35 - 148155039 * (int64_t)y1 - 57833933 * (int64_t)y3, 30);
        x[35] = paper_tool_q31_round(-182782289 * (int64_t)x34 - 269308572 * (int64_t)x35 - 242344758 * (int64_t)y1 + 400006564 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142478257 * (int64_t)x36 + 1639004 * (int64_t)y0 - 2234628 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142478257 * (int64_t)x37 + 1639004 * (int64_t)y1 - 2234628 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 602505986 * (int64_t)e[0] + 510979010 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -1149664138 * (int64_t)e[0] - 932203498 * (int64_t)e[2], 19);
        x[2] = paper_tool_q31_correct(x[2], 602505986 * (int64_t)e[1] + 510979010 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -1149664138 * (int64_t)e[1] - 932203498 * (int64_t)e[3], 19);
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
        {875212452, 0, 328722144, 0, 76922245, 0, -7961925, 0},
        {-1048978849, 0, -102510126, 0, -64753458, 0, 37318305, 0},
        {0, 875212452, 0, 328722144, 0, 76922245, 0, -7961925},
        {0, -1048978849, 0, -102510126, 0, -64753458, 0, 37318305},
        {-1319297368, 0, -121905829, 0, -1327708, 0, 440910, 0},
        {-1378013519, 0, 529411986, 0, 4072060, 0, -1418357, 0},
        {0, -1319297368, 0, -121905829, 0, -1327708, 0, 440910},
        {0, -1378013519, 0, 529411986, 0, 4072060, 0, -1418357},
        {1301957332, 0, -747162102, 0, 485402, 0, -164805, 0},
        {756593013, 0, -432155702, 0, 2204404, 0, -764207, 0},
        {0, 1301957332, 0, -747162102, 0, 485402, 0, -164805},
        {0, 756593013, 0, -432155702, 0, 2204404, 0, -764207},
        {-621704357, 0, -551315279, 0, 1283365, 0, -440819, 0},
        {-1409790201, 0, -6638904, 0, -5071892, 0, 1757978, 0},
        {0, -621704357, 0, -551315279, 0, 1283365, 0, -440819},
        {0, -1409790201, 0, -6638904, 0, -5071892, 0, 1757978},
        {-739100043, 0, 953756991, 0, 646331, 0, -224770, 0},
        {801665212, 0, 1291641127, 0, -4236316, 0, 1466313, 0},
        {0, -739100043, 0, 953756991, 0, 646331, 0, -224770},
        {0, 801665212, 0, 1291641127, 0, -4236316, 0, 1466313},
        {-291799456, 0, -948947420, 0, -148503, 0, 54956, 0},
        {-330858237, 0, 1226269279, 0, 2940796, 0, -1015083, 0},
        {0, -291799456, 0, -948947420, 0, -148503, 0, 54956},
        {0, -330858237, 0, 1226269279, 0, 2940796, 0, -1015083},
        {1822113373, 0, 32662870, 0, -76314059, 0, 26521310, 0},
        {1630708246, 0, 508711686, 0, 396406, 0, -144165, 0},
        {0, 1822113373, 0, 32662870, 0, -76314059, 0, 26521310},
        {0, 1630708246, 0, 508711686, 0, 396406, 0, -144165},
        {304071848, 0, 1622531951, 0, 5286235, 0, -1857892, 0},
        {-265131404, 0, -1380066853, 0, -206573, 0, 64134, 0},
        {0, 304071848, 0, 1622531951, 0, 5286235, 0, -1857892},
        {0, -265131404, 0, -1380066853, 0, -206573, 0, 64134},
        {-759808107, 0, 480673510, 0, 5489949, 0, -1906186, 0},
        {-430735806, 0, 1231912016, 0, 17040589, 0, -5905706, 0},
        {0, -759808107, 0, 480673510, 0, 5489949, 0, -1906186},
        {0, -430735806, 0, 1231912016, 0, 17040589, 0, -5905706},
        {608389674, 0, -1171013672, 0, -16969390, 0, 5856957, 0},
        {0, 608389674, 0, -1171013672, 0, -16969390, 0, 5856957},
    };
    static const int16_t shift[38] = {
        25, 25, 25, 25, 34, 35, 34, 35, 37, 35, 37, 35, 33, 33, 33, 33, 34, 36, 34, 36, 33, 33, 33, 33, 34, 33, 34, 33, 36, 34, 36, 34, 32, 32, 32, 32, 41, 41};
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
