#pragma once
/// `PISTE_WIDE` before a function has it compiled twice, for four doubles at a time and for two, and chosen by the
/// processor when the program is loaded. Sums keep their order, so that both give the same bits. `PISTE_WIDEST` is for
/// one that works with many numbers at a time: a third copy has twice as many registers of four.
/// `PISTE_INSIDE` is for what these call, so that it is compiled with each copy.

// clang 14 compiles such copies; clang 19 does not emit the inline functions that only they call (15 to 18: not tried).
#if defined(__x86_64__) && defined(__gnu_linux__) && (!defined(__clang__) || __clang_major__ < 15)
#define PISTE_WIDE __attribute__((target_clones("avx2", "default")))
#define PISTE_WIDEST __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define PISTE_WIDE
#define PISTE_WIDEST
#endif

#define PISTE_INSIDE [[gnu::always_inline]] inline
