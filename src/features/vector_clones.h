// EIFMAP_VECTOR_CLONES before a hot function: compiled once for AVX2 and once for any x86-64, and
// chosen when the program starts. Without fused multiply-add both give the same bits.
#pragma once

// Sanitizers are not yet running when the choice is made, hence not there.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define EIFMAP_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define EIFMAP_VECTOR_CLONES
#endif
