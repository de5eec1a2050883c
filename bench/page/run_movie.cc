#include "bench/page/run_movie.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "bench/page/run_frames.h"
#include "bench/report/json_output.h"
#include "bench/report/program.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_file.h"
#include "core/files/hdf5_file.h"
#include "core/pictures/flat_view.h"
#include "core/pictures/force_picture.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFfmpeg = "movies are made by it: install the package ffmpeg";
constexpr double kPatience = 1800;    // seconds for ffmpeg
constexpr std::size_t kSamples = 30;  // frames that decide the scales

/// A folder for pictures that goes with its contents.
class PictureFolder {
 public:
  explicit PictureFolder(fs::path path) : path_(std::move(path)) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~PictureFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PictureFolder(const PictureFolder&) = delete;
  PictureFolder& operator=(const PictureFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

struct Shown {
  Scene<2> scene;
  State<2> state;
  std::vector<double> speeds;
};

Shown shown(const Scene<2>& scene, const State<2>& state) {
  Shown view{scene, state, {}};
  for (const Disk& disk : state.bodies) view.speeds.push_back(disk.v.norm());
  return view;
}
Shown shown(const Scene<3>& scene, const State<3>& state) {
  const FlatView flat = project(scene, state);
  Shown view{flat.scene, flat.state, {}};
  for (const int k : flat.bodies) view.speeds.push_back(state.bodies[to_size(k)].v.norm());
  return view;
}

/// The value that a share of the numbers does not exceed; 0 without numbers.
double value_at_share(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The same view, force scale and colours for all frames.
template <int D>
ForcePictureOptions scales(const RunFrames<D>& run, const Scene<D>& scene) {
  ForcePictureOptions options{.width = 800,
                              .resolution = 1,
                              .take_off = false,
                              .fill = {.values = {}, .label = "speed", .unit = "m/s"}};
  std::vector<double> strongest, speeds;
  Box<2> view;
  const std::size_t stride = std::max<std::size_t>(1, run.film.frames.size() / kSamples);
  for (std::size_t k = 0; k < run.film.frames.size(); ++k) {
    const Shown at = shown(scene, shown_state(run, run.film.frames[k], scene.step));
    const Box<2> box = whole_view(at.scene, at.state);
    view.include(box.lower);
    view.include(box.upper);
    if (k % stride != 0) continue;
    speeds.insert(speeds.end(), at.speeds.begin(), at.speeds.end());
    std::vector<double> forces;
    for (const auto& c : at.state.contacts) {
      if (c.s_n > 0) forces.push_back(c.s_n / scene.step);
    }
    if (!forces.empty()) strongest.push_back(value_at_share(std::move(forces), 0.99));
  }
  options.view = view;
  options.full_force = value_at_share(std::move(strongest), 0.6);  // as the page: shocks aside
  options.fill.high = value_at_share(std::move(speeds), 0.99);
  return options;
}

template <int D>
void draw_frames(const fs::path& run_path, const fs::path& pictures, const Scene<D>& scene) {
  const RunFrames<D> run = read_frames<D>(run_path, scene.step);
  ForcePictureOptions options = scales(run, scene);
  const int decimals = std::max(4, static_cast<int>(std::ceil(-std::log10(scene.step))));
  for (std::size_t k = 0; k < run.film.frames.size(); ++k) {
    if (InterruptGuard::requested()) throw Interrupted();
    const FilmFrame& frame = run.film.frames[k];
    Shown at = shown(scene, shown_state(run, frame, scene.step));
    options.fill.values = at.speeds;
    draw_force_picture(pictures / fmt::format("{:06d}.png", k), at.scene, at.state,
                       fmt::format("t = {:.{}f} s, step {:06d}", frame.time, decimals, frame.step),
                       options);
  }
}

}  // namespace

fs::path write_run_movie(const fs::path& run, fs::path file, int frames_a_second) {
  const fs::path folder = run_folder(run);
  if (file.empty()) file = folder / "movie.mp4";
  const bool gif = file.extension() == ".gif";
  if (!gif && file.extension() != ".mp4") {
    throw std::invalid_argument(file.string() + ": expected a name that ends with .mp4 or .gif");
  }
  require_writable(file.string());
  run_program({"ffmpeg", "-version"}, "", kFfmpeg, kPatience);
  const Hdf5File fixed(folder / "run.h5", Hdf5File::Mode::kRead);
  const PictureFolder pictures(folder / "movie.part");
  const std::string text = fixed.read_string("/scene"), source = fixed.read_string("/source");
  const auto scene_of_run = [&] {
    try {
      return parse_any_scene(text, source);
    } catch (const FileError& e) {
      throw FileError(folder, "",
                      fmt::format("its scene reads a file that is not found from here "
                                  "({}): make the movie where the run was started",
                                  e.what()));
    }
  };
  std::visit(
      [&](auto scene) {
        scene.step = fixed.read_double("/time_step");
        draw_frames(folder, pictures.path(), scene);
      },
      scene_of_run());
  // Even sizes, which the codec needs; a gif has few colours, chosen for it.
  const std::string filter =
      gif ? "scale=560:-1:flags=lanczos,split[a][b];[a]palettegen=max_colors=64[p];[b][p]paletteuse"
          : "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white";
  std::vector<std::string> words{"ffmpeg",     "-y",
                                 "-loglevel",  "error",
                                 "-framerate", std::to_string(frames_a_second),
                                 "-i",         (pictures.path() / "%06d.png").string(),
                                 "-vf",        filter};
  if (!gif) words.insert(words.end(), {"-pix_fmt", "yuv420p", "-movflags", "+faststart"});
  const fs::path made = pictures.path() / file.filename();
  words.push_back(made.string());
  run_program(words, "", kFfmpeg, kPatience);
  AtomicFile target(file);
  fs::copy_file(made, target.draft(), fs::copy_options::overwrite_existing);
  target.commit();
  return file;
}

}  // namespace bipot
