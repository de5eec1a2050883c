#include "core/run_files/film.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFilmMark = "bipot film 2\n", kEarlierMark = "bipot film 1\n";

template <class T>
std::string_view bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

}  // namespace

Film read_film(const fs::path& folder, int after) {
  const fs::path path = folder / kFilmFile;
  Film film;
  std::ifstream in(path, std::ios::binary);
  if (!in) return film;
  in.seekg(0, std::ios::end);
  const std::streamoff end = in.tellg();
  in.seekg(0);
  const auto take = [&](auto& value) {
    in.read(reinterpret_cast<char*>(&value), sizeof value);
    return bool(in);
  };
  std::string mark(kFilmMark.size(), '\0');
  in.read(mark.data(), static_cast<std::streamsize>(mark.size()));
  if (in && mark == kEarlierMark) return film;
  if (in && mark != kFilmMark) throw FileError(path, "", "not a film of this version");
  if (!in || !take(film.grid)) return film;  // killed at the start
  std::uint32_t size = 0;
  std::int32_t step = 0;  // with which a frame begins
  std::string bytes;
  while (take(size)) {
    const std::streamoff begin = in.tellg();
    if (size > end - begin || !take(step)) break;  // the frame under way when the run was killed
    film.steps.push_back(step);
    if (step > after) {
      bytes.resize(size);
      in.seekg(begin);
      in.read(bytes.data(), size);
      try {
        film.frames.push_back(frame_of_bytes(bytes));
      } catch (const std::invalid_argument& defect) {
        throw FileError(path, "", defect.what());
      }
    }
    in.seekg(begin + size);
  }
  return film;
}

template <int D>
FilmRecorder<D>::FilmRecorder(fs::path folder, const Scene<D>& scene, int resume_after)
    : path_(folder / kFilmFile), scene_(scene), grid_(film_grid(scene)) {
  Film before = read_film(folder);
  std::erase_if(before.frames, [&](const FilmFrame& f) { return f.step > resume_after; });
  // One film has one grid; bodies that a start moved apart were elsewhere when it was made.
  if (before.grid.quantum == grid_.quantum) grid_ = before.grid;
  if (before.grid != grid_) before.frames.clear();
  // Distances tell how often steps were taken; the first and the last may stand anywhere.
  const auto& frames = before.frames;
  if (frames.size() > 3) every_ = std::max(1, frames[2].step - frames[1].step);
  rewrite(frames);
}

template <int D>
void FilmRecorder<D>::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
  }
}

template <int D>
void FilmRecorder<D>::rewrite(const std::vector<FilmFrame>& frames) {
  fs::path draft = path_;
  draft += ".part";
  file_.reset(std::fopen(draft.c_str(), "wb"));
  if (!file_) throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
  write(kFilmMark);
  write(bytes_of(grid_));
  frames_ = bytes_ = 0;
  for (const FilmFrame& frame : frames) append(frame);
  std::error_code error;
  if (std::fflush(file_.get()) == 0) fs::rename(draft, path_, error);
  if (error) throw FileError(path_, "", "cannot write: " + error.message());
}

template <int D>
void FilmRecorder<D>::step(const State<D>& state) {
  if (state.step % every_ != 0) return;
  add(state);
  if (frames_ >= kMostFrames || (bytes_ > kMostBytes && frames_ > 2)) thin();
}

template <int D>
void FilmRecorder<D>::add(const State<D>& state) {
  if (state.step <= last_) return;
  FilmFrame frame = film_frame(state, grid_, scene_.step, scene_.has_gates());
  const auto turns = [](const Wall<D>& wall) { return wall.spin != 0; };
  if (std::any_of(scene_.walls.begin(), scene_.walls.end(), turns)) {
    for (const Wall<D>& wall : scene_.walls) {
      frame.wall_turn.push_back(angle_code(turned_angle(wall, state.time)));
    }
  }
  append(frame);
  if (std::fflush(file_.get()) != 0) {
    throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
  }
}

template <int D>
void FilmRecorder<D>::append(const FilmFrame& frame) {
  const std::string bytes = to_bytes(frame);
  write(bytes_of(static_cast<std::uint32_t>(bytes.size())));
  write(bytes);
  last_ = frame.step;
  bytes_ += bytes.size();
  ++frames_;
}

template <int D>
void FilmRecorder<D>::thin() {
  every_ *= 2;
  std::vector<FilmFrame> frames = read_film(path_.parent_path()).frames;
  std::erase_if(frames, [&, first = frames.front().step](const FilmFrame& frame) {
    return frame.step != first && frame.step % every_ != 0;
  });
  rewrite(frames);
}

template class FilmRecorder<2>;
template class FilmRecorder<3>;

}  // namespace bipot
