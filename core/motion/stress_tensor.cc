#include "core/motion/stress_tensor.h"

#include <algorithm>
#include <cmath>

#include "core/motion/periodic_state.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/scene_parts.h"

namespace bipot {
namespace {

/// Force and geometry of a contact. Its tensor is f ⊗ l except for the antisymmetric part, which
/// uses the lever arms of the step (MeanStress).
template <int D>
struct Link {
  int i = 0, j = -1;   // j < 0: a wall
  Vec<D> from, to;     // ends of the branch: centre of i; centre of j or point of the wall
  double share_i = 1;  // of disk i in the branch
  Mat<D> symmetric = Mat<D>::Zero();  // [N m]
  Spin<D> arms = no_turn<D>();        // (a_i + a_j) n × s_t / h             [N m]
  Vec<D> force = Vec<D>::Zero();      // on i                                  [N]
  Mat<D> lever = Mat<D>::Zero();      // beside the tensor, where it ends in clusters [N m]
  Mat<D> tensor() const { return symmetric + cross_matrix(0.5 * arms); }
};

template <int D>
std::vector<Link<D>> collect_links(const State<D>& state, double step) {
  std::vector<Link<D>> links;
  links.reserve(state.contacts.size());
  const int num_disks = static_cast<int>(state.bodies.size());
  for (const ContactOutcome<D>& o : state.contacts) {
    if (o.s_n == 0 && o.s_t == no_turn<D>()) continue;
    const Body<D>& a = state.bodies[static_cast<std::size_t>(o.contact.i)];
    Link<D> link;
    link.i = o.contact.i;
    link.from = middle_of_step(a, step);
    double arms = a.radius;
    if (o.contact.j < num_disks) {
      const Body<D>& b = state.bodies[static_cast<std::size_t>(o.contact.j)];
      link.j = o.contact.j;
      arms += b.radius;
      link.share_i = a.radius / arms;
    }
    const Vec<D>& n = o.contact.n;
    const double length = arms + o.contact.gap;
    link.to = link.from - length * n;
    if constexpr (D == 2) {
      const Vec2 t(-n[1], n[0]);
      link.symmetric =
          length / step *
          (o.s_n * n * n.transpose() + 0.5 * o.s_t * (t * n.transpose() + n * t.transpose()));
    } else {
      link.symmetric =
          length / step *
          (o.s_n * n * n.transpose() + 0.5 * (o.s_t * n.transpose() + n * o.s_t.transpose()));
    }
    link.arms = arms * turning(n, o.s_t) / step;
    link.force = (o.s_n * n + tangent_vector(n, o.s_t)) / step;
    links.push_back(link);
  }
  return links;
}

template <int D>
Vec<D> mean_velocity(std::span<const Body<D>> disks) {
  Vec<D> momentum = Vec<D>::Zero();
  double mass = 0;
  for (const Body<D>& d : disks) {
    momentum += d.mass * d.v;
    mass += d.mass;
  }
  return mass > 0 ? Vec<D>(momentum / mass) : Vec<D>(Vec<D>::Zero());
}

template <int D>
Mat<D> kinetic_part(const Body<D>& d, const Vec<D>& mean) {
  const Vec<D> v = d.v - mean;
  return d.mass * v * v.transpose();
}

/// The disks, and after them the clusters as bodies with mass and motion only; velocities are
/// relative to the deformation of their periodic cell.
template <int D>
std::vector<Body<D>> relative_bodies(const State<D>& state) {
  std::vector<Body<D>> bodies = state.bodies;
  for (const Cluster<D>& c : state.clusters.bodies) {
    bodies.push_back({.x = c.x, .v = c.v, .mass = c.mass});
  }
  if (!state.cell.deforms()) return bodies;
  for (Body<D>& body : bodies) {
    body.v -= in_dimensions<D>(homogeneous_velocity(state.cell, body.x.template head<2>()));
  }
  return bodies;
}

/// From the centre of mass of its cluster to each disk at mid-step, zero for disks in no cluster.
template <int D>
std::vector<Vec<D>> arms_at_middle(const State<D>& state, double step) {
  std::vector<Vec<D>> arms(state.bodies.size(), Vec<D>::Zero());
  for (std::size_t k = 0; k < arms.size(); ++k) {
    if (state.bodies[k].cluster < 0) continue;
    Cluster<D> cluster = state.clusters.bodies[to_size(state.bodies[k].cluster)];
    drift(cluster, -0.5 * step);
    arms[k] = turned_arm(cluster, state.clusters.arms[k]);
  }
  return arms;
}

/// Adds the terms of contacts of clusters, whose branches end in the centre of mass, not in that of
/// the disk. A force f on a disk at c from it adds -f ⊗ c to the contact part, and its moment c × f
/// to the spin part. `add(disk, contact, spin)`. [N m]
template <int D, class Add>
void add_levers(const State<D>& state, double step, const Add& add) {
  const int num_disks = static_cast<int>(state.bodies.size());
  const std::vector<Vec<D>> arms = arms_at_middle(state, step);
  for (const ContactOutcome<D>& o : state.contacts) {
    const Vec<D> f = (o.s_n * o.contact.n + tangent_vector(o.contact.n, o.s_t)) / step;
    for (const auto& [body, force] :
         {std::pair<int, Vec<D>>(o.contact.i, f), std::pair<int, Vec<D>>(o.contact.j, -f)}) {
      if (body >= num_disks || state.bodies[to_size(body)].cluster < 0) continue;
      const Vec<D>& c = arms[to_size(body)];
      add(to_size(body), Mat<D>(-force * c.transpose()), cross_matrix(0.5 * arm_times(c, force)));
    }
  }
}

template <class Spin>
auto spin_part(const Spin& moment, double step) {
  return cross_matrix(0.5 * moment / step);
}

template <int D>
void divide(MeanStress<D>& stress, double area) {
  stress.area = area;
  stress.contact /= area;
  stress.kinetic /= area;
  stress.spin /= area;
}

/// Gives each disk of a cluster the mean stress of the whole cluster over the area of its union.
/// `bodies`: relative_bodies().
template <int D>
void gather_clusters(const State<D>& state, double step, const std::vector<Body<D>>& bodies,
                     const Vec<D>& mean, std::vector<MeanStress<D>>& stresses) {
  add_levers(state, step, [&](std::size_t disk, const Mat<D>& contact, const Mat<D>& spin) {
    stresses[disk].contact += contact;
    stresses[disk].spin += spin;
  });
  std::vector<MeanStress<D>> of_cluster(state.clusters.bodies.size());
  for (std::size_t c = 0; c < of_cluster.size(); ++c) {
    of_cluster[c].kinetic = kinetic_part<D>(bodies[stresses.size() + c], mean);
  }
  for (std::size_t k = 0; k < stresses.size(); ++k) {
    const int cluster = state.bodies[k].cluster;
    if (cluster < 0) continue;
    of_cluster[to_size(cluster)].contact += stresses[k].contact;
    of_cluster[to_size(cluster)].spin += stresses[k].spin;
  }
  for (std::size_t c = 0; c < of_cluster.size(); ++c) {
    divide(of_cluster[c], state.clusters.bodies[c].size);
  }
  for (std::size_t k = 0; k < stresses.size(); ++k) {
    const int cluster = state.bodies[k].cluster;
    if (cluster >= 0) stresses[k] = of_cluster[to_size(cluster)];
  }
}

/// Changes links that end in clusters: branches then lead to the centres of mass, with the tensors
/// that follow. Moments of the contacts on clusters are added to those of the clusters. `arms`:
/// arms_at_middle().
template <int D>
void end_in_clusters(const State<D>& state, std::vector<Link<D>>& links,
                     const std::vector<Vec<D>>& arms) {
  for (Link<D>& link : links) {
    if (state.bodies[to_size(link.i)].cluster >= 0) {
      const Vec<D>& c = arms[to_size(link.i)];
      link.from -= c;
      link.lever -= link.force * c.transpose();
    }
    if (link.j >= 0 && state.bodies[to_size(link.j)].cluster >= 0) {
      const Vec<D>& c = arms[to_size(link.j)];
      link.to -= c;
      link.lever += link.force * c.transpose();
    }
  }
}

/// The place to which motion and moment of a body are assigned.
template <int D>
struct Centre {
  Body<D> body;  // x at mid-step
  Spin<D> moment = no_turn<D>();
};

template <int D>
std::vector<Centre<D>> centres(const State<D>& state, double step,
                               std::span<const std::type_identity_t<Spin<D>>> moments) {
  std::vector<Centre<D>> list;
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    if (state.bodies[k].cluster >= 0) continue;
    list.push_back({state.bodies[k], moments[k]});
    list.back().body.x = middle_of_step(state.bodies[k], step);
  }
  if (state.clusters.empty()) return list;
  const std::size_t first = list.size();
  for (const Cluster<D>& c : state.clusters.bodies) {
    list.push_back({.body = {.x = c.x - 0.5 * step * c.v, .v = c.v, .mass = c.mass}});
  }
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    const int c = state.bodies[k].cluster;
    if (c >= 0) list[first + to_size(c)].moment += moments[k];
  }
  const std::vector<Vec<D>> arms = arms_at_middle(state, step);
  for (const Link<D>& link : collect_links(state, step)) {
    for (const auto& [disk, sign] : {std::pair(link.i, 1.0), std::pair(link.j, -1.0)}) {
      const int c = disk < 0 ? -1 : state.bodies[to_size(disk)].cluster;
      if (c < 0) continue;
      const Vec<D> force = sign * link.force;
      list[first + to_size(c)].moment += step * arm_times(arms[to_size(disk)], force);
    }
  }
  return list;
}

/// Fraction of the segment from a to b with lower <= x < upper in every coordinate.
template <int D>
double share_inside(const Vec<D>& a, const Vec<D>& b, const Box<D>& box) {
  double first = 0, last = 1;
  for (int k = 0; k < D; ++k) {
    const double slope = b[k] - a[k];
    if (slope == 0) {
      if (a[k] < box.lower[k] || a[k] >= box.upper[k]) return 0;
      continue;
    }
    const double low = (box.lower[k] - a[k]) / slope, high = (box.upper[k] - a[k]) / slope;
    first = std::max(first, std::min(low, high));
    last = std::min(last, std::max(low, high));
  }
  return std::max(0.0, last - first);
}

}  // namespace

template <int D>
std::vector<Spin<D>> contact_moments(const State<D>& state) {
  std::vector<Spin<D>> moments(state.bodies.size(), no_turn<D>());
  const int num_disks = static_cast<int>(state.bodies.size());
  for (const ContactOutcome<D>& o : state.contacts) {
    const Spin<D> turned = turning(o.contact.n, o.s_t);
    for (const int body : {o.contact.i, o.contact.j}) {
      if (body >= num_disks) continue;
      const auto k = static_cast<std::size_t>(body);
      const double side = body == o.contact.i ? 1 : -1;
      moments[k] -= state.bodies[k].radius * turned - side * o.moment;
    }
  }
  return moments;
}

template <int D>
std::vector<Spin<D>> spin_changes(const State<D>& before, const State<D>& after) {
  std::vector<Spin<D>> changes(after.bodies.size());
  for (std::size_t k = 0; k < changes.size(); ++k) {
    changes[k] = after.bodies[k].inertia * (after.bodies[k].spin - before.bodies[k].spin);
  }
  return changes;
}

template <int D>
MeanStress<D> sample_stress(const State<D>& state, double step, double area,
                            std::span<const std::type_identity_t<Spin<D>>> moments) {
  MeanStress<D> stress;
  for (const Link<D>& link : collect_links(state, step)) stress.contact += link.tensor();
  const std::vector<Body<D>> bodies = relative_bodies(state);
  const Vec<D> mean = mean_velocity<D>(bodies);
  for (const Body<D>& d : bodies) stress.kinetic += kinetic_part(d, mean);
  for (std::size_t k = 0; k < state.bodies.size(); ++k) stress.spin += spin_part(moments[k], step);
  if (!state.clusters.empty()) {
    add_levers(state, step, [&](std::size_t, const Mat<D>& contact, const Mat<D>& spin) {
      stress.contact += contact;
      stress.spin += spin;
    });
  }
  divide(stress, area);
  return stress;
}

template <int D>
MeanStress<D> window_stress(const State<D>& state, double step, const Box<D>& window,
                            std::span<const std::type_identity_t<Spin<D>>> moments) {
  MeanStress<D> stress;
  const Box<2> region = window.flat();
  const PeriodicCell& cell = state.cell;
  std::vector<Link<D>> links = collect_links(state, step);
  if (!state.clusters.empty()) end_in_clusters(state, links, arms_at_middle(state, step));
  Box<2> contents;
  for (const Link<D>& link : links) {
    contents.include(link.from.template head<2>());
    contents.include(link.to.template head<2>());
  }
  const std::vector<CellNumber> images = images_over(cell, contents, region);
  for (const Link<D>& link : links) {
    for (const auto& [kx, ky] : images) {
      const Vec<D> shift = in_dimensions<D>(cell.shift(kx, ky));
      const double share = share_inside<D>(link.from + shift, link.to + shift, window);
      if (share > 0) stress.contact += share * (link.tensor() + link.lever);
    }
  }
  std::vector<Body<D>> inside;
  const std::vector<Centre<D>> bodies = centres(state, step, moments);
  contents = {};
  for (const Centre<D>& centre : bodies) contents.include(centre.body.x.template head<2>());
  for (const auto& [kx, ky] : images_over(cell, contents, region)) {
    for (const Centre<D>& centre : bodies) {
      Body<D> body = centre.body;
      body.x += in_dimensions<D>(cell.shift(kx, ky));
      if (!window.contains(body.x)) continue;
      body.v += in_dimensions<D>(cell.shift_velocity(kx, ky));
      inside.push_back(body);
      stress.spin += spin_part(centre.moment, step);
    }
  }
  const Vec<D> mean = mean_velocity<D>(inside);
  for (const Body<D>& d : inside) stress.kinetic += kinetic_part(d, mean);
  divide(stress, window.size().prod());
  return stress;
}

template <int D>
std::vector<MeanStress<D>> disk_stresses(const State<D>& state, double step,
                                         std::span<const std::type_identity_t<Spin<D>>> moments) {
  std::vector<MeanStress<D>> stresses(state.bodies.size());
  for (const Link<D>& link : collect_links(state, step)) {
    const Mat<D> tensor = link.tensor();
    stresses[static_cast<std::size_t>(link.i)].contact += link.share_i * tensor;
    if (link.j >= 0) {
      stresses[static_cast<std::size_t>(link.j)].contact += (1 - link.share_i) * tensor;
    }
  }
  const std::vector<Body<D>> bodies = relative_bodies(state);
  const Vec<D> mean = mean_velocity<D>(bodies);
  for (std::size_t k = 0; k < stresses.size(); ++k) {
    stresses[k].kinetic = kinetic_part(bodies[k], mean);
    stresses[k].spin = spin_part(moments[k], step);
  }
  if (!state.clusters.empty()) gather_clusters(state, step, bodies, mean, stresses);
  for (std::size_t k = 0; k < stresses.size(); ++k) {
    const Body<D>& d = state.bodies[k];
    if (d.cluster < 0) divide(stresses[k], extent(d));
  }
  return stresses;
}

template <int D>
Mat<D> fabric_tensor(const State<D>& state) {
  Mat<D> sum = Mat<D>::Zero();
  int loaded = 0;
  for (const ContactOutcome<D>& o : state.contacts) {
    if (!o.loaded()) continue;
    sum += o.contact.n * o.contact.n.transpose();
    ++loaded;
  }
  return loaded > 0 ? Mat<D>(sum / loaded) : sum;
}

double anisotropy(const Mat2& tensor) {
  const double trace = tensor.trace();
  if (trace == 0) return kNaN;
  const double shear = tensor(0, 1) + tensor(1, 0);
  return std::hypot(tensor(0, 0) - tensor(1, 1), shear) / std::abs(trace);
}

double asymmetry(const Mat2& tensor) {
  const double trace = tensor.trace();
  return trace == 0 ? kNaN : std::abs(tensor(0, 1) - tensor(1, 0)) / std::abs(trace);
}

template std::vector<double> contact_moments(const State<2>&);
template std::vector<double> spin_changes(const State<2>&, const State<2>&);
template MeanStress<2> sample_stress<2>(const State<2>&, double, double, std::span<const double>);
template std::vector<MeanStress<2>> disk_stresses<2>(const State<2>&, double,
                                                     std::span<const double>);
template MeanStress<2> window_stress<2>(const State<2>&, double, const Box<2>&,
                                        std::span<const double>);
template MeanStress<3> window_stress<3>(const State<3>&, double, const Box<3>&,
                                        std::span<const Vec3>);
template Mat2 fabric_tensor(const State<2>&);
template std::vector<Vec3> contact_moments(const State<3>&);
template std::vector<Vec3> spin_changes(const State<3>&, const State<3>&);
template MeanStress<3> sample_stress<3>(const State<3>&, double, double, std::span<const Vec3>);
template std::vector<MeanStress<3>> disk_stresses<3>(const State<3>&, double,
                                                     std::span<const Vec3>);
template Mat<3> fabric_tensor(const State<3>&);

}  // namespace bipot
