#include "core/motion/population.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "core/base/portable_random.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

/// Number of places tried for a body before it waits for the next step.
constexpr int kTries = 200;

/// `body`: a Body or a Cluster.
template <int D, class B>
void book(const B& body, const Vec<D>& gravity, GateFlow<D>& flow) {
  ++flow.count;
  flow.mass += body.mass;
  flow.last_mass += body.mass;
  flow.energy += 0.5 * body.mass * body.v.squaredNorm() + turning_energy(body) -
                 body.mass * gravity.dot(body.x);
  flow.momentum += body.mass * body.v;
}

/// Body number k of an inlet, without its place.
template <int D>
Body<D> body_due(const Inlet<D>& inlet, int k) {
  KeyedRandom random(KeyedEngine{inlet.seed, k, -1});
  const double drawn =
      random.uniform() * std::accumulate(inlet.shares.begin(), inlet.shares.end(), 0.0);
  std::size_t chosen = 0;
  for (double upto = inlet.shares[0]; drawn >= upto && chosen + 1 < inlet.radii.size();) {
    upto += inlet.shares[++chosen];
  }
  Body<D> body;
  body.radius = inlet.radii[chosen];
  const double square = body.radius * body.radius;
  const double size =
      D == 2 ? std::numbers::pi * square : 4.0 / 3 * std::numbers::pi * square * body.radius;
  body.mass = inlet.mass > 0 ? inlet.mass : inlet.density * size;
  body.inertia = inlet.inertia > 0 ? inlet.inertia : (D == 2 ? 0.5 : 0.4) * body.mass * square;
  body.v = inlet.v;
  body.spin = inlet.spin;
  body.material = inlet.material;
  return body;
}

/// Bodies that may obstruct an inlet.
template <int D>
std::vector<Body<D>> bodies_near(const Inlet<D>& inlet, const std::vector<Body<D>>& bodies,
                                 double distance) {
  std::vector<Body<D>> near;
  for (const Body<D>& b : bodies) {
    const Vec<D> inside = b.x.cwiseMax(inlet.lower).cwiseMin(inlet.upper);
    const double reach = b.radius + distance;
    if ((b.x - inside).squaredNorm() <= reach * reach) near.push_back(b);
  }
  return near;
}

template <int D>
bool has_room(const Body<D>& body, const std::vector<Body<D>>& near,
              const std::vector<Wall<D>>& walls, double distance) {
  for (const Body<D>& b : near) {
    const double reach = body.radius + b.radius + distance;
    if ((b.x - body.x).squaredNorm() <= reach * reach) return false;
  }
  std::vector<Contact<D>> touched;
  for (const Wall<D>& wall : walls) {
    if (!wall.present) continue;
    try {
      find_wall_contact<D>(body, 0, wall, 0, distance, touched);
    } catch (const std::invalid_argument&) {
      return false;  // its centre lies on the wall
    }
    if (!touched.empty()) return false;
  }
  return true;
}

/// Places a body at random in the inlet's box; false if no free place is found.
template <int D>
bool find_place(const Inlet<D>& inlet, int k, int step, const std::vector<Body<D>>& near,
                const std::vector<Wall<D>>& walls, double distance, Body<D>& body) {
  KeyedRandom random(KeyedEngine{inlet.seed, k, step});
  const Vec<D> low = inlet.lower + Vec<D>::Constant(body.radius);
  const Vec<D> room = inlet.upper - inlet.lower - Vec<D>::Constant(2 * body.radius);
  for (int tried = 0; tried < kTries; ++tried) {
    for (int axis = 0; axis < D; ++axis) body.x[axis] = low[axis] + random.uniform() * room[axis];
    if (has_room(body, near, walls, distance)) return true;
  }
  return false;
}

/// Number of bodies of an inlet that are due at a time.
template <int D>
int number_due(const Inlet<D>& inlet, double time) {
  if (time < inlet.starts || time >= inlet.stops) return 0;
  // Rounding must not delay a body that is due exactly at the time of a step.
  const double due = std::floor((time - inlet.starts) * inlet.rate + 1e-9) + 1;
  const double most = inlet.count < 0 ? 1e9 : inlet.count;
  return static_cast<int>(std::min(due, most));
}

/// The outlet that takes a body at a place with a velocity, or an image of it that reaches a box;
/// the number of outlets if none does.
template <int D>
std::size_t outlet_at(const Scene<D>& scene, const State<D>& state, Vec<D> x, Vec<D> v) {
  const PeriodicCell& cell = state.cell;
  if (cell.periodic()) {
    v -= image_velocity(cell, x);
    x.template head<2>() = wrapped(cell, x.template head<2>());
  }
  // The parts of a step bend the way.
  const double half_step = scene.accuracy > 0 ? 0.0 : 0.5 * scene.step;
  const Vec<D> way = half_step * v;
  const auto takes = [&](const Outlet<D>& outlet) {
    if (!outlet.box || !cell.periodic()) return outlet.takes(x, way);
    Box<2> along;
    along.include((x - way).template head<2>());
    along.include((x + way).template head<2>());
    return std::ranges::any_of(
        first_images_over(cell, along, half_step, Box<D>{outlet.lower, outlet.upper}.flat()),
        [&](const CellNumber& k) {
          const Vec<D> of_image = half_step * in_dimensions<D>(cell.shift_velocity(k.kx, k.ky));
          return outlet.takes(x + in_dimensions<D>(cell.shift(k.kx, k.ky)), way + of_image);
        });
  };
  return static_cast<std::size_t>(std::ranges::find_if(scene.outlets, takes) -
                                  scene.outlets.begin());
}

/// Removes clusters by their centres of mass. Returns new indices of the clusters, -1: removed.
template <int D>
std::vector<int> let_clusters_out(const Scene<D>& scene, const Vec<D>& gravity, State<D>& state) {
  std::vector<Cluster<D>>& clusters = state.clusters.bodies;
  std::vector<int> new_number(clusters.size(), -1);
  int kept = 0;
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    const std::size_t outlet = outlet_at(scene, state, clusters[c].x, clusters[c].v);
    if (outlet < scene.outlets.size()) {
      book<D>(clusters[c], gravity, state.population.outlets[outlet]);
      continue;
    }
    new_number[c] = kept;
    clusters[to_size(kept++)] = clusters[c];
  }
  clusters.resize(to_size(kept));
  return new_number;
}

template <int D>
void let_out(const Scene<D>& scene, const Vec<D>& gravity, State<D>& state,
             std::vector<int>& new_index) {
  const std::vector<int> new_cluster = let_clusters_out(scene, gravity, state);
  std::vector<Vec<D>>& arms = state.clusters.arms;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    Body<D> body = state.bodies[i];
    if (body.cluster >= 0) {
      body.cluster = new_cluster[to_size(body.cluster)];
      if (body.cluster < 0) continue;
    } else if (body.wall < 0) {
      const std::size_t outlet = outlet_at(scene, state, body.x, body.v);
      if (outlet < scene.outlets.size()) {
        book<D>(body, gravity, state.population.outlets[outlet]);
        continue;
      }
    }
    new_index[i] = static_cast<int>(kept);
    state.population.numbers[kept] = state.population.numbers[i];
    if (!arms.empty()) arms[kept] = arms[i];
    state.bodies[kept++] = body;
  }
  if (!arms.empty()) arms.resize(kept);
  state.bodies.resize(kept);
  state.population.numbers.resize(kept);
}

template <int D>
void let_in(const Scene<D>& scene, const Vec<D>& gravity, State<D>& state) {
  int number = static_cast<int>(scene.bodies.size());
  for (const GateFlow<D>& flow : state.population.inlets) number += flow.count;
  for (std::size_t g = 0; g < scene.inlets.size(); ++g) {
    const Inlet<D>& inlet = scene.inlets[g];
    GateFlow<D>& flow = state.population.inlets[g];
    const int due = number_due(inlet, state.time);
    if (flow.count >= due) continue;
    std::vector<Body<D>> near = bodies_near(inlet, state.bodies, scene.contact_distance);
    while (flow.count < due) {
      Body<D> body = body_due(inlet, flow.count);
      if (!find_place(inlet, flow.count, state.step, near, state.walls, scene.contact_distance,
                      body)) {
        ++flow.waiting;
        break;
      }
      book<D>(body, gravity, flow);
      near.push_back(body);
      state.bodies.push_back(body);
      if (!state.clusters.arms.empty()) state.clusters.arms.push_back(Vec<D>::Zero());
      state.population.numbers.push_back(number++);
    }
  }
}

/// Renumbers the contacts of the last step; `before`: the number of bodies before.
template <int D>
void renumber_contacts(const std::vector<int>& new_index, State<D>& state) {
  const int before = static_cast<int>(new_index.size());
  const int now = static_cast<int>(state.bodies.size());
  const auto renumbered = [&](int body) {
    return body < before ? new_index[to_size(body)] : body - before + now;
  };
  for (ContactOutcome<D>& outcome : state.contacts) {
    for (int* body : {&outcome.contact.i, &outcome.contact.j}) *body = renumbered(*body);
  }
  std::erase_if(state.contacts, [](const ContactOutcome<D>& outcome) {
    return outcome.contact.i < 0 || outcome.contact.j < 0;
  });
}

}  // namespace

template <int D>
Population<D> initial_population(const Scene<D>& scene) {
  Population<D> population;
  if (!scene.has_gates()) return population;
  population.numbers.resize(scene.bodies.size());
  std::iota(population.numbers.begin(), population.numbers.end(), 0);
  population.outlets.resize(scene.outlets.size());
  population.inlets.resize(scene.inlets.size());
  return population;
}

template <int D>
bool change_population(const Scene<D>& scene, State<D>& state) {
  Population<D>& population = state.population;
  if (population.numbers.size() != state.bodies.size() ||
      population.outlets.size() != scene.outlets.size() ||
      population.inlets.size() != scene.inlets.size()) {
    throw std::invalid_argument("the state's population is not one of the scene");
  }
  for (auto* flows : {&population.outlets, &population.inlets}) {
    for (GateFlow<D>& flow : *flows) flow.last_mass = 0;
  }
  const Vec<D> gravity = gravity_at(scene, state.time);
  const std::size_t before = state.bodies.size();
  std::vector<int> new_index(before, -1);
  let_out(scene, gravity, state, new_index);
  const std::size_t left = before - state.bodies.size();
  let_in(scene, gravity, state);
  const bool changed = left > 0 || state.bodies.size() != before;
  if (changed) renumber_contacts(new_index, state);
  return changed;
}

template <int D>
int body_index(const State<D>& state, int number) {
  const std::vector<int>& numbers = state.population.numbers;
  if (state.population.outlets.empty() && state.population.inlets.empty()) {
    return number < static_cast<int>(state.bodies.size()) ? number : -1;
  }
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), number);
  const bool there = found != numbers.end() && *found == number;
  return there ? static_cast<int>(found - numbers.begin()) : -1;
}

template <int D>
GateFlow<D> passed(const State<D>& state) {
  GateFlow<D> sum;
  for (const auto& [flows, sign] :
       {std::pair(&state.population.inlets, 1), std::pair(&state.population.outlets, -1)}) {
    for (const GateFlow<D>& flow : *flows) {
      sum.energy += sign * flow.energy;
      sum.momentum += sign * flow.momentum;
    }
  }
  return sum;
}

template Population<2> initial_population(const Scene<2>&);
template Population<3> initial_population(const Scene<3>&);
template bool change_population(const Scene<2>&, State<2>&);
template bool change_population(const Scene<3>&, State<3>&);
template int body_index(const State<2>&, int);
template int body_index(const State<3>&, int);
template GateFlow<2> passed(const State<2>&);
template GateFlow<3> passed(const State<3>&);

}  // namespace bipot
