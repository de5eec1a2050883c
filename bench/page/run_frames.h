#pragma once

#include <filesystem>
#include <vector>

#include "bench/page/page_frames.h"
#include "core/run_files/film.h"
#include "core/run_files/run_reader.h"

namespace bipot {

/// The frames of a run that a page or a movie shows.
template <int D>
struct RunFrames {
  Film film;
  std::vector<PageBody> bodies;  ///< by number
  std::vector<Wall<D>> walls;    ///< at the start
  bool gates = false;            ///< bodies come or go
};

/// Frames of the film in the folder of a run; without a film, of an older version, those of its HDF5
/// files. `step`: size of the time step [s]. `after`: frames up to that step are left out; with gates,
/// `bodies` then has only those of the other frames. Throws FileError.
template <int D>
RunFrames<D> read_frames(const std::filesystem::path& folder, double step, int after = -1);

/// The state that a frame shows, as exact as the frame; without clusters and populations.
template <int D>
State<D> shown_state(const RunFrames<D>& run, const FilmFrame& frame, double step);

}  // namespace bipot
