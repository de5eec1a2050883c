#include "tests/support/lattice_problem.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/triplets.h"

namespace bipot {
namespace {

using Vec3 = Eigen::Vector3d;

/// Collects contacts of equal disks and writes the problem of data/manual/explanation/method.md §1.
class Builder {
 public:
  Builder(int dim, const LatticeOptions& options) : o_(options) {
    p_.dim = dim;
    dofs_ = dim == 1 ? 2 : (dim == 2 ? 3 : 6);
  }

  /// Contact of body i with body j (j < 0: a fixed wall), n points from j to i.
  void touch(int i, int j, Vec3 n) {
    if (p_.dim < 3) {
      const double c = std::cos(o_.turn), s = std::sin(o_.turn);
      n = Vec3(c * n[0] - s * n[1], s * n[0] + c * n[1], 0);
    }
    const int column = contacts_++ * p_.dim;
    const Vec3 e3(0, 0, 1);
    Vec3 directions[3] = {n, e3.cross(n), Vec3::Zero()};
    if (p_.dim == 3) {
      directions[1] = n.cross(std::abs(n[2]) < 0.5 ? e3 : Vec3(1, 0, 0)).normalized();
      directions[2] = n.cross(directions[1]);
    }
    for (int a = 0; a < p_.dim; ++a) {
      const Vec3 arm = -o_.radius * n.cross(directions[a]);
      const double scale = 1 / std::sqrt(1 + (a == 0 ? o_.e_n : o_.e_t));
      for (int side = 0; side < 2; ++side) {
        const int body = side == 0 ? i : j;
        if (body < 0) continue;
        for (int k = 0; k < (p_.dim == 3 ? 3 : 2); ++k) {
          add(body * dofs_ + k, column + a, (side == 0 ? scale : -scale) * directions[a][k]);
        }
        if (a == 0) continue;
        if (p_.dim == 2) add(body * dofs_ + 2, column + a, scale * arm[2]);
        for (int k = 0; k < 3 && p_.dim == 3; ++k) {
          add(body * dofs_ + 3 + k, column + a, scale * arm[k]);
        }
      }
    }
  }

  ContactProblem finish(int bodies) {
    const int n = bodies * dofs_, m = contacts_ * p_.dim;
    const int translations = p_.dim == 3 ? 3 : 2;
    const double inertia = (p_.dim == 3 ? 0.4 : 0.5) * o_.mass * o_.radius * o_.radius;
    const double angle = o_.tilt + (p_.dim == 3 ? 0 : o_.turn);
    const double dv = o_.gravity * o_.time_step;
    Vec3 fall = p_.dim == 3 ? Vec3(dv * std::sin(angle), 0, -dv * std::cos(angle))
                            : Vec3(dv * std::sin(angle), -dv * std::cos(angle), 0);
    Vector mass(n);
    p_.v_free = Vector::Zero(n);
    for (int k = 0; k < n; ++k) {
      const bool translation = k % dofs_ < translations;
      mass[k] = translation ? o_.mass : inertia;
      if (translation) p_.v_free[k] = fall[k % dofs_];
    }
    p_.A = mass.asDiagonal();
    p_.H = from_triplets(n, m, entries_);
    p_.u_free = p_.H.transpose() * p_.v_free;
    p_.mu = Vector::Constant(contacts_, p_.dim == 1 ? 0 : o_.mu);
    if (o_.e_n != 0 || o_.e_t != 0) {
      p_.row_scale.resize(m);
      for (int row = 0; row < m; ++row) {
        p_.row_scale[row] = std::sqrt(1 + (row % p_.dim == 0 ? o_.e_n : o_.e_t));
      }
      if (p_.dim > 1) p_.mu *= p_.row_scale[1] / p_.row_scale[0];
    }
    return std::move(p_);
  }

 private:
  void add(int row, int column, double value) {
    if (value != 0) entries_.emplace_back(row, column, value);
  }

  const LatticeOptions& o_;
  ContactProblem p_;
  int dofs_ = 3, contacts_ = 0;
  Triplets entries_;
};

const double kHalf = 0.5, kRoot3Half = std::sqrt(3.0) / 2;

}  // namespace

ContactProblem square_lattice(int n, const LatticeOptions& options) {
  Builder b(options.dim, options);
  for (int row = 0; row < n; ++row) {
    for (int k = 0; k < n; ++k) {
      const int i = row * n + k;
      if (k == 0) b.touch(i, -1, Vec3(1, 0, 0));
      if (row == 0) b.touch(i, -1, Vec3(0, 1, 0));
      b.touch(i, k + 1 < n ? i + 1 : -1, Vec3(-1, 0, 0));
      if (row + 1 < n) b.touch(i, i + n, Vec3(0, -1, 0));
    }
  }
  return b.finish(n * n);
}

ContactProblem triangular_lattice(int n, const LatticeOptions& options) {
  Builder b(options.dim, options);
  int first = 0;
  for (int row = 0; row < n; ++row) {
    const bool is_long = row % 2 == 0;
    const int size = is_long ? n : n - 1;
    for (int k = 0; k < size; ++k) {
      const int i = first + k;
      if (is_long && k == 0) b.touch(i, -1, Vec3(1, 0, 0));
      if (row == 0) b.touch(i, -1, Vec3(0, 1, 0));
      if (k + 1 < size) b.touch(i, i + 1, Vec3(-1, 0, 0));
      if (is_long && k + 1 == size) b.touch(i, -1, Vec3(-1, 0, 0));
      if (row + 1 == n) continue;
      // The row above is shifted by one radius: to the right of a long row's first disk, to the
      // left of a short row's.
      const int left = first + size + (is_long ? k - 1 : k);
      if (!is_long || k > 0) b.touch(i, left, Vec3(kHalf, -kRoot3Half, 0));
      if (!is_long || k + 1 < size) b.touch(i, left + 1, Vec3(-kHalf, -kRoot3Half, 0));
    }
    first += size;
  }
  return b.finish(first);
}

ContactProblem pyramid(int n, const LatticeOptions& options) {
  Builder b(options.dim, options);
  int first = 0;
  for (int size = n; size > 0; --size) {
    for (int k = 0; k < size; ++k) {
      const int i = first + k;
      if (size == n) b.touch(i, -1, Vec3(0, 1, 0));
      if (k + 1 < size) b.touch(i, i + 1, Vec3(-1, 0, 0));
      if (k > 0) b.touch(i, first + size + k - 1, Vec3(kHalf, -kRoot3Half, 0));
      if (k + 1 < size) b.touch(i, first + size + k, Vec3(-kHalf, -kRoot3Half, 0));
    }
    first += size;
  }
  return b.finish(first);
}

ContactProblem cubic_lattice(int n, const LatticeOptions& options) {
  Builder b(3, options);
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const int i = (z * n + y) * n + x;
        if (x == 0) b.touch(i, -1, Vec3(1, 0, 0));
        b.touch(i, x + 1 < n ? i + 1 : -1, Vec3(-1, 0, 0));
        if (y == 0) b.touch(i, -1, Vec3(0, 1, 0));
        b.touch(i, y + 1 < n ? i + n : -1, Vec3(0, -1, 0));
        if (z == 0) b.touch(i, -1, Vec3(0, 0, 1));
        if (z + 1 < n) b.touch(i, i + n * n, Vec3(0, 0, -1));
      }
    }
  }
  return b.finish(n * n * n);
}

ContactProblem with_driven_wall(const ContactProblem& lattice, const Vector& normal, double mass,
                                double speed) {
  ContactProblem p = lattice;
  const int wall = p.num_dofs(), dofs = p.dim == 1 ? 2 : (p.dim == 2 ? 3 : 6);
  p.A.conservativeResize(wall + 1, wall + 1);
  p.A.insert(wall, wall) = mass;
  p.A.makeCompressed();
  p.H.conservativeResize(wall + 1, p.H.cols());
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Vector column = p.H.col(c * p.dim);
    double length2 = 0, along = 0;
    for (int body = 0; body < wall / dofs; ++body) {
      const auto force = column.segment(body * dofs, normal.size());
      length2 += force.squaredNorm();
      along += force.dot(normal);
    }
    const double length = std::sqrt(length2);
    // Normals of two bodies add up to zero.
    if (std::abs(along - length) > 1e-9 * length) continue;
    p.H.insert(wall, c * p.dim) = -length;
    p.u_free[c * p.dim] -= length * speed;
  }
  p.H.makeCompressed();
  p.v_free.conservativeResize(wall + 1);
  p.v_free[wall] = speed;
  return p;
}

}  // namespace bipot
