// Siconos' text format.
#include "tests/fuzz/problem_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return read_fuzzed_problem(data, size);
}
