#include "bench/problems/sphere_problems.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/base/nearest_name.h"
#include "core/scene/contact_detection.h"
#include "core/scene/scene_parts.h"

namespace bipot {
namespace {

constexpr double kRadius = 0.5, kMass = 1, kGravity = 9.81, kStep = 0.01;
constexpr int kDofs = 6;
/// Entries of H in the three columns of a contact: 3 forces and, of tangents, 3 torques a body.
constexpr int kMostEntries = 2 * (3 + 6 + 6);

/// Those that touch, sphere-sphere first for each sphere.
std::vector<Contact<3>> touching(const std::vector<Vec3>& x, const std::vector<Wall<3>>& walls) {
  std::vector<Sphere> spheres;
  for (const Vec3& place : x) spheres.push_back(round_body<3>(place, kRadius, kMass));
  return detect_contacts<3>(spheres, walls, 2e-9 * kRadius);
}

ContactProblem assemble(const std::vector<Vec3>& x, const std::vector<Wall<3>>& walls, double mu,
                        double tilt_degrees) {
  const int spheres = static_cast<int>(x.size()), n = kDofs * spheres;
  const double tilt = tilt_degrees * std::numbers::pi / 180;
  const Vec3 fall = kStep * kGravity * Vec3(std::sin(tilt), 0, -std::cos(tilt));
  const std::vector<Contact<3>> contacts = touching(x, walls);

  ContactProblem p{.dim = 3};
  p.A.resize(n, n);
  p.A.reserve(n);
  p.v_free = Vector::Zero(n);
  for (int k = 0; k < n; ++k) {
    const bool turns = k % kDofs >= 3;
    p.A.startVec(k);
    p.A.insertBack(k, k) = turns ? 0.4 * kMass * kRadius * kRadius : kMass;
    if (!turns) p.v_free[k] = fall[k % kDofs];
  }
  p.A.finalize();
  // Entry after entry: a list of triplets would be the peak of a solve's memory.
  p.H.resize(n, 3 * static_cast<int>(contacts.size()));
  p.H.reserve(static_cast<Eigen::Index>(contacts.size()) * kMostEntries);
  for (int c = 0; c < static_cast<int>(contacts.size()); ++c) {
    const Contact<3>& contact = contacts[to_size(c)];
    const Vec3 helper = std::abs(contact.n[0]) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    const Vec3 t = contact.n.cross(helper).normalized();
    const Vec3 axes[3] = {contact.n, t, contact.n.cross(t)};
    for (int r = 0; r < 3; ++r) {
      // The contact point is at -a n from the centre of i and at +a n from that of j. With velocity
      // v + w x (∓a n), the part of the spin is (∓a n) x axis.
      const Vec3 spin = (kRadius * contact.n).cross(axes[r]);
      p.H.startVec(3 * c + r);
      for (const int body : {std::min(contact.i, contact.j), std::max(contact.i, contact.j)}) {
        if (body >= spheres) continue;
        const double sign = body == contact.i ? 1 : -1;
        for (int k = 0; k < 3; ++k) p.H.insertBack(kDofs * body + k, 3 * c + r) = sign * axes[r][k];
        if (r == 0) continue;
        for (int k = 0; k < 3; ++k) p.H.insertBack(kDofs * body + 3 + k, 3 * c + r) = -spin[k];
      }
    }
  }
  p.H.finalize();
  p.u_free = p.H.transpose() * p.v_free;
  p.mu = Vector::Constant(static_cast<int>(contacts.size()), mu);
  return p;
}

}  // namespace

ContactProblem sphere_pyramid(int layers, double mu, double tilt_degrees) {
  std::vector<Vec3> x;
  for (int k = 0; k < layers; ++k) {
    for (int i = 0; i < layers - k; ++i) {
      for (int j = 0; j < layers - k; ++j) {
        // Centres of a layer are sqrt(2) a above those of the layer below.
        x.emplace_back(kRadius * Vec3(2 * i + k, 2 * j + k, 1 + std::numbers::sqrt2 * k));
      }
    }
  }
  return assemble(x, {flat_floor<3>()}, mu, tilt_degrees);
}

ContactProblem sphere_box(int side, double mu, double tilt_degrees) {
  std::vector<Vec3> x;
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i)
        x.emplace_back(kRadius * Vec3(2 * i + 1, 2 * j + 1, 2 * k + 1));
    }
  }
  const double width = 2 * kRadius * side;
  const auto wall = [](const Vec3& point, const Vec3& normal) {
    return half_space<3>(point, normal);
  };
  const std::vector<Wall<3>> walls = {
      flat_floor<3>(), wall(Vec3::Zero(), Vec3::UnitX()), wall(Vec3::Zero(), Vec3::UnitY()),
      wall(Vec3(width, 0, 0), -Vec3::UnitX()), wall(Vec3(0, width, 0), -Vec3::UnitY())};
  return assemble(x, walls, mu, tilt_degrees);
}

ContactProblem sphere_family(const std::string& name, int side, double mu, double tilt_degrees) {
  if (name == "cannonballs") return sphere_pyramid(side, mu, tilt_degrees);
  if (name == "cubic") return sphere_box(side, mu, tilt_degrees);
  throw std::invalid_argument(unknown_name_message("family", name, sphere_family_names()));
}

std::vector<std::string> sphere_family_names() { return {"cannonballs", "cubic"}; }

double spheres_in(const std::string& family, int side) {
  const double n = side;
  return family == "cubic" ? n * n * n : n * (n + 1) * (2 * n + 1) / 6;
}

}  // namespace bipot
