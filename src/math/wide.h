#pragma once
/// `PISTE_WIDE` before a function has it compiled twice, for four doubles at a time and for two, and chosen by the
/// processor when the program is loaded. Sums keep their order, so that both give the same bits.

#if defined(__x86_64__) && defined(__gnu_linux__)
#define PISTE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PISTE_WIDE
#endif
