// EIFMAP_VECTOR_CLONES before a hot function: compiled for AVX-512, AVX2 and any x86-64, and chosen
// when the program starts. Without fused multiply-add all give the same bits.
#pragma once

// Sanitizers are not yet running when the choice is made, hence not there.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define EIFMAP_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define EIFMAP_VECTOR_CLONES
#endif
