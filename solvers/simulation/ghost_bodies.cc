#include "solvers/simulation/ghost_bodies.h"

#include <algorithm>
#include <utility>

#include "core/motion/midpoint.h"
#include "solvers/simulation/body_buffer.h"

namespace bipot {
namespace {

/// Relative rounding of positions and gaps, by which detection may differ.
constexpr double kRounding = 1e-12;

/// Wider by this, and by rounding.
template <int D>
void widen(Box<D>& box, double by) {
  const double size = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
  box.widen(by * (1 + kRounding) + kRounding * size);
}

template <int D>
bool meet(const Box<D>& a, const Box<D>& b) {
  return (b.upper.array() >= a.lower.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

/// Boxes of the bodies of all processes, and the largest radius.
template <int D>
std::vector<Box<D>> gather_reaches(const Box<D>& mine, double& largest_radius,
                                   ProcessGroup& group) {
  Buffer numbers;
  append(numbers, mine.lower, mine.upper, largest_radius);
  const Buffer all = group.gather(numbers);
  BufferReader reader(all);
  std::vector<Box<D>> reaches(to_size(group.size()));
  for (Box<D>& reach : reaches) {
    reader.take(reach.lower, reach.upper);
    largest_radius = std::max(largest_radius, reader.number());
  }
  return reaches;
}

}  // namespace

template <int D>
LocalBodies<D> with_ghosts(const Scene<D>& scene, const DomainState<D>& state,
                           ProcessGroup& group) {
  std::vector<Buffer> buffers(to_size(group.size()));
  {
    const std::vector<Body<D>> bodies = free_midpoint(scene, state.here).bodies;
    Box<D> mine;
    double largest_radius = 0;
    for (const Body<D>& d : bodies) {
      mine.include(d.x, d.radius);
      largest_radius = std::max(largest_radius, d.radius);
    }
    std::vector<Box<D>> reaches = gather_reaches(mine, largest_radius, group);
    for (int r = 0; r < group.size(); ++r) {
      Box<D>& theirs = reaches[to_size(r)];
      if (r == group.rank() || theirs.empty()) continue;
      widen(theirs, 2 * largest_radius + 2 * std::max(scene.contact_distance, 0.0));
      if (!meet(theirs, mine)) continue;
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        Box<D> of_body;
        of_body.include(bodies[k].x, bodies[k].radius);
        if (!meet(theirs, of_body)) continue;
        put(state.numbers[k], state.here.bodies[k], buffers[to_size(r)]);
      }
    }
  }
  buffers = group.deliver(std::move(buffers));
  struct Ghost {
    NumberedBody<D> body;
    int owner;
  };
  std::vector<Ghost> ghosts;
  for (int r = 0; r < group.size(); ++r) {
    for (BufferReader reader(buffers[to_size(r)]); !reader.at_end();) {
      ghosts.push_back({take_body<D>(reader), r});
    }
  }
  std::sort(ghosts.begin(), ghosts.end(),
            [](const Ghost& a, const Ghost& b) { return a.body.number < b.body.number; });

  LocalBodies<D> local{
      .state = {.time = state.here.time, .step = state.here.step, .walls = state.here.walls}};
  const std::size_t total = state.numbers.size() + ghosts.size();
  local.numbers.reserve(total);
  local.owner.reserve(total);
  local.state.bodies.reserve(total);
  auto ghost = ghosts.begin();
  const auto add_ghosts_before = [&](int number) {
    for (; ghost != ghosts.end() && ghost->body.number < number; ++ghost) {
      local.numbers.push_back(ghost->body.number);
      local.owner.push_back(ghost->owner);
      local.state.bodies.push_back(ghost->body.body);
    }
  };
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    add_ghosts_before(state.numbers[k]);
    local.own.push_back(static_cast<int>(local.numbers.size()));
    local.numbers.push_back(state.numbers[k]);
    local.owner.push_back(group.rank());
    local.state.bodies.push_back(state.here.bodies[k]);
  }
  add_ghosts_before(state.bodies);
  return local;
}

template LocalBodies<2> with_ghosts(const Scene<2>&, const DomainState<2>&, ProcessGroup&);
template LocalBodies<3> with_ghosts(const Scene<3>&, const DomainState<3>&, ProcessGroup&);

}  // namespace bipot
