#include "solvers/methods/anderson.h"

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

constexpr double kLargestGrowth = 2;     // of the residual, over the smallest one accepted
constexpr double kSmallestPivot = 1e-8;  // of the triangular factor, relative

/// The last differences of residuals f and values g, with ΔF = Q R kept up to date column by
/// column (Walker and Ni 2011, section 4).
class Memory {
 public:
  Memory(Eigen::Index rows, int columns)
      : q_(rows, columns), g_(rows, columns), r_(Eigen::MatrixXd::Zero(columns, columns)) {}

  void clear() { size_ = 0; }

  void append(const Vector& df, const Vector& dg) {
    if (size_ == static_cast<int>(q_.cols())) drop_oldest();
    auto column = q_.col(size_);
    column = df;
    for (int k = 0; k < size_; ++k) r_(k, size_) = 0;
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough for orthogonality to rounding
      for (int k = 0; k < size_; ++k) {
        const double dot = q_.col(k).dot(column);
        r_(k, size_) += dot;
        column -= dot * q_.col(k);
      }
    }
    const double norm = column.norm();
    if (!(norm > 0)) return;  // nothing new
    column /= norm;
    r_(size_, size_) = norm;
    g_.col((first_ + size_) % g_.cols()) = dg;
    ++size_;
    while (size_ > 1 && badly_conditioned()) drop_oldest();
  }

  /// g - ΔG argmin ‖f - ΔF gamma‖.
  void combine(const Vector& f, const Vector& g, Vector& x) const {
    x = g;
    if (size_ == 0) return;
    Vector gamma = q_.leftCols(size_).transpose() * f;
    r_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>().solveInPlace(gamma);
    for (int k = 0; k < size_; ++k) x -= gamma[k] * g_.col((first_ + k) % g_.cols());
  }

 private:
  bool badly_conditioned() const {
    const auto pivots = r_.diagonal().head(size_).cwiseAbs();
    return pivots.minCoeff() < kSmallestPivot * pivots.maxCoeff();
  }
  void drop_oldest() {
    // Without its first column R is upper Hessenberg; rotations make it triangular again.
    for (int k = 0; k + 1 < size_; ++k) {
      for (int row = 0; row <= k + 1; ++row) r_(row, k) = r_(row, k + 1);
      for (int row = k + 2; row < size_; ++row) r_(row, k) = 0;
    }
    for (int k = 0; k + 1 < size_; ++k) {
      Eigen::JacobiRotation<double> rotation;
      rotation.makeGivens(r_(k, k), r_(k + 1, k));
      r_.leftCols(size_ - 1).applyOnTheLeft(k, k + 1, rotation.adjoint());
      q_.applyOnTheRight(k, k + 1, rotation);
    }
    first_ = (first_ + 1) % static_cast<int>(g_.cols());
    --size_;
  }

  Eigen::MatrixXd q_, g_, r_;  // g_ is a ring that begins at first_
  int size_ = 0, first_ = 0;
};

/// map: s -> G(s), in the problem's variables.
void iterate(const ContactScaling& scaling, const Vector& s0, int columns,
             IterationMonitor& monitor, const std::function<void(Vector&)>& map) {
  Memory memory(s0.size(), columns);
  Vector x = scaling.impulse.cwiseProduct(s0), s = s0, g(x.size()), f(x.size());
  Vector f_before, g_before;
  double smallest = std::numeric_limits<double>::infinity();
  bool accelerated = false;
  for (int iteration = 0; !monitor.stop(iteration, s); ++iteration) {
    s = x.cwiseProduct(scaling.velocity);
    map(s);
    g = scaling.impulse.cwiseProduct(s);
    f = g - x;
    const double residual = f.norm();
    if (accelerated && !(residual <= kLargestGrowth * smallest)) {
      memory.clear();
      x = g_before;
      accelerated = false;
      f_before.resize(0);
      smallest = std::numeric_limits<double>::infinity();
      continue;
    }
    smallest = std::min(smallest, residual);
    if (f_before.size() != 0) memory.append(f - f_before, g - g_before);
    f_before = f;
    g_before = g;
    memory.combine(f, g, x);
    accelerated = true;
  }
}

}  // namespace

SolveResult solve_anderson(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kAndersonParameters);
  const int columns = parameters.integer("memory");
  const bool sweeps = parameters.choice("map") == "sweep";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  const Vector s0 = start_of(p, options);
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    if (sweeps) {
      with_local_updates<D>(p, delassus, {}, false, [&](auto& sweep, auto visit) {
        monitor.end_setup();
        iterate(scaling, s0, columns, monitor, [&](Vector& s) {
          sweep.reset(s);
          for (int c = 0; c < p.num_contacts(); ++c) visit(c);
          for (int c = p.num_contacts() - 1; c >= 0; --c) visit(c);
          s = sweep.impulse();
        });
      });
    } else {
      const double rho = 1 / (kSpectralMargin * spectral_estimate(p, delassus, scaling.velocity));
      Vector u(p.num_rows());
      monitor.end_setup();
      iterate(scaling, s0, columns, monitor, [&](Vector& s) {
        delassus.velocity(s, u);
        for (int c = 0; c < p.num_contacts(); ++c) {
          const Local<D> to_x = scaling.impulse.segment<D>(c * D);
          Local<D> x = s.segment<D>(c * D).cwiseProduct(to_x);
          x -= rho * u.segment<D>(c * D).cwiseQuotient(to_x);
          x[0] = positive_part(x[0]);
          if constexpr (D > 1) {
            const double norm = tangential_norm<D>(x), radius = scaling.mu[c] * x[0];
            if (norm > radius) x.template tail<D - 1>() *= radius / norm;
          }
          s.segment<D>(c * D) = x.cwiseQuotient(to_x);
        }
      });
    }
  });
  return monitor.finish();
}

}  // namespace bipot
