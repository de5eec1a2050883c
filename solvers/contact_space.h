#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/criterion/contact_error.h"
#include "core/problem/delassus.h"
#include "solvers/proved_claim.h"
#include "solvers/solver.h"

namespace bipot {

class DistributedSpace;  // solvers/parallel/distributed_space.h
class WholeSpace;

/// A failure that every process knows of and throws at the same place, so that no process waits.
/// Any other exception of one process must end them all (solvers/parallel/petsc_group.h).
class CommonFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The space of a problem's impulses and velocities: products with W, sums over all contacts, and
/// the criterion. Vectors have the rows of problem(): all of them on one process (WholeSpace), or
/// those of this process's contacts (DistributedSpace). Functions that are not const are
/// collective: every process calls them, in the same order. One caller at a time.
class ContactSpace {
 public:
  virtual ~ContactSpace() = default;
  ContactSpace(const ContactSpace&) = delete;
  ContactSpace& operator=(const ContactSpace&) = delete;

  /// The contacts of this process.
  virtual const ContactProblem& problem() const = 0;
  /// Number of contacts of all processes.
  virtual int whole_contacts() const = 0;
  /// Numbers in the whole of the contacts of this process, ascending; null: all are here.
  virtual const std::vector<int>* numbers() const { return nullptr; }
  /// This space if one process has the whole, else null; and in parallel.
  virtual WholeSpace* whole() { return nullptr; }
  virtual DistributedSpace* parts() { return nullptr; }

  /// Diagonal of W, in the rows of this process.
  virtual Vector diagonal() const = 0;
  /// u = W s.
  virtual void apply(const Vector& s, Vector& u) = 0;
  /// u = W s + u_free.
  virtual void velocity(const Vector& s, Vector& u) = 0;
  /// ‖diag(scale) W diag(scale)‖_inf, an upper bound of the largest eigenvalue. Assembles W if the
  /// problem has none: the cheaper bound from |H| would depend on the orientation of the scene.
  virtual double norm_bound(const Vector& scale) = 0;

  virtual double dot(const Vector& a, const Vector& b) = 0;
  virtual double norm(const Vector& a) = 0;
  /// Products of the first `size` columns with f.
  virtual Vector products(const Eigen::MatrixXd& columns, int size, const Vector& f) = 0;
  /// Sums, and largest values, over all processes.
  virtual void sum(std::span<double> values) = 0;
  virtual void largest(std::span<double> values) = 0;
  /// True if `mine` is true on any process.
  bool any(bool mine) {
    double value = mine ? 1 : 0;
    largest({&value, 1});
    return value > 0;
  }
  /// True if all sums are exact, with the same bits for any number of processes.
  virtual bool exact() const { return false; }

  /// The criterion of the whole: projects s, computes its velocity, judges. `more`: numbers of each
  /// process that are summed in the same reduction. The worst contacts may be unknown (-1).
  virtual ContactError error(const Eigen::Ref<const Vector>& s, std::span<double> more = {}) = 0;
  /// Finds the worst contacts of the last error().
  virtual void find_worst(ContactError&) {}
  /// Projected impulse and its velocity of the last error().
  virtual const Vector& impulse() const = 0;
  virtual const Vector& impulse_velocity() const = 0;
  /// The criterion's energy for s = 0.
  virtual double energy_at_rest() = 0;
  /// Releases the scratch memory of error(), until the next call.
  virtual void release_scratch() {}
  /// prove_claim() of the impulse s: the same result on all processes.
  virtual ProvedClaim prove(const SolverOptions& options, const Eigen::Ref<const Vector>& s,
                            const ContactError& error) = 0;
  /// In parallel: solve() on the root process, with the whole problem.
  virtual SolveResult solve_on_root(const SolverEntry&, const SolverOptions&) { return {}; }

 protected:
  ContactSpace() = default;
};

/// A problem on one process. Keeps a reference to it. Data made once from the problem are shared by
/// all spaces made from one another: the operator, the criterion's weights and the last proved
/// claim.
class WholeSpace final : public ContactSpace {
 public:
  explicit WholeSpace(const ContactProblem& problem, int threads = 1, const ErrorShare& share = {});
  explicit WholeSpace(ContactProblem&&, int = 1, const ErrorShare& = {}) = delete;  // would dangle
  /// Another space for the problem of `made`, for another caller, which judges with a share of its
  /// own.
  WholeSpace(const WholeSpace& made, const ErrorShare& share);

  const ContactProblem& problem() const override { return problem_; }
  int whole_contacts() const override { return problem_.num_contacts(); }
  WholeSpace* whole() override { return this; }
  const DelassusOperator& delassus() const { return evaluator_.delassus(); }
  ContactErrorEvaluator& evaluator() { return evaluator_; }
  const ErrorShare& share() const { return share_; }

  Vector diagonal() const override { return delassus().diagonal(); }
  void apply(const Vector& s, Vector& u) override { delassus().apply(s, u); }
  void velocity(const Vector& s, Vector& u) override { delassus().velocity(s, u); }
  double norm_bound(const Vector& scale) override;

  double dot(const Vector& a, const Vector& b) override { return a.dot(b); }
  double norm(const Vector& a) override { return a.norm(); }
  Vector products(const Eigen::MatrixXd& columns, int size, const Vector& f) override {
    return columns.leftCols(size).transpose() * f;
  }
  void sum(std::span<double>) override {}
  void largest(std::span<double>) override {}

  ContactError error(const Eigen::Ref<const Vector>& s, std::span<double> = {}) override {
    return evaluator_(s);
  }
  const Vector& impulse() const override { return evaluator_.impulse(); }
  const Vector& impulse_velocity() const override { return evaluator_.velocity(); }
  double energy_at_rest() override { return evaluator_.energy_at_rest(); }
  void release_scratch() override { evaluator_.release_scratch(); }
  ProvedClaim prove(const SolverOptions& options, const Eigen::Ref<const Vector>& s,
                    const ContactError& error) override;

 private:
  /// The last proved claim, judged without a share.
  struct Proof {
    double tol = kNaN;
    Vector impulse;
    ProvedClaim claim;
  };

  const ContactProblem& problem_;
  ErrorShare share_;
  ContactErrorEvaluator evaluator_;
  std::shared_ptr<Proof> proof_;
};

}  // namespace bipot
