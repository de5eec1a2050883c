#include "core/criterion/contact_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/parallel.h"
#include "core/criterion/error_terms.h"
#include "core/criterion/vector_error.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

Vector zeros(int size) {
  Vector v = large_vector(size);
  v.setZero();
  return v;
}

/// 0/0 is 0 (no motion and no violation), x/0 is infinite. NaN has no sign.
double ratio(double numerator, double denominator) {
  if (numerator == 0) return 0;
  if (denominator == 0) return kInfinity;
  const double quotient = numerator / denominator;
  return std::isnan(quotient) ? kNaN : quotient;
}

}  // namespace

ContactError error_of(const ErrorSums& total) {
  ContactError e;
  e.friction_power = total.friction;
  e.energy = std::max(0.5 * total.moved, total.free_energy);
  const double denominator = std::max(total.friction, kTheta * e.energy);
  e.epsilon = ratio(total.gap + total.penetration, denominator);
  e.eta = std::sqrt(ratio(total.natural, denominator));
  e.raw42 = total.friction > 0 ? total.gap_clipped / total.friction : kNaN;
  e.natural_map = ratio(std::sqrt(total.natural_rel),
                        std::max(std::sqrt(total.impulse2), std::sqrt(total.free_impulse2)));
  return e;
}

ContactError error_of(const ErrorSums& part, const ErrorShare& share) {
  ErrorSums whole = part;
  whole += share.others;
  ContactError e = error_of(whole);
  e.epsilon /= share.share;
  e.eta /= share.share;
  if (share.alone > 0) {
    const ContactError own = error_of(part);
    // Written so that NaN stays NaN.
    if (!(e.epsilon <= share.alone * own.epsilon)) e.epsilon = share.alone * own.epsilon;
    if (!(e.eta <= share.alone * own.eta)) e.eta = share.alone * own.eta;
  }
  return e;
}

/// Data of the problem that do not depend on s.
struct ContactErrorEvaluator::Prepared {
  ErrorWeights weights;
  ErrorSums free;  ///< free_energy and free_impulse2

  Prepared(const ContactProblem& p, const Vector& delassus_diagonal)
      : weights(error_weights(p, delassus_diagonal)) {
    for (int c = 0; c < p.num_contacts(); ++c) add_free_terms(p, weights, c, free);
  }
};

ContactErrorEvaluator::ContactErrorEvaluator(const ContactProblem& problem, int threads,
                                             const ErrorShare& share)
    : problem_(problem),
      threads_(threads),
      delassus_(
          std::make_unique<DelassusOperator>(problem, DelassusOperator::Form::kAuto, threads)),
      prepared_(std::make_shared<const Prepared>(problem, delassus_->diagonal())),
      share_(share) {}

ContactErrorEvaluator::ContactErrorEvaluator(const ContactErrorEvaluator& made,
                                             const ErrorShare& share)
    : problem_(made.problem_),
      threads_(made.threads_),
      delassus_(std::make_unique<DelassusOperator>(*made.delassus_)),
      prepared_(made.prepared_),
      share_(share) {}

ContactErrorEvaluator::ContactErrorEvaluator(const ContactErrorEvaluator& made)
    : ContactErrorEvaluator(made, made.share_) {
  sums_ = made.sums_;
  s_ = made.s_;
  u_ = made.u_;
}

ContactErrorEvaluator::ContactErrorEvaluator(ContactErrorEvaluator&&) noexcept = default;
ContactErrorEvaluator::~ContactErrorEvaluator() = default;

void ContactErrorEvaluator::release_scratch() {
  s_.resize(0);
  u_.resize(0);
  delassus_->release_scratch();
}

double ContactErrorEvaluator::energy_at_rest() const {
  return error_of(prepared_->free, share_).energy;
}

ContactError ContactErrorEvaluator::operator()(const Eigen::Ref<const Vector>& s) {
  if (s_.size() != problem_.num_rows()) {
    s_ = zeros(problem_.num_rows());
    u_ = zeros(problem_.num_rows());
  }
  return dispatch_form(problem_, [&](auto d, auto scaled) { return evaluate<d(), scaled()>(s); });
}

/// s <- its projection on the cones of the contacts [begin, end).
template <auto D, bool kScaled>
void ContactErrorEvaluator::project(int begin, int end) {
  for (int c = begin; c < end; ++c) {
    project_physically<D, kScaled>(problem_, c, prepared_->weights.arm_of(c), s_);
  }
}

template <auto D, bool kScaled>
PieceSums ContactErrorEvaluator::sums(int begin, int end) const {
  PieceSums e;
  for (int c = begin; c < end; ++c) {
    const ContactTerms<double> terms =
        add_error_terms<D, kScaled>(problem_, c, s_, u_, prepared_->weights, e);
    if (terms.violation > e.worst_gap) {
      e.worst_gap = terms.violation;
      e.worst_epsilon = c;
    }
    if (terms.natural > e.worst_natural) {
      e.worst_natural = terms.natural;
      e.worst_eta = c;
    }
  }
  return e;
}

ContactArrays ContactErrorEvaluator::arrays() const {
  const auto& [w_nn, rho_nn, rho_nat, arm] = prepared_->weights;
  const double* const row_scale =
      problem_.row_scale.size() == 0 ? nullptr : problem_.row_scale.data();
  return {s_.data(),          u_.data(),   problem_.u_free.data(), row_scale,
          problem_.mu.data(), w_nn.data(), rho_nn.data(),          rho_nat.data()};
}

template <auto D, bool kScaled>
ContactError ContactErrorEvaluator::evaluate(const Eigen::Ref<const Vector>& s) {
  // Each step works on a piece while it is in the cache: large problems wait for memory.
  const int contacts = problem_.num_contacts();
  run_pieces(threads_, contacts, [&](int begin, int end) {
    s_.segment(begin * D, (end - begin) * D) = s.segment(begin * D, (end - begin) * D);
    if constexpr (D == 2 && !D.rolls) {
      project_on_plane_cones(arrays(), begin, end, s_.data());
    } else if constexpr (D == 3 && !D.rolls) {
      project_on_space_cones(arrays(), begin, end, s_.data());
    } else {
      project<D, kScaled>(begin, end);
    }
  });
  const bool packed = delassus_->is_packed();
  if (packed) {
    delassus_->move_bodies(s_);
  } else {
    delassus_->velocity(s_, u_);
  }
  std::vector<PieceSums> pieces(to_size((contacts + kPieceItems - 1) / kPieceItems));
  run_pieces(threads_, contacts, [&](int begin, int end) {
    if (packed) delassus_->contact_velocity(begin, end, u_);
    PieceSums& piece = pieces[to_size(begin / kPieceItems)];
    if constexpr (D == 2 && !D.rolls) {
      piece = sum_plane_errors(arrays(), begin, end);
    } else if constexpr (D == 3 && !D.rolls) {
      piece = sum_space_errors(arrays(), begin, end);
    } else {
      piece = sums<D, kScaled>(begin, end);
    }
  });
  PieceSums total;
  for (const PieceSums& piece : pieces) total.add(piece);

  total.free_energy = prepared_->free.free_energy;
  total.free_impulse2 = prepared_->free.free_impulse2;

  sums_ = total;
  ContactError e = error_of(total, share_);
  e.worst_epsilon = total.worst_epsilon;
  e.worst_eta = total.worst_eta;
  return e;
}

ErrorSums ContactErrorEvaluator::part(int contact) const {
  ErrorSums part = dispatch_form(problem_, [&](auto d, auto scaled) -> ErrorSums {
    return sums<d(), scaled()>(contact, contact + 1);
  });
  add_free_terms(problem_, prepared_->weights, contact, part);
  return part;
}

ContactError contact_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s) {
  if (s.size() != problem.num_rows()) {
    throw std::invalid_argument(fmt::format(
        "contact_error: {} rows of the impulse, {} of the problem", s.size(), problem.num_rows()));
  }
  return ContactErrorEvaluator(problem)(s);
}

ContactCount count_contacts(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  ContactCount count;
  dispatch_rows(p, [&](auto d) {
    constexpr ContactRows D = d();
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Local<D> x = local<D>(s, c);
      if (x[0] <= 0) {
        ++count.take_off;
      } else if (on_edge<D>(x, friction_of<D>(p, c))) {
        ++count.slip;
      } else {
        ++count.stick;
      }
    }
  });
  return count;
}

}  // namespace bipot
