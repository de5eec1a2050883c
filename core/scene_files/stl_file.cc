#include "core/scene_files/stl_file.h"

#include <fmt/format.h>

#include <cctype>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>

#include "core/files/input_file.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

using Triangle = std::array<Vec3, 3>;
constexpr std::size_t kHead = 84, kRecord = 50;  // bytes of the binary form

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  throw SceneFileError(fmt::format("{}: {}", path.string(), why));
}

std::vector<Triangle> read_binary(const std::filesystem::path& path, const std::string& bytes) {
  std::vector<Triangle> triangles((bytes.size() - kHead) / kRecord);
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    float corners[9];  // after the normal
    std::memcpy(corners, bytes.data() + kHead + kRecord * k + 12, sizeof corners);
    for (int n = 0; n < 9; ++n) triangles[k][to_size(n / 3)][n % 3] = corners[n];
    for (const Vec3& corner : triangles[k]) {
      if (!corner.allFinite()) refuse(path, fmt::format("triangle {} is not finite", k));
    }
  }
  return triangles;
}

std::string lowered(std::string word) {
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

bool begins_with_solid(const std::string& text) {
  std::string word;
  std::istringstream(text) >> word;
  return lowered(word) == "solid";
}

/// solid NAME, then facets `facet normal x y z outer loop vertex x y z ... endloop endfacet`, then
/// endsolid; several solids may follow each other. A line ends the names.
std::vector<Triangle> read_text(const std::filesystem::path& path, const std::string& bytes) {
  std::istringstream file(bytes);
  std::vector<Triangle> triangles;
  std::vector<Vec3> loop;
  std::string text, word;
  bool open = false;
  for (int line = 1; std::getline(file, text); ++line) {
    const auto refuse_line = [&](const char* why) {
      refuse(path, fmt::format("line {}: {}", line, why));
    };
    std::istringstream words(text);
    while (words >> word) {
      word = lowered(word);
      if (word == "solid") {
        open = true;
        break;
      }
      if (!open) refuse_line("expected 'solid'");
      if (word == "vertex") {
        Vec3 x;
        if (!(words >> x[0] >> x[1] >> x[2]) || !x.allFinite()) {
          refuse_line("expected three numbers");
        }
        loop.push_back(x);
      } else if (word == "endfacet") {
        if (loop.size() != 3) refuse_line("a facet needs three vertices");
        triangles.push_back({loop[0], loop[1], loop[2]});
        loop.clear();
      } else if (word == "endsolid") {
        if (!loop.empty()) refuse_line("the last facet has no end");
        open = false;
        break;
      } else if (word == "normal") {
        for (int k = 0; k < 3; ++k) words >> word;
      } else if (word != "facet" && word != "outer" && word != "loop" && word != "endloop") {
        refuse_line("no word of an STL file");
      }
    }
  }
  if (open) refuse(path, "ends before 'endsolid'");
  return triangles;
}

}  // namespace

std::vector<Triangle> read_stl(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  std::uint32_t count = 0;
  if (bytes.size() >= kHead) std::memcpy(&count, bytes.data() + kHead - 4, sizeof count);
  const bool binary = bytes.size() >= kHead && bytes.size() == kHead + kRecord * count;
  if (!binary && !begins_with_solid(bytes)) {
    refuse(path, bytes.size() < kHead
                     ? std::string("is no STL file")
                     : fmt::format("{} bytes, but {} triangles need {}: damaged, or no STL file",
                                   bytes.size(), count, kHead + kRecord * std::size_t{count}));
  }
  std::vector<Triangle> triangles = binary ? read_binary(path, bytes) : read_text(path, bytes);
  std::erase_if(triangles, [](const Triangle& t) {
    const Vec3 a = t[1] - t[0], b = t[2] - t[0];
    return !(a.cross(b).norm() > 1e-12 * (a.squaredNorm() + b.squaredNorm()));
  });
  if (triangles.empty()) refuse(path, "has no triangle with an area");
  return triangles;
}

}  // namespace bipot
