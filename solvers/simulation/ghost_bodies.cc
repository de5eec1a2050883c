#include "solvers/simulation/ghost_bodies.h"

#include <algorithm>
#include <utility>

#include "core/motion/midpoint.h"
#include "solvers/simulation/body_buffer.h"

namespace bipot {
namespace {

/// Relative rounding of positions and gaps, by which detection may differ.
constexpr double kRounding = 1e-12;

/// A box of bodies, rims included; empty if lower > upper.
template <int D>
struct Reach {
  Vec<D> lower = Vec<D>::Constant(kInfinity), upper = Vec<D>::Constant(-kInfinity);

  void include(const Body<D>& d) {
    lower = lower.cwiseMin((d.x.array() - d.radius).matrix());
    upper = upper.cwiseMax((d.x.array() + d.radius).matrix());
  }
  bool empty() const { return !(lower.array() <= upper.array()).all(); }
  void widen(double by) {
    const double rounding =
        kRounding * std::max(lower.cwiseAbs().maxCoeff(), upper.cwiseAbs().maxCoeff());
    lower.array() -= by * (1 + kRounding) + rounding;
    upper.array() += by * (1 + kRounding) + rounding;
  }
  bool meets(const Body<D>& d) const {
    return (d.x.array() + d.radius >= lower.array()).all() &&
           (d.x.array() - d.radius <= upper.array()).all();
  }
  bool meets(const Reach& other) const {
    return (other.upper.array() >= lower.array()).all() &&
           (other.lower.array() <= upper.array()).all();
  }
};

/// Boxes of the bodies of all processes, and the largest radius.
template <int D>
std::vector<Reach<D>> gather_reaches(const Reach<D>& mine, double& largest_radius,
                                     ProcessGroup& group) {
  constexpr std::size_t kNumbers = 2 * D + 1;
  std::vector<double> numbers(mine.lower.begin(), mine.lower.end());
  numbers.insert(numbers.end(), mine.upper.begin(), mine.upper.end());
  numbers.push_back(largest_radius);
  const std::vector<double> all = group.gather(numbers);
  std::vector<Reach<D>> reaches(to_size(group.size()));
  for (std::size_t r = 0; r < reaches.size(); ++r) {
    const double* from = all.data() + r * kNumbers;
    reaches[r].lower = Eigen::Map<const Vec<D>>(from);
    reaches[r].upper = Eigen::Map<const Vec<D>>(from + D);
    largest_radius = std::max(largest_radius, from[2 * D]);
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
    Reach<D> mine;
    double largest_radius = 0;
    for (const Body<D>& d : bodies) {
      mine.include(d);
      largest_radius = std::max(largest_radius, d.radius);
    }
    std::vector<Reach<D>> reaches = gather_reaches(mine, largest_radius, group);
    for (int r = 0; r < group.size(); ++r) {
      Reach<D>& theirs = reaches[to_size(r)];
      if (r == group.rank() || theirs.empty()) continue;
      theirs.widen(2 * largest_radius + 2 * std::max(scene.contact_distance, 0.0));
      if (!theirs.meets(mine)) continue;
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        if (!theirs.meets(bodies[k])) continue;
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

  LocalBodies<D> local;
  local.state.time = state.here.time;
  local.state.step = state.here.step;
  local.state.walls = state.here.walls;
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
