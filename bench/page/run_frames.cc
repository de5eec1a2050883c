#include "bench/page/run_frames.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

template <int D>
void describe_bodies(const State<D>& first, RunFrames<D>& run) {
  for (const Body<D>& body : first.bodies) {
    run.bodies.push_back({.radius = static_cast<float>(body.radius),
                          .mass = static_cast<float>(body.mass),
                          .material = static_cast<std::uint8_t>(std::min(body.material, 255)),
                          .glued = body.wall >= 0,
                          .cluster = body.cluster});
  }
  if (!run.gates) return;
  for (const FilmFrame& frame : run.film.frames) {
    for (std::size_t k = 0; k < frame.number.size(); ++k) {
      const std::size_t number = to_size(frame.number[k]);
      if (number >= run.bodies.size()) run.bodies.resize(number + 1);
      run.bodies[number] = {
          .radius = frame.radius.at(k), .mass = frame.mass.at(k), .material = frame.material.at(k)};
    }
  }
}

}  // namespace

template <int D>
RunFrames<D> read_frames(const fs::path& folder, double step, int after) {
  RunFrames<D> run;
  const std::vector<int> steps = steps_in_folder(folder);
  if (steps.empty()) throw FileError(folder, "frames", "no frame has been written");
  const State<D> first = read_state<D>(folder, steps.front());
  run.gates = !first.population.numbers.empty() || !first.population.outlets.empty() ||
              !first.population.inlets.empty();
  run.walls = first.walls;
  run.film = read_film(folder, after);
  if (run.film.frames.empty() && after < 0) {
    Scene<D> scene;
    scene.bodies = first.bodies;
    scene.cell = first.cell;
    run.film.grid = film_grid(scene);
    for (const int k : steps) {
      run.film.frames.push_back(
          film_frame(read_state<D>(folder, k), run.film.grid, step, run.gates));
    }
  }
  describe_bodies(first, run);
  return run;
}

template <int D>
State<D> shown_state(const RunFrames<D>& run, const FilmFrame& frame, double step) {
  const FilmFrame::Widths widths(D);
  State<D> state;
  state.step = frame.step;
  state.time = frame.time;
  state.cell.in_x = frame.cell[0] > 0;
  state.cell.in_y = frame.cell[1] > 0;
  for (int side = 0; side < 3; ++side) state.cell.side(side).length = frame.cell[to_size(side)];
  state.walls = run.walls;
  for (std::size_t w = 0; w < state.walls.size(); ++w) {
    const double* place = frame.walls.data() + w * (2 * D + 1);
    state.walls[w].a = Eigen::Map<const Vec<D>>(place);
    state.walls[w].b = Eigen::Map<const Vec<D>>(place + D);
    state.walls[w].present = place[2 * D] != 0;
  }
  std::map<int, int> index;
  for (std::size_t k = 0; k < frame.number.size(); ++k) {
    const PageBody& known = run.bodies.at(to_size(frame.number[k]));
    Body<D> body;
    body.radius = static_cast<double>(known.radius);
    body.mass = static_cast<double>(known.mass);
    for (int c = 0; c < D; ++c) {
      body.x[c] = run.film.grid.position(frame.x[k * widths.x + to_size(c)], to_size(c));
      body.v[c] = log_value(frame.v[k * widths.x + to_size(c)]);
    }
    if constexpr (D == 2) {
      body.angle = angle_value(frame.turn[k]);
    } else {
      body.orientation = quaternion_value(frame.turn.data() + 3 * k);
    }
    index[frame.number[k]] = static_cast<int>(k);
    state.bodies.push_back(body);
  }
  const int bodies = static_cast<int>(state.bodies.size());
  for (std::size_t k = 0; k < frame.i.size(); ++k) {
    ContactOutcome<D> outcome;
    Contact<D>& contact = outcome.contact;
    const bool wall = frame.j[k] >= FilmFrame::kWall;
    contact.i = index.at(frame.i[k]);
    contact.j = wall ? bodies + frame.j[k] - FilmFrame::kWall : index.at(frame.j[k]);
    contact.gap = log_value(frame.gap[k]);
    if constexpr (D == 2) {
      const double angle = angle_value(frame.n[k]);
      contact.n = Vec2(std::cos(angle), std::sin(angle));
      outcome.s_t = step * log_value(frame.force_t[k]);
    } else {
      contact.n = direction_value(frame.n[2 * k], frame.n[2 * k + 1]);
      for (int c = 0; c < 3; ++c)
        outcome.s_t[c] = step * log_value(frame.force_t[3 * k + to_size(c)]);
    }
    outcome.s_n = step * log_value(frame.force_n[k]);
    outcome.status = static_cast<ContactStatus>(frame.status[k]);
    if (!wall && state.cell.in_x) {
      // The image of j that lies where the contact says.
      const Body<D>&i = state.bodies[to_size(contact.i)], &j = state.bodies[to_size(contact.j)];
      const Vec<D> away = i.x - (i.radius + j.radius + contact.gap) * contact.n - j.x;
      const double height = state.cell.height.length, offset = state.cell.offset.length;
      contact.image_y = state.cell.in_y ? static_cast<int>(std::lround(away[1] / height)) : 0;
      contact.image_x = static_cast<int>(
          std::lround((away[0] - contact.image_y * offset) / state.cell.width.length));
    }
    state.contacts.push_back(outcome);
  }
  return state;
}

template RunFrames<2> read_frames<2>(const fs::path&, double, int);
template RunFrames<3> read_frames<3>(const fs::path&, double, int);
template State<2> shown_state(const RunFrames<2>&, const FilmFrame&, double);
template State<3> shown_state(const RunFrames<3>&, const FilmFrame&, double);

}  // namespace bipot
