/* Magnetic-bearing controller: u = K y, written by muspin.
 *
 * Controller: {{ controller }}
 * Machine:    {{ machine }}
 * SHA-256 of the controller JSON: {{ sha256 }}
 * Stability:  {{ stability }}
 *
 * Form: {{ form }}; {{ states }} states, {{ signals }} signals, {{ inputs }} inputs, {{ outputs }} outputs.
{%- for note in notes %}
 * Note: {{ note }}.
{%- endfor %}
 * Sample time {{ sample_time }} s. Inputs: displacements {{ axes }}, m. Outputs: currents, A.
 * Per sample: {{ products }} products; the outputs leave after the first {{ output_products }} of them.
 * Memory of one instance: {{ bytes }} bytes (float32), {{ q31_bytes }} bytes (Q31). Coefficients are part of the code.
 *
 * One sample is output() and then update(); step() does both. Write the currents to the amplifiers between the two.
 *
 * Limits: inputs beyond +-{{ input_limit }} m and outputs beyond +-{{ output_limit }} A are clamped. States are scaled so that
 * inputs within the limit never drive them beyond +-1, but for slow real ones (integrators and poles below 10 Hz): each ends
 * where it alone would make a whole output.{{ anti_windup }} While no clamp acts the controller is linear.
 *
 * float32: a displacement that is NaN or infinite is replaced by the last valid one of its channel and counted in
 * `status`. If an output is NaN, or so large that no plausible state gives it (memory that was not set, or was
 * overwritten), all states restart from zero in the same sample; `status` counts that too. Outputs are never NaN.
 * Products and sums are rounded one by one; the source switches contraction to fused multiply-add off and refuses
 * -ffast-math. The test vectors then come out bit for bit.
 * Q31: y and u are fractions of {{ NAME }}_INPUT_LIMIT_M and {{ NAME }}_OUTPUT_LIMIT_A times 2^31; 64-bit sums,
 * rounded to nearest, saturated. An invalid sample has no representation in Q31: give the last valid one.
 * MUSPIN_NO_F32 or MUSPIN_NO_Q31 leaves one of the two out.
 *
 * Change of controller at run time: {{ name }}_f32_hand_over() continues the currents of another controller.
 *
 * Generic names: muspin_f32, muspin_f32_step, MUSPIN_INPUTS ... stand for {{ name }}_f32, {{ name }}_f32_step,
 * {{ NAME }}_INPUTS ... as long as a source file includes the header of one controller only.
 * Self test: cc -DMUSPIN_SELF_TEST controller.c -o selftest && ./selftest test_vectors.csv
 */
#ifndef {{ NAME }}_CONTROLLER_H
#define {{ NAME }}_CONTROLLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define {{ NAME }}_INPUTS {{ inputs }}
#define {{ NAME }}_OUTPUTS {{ outputs }}
#define {{ NAME }}_STATES {{ states }}
#define {{ NAME }}_SIGNALS {{ signals }}
#define {{ NAME }}_SAMPLE_TIME_S {{ sample_time }}
#define {{ NAME }}_INPUT_LIMIT_M {{ input_limit }}
#define {{ NAME }}_OUTPUT_LIMIT_A {{ output_limit }}
/* 1: the closed loop is proven stable at every speed of the range; 0: it is not, see above. */
#define {{ NAME }}_VERIFIED {{ verified }}
#define {{ NAME }}_INPUT_SHA256 "{{ sha256 }}"

#ifndef MUSPIN_NO_F32
typedef struct {
    float state[{{ state_room }}];
    float y_m[{{ input_room }}]; /* last valid displacements, within the limit */
{%- if signals > 0 %}
    float signal[{{ signals }}];
{%- endif %}
{%- if conditioned %}
    float excess_a[{{ output_room }}]; /* what the limit took from the outputs of this sample */
    int limited; /* 1 when it took anything */
{%- endif %}
    uint32_t status; /* bits 0 to 15: samples replaced; bits 16 to 31: restarts; both stop at 65535 */
} {{ name }}_f32;
/* Sets states and status to zero. */
void {{ name }}_f32_init({{ name }}_f32 *c);
/* First half of a sample: currents (A) from displacements (m). */
void {{ name }}_f32_output({{ name }}_f32 *c, const float y_m[{{ input_room }}], float u_a[{{ output_room }}]);
/* Second half of a sample: advances the states. */
void {{ name }}_f32_update({{ name }}_f32 *c);
/* Both halves. */
void {{ name }}_f32_step({{ name }}_f32 *c, const float y_m[{{ input_room }}], float u_a[{{ output_room }}]);
/* Bumpless hand-over, after init(): from the displacements now and the currents of the last sample of another controller,
 * sets the states so that output() with these displacements repeats these currents and, while the displacements stay,
 * moves away from them as little as possible. */
void {{ name }}_f32_hand_over({{ name }}_f32 *c, const float y_m[{{ input_room }}], const float u_a[{{ output_room }}]);
/* The states, for telemetry: {{ NAME }}_STATES values. */
const float *{{ name }}_f32_state(const {{ name }}_f32 *c);
/* Samples replaced so far, and restarts so far. */
uint32_t {{ name }}_f32_bad_samples(const {{ name }}_f32 *c);
uint32_t {{ name }}_f32_restarts(const {{ name }}_f32 *c);
#endif

#ifndef MUSPIN_NO_Q31
typedef struct {
    int32_t state[{{ state_room }}];
    int32_t y[{{ input_room }}];
{%- if signals > 0 %}
    int32_t signal[{{ signals }}];
{%- endif %}
{%- if conditioned %}
    int32_t excess[{{ output_room }}];
    int limited;
{%- endif %}
} {{ name }}_q31;
/* The same functions; displacements and currents are Q31 fractions of full scale. */
void {{ name }}_q31_init({{ name }}_q31 *c);
void {{ name }}_q31_output({{ name }}_q31 *c, const int32_t y[{{ input_room }}], int32_t u[{{ output_room }}]);
void {{ name }}_q31_update({{ name }}_q31 *c);
void {{ name }}_q31_step({{ name }}_q31 *c, const int32_t y[{{ input_room }}], int32_t u[{{ output_room }}]);
void {{ name }}_q31_hand_over({{ name }}_q31 *c, const int32_t y[{{ input_room }}], const int32_t u[{{ output_room }}]);
const int32_t *{{ name }}_q31_state(const {{ name }}_q31 *c);
#endif

#ifdef __cplusplus
}
#endif

/* Generic names belong to the only controller of a source file; the header of a second one withdraws them. */
#ifndef MUSPIN_GENERIC_NAMES
#define MUSPIN_GENERIC_NAMES
{%- for generic in generics %}
#define {{ generic[0] }} {{ generic[1] }}
{%- endfor %}
#else
{%- for generic in generics %}
#undef {{ generic[0] }}
{%- endfor %}
#endif

#endif
