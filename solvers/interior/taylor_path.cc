#include "solvers/interior/taylor_path.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace bipot {
namespace {

constexpr double kLargestT = 100;
constexpr int kMaxRetractions = 6;
constexpr double kSmallestReach = 1e-14;
constexpr double kSmallestRetraction = 1e-9;
constexpr double kGrow = 1.2, kShrink = 0.8;
constexpr int kMaxGrowths = 12;
// Largest relative error of a product within the reach of a series. The error becomes part of the
// path, so that only the orientation limits it.
constexpr double kSeriesTolerance = 0.1;

// Rows of the sample of a series, in groups of one contact's pairs.
constexpr int kSampledGroups = 16;

}  // namespace

template <ContactRows D>
TaylorPath<D>::TaylorPath(InteriorSystem<D>& system, InteriorState<D> start, int order)
    : system_(system),
      order_(order),
      z_(std::move(start)),
      t_(Vector::Zero(order + 1)),
      weights_(order) {}

template <ContactRows D>
PathStep TaylorPath<D>::end() {
  ended_ = true;
  return PathStep::kEnded;
}

template <ContactRows D>
PathStep TaylorPath<D>::advance() {
  if (ended_) return PathStep::kEnded;
  if (!system_.linearise(z_, 0.0)) return end();
  Vector c = system_.products(z_.X, z_.Y) / t_now_;
  system_.direction(z_, c, -z_.p / t_now_, tangent_);
  const double length = std::sqrt(metric(tangent_, tangent_) + 1 / (t_now_ * t_now_));
  if (!std::isfinite(length)) return end();
  if (!orient(system_.determinant_sign(), tangent_)) {
    retract();
    return PathStep::kRetracted;
  }
  c_ = std::move(c);
  if (!expand(orientation_ / length, tangent_)) return end();
  if (!find_reach()) return end();
  ++num_series_;
  take(reach_);
  if (t_now_ > kLargestT) return end();
  return PathStep::kAdvanced;
}

/// Chooses the orientation. False: tangent and determinant disagree, and a shorter step may help.
template <ContactRows D>
bool TaylorPath<D>::orient(int determinant, const PairDirection& tangent) {
  if (num_series_ == 0) {
    reference_sign_ = determinant;
    orientation_ = -1;
    return true;
  }
  const double along = metric(end_tangent_, tangent) + end_dt_ / (t_now_ * t_now_);
  const int continued = along > 0 ? 1 : -1;
  const int expected = determinant == reference_sign_ ? -1 : 1;
  if (continued != expected) {
    if (retractions_here_ < kMaxRetractions && reach_ > kSmallestRetraction) return false;
    reference_sign_ = -reference_sign_;
  }
  retractions_here_ = 0;
  if (continued != orientation_) ++folds_;
  orientation_ = continued;
  return true;
}

/// Goes back to half of the last step, or to a smaller part where the sum is accurate.
template <ContactRows D>
void TaylorPath<D>::retract() {
  ++retractions_here_;
  do {
    reach_ *= 0.5;
  } while (!accurate(reach_) && reach_ > kSmallestRetraction);
  take(reach_);
}

/// The coefficients of the series from z_, whose first order is dt * tangent.
template <ContactRows D>
bool TaylorPath<D>::expand(double dt, const PairDirection& tangent) {
  const int contacts = system_.num_contacts();
  const std::size_t size = to_size(z_.X.size() * t_.size());
  X_.resize(size);
  Y_.resize(size);
  r_.resize(z_.X.size());
  covector_x_.resize(z_.X.size());
  covector_y_.resize(z_.X.size());
  for (int c = 0; c < contacts; ++c) {
    const unsigned f = system_.parts(c);
    const Pairs x = system_.pairs(z_.X, c), y = system_.pairs(z_.Y, c);
    coefficients(X_, c).col(0) = x;
    coefficients(Y_, c).col(0) = y;
    const auto weigh = [&](const Pairs& d, const Pairs& at) {
      return Jordan::divide(Jordan::divide(d, at, f), at, f);
    };
    // The multiplication by x is symmetric: <z_1, .> is a plain scalar product with these.
    covector_x_.template segment<P>(c * P) = dt * weigh(system_.pairs(tangent.dX, c), x);
    covector_y_.template segment<P>(c * P) = dt * weigh(system_.pairs(tangent.dY, c), y);
  }
  t_[0] = t_now_;
  t_[1] = dt;
  next_.dX = Vector::Zero(z_.X.size());
  next_.dY = next_.dX;
  store(1, next_, dt, tangent);
  for (int k = 2; k <= order_; ++k) {
    for (int c = 0; c < contacts; ++c) {
      const auto X = coefficients(X_, c), Y = coefficients(Y_, c);
      Pairs sum = Pairs::Zero();
      for (int j = 1; j < k; ++j) {
        sum -= Jordan::product(X.col(j), Y.col(k - j), system_.parts(c));
      }
      r_.template segment<P>(c * P) = sum;
    }
    // Without refinement: accurate() detects an error here and shortens the step.
    system_.direction(z_, r_, {}, next_, 0);
    const double along =
        (covector_x_.dot(next_.dX) + covector_y_.dot(next_.dY)) / system_.num_eigenvalues();
    const double tk = -dt * along;
    if (!std::isfinite(tk)) return false;
    t_[k] = tk;
    store(k, next_, tk, tangent);
  }
  return true;
}

/// Column `order` of the coefficients: d + dt * tangent.
template <ContactRows D>
void TaylorPath<D>::store(int order, const PairDirection& d, double dt,
                          const PairDirection& tangent) {
  for (int c = 0; c < system_.num_contacts(); ++c) {
    coefficients(X_, c).col(order) = system_.pairs(d.dX, c) + dt * system_.pairs(tangent.dX, c);
    coefficients(Y_, c).col(order) = system_.pairs(d.dY, c) + dt * system_.pairs(tangent.dY, c);
  }
}

/// Sets the weights and the longest arclength, within the factor 1.2, at which the sum is accurate.
template <ContactRows D>
bool TaylorPath<D>::find_reach() {
  double last = 0;  // <z_p, z_p> of the last order
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const auto [x, y] = relative_term(c, order_);
    last += x.squaredNorm() + y.squaredNorm();
  }
  last = std::sqrt(last / system_.num_eigenvalues());
  reach_ = std::pow(kSeriesTolerance / std::max(last, 1e-300), 1.0 / (order_ - 1));
  if (!std::isfinite(reach_)) return false;
  weights_ = SeriesWeights(order_);
  if (accurate(reach_)) {
    grow();
  } else {
    do {
      reach_ *= kShrink;
      if (!(reach_ > kSmallestReach)) return false;
    } while (!accurate(reach_));
  }
  weights_.fit(sample(), reach_);
  if (!grow()) weights_ = SeriesWeights(order_);
  return true;
}

/// Lengthens the reach while the sum stays accurate. False: it is not.
template <ContactRows D>
bool TaylorPath<D>::grow() {
  int k = 0;
  for (; k < kMaxGrowths && accurate(kGrow * reach_); ++k) reach_ *= kGrow;
  return k > 0;
}

/// Term k of the series of X and Y of a contact, relative to X and Y.
template <ContactRows D>
auto TaylorPath<D>::relative_term(int c, int k) const -> std::pair<Pairs, Pairs> {
  const unsigned f = system_.parts(c);
  return {Jordan::divide(coefficients(X_, c).col(k), system_.pairs(z_.X, c), f),
          Jordan::divide(coefficients(Y_, c).col(k), system_.pairs(z_.Y, c), f)};
}

/// The relative terms times reach^k, of all contacts: each is added with a random sign to a random
/// group of rows, so that norms are kept to some ten per cent. (A sketch of sparse columns:
/// Clarkson and Woodruff, J. ACM 63, 2017.)
template <ContactRows D>
Eigen::MatrixXd TaylorPath<D>::sample() const {
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(kSampledGroups * 2 * P, order_);
  std::mt19937 random;  // the same for each series
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const auto number = random();
    const int row = static_cast<int>(number / 2 % kSampledGroups) * 2 * P;
    double factor = number % 2 == 0 ? 1 : -1;
    for (int k = 1; k <= order_; ++k) {
      factor *= reach_;
      const auto [x, y] = relative_term(c, k);
      terms.col(k - 1).template segment<P>(row) += factor * x;
      terms.col(k - 1).template segment<P>(row + P) += factor * y;
    }
  }
  return terms;
}

/// True if the sum stays inside the cones at alpha and its products are accurate: the largest
/// eigenvalue of X∘Y/t - c is at most the tolerance times the smallest of c.
template <ContactRows D>
bool TaylorPath<D>::accurate(double alpha) const {
  const SeriesWeights::At at = weights_.at(alpha);
  const double t = t_.dot(at.value);
  if (!(at.regular && t > 0)) return false;
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const unsigned f = system_.parts(c);
    const Pairs x = coefficients(X_, c) * at.value;
    const Pairs y = coefficients(Y_, c) * at.value;
    const auto inside = [&](const Pairs& v) { return Jordan::eigenvalues(v, f).minCoeff() > 0; };
    if (!(inside(x) && inside(y))) return false;
    const Pairs goal = system_.pairs(c_, c);
    const Pairs error = Jordan::product(x, y, f) / t - goal;
    const auto e = Jordan::eigenvalues(error, f), g = Jordan::eigenvalues(goal, f);
    bool ok = std::abs(e[0]) <= kSeriesTolerance * g[0];
    Jordan::each_part(f, [&](auto first, auto count, auto pair) {
      constexpr int place = 1 + 2 * (pair() - first());
      ok = ok && std::abs(e[place]) <= kSeriesTolerance * g[place] &&
           std::abs(e[place + 1]) <= kSeriesTolerance * g[place + (count() == 1 ? 1 : 0)];
    });
    if (!ok) return false;
  }
  return true;
}

/// Moves to the point at alpha of the series, which defines the path from there on.
template <ContactRows D>
void TaylorPath<D>::take(double alpha) {
  const SeriesWeights::At at = weights_.at(alpha);
  end_tangent_.dX.resize(z_.X.size());
  end_tangent_.dY.resize(z_.X.size());
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const auto X = coefficients(X_, c), Y = coefficients(Y_, c);
    Pairs x = X * at.value;
    Jordan::join_copies(x, system_.mu(c), system_.parts(c));
    z_.X.template segment<P>(c * P) = x;
    z_.Y.template segment<P>(c * P) = Y * at.value;
    end_tangent_.dX.template segment<P>(c * P) = X * at.slope;
    end_tangent_.dY.template segment<P>(c * P) = Y * at.slope;
  }
  t_now_ = t_.dot(at.value);
  end_dt_ = t_.dot(at.slope);
  system_.recompute(z_);
}

template <ContactRows D>
auto TaylorPath<D>::point(double alpha) const -> Point {
  const SeriesWeights::At at = weights_.at(alpha);
  Point p{Vector(z_.X.size()), Vector(z_.X.size()), t_.dot(at.value)};
  for (int c = 0; c < system_.num_contacts(); ++c) {
    p.X.template segment<P>(c * P) = coefficients(X_, c) * at.value;
    p.Y.template segment<P>(c * P) = coefficients(Y_, c) * at.value;
  }
  return p;
}

template <ContactRows D>
double TaylorPath<D>::metric(const PairDirection& a, const PairDirection& b) const {
  double sum = 0;
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const unsigned f = system_.parts(c);
    const Pairs x = system_.pairs(z_.X, c), y = system_.pairs(z_.Y, c);
    sum += Jordan::divide(system_.pairs(a.dX, c), x, f)
               .dot(Jordan::divide(system_.pairs(b.dX, c), x, f));
    sum += Jordan::divide(system_.pairs(a.dY, c), y, f)
               .dot(Jordan::divide(system_.pairs(b.dY, c), y, f));
  }
  return sum / system_.num_eigenvalues();
}

BIPOT_FOR_ROWS(template class TaylorPath);

}  // namespace bipot
