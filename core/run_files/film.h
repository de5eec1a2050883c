#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/file_error.h"
#include "core/run_files/film_frame.h"

namespace bipot {

inline constexpr const char* kFilmFile = "film.bin";  ///< in the folder of a run

/// film.bin in the folder of a run: frames for the eye, written while the run goes on. The length
/// of the run need not be known. It begins with every step. Whenever it holds kMostFrames frames or
/// kMostBytes, every other frame goes, and later steps are taken half as often. A run that is
/// killed leaves all but the frame under way. Throws FileError.
template <int D>
class FilmRecorder {
 public:
  static constexpr std::size_t kMostFrames = 800, kMostBytes = 48u << 20;

  /// Begins a film, or with `resume_after` >= 0 goes on with the one in the folder, whose later
  /// frames go. The scene must outlive the recorder.
  FilmRecorder(std::filesystem::path folder, const Scene<D>& scene, int resume_after = -1);

  /// Takes the state if its step is due.
  void step(const State<D>& state);
  /// Takes the last state in any case.
  void finish(const State<D>& last) { add(last); }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void add(const State<D>& state);
  void append(const FilmFrame& frame);
  void write(std::string_view bytes);
  void rewrite(const std::vector<FilmFrame>& frames);
  void thin();

  std::filesystem::path path_;
  const Scene<D>& scene_;
  std::unique_ptr<std::FILE, Close> file_;
  FilmGrid grid_;
  int every_ = 1, last_ = -1;  // steps
  std::size_t frames_ = 0, bytes_ = 0;
};

struct Film {
  FilmGrid grid;
  std::vector<FilmFrame> frames;
  std::vector<int> steps;  ///< of all frames, of those left out as well
};

/// The film of a run, in which a frame that is cut off at the end does not count; without frames if
/// the run has none of this version. `after`: frames up to that step are left out. The run may go
/// on meanwhile. Throws FileError.
Film read_film(const std::filesystem::path& folder, int after = -1);

}  // namespace bipot
