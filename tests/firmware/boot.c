/* Start-up of a bare Cortex-M under QEMU with semihosting: vector table, floating-point unit, data, then main(). */
#include <stdint.h>

extern uint32_t image_data_load, image_data_start, image_data_end, image_bss_start, image_bss_end, image_stack_top;
extern void initialise_monitor_handles(void);
extern int main(void);
extern void _exit(int);

void on_reset(void);
void on_fault(void);

typedef union {
    uint32_t *stack;
    void (*handler)(void);
} vector;

__attribute__((section(".vectors"), used)) const vector vector_table[16] = {
    {.stack = &image_stack_top}, {.handler = on_reset}, {.handler = on_fault}, {.handler = on_fault},
    {.handler = on_fault}, {.handler = on_fault}, {.handler = on_fault}};

void on_fault(void)
{
    _exit(3);
}

void on_reset(void)
{
    uint32_t *from = &image_data_load, *to;
    /* Full access to coprocessors 10 and 11, the floating-point unit. */
    volatile uint32_t *const coprocessor_access = (uint32_t *)0xE000ED88u;
    *coprocessor_access |= 0x00F00000u;
    __asm volatile("dsb\n isb");
    for (to = &image_data_start; to < &image_data_end;) {
        *to++ = *from++;
    }
    for (to = &image_bss_start; to < &image_bss_end;) {
        *to++ = 0;
    }
    initialise_monitor_handles();
    _exit(main());
}
