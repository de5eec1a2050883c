#include "solvers/interior/arclength.h"

#include <cmath>

namespace bipot {
namespace {

constexpr double kFirstTrigger = 1e-3;  // the endgame is tried below this t
constexpr double kLargestT = 3;
constexpr double kLongestArc = 64;
constexpr double kShortestArc = 1e-8;
constexpr double kRmsDeviation = 0.4;

template <int D>
class Path {
 public:
  using Jordan = ContactJordan<D>;
  static constexpr int P = Jordan::P;

  Path(const InteriorSystem<D>& system, const InteriorState<D>& start)
      : system_(system), c_(system.products(start.X, start.Y)), p0_(start.p) {
    if constexpr (D == 3) {
      for (int c = 0; c < system.num_contacts(); ++c) {
        if (system.friction(c)) c_.template segment<3>(c * P + 1) = Vector3(c_[c * P + 1], 0, 0);
      }
    }
  }

  const Vector& target() const { return c_; }
  const Vector& residual() const { return p0_; }

  /// Largest |log| of the ratio of a product's eigenvalue to t times the path's, and the root mean
  /// square of the ratio less one.
  struct Deviation {
    double worst = 0, rms = 0;
  };
  Deviation deviation(const Vector& X, const Vector& Y, double t) const {
    Deviation d;
    for (int c = 0; c < system_.num_contacts(); ++c) {
      const bool f = system_.friction(c);
      const auto x = system_.pairs(X, c), y = system_.pairs(Y, c);
      const auto e = Jordan::eigenvalues(Jordan::product(x, y, f), f);
      const auto goal = Jordan::eigenvalues(system_.pairs(c_, c), f);
      for (int k = 0; k < Jordan::rank(f); ++k) {
        const double ratio = e[k] / (t * goal[k]);
        if (!(ratio > 0)) return {std::numeric_limits<double>::infinity(), 0};
        d.worst = std::max(d.worst, std::abs(std::log(ratio)));
        d.rms += (ratio - 1) * (ratio - 1);
      }
    }
    d.rms = std::sqrt(d.rms / system_.num_eigenvalues());
    return d;
  }

  /// Inner product of two directions, in relative changes at z, averaged over the pairs.
  double dot(const InteriorState<D>& z, const PairDirection& a, const PairDirection& b) const {
    double sum = 0;
    for (int c = 0; c < system_.num_contacts(); ++c) {
      const bool f = system_.friction(c);
      const auto x = system_.pairs(z.X, c), y = system_.pairs(z.Y, c);
      sum += Jordan::divide(system_.pairs(a.dX, c), x, f)
                 .dot(Jordan::divide(system_.pairs(b.dX, c), x, f));
      sum += Jordan::divide(system_.pairs(a.dY, c), y, f)
                 .dot(Jordan::divide(system_.pairs(b.dY, c), y, f));
    }
    return sum / system_.num_eigenvalues();
  }

 private:
  using Vector3 = Eigen::Vector3d;
  const InteriorSystem<D>& system_;
  Vector c_, p0_;
};

void add(PairDirection& a, double factor, const PairDirection& b) {
  a.dX += factor * b.dX;
  a.dY += factor * b.dY;
  a.ds += factor * b.ds;
}

}  // namespace

template <int D>
StageEnd follow_central_path(InteriorSystem<D>& system, InteriorState<D> z, InteriorRun& run,
                             const ArclengthOptions& options,
                             const ProximalInteriorPointOptions& endgame, InteriorState<D>& best) {
  const Path<D> path(system, z);
  const double corridor = std::log(1 / options.neighbourhood);
  const Vector none = Vector::Zero(z.p.size());
  double t = 1, trigger = kFirstTrigger;
  double progress_t = t;
  int progress = 0;
  double best_error = std::numeric_limits<double>::infinity();
  int start_sign = 0;
  PairDirection T, Y, Q;
  for (int k = 0; k < options.max_iterations; ++k) {
    if (!system.linearise(z, 0.0)) return StageEnd::kFailed;
    const int sign = system.determinant_sign();
    if (start_sign == 0) start_sign = sign;
    const double orientation = sign == start_sign ? -1 : 1;  // of dt

    // Tangent with dt = 1, then normalised and oriented.
    system.direction(z, path.target(), -path.residual(), T);
    double dt = 1;
    {
      const double norm = std::sqrt(path.dot(z, T, T) + 1 / (t * t));
      if (!std::isfinite(norm)) return StageEnd::kFailed;
      const double factor = orientation / norm;
      T.dX *= factor;
      T.dY *= factor;
      T.ds *= factor;
      dt = factor;
    }
    system.direction(z, t * path.target() - system.products(z.X, z.Y), z.p - t * path.residual(),
                     Y);
    double y_dt = 0;
    double along = path.dot(z, T, Y);
    add(Y, -along, T);
    y_dt -= along * dt;
    system.direction(z, -system.products(T.dX, T.dY), none, Q);
    double q_dt = 0;
    along = path.dot(z, T, Q);
    add(Q, -along, T);
    q_dt -= along * dt;
    if (!Y.ds.allFinite() || !Q.ds.allFinite()) return StageEnd::kFailed;

    // Correction, shortened until the deviation does not grow.
    const double error = path.deviation(z.X, z.Y, t).worst;
    double alpha = 1;
    double corrected = error;
    for (; alpha > 1e-4; alpha *= 0.6) {
      const double t_new = t + alpha * y_dt;
      if (t_new <= 0) continue;
      corrected = path.deviation(z.X + alpha * Y.dX, z.Y + alpha * Y.dY, t_new).worst;
      if (corrected <= std::max(error, 1e-3)) break;
    }
    if (alpha <= 1e-4) alpha = 0;

    double h = 0;
    if (alpha == 1 || error < 0.3 * corridor) {
      for (h = kLongestArc; h > kShortestArc; h *= 0.75) {
        const double t_new = t + alpha * y_dt + h * dt + h * h * q_dt;
        if (t_new <= 0) continue;
        const Vector X = z.X + alpha * Y.dX + h * T.dX + (h * h) * Q.dX;
        const Vector Ydual = z.Y + alpha * Y.dY + h * T.dY + (h * h) * Q.dY;
        if (X.size() == 0) break;
        const auto d = path.deviation(X, Ydual, t_new);
        if (d.worst <= corridor && d.rms <= kRmsDeviation) {
          // The products may be positive with both factors negative.
          PairDirection step{alpha * Y.dX + h * T.dX + (h * h) * Q.dX,
                             alpha * Y.dY + h * T.dY + (h * h) * Q.dY,
                             {}};
          if (system.longest_step(z, step) > 1) break;
        }
      }
      if (h <= kShortestArc) h = 0;
    }
    if (alpha == 0 && h == 0) return StageEnd::kStuck;
    PairDirection step{
        alpha * Y.dX + h * T.dX + (h * h) * Q.dX, alpha * Y.dY + h * T.dY + (h * h) * Q.dY, {}};
    system.move(z, step, 1);
    t += alpha * y_dt + h * dt + h * h * q_dt;
    if (run.next(z.s, h)) return StageEnd::kStop;
    if (run.judged() && run.monitor.last_error() < best_error) {
      best_error = run.monitor.last_error();
      best = z;
    }
    if (t < 0.5 * progress_t) {
      progress_t = t;
      progress = k;
    }
    if (k - progress >= options.patience) return StageEnd::kStuck;
    if (t > kLargestT) return StageEnd::kStuck;
    if (t < trigger && orientation < 0) {
      InteriorState<D> copy = z, endgame_best = z;
      if (proximal_interior_point(system, copy, run, endgame, endgame_best) == StageEnd::kStop) {
        return StageEnd::kStop;
      }
      trigger *= 0.01;
    }
  }
  return StageEnd::kLimit;
}

template StageEnd follow_central_path<1>(InteriorSystem<1>&, InteriorState<1>, InteriorRun&,
                                         const ArclengthOptions&,
                                         const ProximalInteriorPointOptions&, InteriorState<1>&);
template StageEnd follow_central_path<2>(InteriorSystem<2>&, InteriorState<2>, InteriorRun&,
                                         const ArclengthOptions&,
                                         const ProximalInteriorPointOptions&, InteriorState<2>&);
template StageEnd follow_central_path<3>(InteriorSystem<3>&, InteriorState<3>, InteriorRun&,
                                         const ArclengthOptions&,
                                         const ProximalInteriorPointOptions&, InteriorState<3>&);

}  // namespace bipot
