#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/parallel/exact_sum.h"
#include "solvers/parallel/problem_piece.h"

namespace bipot {

/// Products with W and sums over all contacts of a problem that lies on several processes. Vectors
/// have the rows of this process's contacts (ProblemPiece::own). Everything is collective.
///
/// The product has the bits of one process, as each body adds up all its contacts in the order of the
/// whole; but where degrees of freedom stand on every process, whose momentum is one more reduction.
/// Sums are taken by process. With `exact`, all of them are ExactSums: then every number has the same
/// bits for any number of processes.
class DistributedSpace {
 public:
  /// Keeps references, also to the group.
  DistributedSpace(const ProblemPiece& piece, ProcessGroup& group, bool exact);
  DistributedSpace(ProblemPiece&&, ProcessGroup&, bool) = delete;  // would dangle

  const ContactProblem& problem() const { return piece_.own; }
  const ProblemPiece& piece() const { return piece_; }
  ProcessGroup& group() const { return group_; }
  bool exact() const { return exact_; }
  /// Diagonal of W in the rows that are here.
  const Vector& diagonal() const { return diagonal_; }

  /// u = W s.
  void apply(const Vector& s, Vector& u);
  /// u = W s + u_free.
  void velocity(const Vector& s, Vector& u);
  /// s of the contacts of the halo, in the order of piece().halo.
  const std::vector<double>& halo(const Vector& s);
  /// Whether the contacts of all processes are those of disks.
  bool disks() const { return all_disks_; }
  /// piece().with_halo as disks. Requires disks(), and a contact here.
  const DiskStructure& halo_disks() const { return *disks_->disks(); }
  /// The values of the owned contacts and of the halo, in the rows of piece().with_halo.
  void with_halo(const Vector& s, Vector& all);
  /// v = v_free + A⁻¹ H s in the degrees of freedom of piece().own.
  void body_velocities(const Vector& s, Vector& v);

  /// H s in the degrees of freedom that every process has, of all contacts.
  const std::vector<double>& everywhere_momentum(const Vector& s);

  /// Sums over all processes of what each has.
  void sum(std::span<double> values) { group_.sum(values); }
  template <class A, class B>
  double dot(const A& a, const B& b) {
    if (exact_) {
      ExactSum sum;
      add_products(a, b, sum);
      return total(sum);
    }
    double value = a.dot(b);
    group_.sum({&value, 1});
    return value;
  }
  template <class A>
  double norm(const A& a) {
    return std::sqrt(dot(a, a));
  }
  double total(ExactSum& sum);
  /// All of them in one reduction.
  void totals(std::span<ExactSum> sums, std::span<double> values);

  template <class A, class B>
  static void add_products(const A& a, const B& b, ExactSum& sum) {
    for (Eigen::Index i = 0; i < a.size(); ++i) sum += a.coeff(i) * b.coeff(i);
  }

 private:
  void fill(const Vector& s);
  void product();

  const ProblemPiece& piece_;
  ProcessGroup& group_;
  bool exact_;
  std::unique_ptr<Exchange> exchange_;
  std::optional<DelassusOperator> disks_;  // where the whole problem is one of disks
  bool all_disks_ = false;
  Vector inverse_mass_, velocity_;  // of with_halo
  Vector diagonal_;
  bool any_everywhere_ = false;
  std::vector<double> momentum_, halo_;
  std::vector<std::int64_t> digits_;
  Vector s_all_, u_all_;
};

/// The sums of a projected gradient: doubles, taken by process.
struct FastSums {
  DistributedSpace& space;

  using Sum = double;
  void velocity(const Vector& s, Vector& u) { space.velocity(s, u); }
  template <class A, class B>
  void add_dot(const A& a, const B& b, Sum& sum) const {
    sum += a.dot(b);
  }
  GradientProgress total(Sum turn, Sum change2, Sum energy) {
    double values[3] = {turn, change2, energy};
    space.sum(values);
    return {values[0], values[1], values[2]};
  }
};

/// The same, exact: one reduction of three long accumulators.
struct ExactSums {
  DistributedSpace& space;

  using Sum = ExactSum;
  void velocity(const Vector& s, Vector& u) { space.velocity(s, u); }
  template <class A, class B>
  void add_dot(const A& a, const B& b, Sum& sum) const {
    DistributedSpace::add_products(a, b, sum);
  }
  GradientProgress total(const Sum& turn, const Sum& change2, const Sum& energy) {
    ExactSum sums[3] = {turn, change2, energy};
    double values[3];
    space.totals(sums, values);
    return {values[0], values[1], values[2]};
  }
};

}  // namespace bipot
