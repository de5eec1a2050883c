#include "bench/page/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/page/deflate.h"
#include "bench/page/page_curves.h"
#include "bench/page/page_files.h"
#include "bench/page/page_frames.h"
#include "bench/page/run_frames.h"
#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "bench/report/text_lines.h"
#include "core/files/atomic_file.h"
#include "core/files/hdf5_file.h"
#include "core/run_files/run_reader.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPageBytes = 20'000'000;
constexpr std::size_t kFewFrames = 32;  // a page keeps so many, and loses weak contacts instead
constexpr std::size_t kMostCurvePoints = 2400;
constexpr std::size_t kMostMarks = 2000;

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

/// The file's JSON; null if there is none, or none that is whole.
Json read_summary(const fs::path& folder) {
  std::ifstream file(folder / "summary.json");
  return file ? Json::parse(file, nullptr, false) : Json();
}

template <int N>
Json numbers(const Eigen::Matrix<double, N, 1>& x) {
  return std::vector<double>(x.begin(), x.end());
}

template <int D>
Json walls_json(const std::vector<Wall<D>>& walls, const std::vector<std::string>& materials) {
  Json list = Json::array();
  constexpr const char* kShapes[] = {"plane", "segment", "hollow", "solid"};
  for (const Wall<D>& wall : walls) {
    const std::size_t material = to_size(wall.material);
    list.push_back({{"name", wall.name},
                    {"shape", kShapes[static_cast<int>(wall.shape)]},
                    {"normal", numbers(wall.normal)},
                    {"radius", wall.radius},
                    {"spin", wall.spin},
                    {"material", material < materials.size() ? materials[material] : ""}});
  }
  return list;
}

/// Regions of outlets and inlets, which only the scene's text has.
Json gates_json(const std::string& scene_text, const std::string& source) {
  Json list = Json::array();
  std::visit(
      [&](const auto& scene) {
        for (const auto& outlet : scene.outlets) {
          Json entry{{"kind", "outlet"}, {"name", outlet.name}};
          if (outlet.box) {
            entry["lower"] = numbers(outlet.lower);
            entry["upper"] = numbers(outlet.upper);
          } else {
            entry["point"] = numbers(outlet.point);
            entry["normal"] = numbers(outlet.normal);
          }
          list.push_back(std::move(entry));
        }
        for (const auto& inlet : scene.inlets) {
          list.push_back({{"kind", "inlet"},
                          {"name", inlet.name},
                          {"lower", numbers(inlet.lower)},
                          {"upper", numbers(inlet.upper)}});
        }
      },
      parse_any_scene(scene_text, source));
  return list;
}

/// Steps that a reader must know of: unsolved, with several answers.
Json marks_json(const std::vector<CurveTable>& curves) {
  Json marks = Json::array();
  if (curves.empty() || curves.front().file != "ledger") return marks;
  const CurveTable& ledger = curves.front();
  const std::vector<double>* step = ledger.column("step");
  const std::vector<double>* time = ledger.column("time");
  if (step == nullptr || time == nullptr) return marks;
  const auto mark = [&](const char* column, const char* kind, const auto& is) {
    const std::vector<double>* values = ledger.column(column);
    if (values == nullptr) return;
    for (std::size_t k = 0; k < values->size() && marks.size() < kMostMarks; ++k) {
      if (is((*values)[k])) marks.push_back({kind, (*step)[k], (*time)[k]});
    }
  };
  mark("converged", "unsolved", [](double x) { return x == 0; });
  mark("answers", "several", [](double x) { return x > 1; });
  return marks;
}

/// Columns in single precision, one after the other, and their description.
std::string packed_curves(const std::vector<CurveTable>& curves, Json& about) {
  about["curves"] = Json::array();
  std::string bytes;
  for (const CurveTable& table : curves) {
    const CurveTable thin = thinned_curves(table, kMostCurvePoints);
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

/// What changes from frame to frame and is short.
void describe_frames(const std::vector<FilmFrame>& frames, Json& about) {
  Json &list = about["frames"] = Json::array(), &walls = about["wall_places"] = Json::array();
  const FilmFrame* before = nullptr;
  for (const FilmFrame& frame : frames) {
    list.push_back({frame.step, frame.time, frame.number.size(), frame.i.size()});
    const bool same = before != nullptr && before->walls == frame.walls;
    walls.push_back(same ? Json() : Json(frame.walls));
    before = &frame;
  }
  if (frames.front().cell[0] == 0) return;
  Json& cells = about["cells"] = Json::array();
  for (const FilmFrame& frame : frames) cells.push_back(frame.cell);
}

/// The deflated frames, fewer or with fewer contacts where they would take more than `most` bytes
/// of text. Says so in the notes.
template <int D>
std::string fitted_frames(RunFrames<D>& run, std::size_t most, Json& about) {
  std::vector<FilmFrame> frames = std::move(run.film.frames);
  const std::size_t all = frames.size();
  std::string packed;
  double quantile = 0, weakest = 0;
  while (true) {
    const std::string bytes = packed_frames(run.bodies, frames, D, run.gates);
    packed = deflated(bytes);
    about["frame_bytes"] = bytes.size();
    const std::size_t size = packed.size() / 3 * 4;
    if (size <= most) break;
    if (frames.size() > kFewFrames) {
      const std::size_t stride = std::min(size / most + 1, frames.size() / (kFewFrames / 2));
      frames = thinned(frames, std::max<std::size_t>(stride, 2));
    } else if (quantile < 0.9) {
      quantile += 0.3;
      weakest = drop_weak_contacts(frames, D, quantile);
    } else if (frames.size() > 2) {
      frames = thinned(frames, 2);
    } else {
      break;  // two frames are the least that a page can play
    }
  }
  if (frames.size() < all) {
    about["notes"].push_back(
        fmt::format("{} of {} frames are shown: a page has at most 20 MB.", frames.size(), all));
  }
  if (weakest > 0) {
    about["notes"].push_back(
        fmt::format("Contacts below {:.3g} N are left out: a page has at most 20 MB.", weakest));
  }
  describe_frames(frames, about);
  run.film.frames = std::move(frames);
  return packed;
}

/// JSON that may stand in a script element.
std::string script_json(const Json& json) {
  std::string text;
  for (const char c : json_text(json)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

template <int D>
RunPage write_page(const fs::path& folder, const Hdf5File& fixed, Json about) {
  RunFrames<D> run = read_frames<D>(folder, about["time_step"].get<double>());
  about["quantum"] = run.film.quantum;
  about["gates"] = run.gates;
  about["bodies"] = run.bodies.size();
  about["walls"] = walls_json(run.walls, fixed.read_strings("/materials/name"));
  about["openings"] = Json::array();
  if (run.gates) {
    try {
      about["openings"] = gates_json(about["scene"].get<std::string>(), about["source"]);
    } catch (const SceneFileError& e) {
      about["notes"].push_back(fmt::format("Outlets and inlets are not drawn: {}", e.what()));
    }
  }
  const std::vector<CurveTable> curves = read_curves(folder);
  about["marks"] = marks_json(curves);
  const std::string curve_text = base64(deflated(packed_curves(curves, about)));
  const PageFiles files = page_files();
  const std::size_t rest = files.page.size() + files.style.size() + files.script.size() +
                           curve_text.size() + script_json(about).size();
  const std::string packed =
      fitted_frames(run, kMostPageBytes - std::min(rest, kMostPageBytes / 2), about);
  const std::string title = about["title"].get<std::string>();
  std::string page(files.page);
  const auto fill = [&](std::string_view mark, const std::string& text) {
    page.replace(page.find(mark), mark.size(), text);
  };
  fill("{{title}}", escape_markup(title));  // of the window
  fill("{{title}}", escape_markup(title));  // of the page
  fill("{{style}}", std::string(files.style));
  fill("{{about}}", script_json(about));
  fill("{{curves}}", curve_text);
  fill("{{frames}}", base64(packed));
  fill("{{script}}", std::string(files.script));
  write_text_file(folder / "index.html", page);
  return {folder / "index.html", page.size(), run.film.frames.size()};
}

}  // namespace

RunPage write_run_page(const fs::path& run) {
  const fs::path folder = run_folder(run);
  const Hdf5File fixed(folder / "run.h5", Hdf5File::Mode::kRead);
  const int dim = fixed.exists("/dimensions") ? fixed.read_int("/dimensions") : 2;
  const std::string title = fixed.read_string("/title"), source = fixed.read_string("/source");
  Json about{{"dim", dim},
             {"title", title.empty() ? fs::path(source).stem().string() : title},
             {"source", source},
             {"folder", folder.string()},
             {"scene", fixed.read_string("/scene")},
             {"version", fixed.read_string("/version")},
             {"commit", build_info().commit},
             {"model", fixed.exists("/model") ? fixed.read_string("/model") : "nscd"},
             {"solver", fixed.read_string("/solver/name")},
             {"tol", fixed.read_double("/solver/tol")},
             {"time_step", fixed.read_double("/time_step")},
             {"accuracy", fixed.exists("/accuracy") ? fixed.read_double("/accuracy") : 0.0},
             {"num_steps", fixed.read_int("/num_steps")},
             {"gravity", fixed.read_doubles("/gravity")},
             {"materials", fixed.read_strings("/materials/name")},
             {"summary", read_summary(folder)},
             {"notes", Json::array()}};
  return dim == 3 ? write_page<3>(folder, fixed, std::move(about))
                  : write_page<2>(folder, fixed, std::move(about));
}

}  // namespace bipot
