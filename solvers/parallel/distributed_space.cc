#include "solvers/parallel/distributed_space.h"

#include <algorithm>

#include "solvers/parallel/whole_problem.h"
#include "solvers/solve.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

constexpr double ErrorSums::*kErrorFields[] = {&ErrorSums::friction,    &ErrorSums::gap,
                                               &ErrorSums::gap_clipped, &ErrorSums::penetration,
                                               &ErrorSums::natural,     &ErrorSums::moved,
                                               &ErrorSums::natural_rel, &ErrorSums::impulse2,
                                               &ErrorSums::free_energy, &ErrorSums::free_impulse2};
constexpr std::size_t kFields = std::size(kErrorFields);

}  // namespace

DistributedSpace::DistributedSpace(const ProblemPiece& piece, ProcessGroup& group, bool exact,
                                   WholeProblem* whole, int shared_factor_rows)
    : piece_(piece),
      group_(group),
      exact_(exact),
      exchange_(group.make_exchange(piece.own.num_contacts(), piece.copies)),
      inverse_mass_(piece.with_halo.A.diagonal().cwiseInverse()),
      velocity_(piece.with_halo.num_dofs()),
      any_everywhere_(!piece.everywhere_inverse_mass.empty()),
      momentum_(piece.everywhere_inverse_mass.size()),
      halo_(piece.halo.size() * to_size(piece.own.dim)),
      s_all_(Vector::Zero(piece.with_halo.num_rows())),
      u_all_(Vector::Zero(piece.with_halo.num_rows())),
      given_whole_(whole),
      shared_factor_rows_(shared_factor_rows) {
  const ContactProblem& p = piece.with_halo;
  if (piece.packed && p.num_contacts() > 0) packed_.emplace(p, DelassusOperator::Form::kTwoPass);
  // All use the packed form or none does: it rounds differently.
  all_packed_ = !group.any(p.num_contacts() > 0 && !(packed_ && packed_->is_packed()));
  if (!all_packed_) packed_.reset();
  const Vector inverse_own = piece.own.A.diagonal().cwiseInverse();
  diagonal_ = Vector::Zero(piece.own.num_rows());
  for (int i = 0; i < piece.own.num_rows(); ++i) {
    for (SparseMatrix::InnerIterator it(piece.own.H, i); it; ++it) {
      diagonal_[i] += it.value() * it.value() * inverse_own[it.row()];
    }
  }
  weights_ = error_weights(piece.own, diagonal_);
}

DistributedSpace::~DistributedSpace() = default;

const std::vector<double>& DistributedSpace::halo(const Vector& s) {
  exchange_->copy({s.data(), to_size(s.size())}, halo_, piece_.own.dim);
  return halo_;
}

/// s_all_ <- the impulses of the owned contacts and of the halo.
void DistributedSpace::fill(const Vector& s) {
  const int d = piece_.own.dim;
  halo(s);
  const auto put = [&](const std::vector<int>& places, const double* from) {
    for (const int place : places) {
      for (int k = 0; k < d; ++k) s_all_[place * d + k] = *from++;
    }
  };
  put(piece_.owned, s.data());
  put(piece_.halo, halo_.data());
}

const std::vector<double>& DistributedSpace::everywhere_momentum(const Vector& s) {
  if (!any_everywhere_) return momentum_;
  if (exact_) {
    std::vector<ExactSum> sums(momentum_.size());
    for (const auto& e : piece_.everywhere) sums[to_size(e.dof)] += e.value * s[e.row];
    totals(sums, momentum_);
    return momentum_;
  }
  std::fill(momentum_.begin(), momentum_.end(), 0.0);
  for (const auto& e : piece_.everywhere) momentum_[to_size(e.dof)] += e.value * s[e.row];
  group_.sum(momentum_);
  return momentum_;
}

/// u_all_ <- W s_all_, valid in the rows of the owned contacts.
void DistributedSpace::product() {
  if (packed_) {
    packed_->apply(s_all_, u_all_);
    return;
  }
  const ContactProblem& p = piece_.with_halo;
  velocity_.noalias() = p.H * s_all_;
  velocity_.array() *= inverse_mass_.array();
  u_all_.noalias() = p.H.transpose() * velocity_;
}

void DistributedSpace::apply(const Vector& s, Vector& u) {
  fill(s);
  product();
  const int d = piece_.own.dim;
  u.resize(s.size());
  double* to = u.data();
  for (const int place : piece_.owned) {
    for (int k = 0; k < d; ++k) *to++ = u_all_[place * d + k];
  }
  everywhere_momentum(s);
  for (const auto& e : piece_.everywhere) {
    const std::size_t dof = to_size(e.dof);
    u[e.row] += e.value * (piece_.everywhere_inverse_mass[dof] * momentum_[dof]);
  }
}

void DistributedSpace::with_halo(const Vector& s, Vector& all) {
  fill(s);
  all = s_all_;
}

void DistributedSpace::velocity(const Vector& s, Vector& u) {
  apply(s, u);
  u += piece_.own.u_free;
}

double DistributedSpace::norm_bound(const Vector& scale) {
  const int d = piece_.own.dim;
  Vector all;
  with_halo(scale, all);
  Vector sums = Vector::Zero(scale.size());
  if (piece_.with_halo.has_velocities()) {
    const SparseRows W = assemble_delassus(piece_.with_halo.A, piece_.with_halo.H, d);
    const Vector absolute = SparseRows(W.cwiseAbs()) * all;
    for (std::size_t k = 0; k < piece_.owned.size(); ++k) {
      sums.segment(static_cast<Eigen::Index>(k) * d, d) = absolute.segment(piece_.owned[k] * d, d);
    }
  }
  std::vector<double> pushes(piece_.everywhere_inverse_mass.size(), 0.0);
  for (const auto& e : piece_.everywhere) {
    pushes[to_size(e.dof)] += std::abs(e.value) * scale[e.row];
  }
  if (!pushes.empty()) sum(pushes);
  for (const auto& e : piece_.everywhere) {
    const std::size_t dof = to_size(e.dof);
    sums[e.row] += std::abs(e.value) * piece_.everywhere_inverse_mass[dof] * pushes[dof];
  }
  double bound = sums.size() > 0 ? sums.cwiseProduct(scale).maxCoeff() : 0.0;
  largest({&bound, 1});
  return bound;
}

double DistributedSpace::dot(const Vector& a, const Vector& b) {
  double value = 0;
  if (exact_) {
    ExactSum sum;
    add_products(a, b, sum);
    totals({&sum, 1}, {&value, 1});
  } else {
    value = a.dot(b);
    group_.sum({&value, 1});
  }
  return value;
}

Vector DistributedSpace::products(const Eigen::MatrixXd& columns, int size, const Vector& f) {
  Vector dots = Vector::Zero(size);
  if (exact_) {
    std::vector<ExactSum> sums(to_size(size));
    for (int k = 0; k < size; ++k) add_products(columns.col(k), f, sums[to_size(k)]);
    totals(sums, {dots.data(), to_size(size)});
  } else {
    dots = columns.leftCols(size).transpose() * f;
    sum({dots.data(), to_size(size)});
  }
  return dots;
}

/// Sums of the contacts here, or with `exact` the same with each contact's terms added to these.
ErrorSums DistributedSpace::local_sums(ExactSum* exact) {
  const ContactProblem& p = problem();
  worst_ = {};
  ErrorSums sums;
  dispatch_form(p, [&](auto d, auto scaled) {
    for (int c = 0; c < p.num_contacts(); ++c) {
      ErrorSums part;
      ErrorSums& to = exact != nullptr ? part : sums;
      const ContactTerms terms = add_error_terms<d(), scaled()>(p, c, s_, u_, weights_, to);
      add_free_terms(p, weights_, c, to);
      if (exact != nullptr) {
        for (std::size_t k = 0; k < kFields; ++k) exact[k] += part.*kErrorFields[k];
      }
      if (terms.violation > worst_.violation)
        worst_ = {terms.violation, worst_.natural, c, worst_.eta};
      if (terms.natural > worst_.natural)
        worst_ = {worst_.violation, terms.natural, worst_.epsilon, c};
    }
  });
  return sums;
}

ContactError DistributedSpace::error(const Eigen::Ref<const Vector>& s, std::span<double> more) {
  const ContactProblem& p = problem();
  s_ = s;
  dispatch_form(p, [&](auto d, auto scaled) {
    for (int c = 0; c < p.num_contacts(); ++c) {
      project_physically<d(), scaled()>(p, c, weights_.arm_of(c), s_);
    }
  });
  velocity(s_, u_);
  std::vector<double> values(kFields + more.size());
  if (exact_) {
    std::vector<ExactSum> sums(values.size());
    local_sums(sums.data());
    for (std::size_t k = 0; k < more.size(); ++k) sums[kFields + k] += more[k];
    totals(sums, values);
  } else {
    const ErrorSums local = local_sums(nullptr);
    for (std::size_t k = 0; k < kFields; ++k) values[k] = local.*kErrorFields[k];
    std::copy(more.begin(), more.end(), values.begin() + kFields);
    sum(values);
  }
  ErrorSums whole;
  for (std::size_t k = 0; k < kFields; ++k) whole.*kErrorFields[k] = values[k];
  std::copy(values.begin() + kFields, values.end(), more.begin());
  return error_of(whole);
}

/// The whole's number of the contact with the largest value; of equal ones the smallest number.
int DistributedSpace::number_of_largest(double value, int contact) {
  double most = value;
  largest({&most, 1});
  double number = -kInfinity;
  if (contact >= 0 && value == most) number = -piece_.number[to_size(contact)];
  largest({&number, 1});
  return std::isfinite(number) ? static_cast<int>(-number) : -1;
}

void DistributedSpace::find_worst(ContactError& error) {
  error.worst_epsilon = number_of_largest(worst_.violation, worst_.epsilon);
  error.worst_eta = number_of_largest(worst_.natural, worst_.eta);
}

double DistributedSpace::energy_at_rest() {
  if (std::isnan(energy_at_rest_))
    energy_at_rest_ = error(Vector::Zero(problem().num_rows())).energy;
  return energy_at_rest_;
}

WholeProblem& DistributedSpace::whole_problem() {
  if (given_whole_ != nullptr) return *given_whole_;
  if (!gathered_) gathered_ = std::make_unique<GatheredWhole>(*this);
  return *gathered_;
}

ProvedClaim DistributedSpace::prove(const SolverOptions& options, const Eigen::Ref<const Vector>& s,
                                    const ContactError& error) {
  if (options.stop != StopTest::kGuarded) return {};
  return whole_problem().claim(options, s, error);
}

SolveResult DistributedSpace::solve_on_root(const SolverEntry& entry, const SolverOptions& given) {
  SolverOptions options = given;
  options.execution.threads = group_.root_threads();
  const bool started = group_.any(given.s0.size() > 0);
  options.s0 = started ? whole_problem().join(start_of(problem(), given)) : Vector();
  const bool shared = piece_.whole_contacts * piece_.own.dim >= shared_factor_rows_;
  const ContactProblem& whole = whole_problem().on_first();
  SolveResult result;
  bool systems = false;  // the solver asked who factors them
  group_.run_on_root([&](SystemFactor& factor) {
    const auto led = [&](SolveRun& run) {
      if (shared) run.set_factor(&factor);
      entry.run(run);
      systems = run.factor_was_asked();
    };
    result = solve(entry.with(led), whole, options);
  });
  // From the root process to all.
  const bool first = group_.rank() == 0;
  if (first && result.s.size() != whole.num_rows()) result.s = Vector::Zero(whole.num_rows());
  const double figures[] = {static_cast<double>(result.status),
                            static_cast<double>(result.iterations), result.setup_seconds,
                            result.solve_seconds, systems ? 1.0 : 0.0};
  const std::vector<double> known =
      group_.gather(first ? std::span<const double>(figures) : std::span<const double>());
  result.message = group_.first_text(first ? result.message : std::string());
  result.message += shared && known[4] > 0 ? "; systems factored by all processes"
                                           : "; on the root process alone";
  result.status = static_cast<SolveStatus>(static_cast<int>(known[0]));
  result.iterations = static_cast<int>(known[1]);
  result.setup_seconds = known[2];
  result.solve_seconds = known[3];
  result.s = whole_problem().part(result.s);
  return result;
}

void DistributedSpace::totals(std::span<ExactSum> sums, std::span<double> values) {
  digits_.clear();
  for (ExactSum& sum : sums) {
    const auto part = sum.digits();
    digits_.insert(digits_.end(), part.begin(), part.end());
  }
  group_.sum(digits_);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const auto first = digits_.begin() + static_cast<std::ptrdiff_t>(k * ExactSum::kDigits);
    std::copy_n(first, ExactSum::kDigits, sums[k].digits().begin());
    values[k] = sums[k].value();
  }
}

}  // namespace bipot
