#include "bench/page/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bench/page/page_curves.h"
#include "bench/page/page_data.h"
#include "bench/page/page_files.h"
#include "bench/page/page_frames.h"
#include "bench/page/run_frames.h"
#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "bench/report/text_lines.h"
#include "core/files/atomic_file.h"
#include "core/files/hdf5_file.h"
#include "core/run_files/film.h"
#include "core/scene/wall_pieces.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewFrames = 32;  // a page keeps so many, and loses weak contacts instead

template <int N>
Json numbers(const Eigen::Matrix<double, N, 1>& x) {
  return std::vector<double>(x.begin(), x.end());
}

template <int D>
Json walls_json(const std::vector<Wall<D>>& walls, const Hdf5File& fixed) {
  // Those of the scene: the walls of a frame may stand at the time.
  const std::vector<double> spins = fixed.exists("/walls/spin")
                                        ? fixed.read_doubles("/walls/spin", walls.size())
                                        : std::vector<double>(walls.size(), 0.0);
  Json list = Json::array();
  constexpr const char* kShapes[] = {"plane", "segment", "hollow", "solid", "mesh", "cone"};
  for (const Wall<D>& wall : walls) {
    list.push_back({{"name", wall.name},
                    {"shape", kShapes[static_cast<int>(wall.shape)]},
                    {"normal", numbers(wall.normal)},
                    {"radius", wall.radius},
                    {"turns", spins[list.size()] != 0}});
    if constexpr (D == 3) {
      if (!wall.is_surface()) continue;
      std::vector<float> corners;  // relative to the point a, which moves
      for (const WallPiece& piece : wall_pieces({&wall, 1}, {})) {
        for (const Vec3& corner : piece.corners) {
          for (const double x : Vec3(corner - wall.a)) corners.push_back(static_cast<float>(x));
        }
      }
      list.back()["pieces"] = corners;
    }
  }
  return list;
}

/// What only the scene's text has: regions of outlets and inlets, and joints. Places are from the
/// origin of the grid on.
void add_openings_and_joints(const std::string& scene_text, const std::string& source,
                             const FilmGrid& grid, Json& about) {
  Json list = Json::array(), joints = Json::array();
  std::visit(
      [&]<int D>(const Scene<D>& scene) {
        const Eigen::Map<const Vec<D>> origin(grid.origin.data());
        const auto place = [&](const Vec<D>& x) { return numbers<D>(x - origin); };
        for (const auto& outlet : scene.outlets) {
          Json entry{{"kind", "outlet"}, {"name", outlet.name}};
          if (outlet.box) {
            entry["lower"] = place(outlet.lower);
            entry["upper"] = place(outlet.upper);
          } else {
            entry["point"] = place(outlet.point);
            entry["normal"] = numbers(outlet.normal);
          }
          list.push_back(std::move(entry));
        }
        for (const auto& inlet : scene.inlets) {
          list.push_back({{"kind", "inlet"},
                          {"name", inlet.name},
                          {"lower", place(inlet.lower)},
                          {"upper", place(inlet.upper)}});
        }
        for (const auto& joint : scene.joints) {
          const bool ground = joint.j < 0;
          joints.push_back({{"i", joint.i},
                            {"j", joint.j},
                            {"at_i", numbers<D>(joint.at_i)},
                            {"at_j", ground ? place(joint.at_j) : numbers<D>(joint.at_j)},
                            {"rope", joint.is_rope()}});
        }
      },
      parse_any_scene(scene_text, source));
  about["openings"] = std::move(list);
  about["joints"] = std::move(joints);
}

/// Says so where bodies lie beyond the grid of the film.
void note_lost_bodies(const Film& film, Json& about) {
  for (const FilmFrame& frame : film.frames) {
    const bool lost = std::ranges::any_of(
        frame.x, [](std::int32_t place) { return std::abs(place) == FilmGrid::kLast; });
    if (!lost) continue;
    about["notes"].push_back(fmt::format(
        "From t = {:.4g} s on bodies are drawn at {:.3g} m from the start that are farther away.",
        frame.time, FilmGrid::kLast * film.grid.quantum));
    return;
  }
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
    packed = deflated(packed_frames(run.bodies, frames, D, run.gates));
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
  const std::string limit = fmt::format("a page has at most {} MB", kMostPageBytes / 1'000'000);
  if (frames.size() < all) {
    about["notes"].push_back(
        fmt::format("{} of {} frames are shown: {}.", frames.size(), all, limit));
  }
  if (weakest > 0) {
    about["notes"].push_back(
        fmt::format("Contacts below {:.3g} N are left out: {}.", weakest, limit));
  }
  run.film.frames = std::move(frames);
  describe_frames(run.film, D, about);
  return packed;
}

/// JSON that may stand in a script element.
std::string script_json(const Json& json) { return replaced(json_text(json), "<", "\\u003c"); }

struct PageText {
  std::string text;
  std::size_t frames = 0;
};

template <int D>
PageText page_text(const fs::path& folder, const Hdf5File& fixed, std::size_t most_bytes,
                   Json about) {
  RunFrames<D> run = read_frames<D>(folder, about["time_step"].get<double>());
  about["quantum"] = run.film.grid.quantum;
  about["origin"] =
      std::vector<double>(run.film.grid.origin.begin(), run.film.grid.origin.begin() + D);
  note_lost_bodies(run.film, about);
  // Few frames of many steps: the film was full of bytes before it was full of frames (film.h).
  const std::vector<FilmFrame>& frames = run.film.frames;
  const int every = frames.size() > 2 ? frames[1].step - frames[0].step : 1;
  if (every > 1 && 2 * frames.size() < FilmRecorder<D>::kMostFrames &&
      fs::exists(folder / kFilmFile)) {
    about["notes"].push_back(fmt::format("One step in {} is shown: a film has at most {} MB.",
                                         every, FilmRecorder<D>::kMostBytes >> 20));
  }
  about["gates"] = run.gates;
  about["bodies"] = run.bodies.size();
  about["walls"] = walls_json(run.walls, fixed);
  about["openings"] = Json::array();
  about["joints"] = Json::array();
  const std::string scene = about["scene"].get<std::string>();
  const auto names = [&](const char* word) { return scene.find(word) != std::string::npos; };
  if (run.gates || names("pins") || names("ropes")) {
    try {
      add_openings_and_joints(scene, about["source"], run.film.grid, about);
    } catch (const std::runtime_error& e) {  // a file beside it may be elsewhere
      about["notes"].push_back(
          fmt::format("Outlets, inlets, pins and ropes are not drawn: {}", e.what()));
    }
  }
  const std::vector<CurveTable> curves = read_curves(folder);
  about["marks"] = page_marks(folder, curves);
  const std::string curve_text = packed_text(
      packed_curves(curves, about["live"].get<bool>() ? kLiveCurvePoints : kCurvePoints, about));
  const PageFiles files = page_files();
  const std::size_t rest = files.page.size() + files.style.size() + files.script.size() +
                           curve_text.size() + script_json(about).size();
  const std::string packed = fitted_frames(run, most_bytes - std::min(rest, most_bytes / 2), about);
  const std::string title = about["title"].get<std::string>();
  std::string page(files.page);
  // Marks in their order: what is filled in may look like one.
  auto fill = [&, from = std::size_t{0}](std::string_view mark, const std::string& text) mutable {
    from = page.find(mark, from);
    page.replace(from, mark.size(), text);
    from += text.size();
  };
  // A page that is served asks its server, and no other.
  fill("{{connect}}", about["live"].get<bool>() ? "; connect-src 'self'" : "");
  fill("{{title}}", escape_markup(title));  // of the window
  fill("{{style}}", std::string(files.style));
  fill("{{title}}", escape_markup(title));  // of the page
  fill("{{about}}", script_json(about));
  fill("{{curves}}", curve_text);
  fill("{{frames}}", base64(packed));
  fill("{{script}}", std::string(files.script));
  return {std::move(page), run.film.frames.size()};
}

/// `live`: the page asks for more while the run goes on.
PageText page_of(const fs::path& folder, std::size_t most_bytes, bool live) {
  const Hdf5File fixed(folder / "run.h5", Hdf5File::Mode::kRead);
  const int dim = fixed.exists("/dimensions") ? fixed.read_int("/dimensions") : 2;
  const std::string title = fixed.read_string("/title"), source = fixed.read_string("/source");
  Json about{{"dim", dim},
             {"title", title.empty() ? fs::path(source).stem().string() : title},
             {"source", source},
             {"words", {{"scene", shell_word(source)}, {"folder", shell_word(folder.string())}}},
             {"scene", fixed.read_string("/scene")},
             {"version", fixed.read_string("/version")},
             {"commit", build_info().commit},
             {"model", fixed.exists("/model") ? fixed.read_string("/model") : "nscd"},
             {"solver", fixed.read_string("/solver/name")},
             {"tol", fixed.read_double("/solver/tol")},
             {"time_step", fixed.read_double("/time_step")},
             {"num_steps", fixed.read_int("/num_steps")},
             {"gravity", fixed.read_doubles("/gravity")},
             {"materials", fixed.read_strings("/materials/name")},
             {"summary", live ? Json() : page_summary(folder)},
             {"notes", Json::array()},
             {"live", live}};
  return dim == 3 ? page_text<3>(folder, fixed, most_bytes, std::move(about))
                  : page_text<2>(folder, fixed, most_bytes, std::move(about));
}

template <int D>
void add_frames(const fs::path& folder, double step, int after, Json& update) {
  const RunFrames<D> run = read_frames<D>(folder, step, after);
  describe_frames(run.film, D, update);
  update["steps"] = run.film.steps;
  update["bodies"] = run.bodies.size();
  update["frame_data"] = packed_text(packed_frames(run.bodies, run.film.frames, D, run.gates));
}

}  // namespace

RunPage write_run_page(const fs::path& run, std::size_t most_bytes) {
  const fs::path folder = run_folder(run), path = folder / "index.html";
  const PageText page = page_of(folder, most_bytes, false);
  write_text_file(path, page.text);
  return {path, page.text.size(), page.frames};
}

std::string live_run_page(const fs::path& run) {
  return page_of(run_folder(run), kMostPageBytes, true).text;
}

std::string page_update(const fs::path& folder, int after, bool ended) {
  Json update{{"ended", ended}, {"summary", ended ? page_summary(folder) : Json()}};
  const Hdf5File fixed(folder / "run.h5", Hdf5File::Mode::kRead);
  const double step = fixed.read_double("/time_step");
  if (fixed.exists("/dimensions")) {
    add_frames<3>(folder, step, after, update);
  } else {
    add_frames<2>(folder, step, after, update);
  }
  const std::vector<CurveTable> curves = read_curves(folder);
  update["marks"] = page_marks(folder, curves);
  update["curve_data"] =
      packed_text(packed_curves(curves, ended ? kCurvePoints : kLiveCurvePoints, update));
  return json_text(update);
}

}  // namespace bipot
