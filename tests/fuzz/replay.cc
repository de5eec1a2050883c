// What a fuzzer starts from, without the fuzzer: replay FOLDER runs each file of it once. So the
// fuzzers are compiled, and their beginnings read, wherever the tests run.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    for (const std::size_t size : {bytes.size(), bytes.size() / 2}) {  // whole and cut short
      LLVMFuzzerTestOneInput(data, size);
    }
    ++files;
  }
  std::printf("%d inputs, each whole and cut short\n", files);
  return files > 0 ? 0 : 1;
}
