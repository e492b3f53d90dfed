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
static const float paper_tool_f32_output_guard = 0x1.c007f0p23f;

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
        float u0 = 0x1.0f36eep0f * v, u2 = 0x1.800000p1f * v;
        v = x[1]; u0 += 0x1.f87efap-1f * v; u2 += 0x1.800000p1f * v;
        v = x[4]; u0 += 0x1.ae6de6p8f * v; u2 += 0x1.1b11bep9f * v;
        v = x[5]; u0 += 0x1.40eadcp6f * v; u2 += -0x1.6cdb3cp9f * v;
        v = x[8]; u0 += 0x1.135a62p10f * v; u2 += -0x1.ddc72ap11f * v;
        v = x[9]; u0 += -0x1.5c76b8p9f * v; u2 += 0x1.33d376p10f * v;
        v = x[12]; u0 += -0x1.bc5576p10f * v; u2 += -0x1.2f17a6p9f * v;
        v = x[13]; u0 += -0x1.cf2502p8f * v; u2 += 0x1.0bfdb6p10f * v;
        v = x[16]; u0 += -0x1.fd3f14p11f * v; u2 += 0x1.200148p11f * v;
        v = x[17]; u0 += 0x1.7500fep6f * v; u2 += -0x1.b6c4eap10f * v;
        v = x[20]; u0 += 0x1.cfc9dep9f * v; u2 += -0x1.595164p9f * v;
        v = x[21]; u0 += 0x1.fe58e0p5f * v; u2 += -0x1.e86b0ep8f * v;
        v = x[24]; u0 += -0x1.4e3c2ep7f * v; u2 += -0x1.9b30aep6f * v;
        v = x[25]; u0 += 0x1.4b57f4p8f * v; u2 += -0x1.939eacp4f * v;
        v = x[28]; u0 += -0x1.d033eep8f * v; u2 += -0x1.ce9d70p6f * v;
        v = x[29]; u0 += -0x1.509600p7f * v; u2 += 0x1.8e907ap7f * v;
        v = x[32]; u0 += 0x1.45a780p8f * v; u2 += -0x1.aecff6p6f * v;
        v = x[33]; u0 += 0x1.c5c76ep8f * v; u2 += -0x1.3cffd4p7f * v;
        v = x[36]; u0 += -0x1.d11c96p4f * v; u2 += 0x1.709b46p5f * v;
        v = y0; u0 += -0x1.02a850p20f * v; u2 += 0x1.d775d0p19f * v;
        v = y2; u0 += 0x1.0054c6p16f * v; u2 += -0x1.f2516ep17f * v;
        u[0] = u0;
        u[2] = u2;
    }
    {
        float v = x[2];
        float u1 = 0x1.0f36eep0f * v, u3 = 0x1.800000p1f * v;
        v = x[3]; u1 += 0x1.f87efap-1f * v; u3 += 0x1.800000p1f * v;
        v = x[6]; u1 += 0x1.ae6de6p8f * v; u3 += 0x1.1b11bep9f * v;
        v = x[7]; u1 += 0x1.40eadcp6f * v; u3 += -0x1.6cdb3cp9f * v;
        v = x[10]; u1 += 0x1.135a62p10f * v; u3 += -0x1.ddc72ap11f * v;
        v = x[11]; u1 += -0x1.5c76b8p9f * v; u3 += 0x1.33d376p10f * v;
        v = x[14]; u1 += -0x1.bc5576p10f * v; u3 += -0x1.2f17a6p9f * v;
        v = x[15]; u1 += -0x1.cf2502p8f * v; u3 += 0x1.0bfdb6p10f * v;
        v = x[18]; u1 += -0x1.fd3f14p11f * v; u3 += 0x1.200148p11f * v;
        v = x[19]; u1 += 0x1.7500fep6f * v; u3 += -0x1.b6c4eap10f * v;
        v = x[22]; u1 += 0x1.cfc9dep9f * v; u3 += -0x1.595164p9f * v;
        v = x[23]; u1 += 0x1.fe58e0p5f * v; u3 += -0x1.e86b0ep8f * v;
        v = x[26]; u1 += -0x1.4e3c2ep7f * v; u3 += -0x1.9b30aep6f * v;
        v = x[27]; u1 += 0x1.4b57f4p8f * v; u3 += -0x1.939eacp4f * v;
        v = x[30]; u1 += -0x1.d033eep8f * v; u3 += -0x1.ce9d70p6f * v;
        v = x[31]; u1 += -0x1.509600p7f * v; u3 += 0x1.8e907ap7f * v;
        v = x[34]; u1 += 0x1.45a780p8f * v; u3 += -0x1.aecff6p6f * v;
        v = x[35]; u1 += 0x1.c5c76ep8f * v; u3 += -0x1.3cffd4p7f * v;
        v = x[37]; u1 += -0x1.d11c96p4f * v; u3 += 0x1.709b46p5f * v;
        v = y1; u1 += -0x1.02a850p20f * v; u3 += 0x1.d775d0p19f * v;
        v = y3; u1 += 0x1.0054c6p16f * v; u3 += -0x1.f2516ep17f * v;
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
        x[0] = -0x1.961c00p-10f * x0 + 0x1.f5f9c0p7f * y0 - 0x1.a76974p6f * y2 + x0;
    }
    {
        const float x1 = x[1];
        x[1] = -0x1.109f2ep-9f * x1 - 0x1.5ec0fcp8f * y0 - 0x1.a4ef40p8f * y2 + x1;
    }
    {
        const float x2 = x[2];
        x[2] = -0x1.961c00p-10f * x2 + 0x1.f5f9c0p7f * y1 - 0x1.a76974p6f * y3 + x2;
    }
    {
        const float x3 = x[3];
        x[3] = -0x1.109f2ep-9f * x3 - 0x1.5ec0fcp8f * y1 - 0x1.a4ef40p8f * y3 + x3;
    }
    {
        const float x4 = x[4];
        const float x5 = x[5];
        x[4] = -0x1.47d15cp-4f * x4 + 0x1.3afebap-1f * x5 + 0x1.21a7f4p6f * y0 - 0x1.32989ep5f * y2
            + x4;
        x[5] = -0x1.3afebap-3f * x4 - 0x1.47d15cp-4f * x5 - 0x1.ef57e2p5f * y0 + 0x1.10926ep0f * y2
            + x5;
    }
    {
        const float x6 = x[6];
        const float x7 = x[7];
        x[6] = -0x1.47d15cp-4f * x6 + 0x1.3afebap-1f * x7 + 0x1.21a7f4p6f * y1 - 0x1.32989ep5f * y3
            + x6;
        x[7] = -0x1.3afebap-3f * x6 - 0x1.47d15cp-4f * x7 - 0x1.ef57e2p5f * y1 + 0x1.10926ep0f * y3
            + x7;
    }
    {
        const float x8 = x[8];
        const float x9 = x[9];
        x[8] = -0x1.1ee3bep-3f * x8 + 0x1.e09a74p-2f * x9 - 0x1.0a7bd6p5f * y0 + 0x1.5bb866p4f * y2
            + x8;
        x[9] = -0x1.e09a74p-2f * x8 - 0x1.1ee3bep-3f * x9 + 0x1.048022p5f * y0 - 0x1.e4df22p3f * y2
            + x9;
    }
    {
        const float x10 = x[10];
        const float x11 = x[11];
        x[10] = -0x1.1ee3bep-3f * x10 + 0x1.e09a74p-2f * x11 - 0x1.0a7bd6p5f * y1 + 0x1.5bb866p4f * y3
            + x10;
        x[11] = -0x1.e09a74p-2f * x10 - 0x1.1ee3bep-3f * x11 + 0x1.048022p5f * y1 - 0x1.e4df22p3f * y3
            + x11;
    }
    {
        const float x12 = x[12];
        const float x13 = x[13];
        x[12] = 0x1.6baa18p-1f * x12 + 0x1.044c50p-1f * x13 + 0x1.b7cd32p7f * y0 - 0x1.2bfadap6f * y2;
        x[13] = -0x1.044c50p-1f * x12 + 0x1.6baa18p-1f * x13 - 0x1.4720fap8f * y0 - 0x1.035312p7f * y2;
    }
    {
        const float x14 = x[14];
        const float x15 = x[15];
        x[14] = 0x1.6baa18p-1f * x14 + 0x1.044c50p-1f * x15 + 0x1.b7cd32p7f * y1 - 0x1.2bfadap6f * y3;
        x[15] = -0x1.044c50p-1f * x14 + 0x1.6baa18p-1f * x15 - 0x1.4720fap8f * y1 - 0x1.035312p7f * y3;
    }
    {
        const float x16 = x[16];
        const float x17 = x[17];
        x[16] = 0x1.232ae6p-1f * x16 + 0x1.79d242p-1f * x17 - 0x1.b07498p6f * y0 + 0x1.14c7f4p5f * y2;
        x[17] = -0x1.79d242p-1f * x16 + 0x1.232ae6p-1f * x17 - 0x1.a8c0a0p6f * y0 + 0x1.8430a4p7f * y2;
    }
    {
        const float x18 = x[18];
        const float x19 = x[19];
        x[18] = 0x1.232ae6p-1f * x18 + 0x1.79d242p-1f * x19 - 0x1.b07498p6f * y1 + 0x1.14c7f4p5f * y3;
        x[19] = -0x1.79d242p-1f * x18 + 0x1.232ae6p-1f * x19 - 0x1.a8c0a0p6f * y1 + 0x1.8430a4p7f * y3;
    }
    {
        const float x20 = x[20];
        const float x21 = x[21];
        x[20] = 0x1.729becp-2f * x20 + 0x1.81cc88p-1f * x21 + 0x1.625486p5f * y0 - 0x1.66a350p9f * y2;
        x[21] = -0x1.81cc88p-1f * x20 + 0x1.729becp-2f * x21 - 0x1.d25cacp7f * y0 + 0x1.1abcccp6f * y2;
    }
    {
        const float x22 = x[22];
        const float x23 = x[23];
        x[22] = 0x1.729becp-2f * x22 + 0x1.81cc88p-1f * x23 + 0x1.625486p5f * y1 - 0x1.66a350p9f * y3;
        x[23] = -0x1.81cc88p-1f * x22 + 0x1.729becp-2f * x23 - 0x1.d25cacp7f * y1 + 0x1.1abcccp6f * y3;
    }
    {
        const float x24 = x[24];
        const float x25 = x[25];
        x[24] = 0x1.48e070p-3f * x24 + 0x1.506500p-1f * x25 + 0x1.e19c54p5f * y0 - 0x1.809264p7f * y2;
        x[25] = -0x1.506500p-1f * x24 + 0x1.48e070p-3f * x25 + 0x1.0f3b10p10f * y0 + 0x1.1b3c2ap7f * y2;
    }
    {
        const float x26 = x[26];
        const float x27 = x[27];
        x[26] = 0x1.48e070p-3f * x26 + 0x1.506500p-1f * x27 + 0x1.e19c54p5f * y1 - 0x1.809264p7f * y3;
        x[27] = -0x1.506500p-1f * x26 + 0x1.48e070p-3f * x27 + 0x1.0f3b10p10f * y1 + 0x1.1b3c2ap7f * y3;
    }
    {
        const float x28 = x[28];
        const float x29 = x[29];
        x[28] = 0x1.ea61a6p-4f * x28 + 0x1.c7790ap-1f * x29 + 0x1.29a190p6f * y0 + 0x1.630910p8f * y2;
        x[29] = -0x1.c7790ap-1f * x28 + 0x1.ea61a6p-4f * x29 - 0x1.e415f2p3f * y0 - 0x1.a3b264p7f * y2;
    }
    {
        const float x30 = x[30];
        const float x31 = x[31];
        x[30] = 0x1.ea61a6p-4f * x30 + 0x1.c7790ap-1f * x31 + 0x1.29a190p6f * y1 + 0x1.630910p8f * y3;
        x[31] = -0x1.c7790ap-1f * x30 + 0x1.ea61a6p-4f * x31 - 0x1.e415f2p3f * y1 - 0x1.a3b264p7f * y3;
    }
    {
        const float x32 = x[32];
        const float x33 = x[33];
        x[32] = -0x1.2ab85ep-2f * x32 + 0x1.6c7b32p-2f * x33 - 0x1.6208c4p8f * y0 - 0x1.dd9b22p7f * y2;
        x[33] = -0x1.6c7b32p-2f * x32 - 0x1.2ab85ep-2f * x33 - 0x1.b5f524p9f * y0 + 0x1.7736b0p10f * y2;
    }
    {
        const float x34 = x[34];
        const float x35 = x[35];
        x[34] = -0x1.2ab85ep-2f * x34 + 0x1.6c7b32p-2f * x35 - 0x1.6208c4p8f * y1 - 0x1.dd9b22p7f * y3;
        x[35] = -0x1.6c7b32p-2f * x34 - 0x1.2ab85ep-2f * x35 - 0x1.b5f524p9f * y1 + 0x1.7736b0p10f * y3;
    }
    {
        const float x36 = x[36];
        x[36] = -0x1.febfb2p-1f * x36 + 0x1.89b16ap1f * y0 - 0x1.0bfd70p2f * y2;
    }
    {
        const float x37 = x[37];
        x[37] = -0x1.febfb2p-1f * x37 + 0x1.89b16ap1f * y1 - 0x1.0bfd70p2f * y3;
    }

    if (c->limited) {
        const float *e = c->excess_a;
        x[0] += 0x1.aa8426p-4f * e[0];
        x[0] += 0x1.47fb10p-4f * e[2];
        x[0] = paper_tool_f32_clamp(x[0], 1.0f);
        x[1] += -0x1.992a08p-4f * e[0];
        x[1] += -0x1.2c5064p-4f * e[2];
        x[1] = paper_tool_f32_clamp(x[1], 1.0f);
        x[2] += 0x1.aa8426p-4f * e[1];
        x[2] += 0x1.47fb10p-4f * e[3];
        x[2] = paper_tool_f32_clamp(x[2], 1.0f);
        x[3] += -0x1.992a08p-4f * e[1];
        x[3] += -0x1.2c5064p-4f * e[3];
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
        {0x1.9ad194p16f, 0.0f, 0x1.2f0c1cp15f, 0.0f, 0x1.933602p-1f, 0.0f, -0x1.5d5ddcp-4f, 0.0f},
        {-0x1.f1aa16p16f, 0.0f, -0x1.bd8bcep13f, 0.0f, -0x1.57b644p-1f, 0.0f, 0x1.842fd6p-2f, 0.0f},
        {0.0f, 0x1.9ad194p16f, 0.0f, 0x1.2f0c1cp15f, 0.0f, 0x1.933602p-1f, 0.0f, -0x1.5d5ddcp-4f},
        {0.0f, -0x1.f1aa16p16f, 0.0f, -0x1.bd8bcep13f, 0.0f, -0x1.57b644p-1f, 0.0f, 0x1.842fd6p-2f},
        {-0x1.4386c2p8f, 0.0f, -0x1.98cdcap4f, 0.0f, -0x1.76f0a4p-16f, 0.0f, 0x1.e98538p-18f, 0.0f},
        {-0x1.303bcap7f, 0.0f, 0x1.dd24bcp5f, 0.0f, 0x1.7c8bb8p-15f, 0.0f, -0x1.055258p-16f, 0.0f},
        {0.0f, -0x1.4386c2p8f, 0.0f, -0x1.98cdcap4f, 0.0f, -0x1.76f0a4p-16f, 0.0f, 0x1.e98538p-18f},
        {0.0f, -0x1.303bcap7f, 0.0f, 0x1.dd24bcp5f, 0.0f, 0x1.7c8bb8p-15f, 0.0f, -0x1.055258p-16f},
        {0x1.6498a8p5f, 0.0f, -0x1.0e41b8p4f, 0.0f, 0x1.08436cp-19f, 0.0f, -0x1.650958p-21f, 0.0f},
        {0x1.5ef936p6f, 0.0f, -0x1.97fd62p5f, 0.0f, 0x1.76ac34p-16f, 0.0f, -0x1.00276ep-17f, 0.0f},
        {0.0f, 0x1.6498a8p5f, 0.0f, -0x1.0e41b8p4f, 0.0f, 0x1.08436cp-19f, 0.0f, -0x1.650958p-21f},
        {0.0f, 0x1.5ef936p6f, 0.0f, -0x1.97fd62p5f, 0.0f, 0x1.76ac34p-16f, 0.0f, -0x1.00276ep-17f},
        {-0x1.24dee4p8f, 0.0f, -0x1.fd806ap7f, 0.0f, 0x1.5e9b4ap-15f, 0.0f, -0x1.daaf8ap-17f, 0.0f},
        {-0x1.3d388ap9f, 0.0f, -0x1.8b8ea6p0f, 0.0f, -0x1.99800ep-13f, 0.0f, 0x1.17f628p-14f, 0.0f},
        {0.0f, -0x1.24dee4p8f, 0.0f, -0x1.fd806ap7f, 0.0f, 0x1.5e9b4ap-15f, 0.0f, -0x1.daaf8ap-17f},
        {0.0f, -0x1.3d388ap9f, 0.0f, -0x1.8b8ea6p0f, 0.0f, -0x1.99800ep-13f, 0.0f, 0x1.17f628p-14f},
        {-0x1.52b4f0p7f, 0.0f, 0x1.b1397ep7f, 0.0f, 0x1.6e32dcp-17f, 0.0f, -0x1.f62fbcp-19f, 0.0f},
        {0x1.575beap5f, 0.0f, 0x1.3cf424p6f, 0.0f, -0x1.79070cp-16f, 0.0f, 0x1.0171e2p-17f, 0.0f},
        {0.0f, -0x1.52b4f0p7f, 0.0f, 0x1.b1397ep7f, 0.0f, 0x1.6e32dcp-17f, 0.0f, -0x1.f62fbcp-19f},
        {0.0f, 0x1.575beap5f, 0.0f, 0x1.3cf424p6f, 0.0f, -0x1.79070cp-16f, 0.0f, 0x1.0171e2p-17f},
        {-0x1.244208p7f, 0.0f, -0x1.9dd0f6p8f, 0.0f, 0x1.0728f2p-15f, 0.0f, -0x1.6384c4p-17f, 0.0f},
        {-0x1.4cff4cp7f, 0.0f, 0x1.2da714p9f, 0.0f, 0x1.09e89cp-13f, 0.0f, -0x1.6a4eeep-15f, 0.0f},
        {0.0f, -0x1.244208p7f, 0.0f, -0x1.9dd0f6p8f, 0.0f, 0x1.0728f2p-15f, 0.0f, -0x1.6384c4p-17f},
        {0.0f, -0x1.4cff4cp7f, 0.0f, 0x1.2da714p9f, 0.0f, 0x1.09e89cp-13f, 0.0f, -0x1.6a4eeep-15f},
        {0x1.cb6892p8f, 0.0f, -0x1.363eaep6f, 0.0f, -0x1.5ea73ep-10f, 0.0f, 0x1.e0af16p-12f, 0.0f},
        {0x1.871f9cp9f, 0.0f, 0x1.b1602ap7f, 0.0f, 0x1.9e161ep-14f, 0.0f, -0x1.1cb9aap-15f, 0.0f},
        {0.0f, 0x1.cb6892p8f, 0.0f, -0x1.363eaep6f, 0.0f, -0x1.5ea73ep-10f, 0.0f, 0x1.e0af16p-12f},
        {0.0f, 0x1.871f9cp9f, 0.0f, 0x1.b1602ap7f, 0.0f, 0x1.9e161ep-14f, 0.0f, -0x1.1cb9aap-15f},
        {0x1.0ecf4ap5f, 0.0f, 0x1.3fd48cp6f, 0.0f, 0x1.3094f6p-18f, 0.0f, -0x1.c13deep-20f, 0.0f},
        {-0x1.9daf7ap5f, 0.0f, -0x1.4035b8p8f, 0.0f, -0x1.5e931ep-18f, 0.0f, 0x1.ba3f38p-20f, 0.0f},
        {0.0f, 0x1.0ecf4ap5f, 0.0f, 0x1.3fd48cp6f, 0.0f, 0x1.3094f6p-18f, 0.0f, -0x1.c13deep-20f},
        {0.0f, -0x1.9daf7ap5f, 0.0f, -0x1.4035b8p8f, 0.0f, -0x1.5e931ep-18f, 0.0f, 0x1.ba3f38p-20f},
        {-0x1.7fbef4p8f, 0.0f, 0x1.03e490p7f, 0.0f, 0x1.2629f4p-12f, 0.0f, -0x1.92a4dap-14f, 0.0f},
        {-0x1.82a85ep8f, 0.0f, 0x1.1e4956p10f, 0.0f, 0x1.1cf6cep-10f, 0.0f, -0x1.859cdap-12f, 0.0f},
        {0.0f, -0x1.7fbef4p8f, 0.0f, 0x1.03e490p7f, 0.0f, 0x1.2629f4p-12f, 0.0f, -0x1.92a4dap-14f},
        {0.0f, -0x1.82a85ep8f, 0.0f, 0x1.1e4956p10f, 0.0f, 0x1.1cf6cep-10f, 0.0f, -0x1.859cdap-12f},
        {0x1.1f7394p0f, 0.0f, -0x1.13acbcp1f, -0.0f, -0x1.5c0518p-19f, -0.0f, 0x1.d9e968p-21f, 0.0f},
        {0.0f, 0x1.1f7394p0f, 0.0f, -0x1.13acbcp1f, 0.0f, -0x1.5c0518p-19f, 0.0f, 0x1.d9e968p-21f},
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
/* Over the test vectors Q31 stays within 5.408e-4 A of exact arithmetic (bound from rounding and coefficients). */

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
        int64_t u0 = 185149 * (int64_t)v, u2 = 262144 * (int64_t)v;
        v = x[1]; u0 += 172201 * (int64_t)v; u2 += 262144 * (int64_t)v;
        v = x[4]; u0 += 75222969 * (int64_t)v; u2 += 49469949 * (int64_t)v;
        v = x[5]; u0 += 14021096 * (int64_t)v; u2 += -63763275 * (int64_t)v;
        v = x[8]; u0 += 192485730 * (int64_t)v; u2 += -333991011 * (int64_t)v;
        v = x[9]; u0 += -121796905 * (int64_t)v; u2 += 107592991 * (int64_t)v;
        v = x[12]; u0 += -310611871 * (int64_t)v; u2 += -52969234 * (int64_t)v;
        v = x[13]; u0 += -80940379 * (int64_t)v; u2 += 93669659 * (int64_t)v;
        v = x[16]; u0 += -711978090 * (int64_t)v; u2 += 201330082 * (int64_t)v;
        v = x[17]; u0 += 16296788 * (int64_t)v; u2 += -153360953 * (int64_t)v;
        v = x[20]; u0 += 162105841 * (int64_t)v; u2 += -60348682 * (int64_t)v;
        v = x[21]; u0 += 11148704 * (int64_t)v; u2 += -42678632 * (int64_t)v;
        v = x[24]; u0 += -29205907 * (int64_t)v; u2 += -8982586 * (int64_t)v;
        v = x[25]; u0 += 57906485 * (int64_t)v; u2 += -2204302 * (int64_t)v;
        v = x[28]; u0 += -81125328 * (int64_t)v; u2 += -10105979 * (int64_t)v;
        v = x[29]; u0 += -29411327 * (int64_t)v; u2 += 17413543 * (int64_t)v;
        v = x[32]; u0 += 56912216 * (int64_t)v; u2 += -9411239 * (int64_t)v;
        v = x[33]; u0 += 79303632 * (int64_t)v; u2 += -13849912 * (int64_t)v;
        v = x[36]; u0 += -5080260 * (int64_t)v; u2 += 4026166 * (int64_t)v;
        v = y0; u0 += -47029176 * (int64_t)v; u2 += 21430258 * (int64_t)v;
        v = y2; u0 += 2912888 * (int64_t)v; u2 += -5662771 * (int64_t)v;
        u[0] = paper_tool_q31_current(c, 0, u0, 19);
        u[2] = paper_tool_q31_current(c, 2, u2, 18);
    }
    {
        int32_t v = x[2];
        int64_t u1 = 185149 * (int64_t)v, u3 = 262144 * (int64_t)v;
        v = x[3]; u1 += 172201 * (int64_t)v; u3 += 262144 * (int64_t)v;
        v = x[6]; u1 += 75222969 * (int64_t)v; u3 += 49469949 * (int64_t)v;
        v = x[7]; u1 += 14021096 * (int64_t)v; u3 += -63763275 * (int64_t)v;
        v = x[10]; u1 += 192485730 * (int64_t)v; u3 += -333991011 * (int64_t)v;
        v = x[11]; u1 += -121796905 * (int64_t)v; u3 += 107592991 * (int64_t)v;
        v = x[14]; u1 += -310611871 * (int64_t)v; u3 += -52969234 * (int64_t)v;
        v = x[15]; u1 += -80940379 * (int64_t)v; u3 += 93669659 * (int64_t)v;
        v = x[18]; u1 += -711978090 * (int64_t)v; u3 += 201330082 * (int64_t)v;
        v = x[19]; u1 += 16296788 * (int64_t)v; u3 += -153360953 * (int64_t)v;
        v = x[22]; u1 += 162105841 * (int64_t)v; u3 += -60348682 * (int64_t)v;
        v = x[23]; u1 += 11148704 * (int64_t)v; u3 += -42678632 * (int64_t)v;
        v = x[26]; u1 += -29205907 * (int64_t)v; u3 += -8982586 * (int64_t)v;
        v = x[27]; u1 += 57906485 * (int64_t)v; u3 += -2204302 * (int64_t)v;
        v = x[30]; u1 += -81125328 * (int64_t)v; u3 += -10105979 * (int64_t)v;
        v = x[31]; u1 += -29411327 * (int64_t)v; u3 += 17413543 * (int64_t)v;
        v = x[34]; u1 += 56912216 * (int64_t)v; u3 += -9411239 * (int64_t)v;
        v = x[35]; u1 += 79303632 * (int64_t)v; u3 += -13849912 * (int64_t)v;
        v = x[37]; u1 += -5080260 * (int64_t)v; u3 += 4026166 * (int64_t)v;
        v = y1; u1 += -47029176 * (int64_t)v; u3 += 21430258 * (int64_t)v;
        v = y3; u1 += 2912888 * (int64_t)v; u3 += -5662771 * (int64_t)v;
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
        x[0] = paper_tool_q31_round(-1663424 * (int64_t)x0 + 68452009 * (int64_t)y0 - 28869328 * (int64_t)y2 + 1073741824 * (int64_t)x0, 30);
    }
    {
        const int32_t x1 = x[1];
        x[1] = paper_tool_q31_round(-2233318 * (int64_t)x1 - 95661242 * (int64_t)y0 - 114801665 * (int64_t)y2 + 1073741824 * (int64_t)x1, 30);
    }
    {
        const int32_t x2 = x[2];
        x[2] = paper_tool_q31_round(-1663424 * (int64_t)x2 + 68452009 * (int64_t)y1 - 28869328 * (int64_t)y3 + 1073741824 * (int64_t)x2, 30);
    }
    {
        const int32_t x3 = x[3];
        x[3] = paper_tool_q31_round(-2233318 * (int64_t)x3 - 95661242 * (int64_t)y1 - 114801665 * (int64_t)y3 + 1073741824 * (int64_t)x3, 30);
    }
    {
        const int32_t x4 = x[4];
        const int32_t x5 = x[5];
        x[4] = paper_tool_q31_round(-85935476 * (int64_t)x4 + 660592446 * (int64_t)x5 + 19749505 * (int64_t)y0 - 10452263 * (int64_t)y2
            + 1073741824 * (int64_t)x4, 30);
        x[5] = paper_tool_q31_round(-165148111 * (int64_t)x4 - 85935476 * (int64_t)x5 - 16886899 * (int64_t)y0 + 290385 * (int64_t)y2
            + 1073741824 * (int64_t)x5, 30);
    }
    {
        const int32_t x6 = x[6];
        const int32_t x7 = x[7];
        x[6] = paper_tool_q31_round(-85935476 * (int64_t)x6 + 660592446 * (int64_t)x7 + 19749505 * (int64_t)y1 - 10452263 * (int64_t)y3
            + 1073741824 * (int64_t)x6, 30);
        x[7] = paper_tool_q31_round(-165148111 * (int64_t)x6 - 85935476 * (int64_t)x7 - 16886899 * (int64_t)y1 + 290385 * (int64_t)y3
            + 1073741824 * (int64_t)x7, 30);
    }
    {
        const int32_t x8 = x[8];
        const int32_t x9 = x[9];
        x[8] = paper_tool_q31_round(-150412779 * (int64_t)x8 + 503949121 * (int64_t)x9 - 9084778 * (int64_t)y0 + 5927119 * (int64_t)y2
            + 1073741824 * (int64_t)x8, 30);
        x[9] = paper_tool_q31_round(-503949121 * (int64_t)x8 - 150412779 * (int64_t)x9 + 8880802 * (int64_t)y0 - 4132476 * (int64_t)y2
            + 1073741824 * (int64_t)x9, 30);
    }
    {
        const int32_t x10 = x[10];
        const int32_t x11 = x[11];
        x[10] = paper_tool_q31_round(-150412779 * (int64_t)x10 + 503949121 * (int64_t)x11 - 9084778 * (int64_t)y1 + 5927119 * (int64_t)y3
            + 1073741824 * (int64_t)x10, 30);
        x[11] = paper_tool_q31_round(-503949121 * (int64_t)x10 - 150412779 * (int64_t)x11 + 8880802 * (int64_t)y1 - 4132476 * (int64_t)y3
            + 1073741824 * (int64_t)x11, 30);
    }
    {
        const int32_t x12 = x[12];
        const int32_t x13 = x[13];
        x[12] = paper_tool_q31_round(762659609 * (int64_t)x12 + 545884688 * (int64_t)x13 + 59973633 * (int64_t)y0 - 20453410 * (int64_t)y2, 30);
        x[13] = paper_tool_q31_round(-545884688 * (int64_t)x12 + 762659609 * (int64_t)x13 - 89217983 * (int64_t)y0 - 35362838 * (int64_t)y2, 30);
    }
    {
        const int32_t x14 = x[14];
        const int32_t x15 = x[15];
        x[14] = paper_tool_q31_round(762659609 * (int64_t)x14 + 545884688 * (int64_t)x15 + 59973633 * (int64_t)y1 - 20453410 * (int64_t)y3, 30);
        x[15] = paper_tool_q31_round(-545884688 * (int64_t)x14 + 762659609 * (int64_t)x15 - 89217983 * (int64_t)y1 - 35362838 * (int64_t)y3, 30);
    }
    {
        const int32_t x16 = x[16];
        const int32_t x17 = x[17];
        x[16] = paper_tool_q31_round(610622660 * (int64_t)x16 + 792348748 * (int64_t)x17 - 29485940 * (int64_t)y0 + 9435827 * (int64_t)y2, 30);
        x[17] = paper_tool_q31_round(-792348748 * (int64_t)x16 + 610622660 * (int64_t)x17 - 28960728 * (int64_t)y0 + 52935611 * (int64_t)y2, 30);
    }
    {
        const int32_t x18 = x[18];
        const int32_t x19 = x[19];
        x[18] = paper_tool_q31_round(610622660 * (int64_t)x18 + 792348748 * (int64_t)x19 - 29485940 * (int64_t)y1 + 9435827 * (int64_t)y3, 30);
        x[19] = paper_tool_q31_round(-792348748 * (int64_t)x18 + 610622660 * (int64_t)x19 - 28960728 * (int64_t)y1 + 52935611 * (int64_t)y3, 30);
    }
    {
        const int32_t x20 = x[20];
        const int32_t x21 = x[21];
        x[20] = paper_tool_q31_round(388611776 * (int64_t)x20 + 809079049 * (int64_t)x21 + 12079578 * (int64_t)y0 - 195622950 * (int64_t)y2, 30);
        x[21] = paper_tool_q31_round(-809079049 * (int64_t)x20 + 388611776 * (int64_t)x21 - 63595553 * (int64_t)y0 + 19277779 * (int64_t)y2, 30);
    }
    {
        const int32_t x22 = x[22];
        const int32_t x23 = x[23];
        x[22] = paper_tool_q31_round(388611776 * (int64_t)x22 + 809079049 * (int64_t)x23 + 12079578 * (int64_t)y1 - 195622950 * (int64_t)y3, 30);
        x[23] = paper_tool_q31_round(-809079049 * (int64_t)x22 + 388611776 * (int64_t)x23 - 63595553 * (int64_t)y1 + 19277779 * (int64_t)y3, 30);
    }
    {
        const int32_t x24 = x[24];
        const int32_t x25 = x[25];
        x[24] = paper_tool_q31_round(344852222 * (int64_t)x24 + 1410940978 * (int64_t)x25 + 32837469 * (int64_t)y0 - 104884444 * (int64_t)y2, 31);
        x[25] = paper_tool_q31_round(-705470489 * (int64_t)x24 + 172426111 * (int64_t)x25 + 295891471 * (int64_t)y0 + 38623403 * (int64_t)y2, 30);
    }
    {
        const int32_t x26 = x[26];
        const int32_t x27 = x[27];
        x[26] = paper_tool_q31_round(344852222 * (int64_t)x26 + 1410940978 * (int64_t)x27 + 32837469 * (int64_t)y1 - 104884444 * (int64_t)y3, 31);
        x[27] = paper_tool_q31_round(-705470489 * (int64_t)x26 + 172426111 * (int64_t)x27 + 295891471 * (int64_t)y1 + 38623403 * (int64_t)y3, 30);
    }
    {
        const int32_t x28 = x[28];
        const int32_t x29 = x[29];
        x[28] = paper_tool_q31_round(128550553 * (int64_t)x28 + 955195720 * (int64_t)x29 + 20293263 * (int64_t)y0 + 96828954 * (int64_t)y2, 30);
        x[29] = paper_tool_q31_round(-955195720 * (int64_t)x28 + 128550553 * (int64_t)x29 - 4125778 * (int64_t)y0 - 57232049 * (int64_t)y2, 30);
    }
    {
        const int32_t x30 = x[30];
        const int32_t x31 = x[31];
        x[30] = paper_tool_q31_round(128550553 * (int64_t)x30 + 955195720 * (int64_t)x31 + 20293263 * (int64_t)y1 + 96828954 * (int64_t)y3, 30);
        x[31] = paper_tool_q31_round(-955195720 * (int64_t)x30 + 128550553 * (int64_t)x31 - 4125778 * (int64_t)y1 - 57232049 * (int64_t)y3, 30);
    }
    {
        const int32_t x32 = x[32];
        const int32_t x33 = x[33];
        x[32] = paper_tool_q31_round(-626461633 * (int64_t)x32 + 764372523 * (int64_t)x33 - 193111810 * (int64_t)y0 - 130257687 * (int64_t)y2, 31);
        x[33] = paper_tool_q31_round(-382186262 * (int64_t)x32 - 313230816 * (int64_t)x33 - 238888717 * (int64_t)y0 + 409328667 * (int64_t)y2, 30);
    }
    {
        const int32_t x34 = x[34];
        const int32_t x35 = x[35];
        x[34] = paper_tool_q31_round(-626461633 * (int64_t)x34 + 764372523 * (int64_t)x35 - 193111810 * (int64_t)y1 - 130257687 * (int64_t)y3, 31);
        x[35] = paper_tool_q31_round(-382186262 * (int64_t)x34 - 313230816 * (int64_t)x35 - 238888717 * (int64_t)y1 + 409328667 * (int64_t)y3, 30);
    }
    {
        const int32_t x36 = x[36];
        x[36] = paper_tool_q31_round(-2142235812 * (int64_t)x36 + 1677689 * (int64_t)y0 - 2284032 * (int64_t)y2, 31);
    }
    {
        const int32_t x37 = x[37];
        x[37] = paper_tool_q31_round(-2142235812 * (int64_t)x37 + 1677689 * (int64_t)y1 - 2284032 * (int64_t)y3, 31);
    }

    if (c->limited) {
        const int32_t *e = c->excess;
        x[0] = paper_tool_q31_correct(x[0], 670852000 * (int64_t)e[0] + 515869044 * (int64_t)e[2], 18);
        x[1] = paper_tool_q31_correct(x[1], -643559598 * (int64_t)e[0] - 472353139 * (int64_t)e[2], 18);
        x[2] = paper_tool_q31_correct(x[2], 670852000 * (int64_t)e[1] + 515869044 * (int64_t)e[3], 18);
        x[3] = paper_tool_q31_correct(x[3], -643559598 * (int64_t)e[1] - 472353139 * (int64_t)e[3], 18);
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
        {896341982, 0, 330600867, 0, 79274501, 0, -8586034, 0},
        {-1085825754, 0, -121513982, 0, -67576527, 0, 38160321, 0},
        {0, 896341982, 0, 330600867, 0, 79274501, 0, -8586034},
        {0, -1085825754, 0, -121513982, 0, -67576527, 0, 38160321},
        {-1411767837, 0, -111493255, 0, -1151816, 0, 375952, 0},
        {-1327579941, 0, 520526172, 0, 4676147, 0, -1605560, 0},
        {0, -1411767837, 0, -111493255, 0, -1151816, 0, 375952},
        {0, -1327579941, 0, 520526172, 0, 4676147, 0, -1605560},
        {1556074627, 0, -589657791, 0, 811817, 0, -274204, 0},
        {765769164, 0, -445084888, 0, 2301989, 0, -786905, 0},
        {0, 1556074627, 0, -589657791, 0, 811817, 0, -274204},
        {0, 765769164, 0, -445084888, 0, 2301989, 0, -786905},
        {-638997930, 0, -555826361, 0, 1077063, 0, -364559, 0},
        {-1384252505, 0, -3371265, 0, -5031939, 0, 1720084, 0},
        {0, -638997930, 0, -555826361, 0, 1077063, 0, -364559},
        {0, -1384252505, 0, -3371265, 0, -5031939, 0, 1720084},
        {-739005191, 0, 945228183, 0, 562481, 0, -192840, 0},
        {749155664, 0, 1383086516, 0, -4632914, 0, 1581741, 0},
        {0, -739005191, 0, 945228183, 0, 562481, 0, -192840},
        {0, 749155664, 0, 1383086516, 0, -4632914, 0, 1581741},
        {-318830507, 0, -902882283, 0, 808427, 0, -273038, 0},
        {-363273912, 0, 1316317719, 0, 3267485, 0, -1113011, 0},
        {0, -318830507, 0, -902882283, 0, 808427, 0, -273038},
        {0, -363273912, 0, 1316317719, 0, 3267485, 0, -1113011},
        {1002357376, 0, -169226413, 0, -34470622, 0, 11813288, 0},
        {853370188, 0, 236389450, 0, 1272073, 0, -437338, 0},
        {0, 1002357376, 0, -169226413, 0, -34470622, 0, 11813288},
        {0, 853370188, 0, 236389450, 0, 1272073, 0, -437338},
        {590864407, 0, 1395639129, 0, 935676, 0, -345018, 0},
        {-225649221, 0, -1397295458, 0, -269241, 0, 84911, 0},
        {0, 590864407, 0, 1395639129, 0, 935676, 0, -345018},
        {0, -225649221, 0, -1397295458, 0, -269241, 0, 84911},
        {-837273466, 0, 283522713, 0, 7229372, 0, -2473844, 0},
        {-421813267, 0, 1249264531, 0, 14006555, 0, -4787561, 0},
        {0, -837273466, 0, 283522713, 0, 7229372, 0, -2473844},
        {0, -421813267, 0, 1249264531, 0, 14006555, 0, -4787561},
        {627174118, 0, -1202958178, 0, -17105873, 0, 5823428, 0},
        {0, 627174118, 0, -1202958178, 0, -17105873, 0, 5823428},
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
