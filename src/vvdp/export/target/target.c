/* Start of a program on a Cortex-M in QEMU, and the counter of instructions.
 *
 * With `-icount shift=6` each instruction takes 64 ns of the time that QEMU simulates. The counter SysTick of the boards
 * mps2-an386 and mps2-an500 has a tick of 40 ns, so an instruction takes 1.6 ticks. */
#include "target.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014)
#define SYSTICK_VALUE (*(volatile uint32_t *)0xE000E018)
#define COPROCESSORS (*(volatile uint32_t *)0xE000ED88)
#define FULL 0xFFFFFFu
#define PATTERN 0xA5u
enum { PAINTED = 32768, OWN = 48 /* of what paints */ };

extern char __stack_top, __data_start, __data_end, __data_load, __bss_start__, __bss_end__;
int main(void);
void initialise_monitor_handles(void);
void Reset_Handler(void);
void _init(void);
void _fini(void);

static struct {
    uint32_t before, nothing, least, most;
    uint64_t sum;
    int sample, longest;
    unsigned char *painted;
    unsigned stack;
} count;

static uint32_t instructions(uint32_t begin, uint32_t end)
{
    return (uint32_t)((((uint64_t)((begin - end) & FULL)) * 5u + 4u) / 8u);
}

/* The stack below the caller is painted before each call; what is changed afterwards was used. */
static void __attribute__((noinline)) paint(void)
{
    count.painted = (unsigned char *)__builtin_frame_address(0) - PAINTED;
    for (volatile unsigned char *at = count.painted; at < count.painted + PAINTED - OWN; at++) {
        *at = PATTERN;
    }
}

void __attribute__((noinline)) count_begin(void)
{
    paint();
    count.before = SYSTICK_VALUE;
}

int __attribute__((noinline)) count_end(int result)
{
    const uint32_t all = instructions(count.before, SYSTICK_VALUE);
    const uint32_t found = all > count.nothing ? all - count.nothing : 0;
    count.least = count.sample == 0 || found < count.least ? found : count.least;
    if (count.sample == 0 || found > count.most) {
        count.most = found;
        count.longest = count.sample;
    }
    count.sum += found;
    count.sample++;
    const unsigned char *at = count.painted;
    while (at < count.painted + PAINTED - OWN && *at == PATTERN) {
        at++;
    }
    const unsigned used = (unsigned)(count.painted + PAINTED - at);
    count.stack = used > count.stack ? used : count.stack;
    return result;
}

static int nothing(void)
{
    return 0;
}

static void forget(void)
{
    const uint32_t own = count.nothing;
    memset(&count, 0, sizeof count);
    count.nothing = own;
}

void count_report(const char *entry, int samples)
{
    printf("%s: %lu to %lu instructions per sample, mean %lu; most in sample %d of %d\n", entry,
           (unsigned long)count.least, (unsigned long)count.most, (unsigned long)(count.sum / (uint64_t)count.sample),
           count.longest, samples);
    printf("%s: stack %u bytes\n", entry, count.stack);
    forget();
}

void _init(void)
{
}

void _fini(void)
{
}

void Reset_Handler(void)
{
    COPROCESSORS |= 0xF00000; /* floating-point unit */
    __asm volatile("dsb\n isb");
    memcpy(&__data_start, &__data_load, (size_t)(&__data_end - &__data_start));
    memset(&__bss_start__, 0, (size_t)(&__bss_end__ - &__bss_start__));
    initialise_monitor_handles();
    SYSTICK_RELOAD = FULL;
    SYSTICK_VALUE = 0;
    SYSTICK_CONTROL = 5u;
    COUNTED(nothing()); /* what counting itself takes */
    count.nothing = count.most;
    forget();
    exit(main());
}

static void fault(void)
{
    static const char words[] = "a fault of the processor\n";
    fwrite(words, 1, sizeof words - 1, stdout);
    exit(2);
}

__attribute__((section(".vectors"), used)) void *const vectors[16] = {
    &__stack_top, (void *)Reset_Handler, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault};
