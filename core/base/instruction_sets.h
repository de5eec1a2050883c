#pragma once

// g++ compiles a function marked BIPOT_CLONES("arch=x86-64-v3", "default") once for each of these
// and chooses one when the program is loaded. Not with sanitizers: they instrument that choice,
// which runs before they are ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define BIPOT_CLONES(...) __attribute__((target_clones(__VA_ARGS__)))
// Functions of one name may also be written once for each level.
#define BIPOT_LEVELS
#else
#define BIPOT_CLONES(...)
#endif

// The levels of x86-64: 512 bits, 256 bits with fused multiply-add, 128 bits.
#define BIPOT_EVERY_LEVEL BIPOT_CLONES("arch=x86-64-v4", "arch=x86-64-v3", "default")
