// HEXRELIEF_VECTORS before a function: compiled for the vector registers of several processors; the program
// takes the widest that there are. Wider ones change no bit, as each lane is a number of its own.
#pragma once

// ThreadSanitizer is not yet up when the choice is made, and the program would crash: one version is enough.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
#define HEXRELIEF_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
// The same for loops over numbers of 8 and 16 bits, which AVX-512F alone has no instructions for.
#define HEXRELIEF_SMALL_VECTORS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define HEXRELIEF_VECTORS
#define HEXRELIEF_SMALL_VECTORS
#endif
// Functions that such a loop is made of have to become part of it.
#define HEXRELIEF_INLINED inline __attribute__((always_inline))
