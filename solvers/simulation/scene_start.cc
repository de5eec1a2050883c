#include "solvers/simulation/scene_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/pictures/flat_view.h"
#include "core/pictures/force_picture.h"
#include "core/scene/start_check.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

constexpr std::size_t kMostMarks = 1000;  // more would hide the bodies

/// The start, with a contact at the deepest overlaps but at outlets.
template <int D>
State<D> overlapping_state(const Scene<D>& scene, const std::vector<StartOverlap<D>>& overlaps) {
  State<D> state = initial_state(scene);
  for (const StartOverlap<D>& overlap : overlaps) {
    if (to_size(overlap.contact.j) >= scene.bodies.size() + scene.walls.size()) continue;
    if (state.contacts.size() == kMostMarks) break;
    state.contacts.push_back({.contact = overlap.contact});
  }
  return state;
}

/// The largest overlap of each body, in radii.
template <int D>
std::vector<double> largest_overlaps(const Scene<D>& scene,
                                     const std::vector<StartOverlap<D>>& overlaps) {
  std::vector<double> radii(scene.bodies.size(), 0.0);
  for (const StartOverlap<D>& overlap : overlaps) {
    for (const std::size_t body : {to_size(overlap.contact.i), to_size(overlap.contact.j)}) {
      if (body < radii.size()) radii[body] = std::max(radii[body], overlap.radii);
    }
  }
  return radii;
}

void draw(const std::filesystem::path& picture, const Scene<2>& scene, const State<2>& state,
          std::vector<double> radii, const std::string& caption, double time_limit) {
  ForcePictureOptions options;
  options.time_limit = time_limit;
  options.forces = false;
  options.fill = {std::move(radii), "overlap at the start", "radii", 0};
  for (std::size_t k = 0; k < state.contacts.size(); ++k) {
    options.marked.push_back(static_cast<int>(k));
  }
  options.marked_label = options.marked.size() < kMostMarks ? "overlaps" : "deepest overlaps";
  draw_force_picture(picture, scene, state, caption, options);
}

template <int D>
void draw_start(const std::filesystem::path& picture, const Scene<D>& scene,
                const std::vector<StartOverlap<D>>& overlaps, double time_limit) {
  const std::string caption = start_sentence(scene, overlaps);
  const State<D> state = overlapping_state(scene, overlaps);
  std::vector<double> radii = largest_overlaps(scene, overlaps);
  if constexpr (D == 2) {
    draw(picture, scene, state, std::move(radii), caption, time_limit);
  } else {
    const FlatView flat = project(scene, state, radii);
    std::vector<double> seen;
    for (const int body : flat.bodies) seen.push_back(radii[to_size(body)]);
    draw(picture, flat.scene, flat.state, std::move(seen),
         caption + "; seen from the side, overlapping bodies in front", time_limit);
  }
}

/// Moves what overlaps apart, without friction and to a tolerance of its own.
template <int D>
PushApart part_bodies(Scene<D>& scene, int threads, double time_limit) {
  SolverChoice choice;
  choice.tol = 1e-6;
  choice.max_iterations = 20000;
  RunSolver solver{
      .solver = choice.name, .options = to_options(choice), .watch = {}, .time_limit = time_limit};
  solver.options.execution.threads = threads;
  return push_apart(
      scene,
      [&](const ContactProblem& problem, Vector s0) {
        return to_step_solution(solver.solve(problem, std::move(s0)));
      },
      threads);
}

template <int D>
[[noreturn]] void refuse(const std::filesystem::path& picture, const Scene<D>& scene,
                         const std::vector<StartOverlap<D>>& overlaps, double time_limit,
                         const std::string& tried) {
  std::string message = start_sentence(scene, overlaps) + tried;
  if (!picture.empty()) {
    try {
      draw_start(picture, scene, overlaps, time_limit);
      message += fmt::format(". {} shows them", picture.string());
    } catch (const std::exception& e) {
      message += fmt::format(". No picture: {}", e.what());
    }
  }
  Scene<D> pushed = scene;
  pushed.start = StartChoice::kPushApart;
  const auto outlets = static_cast<int>(scene.bodies.size() + scene.walls.size());
  const bool can_push =
      scene.start == StartChoice::kRefuse && validate(pushed).empty() &&
      std::ranges::all_of(overlaps, [&](const auto& o) { return o.contact.j < outlets; });
  throw std::invalid_argument(fmt::format("{}. Move them, or set [start] overlaps to {}\"allow\"",
                                          message, can_push ? "\"push apart\" or " : ""));
}

}  // namespace

template <int D>
StartReport check_start(Scene<D>& scene, const std::filesystem::path& picture, int threads,
                        double time_limit) {
  const Stopwatch watch;
  std::vector<StartOverlap<D>> overlaps = start_overlaps(scene, threads);
  if (overlaps.empty()) return {};
  StartReport report;
  report.text = start_sentence(scene, overlaps);
  report.overlapping = static_cast<int>(overlapping_bodies(scene, overlaps).size());
  report.pair = overlap_name<D>(scene, overlaps[0].contact);
  report.depth = -overlaps[0].contact.gap;
  report.radii = overlaps[0].radii;
  if (scene.start == StartChoice::kRefuse) {
    refuse(picture, scene, overlaps, time_limit - watch.seconds(), "");
  }
  if (scene.start == StartChoice::kAllow) return report;
  const PushApart pushed = part_bodies(scene, threads, time_limit);
  const std::string how = fmt::format(
      "pushed apart in {} round{}, by at most {:.3g} m, {:.2g} "
      "radii",
      pushed.rounds, pushed.rounds == 1 ? "" : "s", pushed.way, pushed.radii);
  overlaps = start_overlaps(scene, threads);
  if (!overlaps.empty()) {
    const double left = time_limit - watch.seconds();
    const char* why = left < 0                 ? "; the time limit is over"
                      : pushed.message.empty() ? ""
                                               : "; it seems that they do not fit";
    refuse(picture, scene, overlaps, left, fmt::format(", {}{}", how, why));
  }
  report.text += ": " + how;
  report.push = pushed;
  return report;
}

template <int D>
void check_start(Scene<D>& scene, const std::function<void(const std::string&)>& warn) {
  const std::string start = check_start(scene, {}, 1, kInfinity).text;
  for (const std::string& text : {scene.caution, start}) {
    if (warn && !text.empty()) warn(text);
  }
}

template <int D>
int remaining_steps(const Scene<D>& scene, const State<D>& state, std::optional<double> duration) {
  if (!duration && scene.duration == 0) return std::max(scene.num_steps - state.step, 0);
  // Of the whole duration where all steps have the same size: a restart ends with the same step.
  const bool whole =
      !duration && std::abs(state.time - state.step * scene.step) < 1e-6 * scene.step;
  const double time = duration ? *duration : scene.duration - (whole ? 0 : state.time);
  const double steps = std::round(time / scene.step) - (whole ? state.step : 0);
  if (steps < 1 && time > 0 && state.step == 0) {
    throw std::invalid_argument(fmt::format(
        "the duration of {:.3g} s is shorter than a step of {:.3g} s", time, scene.step));
  }
  if (!(steps < std::numeric_limits<int>::max())) {
    throw std::invalid_argument(
        fmt::format("{:.3g} s are too many steps of {:.3g} s", time, scene.step));
  }
  return std::max(static_cast<int>(steps), 0);
}

template int remaining_steps(const Scene<2>&, const State<2>&, std::optional<double>);
template int remaining_steps(const Scene<3>&, const State<3>&, std::optional<double>);
template StartReport check_start(Scene<2>&, const std::filesystem::path&, int, double);
template StartReport check_start(Scene<3>&, const std::filesystem::path&, int, double);
template void check_start(Scene<2>&, const std::function<void(const std::string&)>&);
template void check_start(Scene<3>&, const std::function<void(const std::string&)>&);

}  // namespace bipot
