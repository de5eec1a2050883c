#pragma once

// g++ compiles a function that is marked BIPOT_EVERY_WIDTH once for each of these and picks one when
// the program is loaded. The sanitizers instrument that choice, which runs before they are ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define BIPOT_EVERY_WIDTH __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BIPOT_EVERY_WIDTH
#endif
