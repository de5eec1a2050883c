#pragma once

#include <memory>
#include <optional>

#include "core/base/lists.h"
#include "core/problem/contact_problem.h"
#include "core/problem/contact_wrenches.h"
#include "core/problem/delassus_blocks.h"
#include "core/problem/packed_bodies.h"

namespace bipot {

/// W = Hᵀ A⁻¹ H in block rows. Every d x d block that couples two contacts is stored whole, columns
/// sorted. With diagonal A, cost and memory are linear in the number of contact pairs that share a
/// body, and the result is symmetric bit for bit. Else Cholesky, dense for few bodies,
/// sparse (CHOLMOD) for many; throws std::runtime_error if A is not positive definite.
SparseRows assemble_delassus(const SparseMatrix& A, const SparseMatrix& H, int dim);

/// s -> W s, by the cheaper form that the problem offers. With a diagonal A: two passes through H
/// (about 10 multiplications a row; packed if H is that of disks or spheres). Else: the explicit W.
/// A problem without W and with a general A gets its W assembled here once.
///
/// Keeps a reference to the problem, which must outlive it and all its copies. A copy has its own
/// scratch memory and shares all constant data: the packed H, a W that was assembled here.
///
/// One operator serves one caller at a time: apply() and velocity() write to its scratch memory.
/// Give every thread a copy. With `threads` > 1 the packed products use as many, with the same
/// bits: a body always sums its contacts in their order.
class DelassusOperator {
 public:
  enum class Form { kAuto, kTwoPass, kExplicit };

  explicit DelassusOperator(const ContactProblem& problem, Form form = Form::kAuto,
                            int threads = 1);
  explicit DelassusOperator(ContactProblem&&, Form = Form::kAuto,
                            int = 1) = delete;  // would dangle

  /// u = W s. No allocation.
  void apply(const Eigen::Ref<const Vector>& s, Vector& u) const;
  /// u = W s + u_free. No allocation.
  void velocity(const Eigen::Ref<const Vector>& s, Vector& u) const;
  /// velocity() in two parts, for callers that process the contacts part by part. Requires
  /// is_packed().
  void move_bodies(const Eigen::Ref<const Vector>& s) const;
  /// u of the contacts [begin, end) after move_bodies().
  void contact_velocity(int begin, int end, Vector& u) const;
  /// Diagonal d x d block of contact c, row-major storage of d*d values.
  Eigen::MatrixXd diagonal_block(int contact) const;
  /// Frees the scratch memory; the next product allocates it anew.
  void release_scratch() { velocity_.resize(0); }
  /// Diagonal of W, size m.
  Vector diagonal() const;
  /// The packed H of disks; empty if the two-pass form is not used or finds other bodies.
  const std::optional<DiskStructure>& disks() const { return prepared_->disks; }
  /// The same for disks or spheres, as dim = D says.
  template <int D>
  const std::optional<BodiesOf<D>>& bodies() const {
    return prepared_->bodies<D>();
  }
  /// Those of W; null in the two-pass form.
  std::shared_ptr<const DelassusBlocks> blocks() const { return prepared_->blocks; }
  bool is_packed() const { return prepared_->disks || prepared_->spheres; }

 private:
  template <int D>
  void move_bodies(const double* s) const;
  template <int D>
  void contact_velocity(int begin, int end, const double* u_free, double* u) const;
  template <int D>
  void add_impulses(const double* s) const;
  template <int D>
  void add_impulses_by_body(const double* s) const;

  /// Data computed once from the problem.
  struct Prepared {
    Vector inverse_mass;                      // diagonal of A⁻¹, two-pass form only
    std::optional<ContactWrenches> wrenches;  // of its H, if it is not packed
    std::optional<DiskStructure> disks;
    std::optional<SphereStructure> spheres;
    // With threads, the contacts of each body in their order: 2 c if it is body i, else 2 c + 1.
    Lists<> sides;
    SparseRows delassus;                           // only when W had to be assembled here
    std::shared_ptr<const DelassusBlocks> blocks;  // explicit form only

    template <int D>
    const std::optional<BodiesOf<D>>& bodies() const {
      if constexpr (D == 3) {
        return spheres;
      } else {
        return disks;
      }
    }
    template <int D>
    void list_sides();
  };

  Vector& scratch() const;

  const ContactProblem& problem_;
  int threads_ = 1;
  bool two_pass_ = false;
  std::shared_ptr<const Prepared> prepared_;
  const SparseRows* delassus_ = nullptr;  // prepared_'s or the problem's W
  // Scratch, n. For disks 4 values a body: (x, y, a ω, padding); for spheres 8: (x, y, z, padding,
  // a ω, padding).
  mutable Vector velocity_;
};

/// An entry of W = Hᵀ A⁻¹ H, for a diagonal A.
double delassus_entry(const SparseMatrix& H, const Vector& inverse_mass, int row, int column);

/// v = v_free + A⁻¹ H s, the velocities after the step in the problem's own degrees of freedom
/// (not scaled: row_scale is inside H), those of the given problem where equality rows were
/// eliminated. Requires has_velocities().
Vector body_velocities(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

}  // namespace bipot
