#include "bench/page/page_update.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "bench/page/page_curves.h"
#include "bench/page/page_data.h"
#include "bench/page/page_frames.h"
#include "bench/page/run_frames.h"
#include "core/files/hdf5_file.h"

namespace bipot {
namespace {

template <int D>
void add_frames(const std::filesystem::path& folder, double step, int after, Json& update) {
  const RunFrames<D> run = read_frames<D>(folder, step, after);
  describe_frames(run.film, D, update);
  update["steps"] = run.film.steps;
  update["bodies"] = run.bodies.size();
  update["frame_data"] = packed_text(packed_frames(run.bodies, run.film.frames, D, run.gates));
}

}  // namespace

std::string page_update(const std::filesystem::path& folder, int after, bool ended) {
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
