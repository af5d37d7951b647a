#pragma once
// A row kernel: one plain loop, compiled for the baseline and for AVX2, chosen when the program starts.
// Without fused multiply-adds (-ffp-contract=off; AVX2 alone has none) both give the same bits.

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define LCMSLAM_ROW_KERNEL __attribute__((target_clones("avx2", "default")))
#else
#define LCMSLAM_ROW_KERNEL
#endif
