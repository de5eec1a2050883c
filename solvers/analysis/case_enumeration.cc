#include "solvers/analysis/case_enumeration.h"

#include <algorithm>
#include <cmath>

#include "core/linear/dense_factor.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

constexpr double kSlack = 1e-7;      // of the inequalities; the criterion decides on the candidates
constexpr double kSingular = 1e-11;  // relative pivots below count as zero

enum class Way { kOpen, kClosed, kStick, kLeft, kRight };

std::vector<Way> ways_of(const ContactProblem& p, int contact) {
  if (p.dim == 1 || p.mu[contact] == 0) return {Way::kOpen, Way::kClosed};
  return {Way::kOpen, Way::kStick, Way::kLeft, Way::kRight};
}

/// The unknowns of one case: s = basis x, and the rows of u that vanish.
struct CaseSystem {
  Eigen::MatrixXd basis;
  std::vector<Eigen::Index> rows;
};

CaseSystem system_of(const ContactProblem& p, const std::vector<Way>& ways) {
  const int d = p.dim;
  CaseSystem made{Eigen::MatrixXd::Zero(p.num_rows(), p.num_rows()), {}};
  Eigen::Index unknowns = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Way way = ways[to_size(c)];
    if (way == Way::kOpen) continue;
    made.basis(c * d, unknowns) = 1;
    made.rows.push_back(c * d);
    if (way == Way::kLeft) made.basis(c * d + 1, unknowns) = p.mu[c];
    if (way == Way::kRight) made.basis(c * d + 1, unknowns) = -p.mu[c];
    ++unknowns;
    if (way != Way::kStick) continue;
    made.basis(c * d + 1, unknowns++) = 1;
    made.rows.push_back(c * d + 1);
  }
  made.basis.conservativeResize(p.num_rows(), unknowns);
  return made;
}

bool obeys(const ContactProblem& p, const std::vector<Way>& ways, const Vector& s,
           const Vector& u) {
  const int d = p.dim;
  const double impulse = kSlack * s.cwiseAbs().maxCoeff();
  const double speed = kSlack * std::max(u.cwiseAbs().maxCoeff(), p.u_free.cwiseAbs().maxCoeff());
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Way way = ways[to_size(c)];
    if (s[c * d] < -impulse || u[c * d] < -speed) return false;
    if (d == 1) continue;
    const double s_t = s[c * d + 1], u_t = u[c * d + 1];
    if (way == Way::kStick && std::abs(s_t) > p.mu[c] * s[c * d] + impulse) return false;
    if (way == Way::kLeft && u_t > speed) return false;
    if (way == Way::kRight && u_t < -speed) return false;
  }
  return true;
}

}  // namespace

EnumeratedCases enumerate_cases(const ContactProblem& p, const std::function<bool()>& stopped) {
  EnumeratedCases found;
  if (p.dim > 2) return found;
  std::vector<std::vector<Way>> choices;
  double total = 1;
  for (int c = 0; c < p.num_contacts(); ++c) {
    choices.push_back(ways_of(p, c));
    total *= static_cast<double>(choices.back().size());
    if (total > kMostCases) return found;
  }
  const Eigen::MatrixXd w =
      p.has_delassus() ? Eigen::MatrixXd(p.W) : Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim));
  const double free = p.u_free.norm();
  for (int number = 0; number < static_cast<int>(total); ++number) {
    if (stopped()) return {};
    std::vector<Way> ways;
    int rest = number;
    for (const auto& choice : choices) {
      const int size = static_cast<int>(choice.size());
      ways.push_back(choice[to_size(rest % size)]);
      rest /= size;
    }
    ++found.cases;
    const CaseSystem system = system_of(p, ways);
    Vector s = Vector::Zero(p.num_rows());
    bool singular = false;
    if (!system.rows.empty()) {
      const Eigen::MatrixXd pushed = w * system.basis;
      const Eigen::MatrixXd a = pushed(system.rows, Eigen::all);
      const Vector b = -p.u_free(system.rows);
      const auto [x, rank] = least_norm_and_rank(a, b, kSingular);
      singular = rank < a.cols();
      if (singular && (a * x - b).norm() > kSlack * free) continue;  // no solution
      s = system.basis * x;
    }
    const Vector u = w * s + p.u_free;
    const bool answer = s.allFinite() && obeys(p, ways, s, u);
    if (answer) found.candidates.push_back(s);
    if (singular) ++(answer ? found.continua : found.undecided);
  }
  return found;
}

}  // namespace bipot
