#pragma once

#include "core/base/instruction_sets.h"

// Compiles a function with loops over numbers for registers of eight, four and two.
#define BIPOT_EVERY_WIDTH BIPOT_CLONES("avx512f", "avx2", "default")
