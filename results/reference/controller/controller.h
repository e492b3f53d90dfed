/* Magnetic-bearing controller: u = K y, written by muspin.
 *
 * Controller: mu
 * Machine:    reference with paper-tool
 * SHA-256 of the controller JSON: d54c0f966847954fd967f111b75d90c992310f6a9b8246e97c53231d9c9d0e12
 * Stability:  verified, closed loop proven stable at every speed from 0 to 50000 rpm and computed at 11 speeds from 0 to 50000 rpm (full finite-element plant, exact delay, sampled; coefficients rounded to float32); slowest decay 32.60 1/s; peak of mu 0.9836
 *
 * Form: real modal form; 38 states, 0 signals, 4 inputs, 4 outputs.
 * Sample time 5e-5 s. Inputs: displacements front_x, front_y, rear_x, rear_y, m. Outputs: currents, A.
 * Per sample: 242 products; the outputs leave after the first 84 of them.
 * Memory of one instance: 192 bytes (float32), 188 bytes (Q31). Coefficients are part of the code.
 *
 * One sample is output() and then update(); step() does both. Write the currents to the amplifiers between the two.
 *
 * Limits: inputs beyond +-2.54e-4 m and outputs beyond +-3e0 A are clamped. States are scaled so that
 * inputs within the limit never drive them beyond +-1, but for slow real ones (integrators and poles below 10 Hz): each ends
 * where it alone would make a whole output.
 * For slow real poles +-1 is the output limit; they are clamped there, so that they do not wind up.
 * Anti-windup: while an output is limited, the slow states are corrected by a gain times what the limit took away. While no clamp acts the controller is linear.
 *
 * float32: a displacement that is NaN or infinite is replaced by the last valid one of its channel and counted in
 * `status`. If an output is NaN, or so large that no plausible state gives it (memory that was not set, or was
 * overwritten), all states restart from zero in the same sample; `status` counts that too. Outputs are never NaN.
 * Products and sums are rounded one by one; the source switches contraction to fused multiply-add off and refuses
 * -ffast-math. The test vectors then come out bit for bit.
 * Q31: y and u are fractions of PAPER_TOOL_INPUT_LIMIT_M and PAPER_TOOL_OUTPUT_LIMIT_A times 2^31; 64-bit sums,
 * rounded to nearest, saturated. An invalid sample has no representation in Q31: give the last valid one.
 * MUSPIN_NO_F32 or MUSPIN_NO_Q31 leaves one of the two out.
 *
 * Change of controller at run time: paper_tool_f32_hand_over() continues the currents of another controller.
 *
 * Generic names: muspin_f32, muspin_f32_step, MUSPIN_INPUTS ... stand for paper_tool_f32, paper_tool_f32_step,
 * PAPER_TOOL_INPUTS ... as long as a source file includes the header of one controller only.
 * Self test: cc -DMUSPIN_SELF_TEST controller.c -o selftest && ./selftest test_vectors.csv
 */
#ifndef PAPER_TOOL_CONTROLLER_H
#define PAPER_TOOL_CONTROLLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PAPER_TOOL_INPUTS 4
#define PAPER_TOOL_OUTPUTS 4
#define PAPER_TOOL_STATES 38
#define PAPER_TOOL_SIGNALS 0
#define PAPER_TOOL_SAMPLE_TIME_S 5e-5
#define PAPER_TOOL_INPUT_LIMIT_M 2.54e-4
#define PAPER_TOOL_OUTPUT_LIMIT_A 3e0
/* 1: the closed loop is proven stable at every speed of the range; 0: it is not, see above. */
#define PAPER_TOOL_VERIFIED 1
#define PAPER_TOOL_INPUT_SHA256 "d54c0f966847954fd967f111b75d90c992310f6a9b8246e97c53231d9c9d0e12"

#ifndef MUSPIN_NO_F32
typedef struct {
    float state[38];
    float y_m[4]; /* last valid displacements, within the limit */
    float excess_a[4]; /* what the limit took from the outputs of this sample */
    int limited; /* 1 when it took anything */
    uint32_t status; /* bits 0 to 15: samples replaced; bits 16 to 31: restarts; both stop at 65535 */
} paper_tool_f32;
/* Sets states and status to zero. */
void paper_tool_f32_init(paper_tool_f32 *c);
/* First half of a sample: currents (A) from displacements (m). */
void paper_tool_f32_output(paper_tool_f32 *c, const float y_m[4], float u_a[4]);
/* Second half of a sample: advances the states. */
void paper_tool_f32_update(paper_tool_f32 *c);
/* Both halves. */
void paper_tool_f32_step(paper_tool_f32 *c, const float y_m[4], float u_a[4]);
/* Bumpless hand-over, after init(): from the displacements now and the currents of the last sample of another controller,
 * sets the states so that output() with these displacements repeats these currents and, while the displacements stay,
 * moves away from them as little as possible. */
void paper_tool_f32_hand_over(paper_tool_f32 *c, const float y_m[4], const float u_a[4]);
/* The states, for telemetry: PAPER_TOOL_STATES values. */
const float *paper_tool_f32_state(const paper_tool_f32 *c);
/* Samples replaced so far, and restarts so far. */
uint32_t paper_tool_f32_bad_samples(const paper_tool_f32 *c);
uint32_t paper_tool_f32_restarts(const paper_tool_f32 *c);
#endif

#ifndef MUSPIN_NO_Q31
typedef struct {
    int32_t state[38];
    int32_t y[4];
    int32_t excess[4];
    int limited;
} paper_tool_q31;
/* The same functions; displacements and currents are Q31 fractions of full scale. */
void paper_tool_q31_init(paper_tool_q31 *c);
void paper_tool_q31_output(paper_tool_q31 *c, const int32_t y[4], int32_t u[4]);
void paper_tool_q31_update(paper_tool_q31 *c);
void paper_tool_q31_step(paper_tool_q31 *c, const int32_t y[4], int32_t u[4]);
void paper_tool_q31_hand_over(paper_tool_q31 *c, const int32_t y[4], const int32_t u[4]);
const int32_t *paper_tool_q31_state(const paper_tool_q31 *c);
#endif

#ifdef __cplusplus
}
#endif

/* Generic names belong to the only controller of a source file; the header of a second one withdraws them. */
#ifndef MUSPIN_GENERIC_NAMES
#define MUSPIN_GENERIC_NAMES
#define muspin_f32 paper_tool_f32
#define muspin_f32_init paper_tool_f32_init
#define muspin_f32_output paper_tool_f32_output
#define muspin_f32_update paper_tool_f32_update
#define muspin_f32_step paper_tool_f32_step
#define muspin_f32_hand_over paper_tool_f32_hand_over
#define muspin_f32_state paper_tool_f32_state
#define muspin_f32_bad_samples paper_tool_f32_bad_samples
#define muspin_f32_restarts paper_tool_f32_restarts
#define muspin_q31 paper_tool_q31
#define muspin_q31_init paper_tool_q31_init
#define muspin_q31_output paper_tool_q31_output
#define muspin_q31_update paper_tool_q31_update
#define muspin_q31_step paper_tool_q31_step
#define muspin_q31_hand_over paper_tool_q31_hand_over
#define muspin_q31_state paper_tool_q31_state
#define MUSPIN_INPUTS PAPER_TOOL_INPUTS
#define MUSPIN_OUTPUTS PAPER_TOOL_OUTPUTS
#define MUSPIN_STATES PAPER_TOOL_STATES
#define MUSPIN_SIGNALS PAPER_TOOL_SIGNALS
#define MUSPIN_SAMPLE_TIME_S PAPER_TOOL_SAMPLE_TIME_S
#define MUSPIN_INPUT_LIMIT_M PAPER_TOOL_INPUT_LIMIT_M
#define MUSPIN_OUTPUT_LIMIT_A PAPER_TOOL_OUTPUT_LIMIT_A
#define MUSPIN_VERIFIED PAPER_TOOL_VERIFIED
#define MUSPIN_INPUT_SHA256 PAPER_TOOL_INPUT_SHA256
#else
#undef muspin_f32
#undef muspin_f32_init
#undef muspin_f32_output
#undef muspin_f32_update
#undef muspin_f32_step
#undef muspin_f32_hand_over
#undef muspin_f32_state
#undef muspin_f32_bad_samples
#undef muspin_f32_restarts
#undef muspin_q31
#undef muspin_q31_init
#undef muspin_q31_output
#undef muspin_q31_update
#undef muspin_q31_step
#undef muspin_q31_hand_over
#undef muspin_q31_state
#undef MUSPIN_INPUTS
#undef MUSPIN_OUTPUTS
#undef MUSPIN_STATES
#undef MUSPIN_SIGNALS
#undef MUSPIN_SAMPLE_TIME_S
#undef MUSPIN_INPUT_LIMIT_M
#undef MUSPIN_OUTPUT_LIMIT_A
#undef MUSPIN_VERIFIED
#undef MUSPIN_INPUT_SHA256
#endif

#endif
