// HEXRELIEF_VECTORS before a function compiles it for several vector register widths; the program runs
// the widest version that the processor supports. The width changes no bit of the result, as SIMD
// lanes do not interact.
#pragma once

// ThreadSanitizer is not initialised when the version is chosen, which would crash: it gets one version only.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
#define HEXRELIEF_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
// Like HEXRELIEF_VECTORS, for loops over 8 and 16 bit numbers, for which plain AVX-512F has no instructions.
#define HEXRELIEF_SMALL_VECTORS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define HEXRELIEF_VECTORS
#define HEXRELIEF_SMALL_VECTORS
#endif
// Functions called in such a loop have to be inlined into it.
#define HEXRELIEF_INLINED inline __attribute__((always_inline))
