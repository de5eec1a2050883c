// Any bytes as a scene file: a Scene that validates, or one of the two refusals.
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "core/files/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const bipot::Scene scene =
        bipot::parse_any_scene(std::string(reinterpret_cast<const char*>(data), size), "fuzzed");
    if (!bipot::validate(scene).empty()) std::abort();
  } catch (const bipot::SceneFileError&) {
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
