// FCLIB's HDF5 format. Inputs begin with HDF5's signature whatever the fuzzer makes of it.
#include <algorithm>
#include <vector>

#include "tests/fuzz/problem_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint8_t kSignature[] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  std::vector<std::uint8_t> file(data, data + size);
  file.resize(std::max(size, sizeof kSignature));
  std::copy(std::begin(kSignature), std::end(kSignature), file.begin());
  return read_fuzzed_problem(file.data(), file.size());
}
