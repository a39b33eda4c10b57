// HEXRELIEF_VECTORS before a function: compiled for the vector registers of several processors; the program
// takes the widest that there are. Wider ones change no bit, as each lane is a number of its own.
#pragma once

#if defined(__x86_64__)
#define HEXRELIEF_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define HEXRELIEF_VECTORS
#endif
