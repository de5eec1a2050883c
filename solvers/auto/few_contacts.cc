#include "solvers/auto/few_contacts.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "solvers/kernels/local_coulomb.h"

namespace bipot {
namespace {

/// Sweeps converge at a rate that depends on the chain of contacts; other cases are left to pivots.
constexpr int kMostSweeps = 100;
/// Changes below this, relative to the largest impulse, are rounding.
constexpr double kLastChange = 64 * std::numeric_limits<double>::epsilon();

}  // namespace

FewContacts::FewContacts(const ContactProblem& problem, const DelassusOperator& delassus)
    : problem_(problem), delassus_(delassus) {
  if (!problem.has_delassus()) inverse_mass_ = problem.A.diagonal().cwiseInverse();
}

int FewContacts::operator()(std::span<const int> contacts, Vector& s) {
  if (problem_.rolls()) return 0;
  return dispatch_dim(problem_.dim, [&](auto d) {
    return contacts.size() == 1 ? single<d()>(contacts[0], s) : sweeps<d()>(contacts, s);
  });
}

/// W(row, column), from W or from the columns of H (A is diagonal if W is not given).
double FewContacts::entry(int row, int column) const {
  if (problem_.has_delassus()) return problem_.W.coeff(row, column);
  return delassus_entry(problem_.H, inverse_mass_, row, column);
}

template <int D>
int FewContacts::single(int contact, Vector& s) {
  LocalProblem<D> local = local_problem<D>(delassus_.diagonal_block(contact), problem_.mu[contact]);
  local.q = problem_.u_free.segment<D>(contact * D);
  Local<D> x = s.segment<D>(contact * D);
  if (!solve_local<D>(local, x)) return 0;
  s.segment<D>(contact * D) = x;
  return 1;
}

template <int D>
int FewContacts::sweeps(std::span<const int> contacts, Vector& s) {
  const int n = static_cast<int>(contacts.size()), m = n * D;
  const auto row = [&](int k) { return contacts[to_size(k / D)] * D + k % D; };
  Eigen::MatrixXd w(m, m);
  Vector x(m), u(m);
  for (int k = 0; k < m; ++k) {
    x[k] = s[row(k)];
    for (int l = 0; l < m; ++l) w(k, l) = entry(row(k), row(l));
  }
  u.noalias() = w * x;
  for (int k = 0; k < m; ++k) u[k] += problem_.u_free[row(k)];
  std::vector<LocalProblem<D>> blocks;
  blocks.reserve(to_size(n));
  for (int c = 0; c < n; ++c) {
    blocks.push_back(
        local_problem<D>(w.block<D, D>(c * D, c * D), problem_.mu[contacts[to_size(c)]]));
  }
  for (int sweep = 1; sweep <= kMostSweeps; ++sweep) {
    double change = 0;
    for (int c = 0; c < n; ++c) {
      LocalProblem<D>& block = blocks[to_size(c)];
      const Local<D> before = x.segment<D>(c * D);
      block.q = u.segment<D>(c * D) - block.w * before;
      Local<D> next = before;
      if (!solve_local<D>(block, next)) return 0;
      const Local<D> step = next - before;
      x.segment<D>(c * D) = next;
      u.noalias() += w.middleCols<D>(c * D) * step;
      change = std::max(change, step.template lpNorm<Eigen::Infinity>());
    }
    if (!(change <= kLastChange * x.lpNorm<Eigen::Infinity>())) continue;
    for (int k = 0; k < m; ++k) s[row(k)] = x[k];
    return sweep;
  }
  return 0;
}

}  // namespace bipot
