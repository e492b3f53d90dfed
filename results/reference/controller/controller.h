/* Magnetic-bearing controller: u = K y, written by muspin.
 *
 * Controller: mu
 * Machine:    reference with paper-tool
 * SHA-256 of the controller JSON: 6a6e25b7c40222c68ab45af5caea48ac2bbc8ec80e7d06852ef455047a7eb0c9
 * Stability:  verified, closed loop stable at 11 speeds from 0 to 50000 rpm (full finite-element plant, exact delay, sampled; coefficients rounded to float32); slowest decay 49.24 1/s; peak of mu 0.9380
 *
 * Form: real modal form; 36 states, 0 signals, 4 inputs, 4 outputs.
 * Sample time 5e-5 s. Inputs: displacements front_x, front_y, rear_x, rear_y, m. Outputs: currents, A.
 * Per sample: 232 multiplications, 232 additions, plus clamps of 4 inputs, 4 outputs, 36 states.
 * Memory: float32 1240 bytes of tables, 144 bytes of state; Q31 1280 and 144.
 *
 * Limits: inputs beyond +-2.54e-4 m and outputs beyond +-3e0 A are clamped. States are scaled so that +-1
 * is their range for inputs within the limit and are clamped there; for slow real poles +-1 is the output limit, so
 * the clamp is the anti-windup. Within the limits no clamp acts and the controller is linear.
 *
 * float32: compile with -ffp-contract=off (no fused multiply-add); then the test vectors come out bit for bit.
 * Q31: y and u are fractions of MUSPIN_INPUT_LIMIT_M and MUSPIN_OUTPUT_LIMIT_A times 2^31; 64-bit sums, rounded to
 * nearest, saturated. MUSPIN_NO_F32 or MUSPIN_NO_Q31 leaves one of the two out.
 * Self test: cc -std=c99 -ffp-contract=off -DMUSPIN_SELF_TEST controller.c -o selftest && ./selftest test_vectors.csv
 */
#ifndef MUSPIN_CONTROLLER_H
#define MUSPIN_CONTROLLER_H

#include <stdint.h>

#define MUSPIN_INPUTS 4
#define MUSPIN_OUTPUTS 4
#define MUSPIN_STATES 36
#define MUSPIN_SIGNALS 0
#define MUSPIN_SAMPLE_TIME_S 5e-5
#define MUSPIN_INPUT_LIMIT_M 2.54e-4
#define MUSPIN_OUTPUT_LIMIT_A 3e0
/* 1: the closed loop was checked and is stable over the speed range; 0: it was not, see above. */
#define MUSPIN_VERIFIED 1
#define MUSPIN_INPUT_SHA256 "6a6e25b7c40222c68ab45af5caea48ac2bbc8ec80e7d06852ef455047a7eb0c9"

#ifndef MUSPIN_NO_F32
typedef struct { float state[36]; } muspin_f32;
/* Sets the states to zero. */
void muspin_f32_init(muspin_f32 *c);
/* One sample: currents (A) from displacements (m). Inputs must be numbers. */
void muspin_f32_step(muspin_f32 *c, const float y_m[MUSPIN_INPUTS], float u_a[MUSPIN_OUTPUTS]);
#endif

#ifndef MUSPIN_NO_Q31
typedef struct { int32_t state[36]; } muspin_q31;
/* Sets the states to zero. */
void muspin_q31_init(muspin_q31 *c);
/* One sample: currents from displacements, both as Q31 fractions of full scale. */
void muspin_q31_step(muspin_q31 *c, const int32_t y[MUSPIN_INPUTS], int32_t u[MUSPIN_OUTPUTS]);
#endif

#endif
