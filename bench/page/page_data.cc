#include "bench/page/page_data.h"

#include <zlib.h>

#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/motion/time_stepping.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostMarks = 20000;
constexpr int kLevel = 4;  // half the time of zlib's default level, a few per cent more bytes

}  // namespace

std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), kLevel) != Z_OK) {
    throw std::bad_alloc();  // the buffer is large enough, the level exists
  }
  packed.resize(size);
  return packed;
}

std::string base64(std::string_view bytes) {
  constexpr const char* kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    std::uint32_t group = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      group = group << 8 | (k + c < bytes.size() ? static_cast<unsigned char>(bytes[k + c]) : 0u);
    }
    for (std::size_t c = 0; c < 4; ++c) {
      text += k + c <= bytes.size() ? kLetters[group >> (18 - 6 * c) & 63] : '=';
    }
  }
  return text;
}

std::string packed_text(std::string_view bytes) { return base64(deflated(bytes)); }

Json page_summary(const fs::path& folder) {
  const fs::path path = folder / "summary.json";
  return fs::is_regular_file(path) ? Json::parse(std::ifstream(path), nullptr, false) : Json();
}

Json page_marks(const fs::path& folder, const std::vector<CurveTable>& curves) {
  Json marks = Json::array();
  if (!curves.empty() && curves.front().file == "ledger") {
    const CurveTable& ledger = curves.front();
    const std::vector<double>*step = ledger.column("step"), *time = ledger.column("time"),
          *converged = ledger.column("converged"), *overlap = ledger.column("overlap");
    for (std::size_t k = 0; step && time && converged && k < step->size(); ++k) {
      if (marks.size() == kMostMarks) break;
      if ((*converged)[k] == 0) marks.push_back({"unsolved", (*step)[k], (*time)[k]});
    }
    if (step && time && overlap && !overlap->empty()) {
      const auto most = std::max_element(overlap->begin(), overlap->end());
      const auto k = static_cast<std::size_t>(most - overlap->begin());
      if (*most > kDeepOverlap) marks.push_back({"overlap", (*step)[k], (*time)[k], *most});
    }
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const Json found = entry.is_directory() ? page_summary(entry.path()) : Json();
    if (found.is_object() && found.value("sets", 0) > 1 && found.contains("step")) {
      marks.push_back({"several", found["step"], found["time"]});
    }
  }
  return marks;
}

std::string packed_curves(const std::vector<CurveTable>& curves, std::size_t points, Json& about) {
  about["curves"] = Json::array();
  std::string bytes;
  for (const CurveTable& table : curves) {
    const CurveTable thin = thinned_curves(table, points);
    const std::size_t rows = thin.columns.front().size();
    about["curves"].push_back({{"file", table.file},
                               {"part", table.part},
                               {"names", thin.names},
                               {"rows", rows},
                               {"all_rows", table.columns.front().size()}});
    for (const std::vector<double>& column : thin.columns) {
      const std::vector<float> single(column.begin(), column.end());
      bytes.append(reinterpret_cast<const char*>(single.data()), rows * sizeof(float));
    }
  }
  return bytes;
}

namespace {

/// Ends and presence of walls, from the origin of the grid on.
std::vector<double> from_origin(std::vector<double> walls, const FilmGrid& grid, std::size_t dim) {
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const std::size_t column = k % (2 * dim + 1);
    if (column < 2 * dim) walls[k] -= grid.origin[column % dim];
  }
  return walls;
}

}  // namespace

void describe_frames(const Film& film, std::size_t dim, Json& about) {
  const std::vector<FilmFrame>& frames = film.frames;
  const bool turning = !frames.empty() && !frames.back().wall_turn.empty();
  const bool periodic = !frames.empty() && frames.front().cell[0] != 0;
  Json list = Json::array(), walls = Json::array(), turns = Json::array(), cells = Json::array();
  const FilmFrame* before = nullptr;
  for (const FilmFrame& frame : frames) {
    list.push_back({frame.step, frame.time, frame.number.size(), frame.i.size()});
    const bool same = before != nullptr && before->walls == frame.walls;
    walls.push_back(same ? Json() : Json(from_origin(frame.walls, film.grid, dim)));
    if (turning) turns.push_back(frame.wall_turn);
    if (periodic) cells.push_back(frame.cell);
    before = &frame;
  }
  about["frames"] = std::move(list);
  about["wall_places"] = std::move(walls);
  if (turning) about["wall_turns"] = std::move(turns);
  if (periodic) about["cells"] = std::move(cells);
}

}  // namespace bipot
