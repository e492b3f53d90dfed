/* Runs the test vectors of an exported controller through it, bit for bit, and counts instructions with SysTick, which
 * under QEMU's `-icount shift=0` advances by one nanosecond of virtual time an instruction. */
#include "controller.h"
#include "vectors.h"
#include <stdio.h>
#include <string.h>

/* Samples counted in each case. */
#define SAMPLES 500

#ifdef COUNT_INSTRUCTIONS
#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)
/* Both boards clock SysTick with the 25 MHz of the processor: 40 ns a count. */
#define INSTRUCTIONS_PER_COUNT 40.0

static uint32_t counter(void)
{
    return 0xFFFFFFu - SYST_CVR;
}
#endif

static muspin_f32 single;
static muspin_q31 fixed;

/* Volatile pointers keep the compiler from moving the controller out of the counted loop. */
static void (*volatile f32_step)(muspin_f32 *, const float *, float *) = muspin_f32_step;
static void (*volatile q31_step)(muspin_q31 *, const int32_t *, int32_t *) = muspin_q31_step;

#ifdef COUNT_INSTRUCTIONS
static void idle(void *instance, const void *y, void *u)
{
    (void)instance;
    (void)y;
    (void)u;
}
static void (*volatile nothing)(void *, const void *, void *) = idle;

#define COUNT(result, call)                                                                                            \
    do {                                                                                                               \
        uint32_t begin, i;                                                                                       \
        begin = counter();                                                                                             \
        for (i = 0; i < SAMPLES; ++i) {                                                                                \
            call;                                                                                                      \
        }                                                                                                              \
        result = INSTRUCTIONS_PER_COUNT * ((counter() - begin) & 0xFFFFFFu) / SAMPLES;                                 \
    } while (0)
#endif

int main(void)
{
    int i, wrong_f32 = 0, wrong_q31 = 0;
    float u[MUSPIN_OUTPUTS];
    int32_t uq[MUSPIN_OUTPUTS];
    muspin_f32_init(&single);
    muspin_q31_init(&fixed);
    for (i = 0; i < VECTORS; ++i) {
        f32_step(&single, vector_y[i], u);
        q31_step(&fixed, vector_yq[i], uq);
        wrong_f32 += memcmp(u, vector_u[i], sizeof u) != 0;
        wrong_q31 += memcmp(uq, vector_uq[i], sizeof uq) != 0;
    }
    printf("%d samples, float32 mismatches %d, Q31 mismatches %d\n", VECTORS, wrong_f32, wrong_q31);
#ifdef COUNT_INSTRUCTIONS
    {
        static const char *const names[2] = {"within the limits", "current limited"};
        int limited;
        SYST_RVR = 0xFFFFFFu;
        SYST_CVR = 0;
        SYST_CSR = 5;
        for (limited = 0; limited < 2; ++limited) {
            /* A millionth of the input limit, and the limit itself. */
            const float size = (limited ? 1.0f : 1e-6f) * (float)MUSPIN_INPUT_LIMIT_M;
            const int32_t size_q31 = limited ? INT32_MAX : 2147;
            const float y[4] = {size, size, -size, -size};
            const int32_t yq[4] = {size_q31, size_q31, -size_q31, -size_q31};
            double empty, of_f32, of_q31;
            muspin_f32_init(&single);
            muspin_q31_init(&fixed);
            COUNT(empty, nothing(&single, y, u));
            COUNT(of_f32, f32_step(&single, y, u));
            COUNT(of_q31, q31_step(&fixed, yq, uq));
            printf("instructions a sample, %s: float32 %.0f, Q31 %.0f\n", names[limited], of_f32 - empty, of_q31 - empty);
        }
    }
#endif
    fflush(stdout);
    return wrong_f32 != 0 || wrong_q31 != 0;
}
