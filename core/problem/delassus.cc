#include "core/problem/delassus.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/base/parallel.h"
#include "core/linear/sparse_factor.h"
#include "core/problem/equality_rows.h"
#include "core/problem/packed_motion.h"

namespace bipot {
namespace {

/// A contact and its row of H in a degree of freedom.
template <int D>
struct ContactRow {
  int contact = 0;
  double h[to_size(D)] = {};
};

template <int D>
SparseRows assemble_diagonal(const SparseMatrix& A, const SparseMatrix& H) {
  const int rows = static_cast<int>(H.cols());
  const int contacts = rows / D;
  const Vector inverse_mass = A.diagonal().cwiseInverse();
  const ContactWrenches by_contact(H, D);
  const auto by_dof = make_lists<ContactRow<D>>(static_cast<int>(H.rows()), [&](const auto& put) {
    for (int c = 0; c < contacts; ++c) {
      for (int k = by_contact.begin(c); k < by_contact.end(c); ++k) {
        ContactRow<D> row{.contact = c};
        std::copy_n(by_contact.row(k), D, row.h);
        put(by_contact.dof(k), row);
      }
    }
  });

  // First pass: the contacts coupled to each contact through a shared degree of freedom.
  std::vector<int> neighbour_start{0}, neighbours;
  neighbour_start.reserve(to_size(contacts) + 1);
  neighbours.reserve(to_size(contacts) * 11);
  std::vector<int> last_seen(to_size(contacts), -1);
  for (int c = 0; c < contacts; ++c) {
    const std::size_t first = neighbours.size();
    for (int k = by_contact.begin(c); k < by_contact.end(c); ++k) {
      for (const auto& other : by_dof.of(by_contact.dof(k))) {
        int& seen = last_seen[to_size(other.contact)];
        if (seen == c) continue;
        seen = c;
        neighbours.push_back(other.contact);
      }
    }
    std::sort(neighbours.begin() + static_cast<std::ptrdiff_t>(first), neighbours.end());
    neighbour_start.push_back(static_cast<int>(neighbours.size()));
  }

  // Second pass: values, straight into the compressed rows.
  SparseRows W(rows, rows);
  W.resizeNonZeros(static_cast<Eigen::Index>(neighbours.size()) * D * D);
  std::vector<int> slot(to_size(contacts), 0);
  for (int c = 0; c < contacts; ++c) {
    const int first = neighbour_start[to_size(c)];
    const int count = neighbour_start[to_size(c) + 1] - first;
    const int* neighbour = neighbours.data() + first;
    const int row_start = first * D * D;
    const int row_length = count * D;
    for (int k = 0; k < count; ++k) slot[to_size(neighbour[k])] = k;
    int* column = W.innerIndexPtr() + row_start;
    double* value = W.valuePtr() + row_start;
    for (int a = 0; a < D; ++a) {
      W.outerIndexPtr()[c * D + a] = row_start + a * row_length;
      for (int k = 0; k < count; ++k) {
        for (int b = 0; b < D; ++b) column[a * row_length + k * D + b] = neighbour[k] * D + b;
      }
    }
    std::fill(value, value + D * row_length, 0.0);
    for (int k = by_contact.begin(c); k < by_contact.end(c); ++k) {
      const double* const mine = by_contact.row(k);
      const double weight = inverse_mass[by_contact.dof(k)];
      for (const auto& other : by_dof.of(by_contact.dof(k))) {
        double* block = value + slot[to_size(other.contact)] * D;
        for (int a = 0; a < D; ++a) {
          for (int b = 0; b < D; ++b) block[a * row_length + b] += mine[a] * other.h[b] * weight;
        }
      }
    }
  }
  W.outerIndexPtr()[rows] = static_cast<int>(neighbours.size()) * D * D;
  return W;
}

/// For a robot's joints, say: sparse algebra would cost more than the solve.
SparseRows assemble_few(const SparseMatrix& A, const SparseMatrix& H) {
  const Eigen::LLT<Eigen::MatrixXd> factor{Eigen::MatrixXd(A)};
  const Eigen::MatrixXd half = factor.matrixL().solve(Eigen::MatrixXd(H));
  if (factor.info() != Eigen::Success || !half.allFinite()) {
    throw std::runtime_error("the mass matrix A is not positive definite");
  }
  const Eigen::MatrixXd W = half.transpose() * half;
  return SparseRows((0.5 * (W + W.transpose())).sparseView());
}

SparseRows assemble_general(const SparseMatrix& A, const SparseMatrix& H) {
  if (A.rows() <= 64 && H.cols() <= 256) return assemble_few(A, H);
  SparseCholesky factor;
  if (!factor.factor(A)) throw std::runtime_error("the mass matrix A is not positive definite");
  const SparseMatrix velocity = factor.solve(H);
  const SparseMatrix W = SparseMatrix(H.transpose()) * velocity;
  const SparseMatrix transposed = W.transpose();
  return SparseRows(0.5 * (W + transposed));  // symmetric up to the rounding of the solves
}

}  // namespace

SparseRows assemble_delassus(const SparseMatrix& A, const SparseMatrix& H, int dim) {
  if (!is_diagonal(A)) return assemble_general(A, H);
  return dispatch_count(dim, [&](auto d) { return assemble_diagonal<d()>(A, H); });
}

template <int D>
void DelassusOperator::Prepared::list_sides() {
  const auto& packed = *bodies<D>();
  sides = make_lists(static_cast<int>(packed.bodies.size()), [&](const auto& put) {
    int side = 0;
    for (const auto& c : packed.contacts) {
      put(c.i, side++);
      put(c.j, side++);
    }
  });
}

DelassusOperator::DelassusOperator(const ContactProblem& problem, Form form, int threads)
    : problem_(problem), threads_(threads) {
  const bool can_two_pass = problem.has_velocities() && is_diagonal(problem.A);
  two_pass_ = can_two_pass && form != Form::kExplicit;
  if (form == Form::kTwoPass && !can_two_pass) {
    throw std::invalid_argument("the two-pass form needs H and a diagonal A");
  }
  const auto made = std::make_shared<Prepared>();
  prepared_ = made;
  delassus_ = &problem.W;
  if (two_pass_) {
    made->inverse_mass = problem.A.diagonal().cwiseInverse();
    made->disks = disk_structure(problem);
    made->spheres = sphere_structure(problem);
    if (is_packed() && threads_ > 1) {
      dispatch_dim(problem.dim, [&](auto d) { made->list_sides<d()>(); });
    }
    if (!is_packed()) made->wrenches.emplace(problem.H, problem.dim);
    scratch();
  } else if (!problem.has_delassus() && problem.has_velocities()) {
    made->delassus = assemble_delassus(problem.A, problem.H, problem.dim);
    delassus_ = &made->delassus;
  }
  if (!two_pass_) made->blocks = std::make_shared<DelassusBlocks>(*delassus_, problem.dim);
}

Vector& DelassusOperator::scratch() const {
  if (velocity_.size() == 0 && two_pass_) {
    Eigen::Index size = problem_.num_dofs();
    if (disks()) size = 4 * static_cast<Eigen::Index>(disks()->bodies.size());
    if (const auto& spheres = prepared_->spheres) {
      size = 8 * static_cast<Eigen::Index>(spheres->bodies.size());
    }
    velocity_ = large_vector(size);
  }
  return velocity_;
}

/// Momenta of the bodies, contact by contact.
template <int D>
void DelassusOperator::add_impulses(const double* s) const {
  double* const v = scratch().data();
  velocity_.setZero();
  for (const auto& c : prepared_->bodies<D>()->contacts) {
    const Push<D> p = push<D>(c, s);
    p.add(1, 1, v + BodyPlace<D>::kSize * c.i);
    p.add(-1, 1, v + BodyPlace<D>::kSize * c.j);
    s += D;
  }
}

/// The same sums, body by body.
template <int D>
void DelassusOperator::add_impulses_by_body(const double* s) const {
  constexpr int kSize = BodyPlace<D>::kSize;
  const Prepared& made = *prepared_;
  const auto& bodies = *made.bodies<D>();
  scratch();
  run_pieces(threads_, bodies.surroundings(), [&](int begin, int end) {
    for (int body = begin; body < end; ++body) {
      double sum[to_size(kSize)] = {};
      for (const int side : made.sides.of(body)) {
        const int c = side / 2;
        const Push<D> p = push<D>(bodies.contacts[to_size(c)], s + D * c);
        p.add(side % 2 == 0 ? 1 : -1, 1, sum);
      }
      std::copy_n(sum, kSize, velocity_.data() + kSize * body);
    }
  });
  velocity_.tail<kSize>().setZero();  // entry for the surroundings: its value does not matter
}

template <int D>
void DelassusOperator::move_bodies(const double* s) const {
  if (prepared_->sides.items.empty()) {
    add_impulses<D>(s);
  } else {
    add_impulses_by_body<D>(s);
  }
  using Place = BodyPlace<D>;
  const auto& bodies = prepared_->bodies<D>()->bodies;
  run_pieces(threads_, static_cast<int>(bodies.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const auto& body = bodies[to_size(k)];
      double* const v = velocity_.data() + Place::kSize * k;
      for (int x = 0; x < Place::kForces; ++x) v[x] *= body.inverse_mass;
      for (int x = 0; x < Place::kTorques; ++x) v[Place::kSpin + x] *= body.inverse_inertia;
    }
  });
}

/// u of the contacts [begin, end), plus `u_free` unless it is null.
template <int D>
void DelassusOperator::contact_velocity(int begin, int end, const double* u_free, double* u) const {
  const double* const v = velocity_.data();
  for (int k = begin; k < end; ++k) {
    const auto& c = prepared_->bodies<D>()->contacts[to_size(k)];
    relative_velocity<D>(c, v + BodyPlace<D>::kSize * c.i, v + BodyPlace<D>::kSize * c.j,
                         [&](int row, double w) {
                           const int at = D * k + row;
                           u[at] = u_free != nullptr ? w + u_free[at] : w;
                         });
  }
}

void DelassusOperator::move_bodies(const Eigen::Ref<const Vector>& s) const {
  dispatch_dim(problem_.dim, [&](auto d) { move_bodies<d()>(s.data()); });
}

void DelassusOperator::contact_velocity(int begin, int end, Vector& u) const {
  dispatch_dim(problem_.dim, [&](auto d) {
    contact_velocity<d()>(begin, end, problem_.u_free.data(), u.data());
  });
}

void DelassusOperator::apply(const Eigen::Ref<const Vector>& s, Vector& u) const {
  if (is_packed()) {
    u.resize(problem_.num_rows());
    dispatch_dim(problem_.dim, [&](auto d) {
      move_bodies<d()>(s.data());
      run_pieces(threads_, problem_.num_contacts(),
                 [&](int begin, int end) { contact_velocity<d()>(begin, end, nullptr, u.data()); });
    });
  } else if (two_pass_) {
    prepared_->wrenches->momentum(s, scratch());
    velocity_.array() *= prepared_->inverse_mass.array();
    prepared_->wrenches->velocity(velocity_, u);
  } else {
    prepared_->blocks->apply(s, u);
  }
}

void DelassusOperator::velocity(const Eigen::Ref<const Vector>& s, Vector& u) const {
  if (is_packed()) {
    u.resize(problem_.num_rows());
    move_bodies(s);
    run_pieces(threads_, problem_.num_contacts(),
               [&](int begin, int end) { contact_velocity(begin, end, u); });
  } else {
    apply(s, u);
    u += problem_.u_free;
  }
}

double delassus_entry(const SparseMatrix& H, const Vector& inverse_mass, int row, int column) {
  SparseMatrix::InnerIterator x(H, row), y(H, column);
  double sum = 0;
  while (x && y) {
    if (x.row() == y.row()) {
      sum += x.value() * y.value() * inverse_mass[x.row()];
      ++x;
      ++y;
    } else if (x.row() < y.row()) {
      ++x;
    } else {
      ++y;
    }
  }
  return sum;
}

Eigen::MatrixXd DelassusOperator::diagonal_block(int contact) const {
  const int d = problem_.dim;
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(d, d);
  if (two_pass_) {
    for (int a = 0; a < d; ++a) {
      for (int b = 0; b < d; ++b) {
        block(a, b) =
            delassus_entry(problem_.H, prepared_->inverse_mass, contact * d + a, contact * d + b);
      }
    }
  } else {
    for (int a = 0; a < d; ++a) {
      for (SparseRows::InnerIterator it(*delassus_, contact * d + a); it; ++it) {
        const int b = static_cast<int>(it.col()) - contact * d;
        if (b >= 0 && b < d) block(a, b) += it.value();
      }
    }
  }
  return block;
}

Vector DelassusOperator::diagonal() const {
  Vector diagonal = Vector::Zero(problem_.num_rows());
  if (two_pass_) {
    for (int i = 0; i < problem_.num_rows(); ++i) {
      for (SparseMatrix::InnerIterator it(problem_.H, i); it; ++it) {
        diagonal[i] += it.value() * it.value() * prepared_->inverse_mass[it.row()];
      }
    }
  } else {
    for (int i = 0; i < problem_.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(*delassus_, i); it; ++it) {
        if (it.col() == i) diagonal[i] += it.value();
      }
    }
  }
  return diagonal;
}

Vector body_velocities(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  if (p.num_dofs() == 0 && !p.equality) {
    throw std::invalid_argument("body velocities need a problem with A and H");
  }
  Vector v = p.v_free;
  if (const Vector wrench = p.H * s; is_diagonal(p.A)) {
    v += wrench.cwiseQuotient(p.A.diagonal());
  } else {
    SparseCholesky factor;
    if (!factor.factor(p.A)) throw std::runtime_error("the mass matrix A is not positive definite");
    v += factor.solve(wrench);
  }
  return p.equality ? p.equality->velocities(v) : v;
}

}  // namespace bipot
