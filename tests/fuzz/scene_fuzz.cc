// Any bytes as a scene file: a scene of disks or spheres that validates, or one of the two
// refusals.
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <variant>

#include "core/scene_files/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const bipot::AnyScene read =
        bipot::parse_any_scene(std::string(reinterpret_cast<const char*>(data), size), "fuzzed");
    std::visit(
        [](const auto& scene) {
          if (!bipot::validate(scene).empty()) std::abort();
        },
        read);
  } catch (const bipot::SceneFileError&) {
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
