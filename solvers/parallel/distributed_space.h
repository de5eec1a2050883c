#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/criterion/error_terms.h"
#include "core/problem/delassus.h"
#include "solvers/contact_space.h"
#include "solvers/kernels/gradient_kernel.h"
#include "solvers/parallel/exact_sum.h"
#include "solvers/parallel/problem_piece.h"

namespace bipot {

class WholeProblem;  // solvers/parallel/whole_problem.h

/// Rows from which the systems of solvers on the root process are factored in parallel; below, one
/// process is faster (data/manual/explanation/parallel.md).
inline constexpr int kSharedFactorRows = 20000;

/// The space of a distributed problem: vectors have the rows of this process's contacts
/// (ProblemPiece::own). The criterion is that of core/criterion/contact_error.h: the same terms of
/// the same contacts, summed over all processes in one reduction.
///
/// The product has the bits of one process, as each body sums all its contacts in the order of the
/// whole. Excepted are degrees of freedom that are on every process, whose momentum is one more
/// reduction. Sums are taken by process. With `exact`, all of them are ExactSums: then every number
/// has the same bits for any number of processes.
class DistributedSpace final : public ContactSpace {
 public:
  /// Keeps references, also to the group. `whole`: access to the whole problem; null: it is
  /// gathered on the root process when needed.
  DistributedSpace(const ProblemPiece& piece, ProcessGroup& group, bool exact,
                   WholeProblem* whole = nullptr, int shared_factor_rows = kSharedFactorRows);
  DistributedSpace(ProblemPiece&&, ProcessGroup&, bool) = delete;  // would dangle
  ~DistributedSpace() override;

  const ContactProblem& problem() const override { return piece_.own; }
  int whole_contacts() const override { return piece_.whole_contacts; }
  const std::vector<int>* numbers() const override { return &piece_.number; }
  DistributedSpace* parts() override { return this; }
  const ProblemPiece& piece() const { return piece_; }
  ProcessGroup& group() const { return group_; }
  bool exact() const override { return exact_; }
  Vector diagonal() const override { return diagonal_; }

  void apply(const Vector& s, Vector& u) override;
  void velocity(const Vector& s, Vector& u) override;
  /// With degrees of freedom on every process, their part is bounded by the sum of the absolute
  /// values of its terms.
  double norm_bound(const Vector& scale) override;

  ContactError error(const Eigen::Ref<const Vector>& s, std::span<double> more = {}) override;
  void find_worst(ContactError& error) override;
  const Vector& impulse() const override { return s_; }
  const Vector& impulse_velocity() const override { return u_; }
  double energy_at_rest() override;
  ProvedClaim prove(const SolverOptions& options, const Eigen::Ref<const Vector>& s,
                    const ContactError& error) override;
  SolveResult solve_on_root(const SolverEntry& entry, const SolverOptions& options) override;
  /// s of the contacts of the halo, in the order of piece().halo.
  const std::vector<double>& halo(const Vector& s);
  /// True if the contacts of all processes are those of disks.
  bool disks() const { return all_packed_ && piece_.own.dim < 3; }
  /// piece().with_halo as disks. Requires disks(), and a contact here.
  const DiskStructure& halo_disks() const { return *packed_->disks(); }
  /// The values of the owned contacts and of the halo, in the rows of piece().with_halo.
  void with_halo(const Vector& s, Vector& all);
  /// H s in the degrees of freedom that every process has, of all contacts.
  const std::vector<double>& everywhere_momentum(const Vector& s);

  void sum(std::span<double> values) override { group_.sum(values); }
  void largest(std::span<double> values) override { group_.largest(values); }
  double dot(const Vector& a, const Vector& b) override;
  double norm(const Vector& a) override { return std::sqrt(dot(a, a)); }
  Vector products(const Eigen::MatrixXd& columns, int size, const Vector& f) override;
  /// All of them in one reduction.
  void totals(std::span<ExactSum> sums, std::span<double> values);

  template <class A, class B>
  static void add_products(const A& a, const B& b, ExactSum& sum) {
    for (Eigen::Index i = 0; i < a.size(); ++i) sum += a.coeff(i) * b.coeff(i);
  }

 private:
  struct Worst {
    double violation = -1, natural = -1;
    int epsilon = -1, eta = -1;
  };
  void fill(const Vector& s);
  void product();
  WholeProblem& whole_problem();
  ErrorSums local_sums(ExactSum* exact);
  int number_of_largest(double value, int contact);

  const ProblemPiece& piece_;
  ProcessGroup& group_;
  bool exact_;
  std::unique_ptr<ProcessGroup::Exchange> exchange_;
  std::optional<DelassusOperator> packed_;  // where the whole problem is one of disks or spheres
  bool all_packed_ = false;
  Vector inverse_mass_, velocity_;  // of with_halo
  Vector diagonal_;
  bool any_everywhere_ = false;
  std::vector<double> momentum_, halo_;
  std::vector<std::int64_t> digits_;
  Vector s_all_, u_all_;

  WholeProblem* given_whole_;
  std::unique_ptr<WholeProblem> gathered_;  // on request
  int shared_factor_rows_;
  ErrorWeights weights_;
  double energy_at_rest_ = kNaN;
  Worst worst_;   // of the last error()
  Vector s_, u_;  // the same
};

/// The sums of a projected gradient (solvers/kernels/gradient_iteration.h), exact: one reduction of
/// three long accumulators.
struct ExactSums {
  DistributedSpace& space;

  using Sum = ExactSum;
  void velocity(const Vector& s, Vector& u) { space.velocity(s, u); }
  template <class A, class B>
  void add_dot(const A& a, const B& b, Sum& sum) const {
    DistributedSpace::add_products(a, b, sum);
  }
  GradientKernel::Progress total(const Sum& turn, const Sum& change2, const Sum& energy) {
    ExactSum sums[3] = {turn, change2, energy};
    double values[3];
    space.totals(sums, values);
    return {values[0], values[1], values[2]};
  }
};

}  // namespace bipot
