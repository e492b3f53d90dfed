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

static const float {{ name }}_f32_input_limit = {{ input_limit_f32 }};
static const float {{ name }}_f32_output_limit = {{ output_limit_f32 }};
static const float {{ name }}_f32_output_guard = {{ output_guard_f32 }};

static float {{ name }}_f32_clamp(float value, float limit)
{
    if (value > limit) {
        return limit;
    }
    return value < -limit ? -limit : value;
}

/* Keeps the displacements within the limit; one that is not a finite number leaves the one before in place. */
static void {{ name }}_f32_hold({{ name }}_f32 *c, const float *y_m)
{
    int i;
    for (i = 0; i < {{ inputs }}; ++i) {
        const float sample = y_m[i];
        if (sample <= {{ name }}_f32_input_limit && sample >= -{{ name }}_f32_input_limit) {
            c->y_m[i] = sample;
        } else if (sample <= FLT_MAX && sample >= -FLT_MAX) {
            c->y_m[i] = {{ name }}_f32_clamp(sample, {{ name }}_f32_input_limit);
        } else if ((c->status & 65535u) < 65535u) {
            ++c->status;
        }
    }
}

/* Signals, and outputs before their limit. */
static void {{ name }}_f32_sums({{ name }}_f32 *c, float *u)
{
{%- if output_reads_states %}
    const float *x = c->state;
{%- endif %}
{%- if output_reads_inputs %}
    const float *y = c->y_m;
{%- endif %}
{%- if signals > 0 %}
    float *t = c->signal;
{%- endif %}
{{ f32_output }}
{%- if outputs_unused %}
    (void)c;
{%- endif %}
}

/* Called when an output is beyond its limit or NaN: restarts from zero states if no plausible state gives such an output,
 * then limits. */
static void {{ name }}_f32_limit({{ name }}_f32 *c, float *u)
{
    int i, plausible = 1;
    for (i = 0; i < {{ outputs }}; ++i) {
        plausible = plausible && u[i] <= {{ name }}_f32_output_guard && u[i] >= -{{ name }}_f32_output_guard;
    }
    if (!plausible) {
        for (i = 0; i < {{ states }}; ++i) {
            c->state[i] = 0.0f;
        }
        if ((c->status >> 16) < 65535u) {
            c->status += (uint32_t)65536u;
        }
        {{ name }}_f32_sums(c, u);
    }
    for (i = 0; i < {{ outputs }}; ++i) {
        const float wanted = u[i] == u[i] ? u[i] : 0.0f;
        u[i] = {{ name }}_f32_clamp(wanted, {{ name }}_f32_output_limit);
{%- if conditioned %}
        c->excess_a[i] = u[i] - wanted;
    }
    c->limited = 1;
{%- else %}
    }
{%- endif %}
}

void {{ name }}_f32_init({{ name }}_f32 *c)
{
    int i;
    for (i = 0; i < {{ state_room }}; ++i) {
        c->state[i] = 0.0f;
    }
    for (i = 0; i < {{ input_room }}; ++i) {
        c->y_m[i] = 0.0f;
    }
{%- if signals > 0 %}
    for (i = 0; i < {{ signals }}; ++i) {
        c->signal[i] = 0.0f;
    }
{%- endif %}
{%- if conditioned %}
    for (i = 0; i < {{ outputs }}; ++i) {
        c->excess_a[i] = 0.0f;
    }
    c->limited = 0;
{%- endif %}
    c->status = 0;
}

void {{ name }}_f32_output({{ name }}_f32 *c, const float y_m[{{ input_room }}], float u_a[{{ output_room }}])
{
    int i, within = 1;
{%- if conditioned %}
    c->limited = 0;
{%- endif %}
    {{ name }}_f32_hold(c, y_m);
    {{ name }}_f32_sums(c, u_a);
    for (i = 0; i < {{ outputs }}; ++i) {
        within = within && u_a[i] <= {{ name }}_f32_output_limit && u_a[i] >= -{{ name }}_f32_output_limit;
    }
    if (!within) {
        {{ name }}_f32_limit(c, u_a);
    }
}

void {{ name }}_f32_update({{ name }}_f32 *c)
{
{%- if states > 0 %}
    float *x = c->state;
{%- if update_reads_inputs %}
    const float *y = c->y_m;
{%- endif %}
{%- if signals > 0 %}
    const float *t = c->signal;
{%- endif %}
{{ f32_update }}
{%- if conditioned %}
    if (c->limited) {
        const float *e = c->excess_a;
{{ f32_conditioning }}    }
{%- endif %}
{{ f32_clamps }}
{%- else %}
    (void)c;
{%- endif %}
}

void {{ name }}_f32_step({{ name }}_f32 *c, const float y_m[{{ input_room }}], float u_a[{{ output_room }}])
{
    {{ name }}_f32_output(c, y_m, u_a);
    {{ name }}_f32_update(c);
}

void {{ name }}_f32_hand_over({{ name }}_f32 *c, const float y_m[{{ input_room }}], const float u_a[{{ output_room }}])
{
{%- if states > 0 %}
    static const float map[{{ states }}][{{ inputs + outputs }}] = {
{{ f32_hand_over }}    };
    int i, j;
    {{ name }}_f32_hold(c, y_m);
    for (i = 0; i < {{ states }}; ++i) {
        float sum = 0.0f;
        for (j = 0; j < {{ inputs }}; ++j) {
            sum += map[i][j] * c->y_m[j];
        }
        for (j = 0; j < {{ outputs }}; ++j) {
            sum += map[i][{{ inputs }} + j] * (u_a[j] == u_a[j] ? {{ name }}_f32_clamp(u_a[j], {{ name }}_f32_output_limit) : 0.0f);
        }
        c->state[i] = sum;
    }
{%- else %}
    (void)u_a;
    {{ name }}_f32_hold(c, y_m);
{%- endif %}
}

const float *{{ name }}_f32_state(const {{ name }}_f32 *c)
{
    return c->state;
}

uint32_t {{ name }}_f32_bad_samples(const {{ name }}_f32 *c)
{
    return c->status & 65535u;
}

uint32_t {{ name }}_f32_restarts(const {{ name }}_f32 *c)
{
    return c->status >> 16;
}
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
#endif

#ifndef MUSPIN_NO_Q31
/* Over the test vectors Q31 stays within {{ error_bound }} A of exact arithmetic (bound from rounding and coefficients). */

/* Right shifts of negative numbers must be arithmetic, as on every usual target. */
typedef char {{ name }}_arithmetic_shift[((-1) >> 1) == -1 ? 1 : -1];

static int32_t {{ name }}_q31_saturate(int64_t value)
{
    if (value > INT32_MAX) {
        return INT32_MAX;
    }
    return value < -INT32_MAX ? -INT32_MAX : (int32_t)value;
}

static int32_t {{ name }}_q31_round(int64_t sum, int shift)
{
    return {{ name }}_q31_saturate((sum + ((int64_t)1 << (shift - 1))) >> shift);
}

{%- if conditioned %}
/* A current, with what its limit takes away. */
static int32_t {{ name }}_q31_current({{ name }}_q31 *c, int i, int64_t sum, int shift)
{
    const int64_t wanted = (sum + ((int64_t)1 << (shift - 1))) >> shift;
    const int32_t current = {{ name }}_q31_saturate(wanted);
    c->excess[i] = 0;
    if (current != wanted) {
        c->excess[i] = {{ name }}_q31_saturate((current - wanted + (((int64_t)1 << {{ excess_shift }}) >> 1)) >> {{ excess_shift }});
        c->limited = 1;
    }
    return current;
}

static int32_t {{ name }}_q31_correct(int32_t state, int64_t sum, int shift)
{
    return {{ name }}_q31_saturate(state + ((sum + ((int64_t)1 << (shift - 1))) >> shift));
}
{% endif %}
void {{ name }}_q31_init({{ name }}_q31 *c)
{
    int i;
    for (i = 0; i < {{ state_room }}; ++i) {
        c->state[i] = 0;
    }
    for (i = 0; i < {{ input_room }}; ++i) {
        c->y[i] = 0;
    }
{%- if conditioned %}
    for (i = 0; i < {{ outputs }}; ++i) {
        c->excess[i] = 0;
    }
    c->limited = 0;
{%- endif %}
{%- if signals > 0 %}
    for (i = 0; i < {{ signals }}; ++i) {
        c->signal[i] = 0;
    }
{%- endif %}
}

void {{ name }}_q31_output({{ name }}_q31 *c, const int32_t y_in[{{ input_room }}], int32_t u[{{ output_room }}])
{
    int32_t *y = c->y;
{%- if output_reads_states %}
    const int32_t *x = c->state;
{%- endif %}
{%- if signals > 0 %}
    int32_t *t = c->signal;
{%- endif %}
    int i;
    for (i = 0; i < {{ inputs }}; ++i) {
        y[i] = y_in[i] < -INT32_MAX ? -INT32_MAX : y_in[i];
    }
{%- if conditioned %}
    c->limited = 0;
{%- endif %}
    {
{{ q31_output }}
    }
}

void {{ name }}_q31_update({{ name }}_q31 *c)
{
{%- if states > 0 %}
    int32_t *x = c->state;
{%- if update_reads_inputs %}
    const int32_t *y = c->y;
{%- endif %}
{%- if signals > 0 %}
    const int32_t *t = c->signal;
{%- endif %}
{{ q31_update }}
{%- if conditioned %}
    if (c->limited) {
        const int32_t *e = c->excess;
{{ q31_conditioning }}    }
{%- endif %}
{%- else %}
    (void)c;
{%- endif %}
}

void {{ name }}_q31_step({{ name }}_q31 *c, const int32_t y[{{ input_room }}], int32_t u[{{ output_room }}])
{
    {{ name }}_q31_output(c, y, u);
    {{ name }}_q31_update(c);
}

void {{ name }}_q31_hand_over({{ name }}_q31 *c, const int32_t y[{{ input_room }}], const int32_t u[{{ output_room }}])
{
{%- if states > 0 %}
    static const int32_t map[{{ states }}][{{ inputs + outputs }}] = {
{{ q31_hand_over }}    };
    static const int16_t shift[{{ states }}] = {
        {{ q31_hand_over_shifts }}};
    int i, j;
    for (i = 0; i < {{ states }}; ++i) {
        int64_t sum = 0;
        for (j = 0; j < {{ inputs }}; ++j) {
            sum += (int64_t)map[i][j] * {{ name }}_q31_saturate(y[j]);
        }
        for (j = 0; j < {{ outputs }}; ++j) {
            sum += (int64_t)map[i][{{ inputs }} + j] * {{ name }}_q31_saturate(u[j]);
        }
        c->state[i] = {{ name }}_q31_round(sum, shift[i]);
    }
{%- else %}
    (void)c;
    (void)y;
    (void)u;
{%- endif %}
}

const int32_t *{{ name }}_q31_state(const {{ name }}_q31 *c)
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
    {{ name }}_f32 f;
    {{ name }}_q31 q;
    long samples = 0, wrong_f32 = 0, wrong_q31 = 0;
    if (!file || !fgets(line, sizeof line, file)) {
        fprintf(stderr, "cannot read the test vectors\n");
        return 2;
    }
    {{ name }}_f32_init(&f);
    {{ name }}_q31_init(&q);
    while (fgets(line, sizeof line, file)) {
        float y[{{ input_room }}] = {0}, u[{{ output_room }}], expected[{{ output_room }}] = {0};
        int32_t yq[{{ input_room }}] = {0}, uq[{{ output_room }}];
        char *at = strchr(line, ',');
        int i;
        for (i = 0; i < {{ inputs }} && at; ++i) {
            y[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < {{ outputs }} && at; ++i) {
            expected[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < {{ inputs }} && at; ++i) {
            yq[i] = (int32_t)strtol(at + 1, &at, 10);
        }
        if (!at) {
            fprintf(stderr, "sample %ld: a column is missing\n", samples);
            return 2;
        }
        {{ name }}_f32_step(&f, y, u);
        {{ name }}_q31_step(&q, yq, uq);
        for (i = 0; i < {{ outputs }}; ++i) {
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
