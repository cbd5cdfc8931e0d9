/* Counts the instructions of each call on a Cortex-M in QEMU; the Makefile includes it before the test. */
#ifndef TARGET_H
#define TARGET_H

/* The result of a call, the instructions of which are counted. */
#define COUNTED(call) (count_begin(), count_end((call)))
#define COUNT_REPORT(entry, samples) count_report((entry), (samples))

void count_begin(void);
int count_end(int result);

/* Prints the instructions of the samples since the last report, and how much stack a call has used. */
void count_report(const char *entry, int samples);

#endif
