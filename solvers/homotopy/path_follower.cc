#include "solvers/homotopy/path_follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/homotopy/ratio_test.h"

namespace bipot {
namespace {

// Pivots between two factorisations, which restore exact data.
constexpr int kRefresh = 400;
// A pivot smaller than this, relative to its column, is rounding: B is factored again.
constexpr double kSmallPivot = 1e-11;
// Largest relative difference of two computed speeds by rounding.
constexpr double kDrift = 1e-6;
// Below this t the path counts as a ray to -infinity.
constexpr double kFarBack = -1e3;
// Faces beyond this t count as met at t = 1: contacts that end on one, up to rounding.
constexpr double kArrived = 1 - 1e-11;
// Violated bounds of that size, relative to the largest parameter, are rounding.
constexpr double kAtZero = 1e-14;
// The same after one refinement.
constexpr double kNearZero = 1e-9;
// A turning point is stored when t has gained this much since the last one.
constexpr double kTurnGain = 0.02;
// Newton steps before a path, the least fraction of one, and the fraction of |F| that a full one
// must remove.
constexpr int kNewtonSteps = 20;
constexpr double kLeastStep = 0.25, kDescent = 0.3;
// With at most this number of faces ahead, the path follows: a pivot is cheaper than a
// factorisation.
constexpr int kFewFaces = 20;
// Pivots between two polls of the stop conditions.
constexpr int kPoll = 16;
// Slots that are tested together in the ratio test.
constexpr int kGroup = 64;

}  // namespace

PathFollower::PathFollower(const LawProblem& problem, std::function<bool()> stop)
    : problem_(problem), stop_(std::move(stop)), basis_(problem, FactorStop(stop_)) {}

PathFollower::End PathFollower::follow(LawPoint& point, const Vector& anchor,
                                       const Vector& proximal, int longest) {
  ++counts_.paths;
  proximal_ = &proximal;
  least_proximal_ = proximal.minCoeff();
  target_ = problem_.b - proximal.cwiseProduct(anchor);
  factored_ = false;
  t_ = turning_t_ = 0;
  End end = kStopped;
  try {
    end = approach(point);
    if (end == kLong) {
      residual(point, r_);
      end = r_.isZero(0) ? kSolved : pursue(point, longest);
    }
  } catch (const FactorStopped&) {
    end = kStopped;
  }
  if (end != kSolved) ++counts_.failed;
  return end;
}

/// f = F(p), returns its norm.
double PathFollower::residual(const LawPoint& point, Vector& f) {
  point.impulse(problem_, s_);
  point.velocity(problem_, u_);
  f = u_ - target_ - proximal_->cwiseProduct(s_);
  f.noalias() -= problem_.W * s_;
  return f.norm();
}

/// Damped Newton steps while many faces lie ahead. kLong: the path does the rest.
PathFollower::End PathFollower::approach(LawPoint& point) {
  double norm = residual(point, r_);
  LawPoint ahead = point, candidate;
  for (int k = 0; k < kNewtonSteps && norm > 0; ++k) {
    if (stop_()) return kStopped;
    point.sort_columns(problem_);
    factored_ = basis_.factor(point, *proximal_);
    if (!factored_) return kSingular;
    ahead = point;
    // One refinement is enough for a step; a solution gets all.
    const auto admissible = [&](double rounding) {
      const double violation = -point.bound.cwiseProduct(y_).minCoeff();
      return violation <= rounding * y_.lpNorm<Eigen::Infinity>();
    };
    basis_.solve_refined(point, target_, 0, r_, 1, y_);
    if (!y_.allFinite()) return kSingular;
    if (admissible(kNearZero)) {
      basis_.refine(point, target_, 0, r_, refinements() - 1, y_);
      if (!y_.allFinite()) return kSingular;
      if (admissible(kAtZero)) {
        point.value = y_;
        return kSolved;
      }
    }
    y_ -= point.value;
    bool accepted = false;
    double reached = norm;
    for (double step = 1; step >= kLeastStep && !accepted; step *= 0.5) {
      ahead.value = point.value + step * y_;
      ahead.impulse(problem_, s_);
      ahead.velocity(problem_, u_);
      candidate = nearest_point(problem_, s_, u_);
      if (step == 1) {
        int faces = 0;
        for (std::size_t i = 0; i < point.cell.size(); ++i) {
          faces += candidate.cell[i] != point.cell[i] ? 1 : 0;
        }
        if (faces <= kFewFaces) return kLong;
      }
      reached = residual(candidate, r_);
      accepted = reached <= (1 - kDescent * step) * norm;
    }
    if (!accepted) return kLong;
    ++counts_.newton;
    point = candidate;
    factored_ = false;
    norm = reached;
  }
  return kLong;
}

PathFollower::End PathFollower::pursue(LawPoint& point, int longest) {
  for (Vector* of_newton_steps : {&s_, &u_, &y_}) of_newton_steps->resize(0);
  if (!refresh(point, /*move=*/false)) return kSingular;
  const int first_direction = direction_ = basis_.orientation(point);
  if (direction_ == 0) return kSingular;
  const std::vector<Cell> first_cell = point.cell;
  int last = -1;  // slot that has just entered: its parameter is zero and grows
  for (int pivots = 0;; ++pivots) {
    const Blocking next = blocking(point, last);
    const double end = t_ + direction_ * next.step;
    if (pivots > 0 && direction_ == first_direction && t_ * direction_ <= 0 &&
        end * direction_ > 0 && point.cell == first_cell) {
      return kLoop;
    }
    if (direction_ > 0 && end >= kArrived) {
      t_ = 1;
      basis_.solve_refined(point, target_, 0, r_, refinements(), point.value);
      return point.value.allFinite() ? kSolved : kSingular;
    }
    if (next.slot < 0 || end < kFarBack) return kRay;
    if (pivots >= longest) return kLong;
    if (pivots % kPoll == 0 && stop_()) return kStopped;
    point.value.noalias() -= (direction_ * next.step) * x_;
    point.value[next.slot] = 0;
    t_ = end;
    last = next.slot;
    const int before = direction_;
    if (!pivot(point, next.slot)) return kSingular;
    if (since_refresh_ == 0) last = -1;  // factored afresh, columns sorted
    if (direction_ != before) {
      ++counts_.turns;
      if (direction_ < 0) note_turn(point);
    }
  }
}

/// The error of a solve is 1e-16 / D of the solution. Each refinement multiplies it by that factor,
/// down to rounding.
int PathFollower::refinements() const {
  return least_proximal_ < 1e-9 ? 3 : least_proximal_ < 1e-7 ? 2 : 1;
}

/// Factors B and computes x from the data, and with `move` the parameters: at t = 0 these are the
/// ones of the residual r.
bool PathFollower::refresh(LawPoint& point, bool move) {
  if (!factored_) {
    point.sort_columns(problem_);
    if (!basis_.factor(point, *proximal_)) return false;
  }
  factored_ = false;
  since_refresh_ = 0;
  // During the path one refinement less is enough.
  if (move) {
    basis_.solve_refined(point, target_, 1 - static_cast<long double>(t_), r_, refinements() - 1,
                         point.value);
  }
  basis_.solve_refined(point, r_, 0, r_, refinements() - 1, x_);
  x_factored_ = x_;
  return x_.allFinite() && point.value.allFinite();
}

/// Calls visit(slot, step) for the bounded parameters, but for `but`, that become zero before t has
/// changed by `limit`, which visit may lower.
template <class Visit>
void PathFollower::for_nearer(const LawPoint& point, int but, const double& limit,
                              const Visit& visit) const {
  const double* const value = point.value.data();
  const double* const bound = point.bound.data();
  const double* const x = x_.data();
  const double direction = direction_;
  const int m = problem_.num_rows();
  for (int begin = 0; begin < m; begin += kGroup) {
    const int end = std::min(begin + kGroup, m);
    // Few groups contain a nearer one: they are found by a test without branches.
    if (!any_nearer(bound + begin, value + begin, x + begin, direction, limit, end - begin)) {
      continue;
    }
    for (int slot = begin; slot < end; ++slot) {
      const double speed = bound[slot] * x[slot] * direction;
      if (!(speed > 0) || slot == but) continue;
      const double distance = std::max(bound[slot] * value[slot], 0.0);
      if (distance < limit * speed) visit(slot, distance / speed);
    }
  }
}

/// Ratio test: the bounded parameter that first becomes zero, and the change of t until then.
PathFollower::Blocking PathFollower::blocking(const LawPoint& point, int last) const {
  Blocking first{-1, kInfinity};
  for_nearer(point, last, first.step, [&](int slot, double step) { first = {slot, step}; });
  return first;
}

/// Prepares the entering column, together with those that would enter next if the path continued
/// straight: one solve for eight costs as much as two single ones.
void PathFollower::look_ahead(const LawPoint& point, const CellBasis::Candidate& now) {
  nearest_.clear();
  const auto candidate = [&](int slot) {
    return CellBasis::Candidate{slot / problem_.dim, point.across(problem_, slot).enters, slot};
  };
  constexpr std::size_t kMost = kRightSides - 1;
  const auto nearer = [](const Blocking& one, const Blocking& other) {
    return one.step < other.step;
  };
  // Beyond it the path has arrived.
  double farthest = direction_ > 0 ? 1 - t_ : kInfinity;
  for_nearer(point, now.slot, farthest, [&](int slot, double step) {
    if (!basis_.is_unknown(candidate(slot))) return;
    const Blocking here{slot, step};
    nearest_.insert(std::upper_bound(nearest_.begin(), nearest_.end(), here, nearer), here);
    if (nearest_.size() > kMost) nearest_.pop_back();
    if (nearest_.size() == kMost) farthest = std::min(farthest, nearest_.back().step);
  });
  candidates_.assign(1, now);
  for (const Blocking& next : nearest_) candidates_.push_back(candidate(next.slot));
  basis_.prepare(candidates_);
}

/// Enters the cell beyond the face where the parameter of `slot` is zero.
bool PathFollower::pivot(LawPoint& point, int slot) {
  const int contact = slot / problem_.dim;
  const Crossing crossing = point.across(problem_, slot);
  const CellBasis::Candidate now{contact, crossing.enters, slot};
  if (basis_.is_unknown(now)) look_ahead(point, now);
  const CellBasis::Entering entering = basis_.entering(contact, crossing.enters, slot);
  if (entering.pivot == 0) return false;
  const double speed = x_[slot] / entering.pivot;
  point.cell[to_size(contact)] = crossing.cell;
  point.column[to_size(slot)] = crossing.enters;
  point.find_bounds(problem_, contact);
  direction_ = crossing.growth * speed < 0 ? 1 : -1;
  ++counts_.pivots;
  const bool small = std::abs(entering.pivot) < kSmallPivot * entering.size;
  if (small || ++since_refresh_ >= kRefresh || basis_.full()) return refresh(point);
  if (!basis_.exchange(entering)) return refresh(point);
  x_ = x_factored_;
  basis_.update(x_);
  // The same speed computed in two ways: a difference shows growth of rounding.
  if (!(std::abs(x_[slot] - speed) <= kDrift * std::abs(speed))) return refresh(point);
  return true;
}

void PathFollower::note_turn(const LawPoint& point) {
  if (t_ <= turning_t_ + kTurnGain) return;
  turning_t_ = t_;
  turning_point_ = point;
  turning_point_.bound.resize(0);
}

}  // namespace bipot
