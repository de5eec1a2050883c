#include "solvers/interior/proximal_interior_point.h"

#include <algorithm>
#include <cmath>

namespace bipot {
namespace {

constexpr double kLeastDelta = 1e-7;      // smallest proximal term, in units of 1/W
constexpr double kNeighbourhood = 1e-3;   // smallest product over the mean one
constexpr double kFirstDelta = 1e-3;      // first proximal term against a negative determinant
constexpr double kShortStepDelta = 1e-5;  // the same, against a short step
constexpr double kShortStep = 0.1, kLongStep = 0.7;
constexpr double kLargestDelta = 1e8;  // beyond it I + C^-1 W is the identity
constexpr double kToBoundary = 0.99;
constexpr double kSmallestStep = 1e-12, kTinyStep = 1e-3;
constexpr int kHoldsBeforeRaise = 8;
constexpr double kFar = 1;
constexpr double kNear = 1e-2;  // guarded error below which a rising error means divergence

/// Ratio of the smallest product to the mean one.
template <ContactRows D>
double centrality(const InteriorSystem<D>& system, const Vector& products) {
  return system.smallest_product(products) / system.mean_product(products);
}

/// target e - products - second order, contact by contact.
template <ContactRows D>
Vector centring(const InteriorSystem<D>& system, const Vector& products, double target) {
  constexpr int P = ContactJordan<D>::P;
  Vector r = -products;
  for (int c = 0; c < system.num_contacts(); ++c) {
    r.segment<P>(c * P) += ContactJordan<D>::identity(target, system.parts(c));
  }
  return r;
}

}  // namespace

template <ContactRows D>
StageEnd ProximalInteriorPoint<D>::operator()(InteriorState<D>& z,
                                              const ProximalInteriorPointOptions& options,
                                              InteriorState<D>& best) {
  double delta = kLeastDelta;
  double first_ratio = 0;  // of residual and products
  int holds = 0, tiny_steps = 0;
  double best_error = kInfinity;
  double progress_error = best_error;
  int progress = 0;
  PairDirection affine, d;
  InteriorState<D> trial;
  for (int k = 0; k < options.max_iterations; ++k) {
    if (!system.linearise(z, delta)) return StageEnd::kFailed;
    while (system.determinant_sign() < 0) {
      delta = std::max(5 * delta, kFirstDelta);
      if (delta > kLargestDelta) return StageEnd::kStuck;
      if (!system.linearise(z, delta)) return StageEnd::kFailed;
      if (run.run.out_of_time()) break;
    }
    const Vector products = system.products(z.X, z.Y);
    const double tau = system.mean_product(products);
    const double residual = system.residual_energy(z);
    if (k == 0) first_ratio = residual / tau;
    const bool hold = residual > 10 * tau && delta > kLeastDelta;
    double target = tau;
    if (hold) {
      if (++holds % kHoldsBeforeRaise == 0) target = tau * std::clamp(residual / tau, 1.0, 1e3);
      system.direction(z, centring(system, products, target), z.p, d);
    } else {
      holds = 0;
      system.direction(z, centring(system, products, 0.0), z.p, affine);
      const double t = std::min(1.0, system.longest_step(z, affine));
      const double tau_affine =
          system.mean_product(system.products(z.X + t * affine.dX, z.Y + t * affine.dY));
      double sigma = std::clamp(std::pow(tau_affine / tau, 3), 1e-3, 0.9);
      if (t < 0.1) sigma = std::max(sigma, 0.5);
      Vector r = centring(system, products, sigma * tau);
      if (t > 0.1) r -= system.products(affine.dX, affine.dY);
      system.direction(z, r, z.p, d);
    }
    if (!d.ds.allFinite()) return StageEnd::kFailed;

    const double floor = std::min(kNeighbourhood, 0.9 * centrality(system, products));
    double t = std::min(1.0, kToBoundary * system.longest_step(z, d));
    while (t > kSmallestStep) {
      const Vector moved = system.products(z.X + t * d.dX, z.Y + t * d.dY);
      if (system.smallest_product(moved) >= floor * system.mean_product(moved)) break;
      t *= 0.7;
    }
    system.move(z, d, t);
    if (run.next(z.s, t)) return StageEnd::kStop;
    if (run.judged() && run.run.last_error() < best_error) {
      best_error = run.run.last_error();
      best = z;
    }
    if (best_error < 0.5 * progress_error) {
      progress_error = best_error;
      progress = k;
    }
    // Errors at large products are not informative.
    if (run.run.last_error() > kFar) {
      if (k < options.far_iterations) progress = k;
      if (k + 1 == options.far_iterations) {
        // Products fall faster than the residual: no forces are left to reduce it.
        return residual / tau > first_ratio ? StageEnd::kSmallStart : StageEnd::kLargeStart;
      }
    }
    if (k - progress >= options.patience) return StageEnd::kStuck;
    if (best_error < kNear && run.judged() &&
        run.run.last_error() > options.largest_growth * best_error) {
      return StageEnd::kStuck;
    }
    if (t < kShortStep) delta = std::max(5 * delta, kShortStepDelta);
    if (t > kLongStep) delta = std::max(kLeastDelta, 0.1 * delta);
    tiny_steps = t < kTinyStep ? tiny_steps + 1 : 0;
    if (tiny_steps >= 3) return StageEnd::kStuck;
  }
  return StageEnd::kLimit;
}

BIPOT_FOR_ROWS(template struct ProximalInteriorPoint);

}  // namespace bipot
