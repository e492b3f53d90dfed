/* One loop of a magnetic bearing with the exported controller, on a PC: a displacement comes in, currents go out. */
#include <stdio.h>
#include "controller.h"

int main(void)
{
    static muspin_f32 controller;
    float y_m[4] = {10e-6f, 0.0f, 0.0f, 0.0f}; /* front_x, front_y, rear_x, rear_y: read your sensors here */
    float u_a[4];
    int sample;

    muspin_f32_init(&controller);
    for (sample = 0; sample < 5; sample++) {
        muspin_f32_output(&controller, y_m, u_a); /* write u_a to your amplifiers here */
        muspin_f32_update(&controller);           /* then prepare the next sample */
        printf("%d: %.4f %.4f %.4f %.4f A\n", sample, u_a[0], u_a[1], u_a[2], u_a[3]);
    }
    return 0;
}
