#include "bench/measure/reference_solution.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/measure/cpu_limit.h"
#include "bench/report/json_output.h"
#include "core/file_error.h"
#include "core/files/atomic_file.h"
#include "core/problem/delassus.h"
#include "core/problem/sparse_factor.h"
#include "core/types.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

// A rank test by dense QR stays below a second up to here.
constexpr int kMaxRankRows = 600;

/// 0/0 is 0 (nothing to get wrong), x/0 is undefined.
double relative(double error, double reference) {
  if (error == 0) return 0;
  return reference > 0 ? error / reference : kNaN;
}

/// sᵀ W s of the problem's W, in the form that keeps it non-negative where there is one.
double energy_product(const ContactProblem& p, const DelassusOperator& delassus, const Vector& s) {
  if (p.has_velocities() && is_diagonal(p.A)) {
    const Vector x = p.H * s;
    return x.cwiseAbs2().cwiseQuotient(Vector(p.A.diagonal())).sum();
  }
  Vector u(p.num_rows());
  delassus.apply(s, u);
  return std::max(0.0, s.dot(u));  // rounded data of other codes: W may be slightly indefinite
}

double largest_impulse(int dim, const Vector& s) {
  double largest = 0;
  for (Eigen::Index row = 0; row < s.size(); row += dim) {
    largest = std::max(largest, s.segment(row, dim).norm());
  }
  return largest;
}

/// True when each normal pushes one body or two with unit forces, the bodies laid out as `rows`
/// says.
bool has_unit_normals(const ContactProblem& p, const BodyRows& rows) {
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double scale = p.row_scale.size() != 0 ? p.row_scale[c * p.dim] : 1.0;
    int body = -1;
    double squared = 0;
    const auto is_unit = [&] { return body < 0 || std::abs(std::sqrt(squared) - 1) < 1e-6; };
    for (SparseMatrix::InnerIterator it(p.H, c * p.dim); it; ++it) {
      const int row = static_cast<int>(it.row());
      if (row >= rows.bodies * rows.per_body) break;
      if (row / rows.per_body != body) {
        if (!is_unit()) return false;
        body = row / rows.per_body;
        squared = 0;
      }
      if (row % rows.per_body < rows.translations) squared += std::pow(scale * it.value(), 2);
    }
    if (body < 0 || !is_unit()) return false;
  }
  return true;
}

/// True when W is regular by a rank-revealing QR; false for large problems, where it is not asked.
bool has_unique_forces(const ContactProblem& p) {
  const int rows = p.num_rows();
  if (rows == 0 || rows > kMaxRankRows) return false;
  if (p.has_velocities() && rows > p.num_dofs()) return false;
  const Eigen::MatrixXd W =
      p.has_delassus() ? Eigen::MatrixXd(p.W) : Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim));
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(W);
  qr.setThreshold(1e-10);
  return qr.rank() == rows;
}

SolveStatus parse_status(const std::string& text) {
  for (int i = 0; i <= static_cast<int>(SolveStatus::kInvalidInput); ++i) {
    if (to_string(static_cast<SolveStatus>(i)) == text) return static_cast<SolveStatus>(i);
  }
  return SolveStatus::kNotRun;
}

}  // namespace

ReferenceSolution find_reference(const ComparisonProblem& given, double time_limit, double target,
                                 LimitOn limit_on) {
  const double witness = std::max(ReferenceSolution::kTrusted, 10 * target);
  const ContactProblem& problem = given.problem;
  ReferenceSolution best;
  best.origin = given.origin;
  best.contacts = problem.num_contacts();
  best.dim = problem.dim;
  best.dofs = problem.num_dofs();
  best.s = Vector::Zero(problem.num_rows());
  double best_error = kInfinity;
  std::vector<Vector> trusted;
  const DelassusOperator delassus(problem);
  // On large problems round-off stands in the way of 1e-12, newton is the slowest, and a witness
  // that sweeps is found at once.
  const bool large = problem.num_contacts() > ReferenceSolution::kLarge;
  const double enough = large ? 10 * target : target;
  const std::vector<const char*> names = large ? std::vector{"auto", "apgd", "ipm", "newton"}
                                               : std::vector{"auto", "newton", "ipm", "apgd"};
  for (const char* name : names) {
    const SolverEntry* entry = find_solver(name);
    if (entry == nullptr) continue;
    SolverOptions options;
    options.tol = target;
    options.time_limit = time_limit;
    CpuLimit limit(time_limit);
    if (limit_on == LimitOn::kCpu) {
      options.time_limit *= CpuLimit::kWallFactor;
      options.cancelled = [&limit] { return limit(); };
    }
    SolveResult result = solve(*entry, problem, options);
    if (limit.reached() && !is_success(result.status)) result.status = SolveStatus::kTimeLimit;
    ReferenceAttempt attempt{name, result.status, kNaN,
                             result.setup_seconds + result.solve_seconds};
    if (result.s.size() == problem.num_rows() && result.status != SolveStatus::kInvalidInput) {
      const ContactError error = contact_error(problem, result.s);
      attempt.guarded = error.guarded();
      if (error.guarded() < best_error) {
        best_error = error.guarded();
        best.solver = name;
        best.s = result.s;
        best.error = error;
      }
      if (error.guarded() <= witness) trusted.push_back(result.s);
    }
    best.attempts.push_back(attempt);
    if (best_error <= enough && trusted.size() >= 2) break;
  }
  if (trusted.size() >= 2) {
    const double scale = std::sqrt(energy_product(problem, delassus, best.s));
    best.velocity_spread = 0;
    for (const Vector& s : trusted) {
      const double apart = std::sqrt(energy_product(problem, delassus, s - best.s));
      best.velocity_spread = std::max(best.velocity_spread, relative(apart, scale));
    }
  }
  return best;
}

std::optional<BodyRows> find_body_rows(const ContactProblem& p) {
  if (!p.has_velocities()) return std::nullopt;
  BodyRows rows;
  rows.per_body = p.dim == 1 ? 2 : p.dim == 2 ? 3 : 6;
  rows.translations = p.dim == 1 ? 2 : p.dim;
  // A few walls' rows could stand where another body's would: their number is searched.
  constexpr int kMaxWalls = 24;
  for (rows.walls = p.num_dofs() % rows.per_body; rows.walls <= std::min(kMaxWalls, p.num_dofs());
       rows.walls += rows.per_body) {
    rows.bodies = (p.num_dofs() - rows.walls) / rows.per_body;
    if (has_unit_normals(p, rows)) return rows;
  }
  return std::nullopt;
}

double TrueErrorEvaluator::largest_resultant(const Vector& s) const {
  const Vector x = given_.problem.H * s;
  const BodyRows& rows = *body_rows_;
  double largest = 0;
  for (int b = 0; b < rows.bodies; ++b) {
    largest = std::max(largest, x.segment(b * rows.per_body, rows.translations).norm());
  }
  if (rows.walls > 0) largest = std::max(largest, x.tail(rows.walls).cwiseAbs().maxCoeff());
  return largest;
}

TrueErrorEvaluator::TrueErrorEvaluator(const ComparisonProblem& problem,
                                       const ReferenceSolution& reference)
    : given_(problem), reference_(reference), evaluate_(problem.problem) {
  const ContactProblem& p = problem.problem;
  reference_norm_ = std::sqrt(energy_product(p, evaluate_.delassus(), reference.s));
  reference_impulse_ = largest_impulse(p.dim, reference.s);
  body_rows_ = find_body_rows(p);
  if (body_rows_) reference_force_ = largest_resultant(reference.s);
  reference_dissipated_ = dissipated(reference.s);
  unique_ = has_unique_forces(p);
}

/// Kinetic energy that the impulses take out of the free motion, -s·(½ W s + b). With bodies given,
/// b = Hᵀ v_free, so that neither restitution nor moving walls enter; else b = u_free.
double TrueErrorEvaluator::dissipated(const Vector& s) const {
  const ContactProblem& p = given_.problem;
  const double linear = p.has_velocities() ? Vector(p.H * s).dot(p.v_free) : s.dot(p.u_free);
  return -(0.5 * energy_product(p, evaluate_.delassus(), s) + linear);
}

TrueError TrueErrorEvaluator::operator()(const Vector& s) const {
  const ContactProblem& p = given_.problem;
  TrueError error;
  if (s.size() != p.num_rows()) return error;
  const Vector difference = s - reference_.s;
  error.velocity =
      relative(std::sqrt(energy_product(p, evaluate_.delassus(), difference)), reference_norm_);
  if (body_rows_) error.force = relative(largest_resultant(difference), reference_force_);
  if (unique_)
    error.contact_force = relative(largest_impulse(p.dim, difference), reference_impulse_);
  evaluate_(s);
  error.penetration_velocity = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double scale = p.row_scale.size() != 0 ? p.row_scale[c * p.dim] : 1.0;
    error.penetration_velocity =
        std::max(error.penetration_velocity, -evaluate_.velocity()[c * p.dim] / scale);
  }
  error.penetration = error.penetration_velocity * given_.step / given_.smallest_radius;
  error.dissipated = dissipated(s);
  error.energy =
      relative(std::abs(error.dissipated - reference_dissipated_), std::abs(reference_dissipated_));
  return error;
}

void write_reference(const std::filesystem::path& path, const std::string& problem,
                     const ReferenceSolution& reference) {
  const auto number = [](double x) {
    return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json j{
      {"problem", problem},   {"origin", reference.origin}, {"contacts", reference.contacts},
      {"dim", reference.dim}, {"dofs", reference.dofs},     {"solver", reference.solver}};
  add_error(j, reference.error);
  j["velocity_spread"] = number(reference.velocity_spread);
  j["attempts"] = nlohmann::ordered_json::array();
  for (const ReferenceAttempt& a : reference.attempts) {
    j["attempts"].push_back({{"solver", a.solver},
                             {"status", to_string(a.status)},
                             {"guarded", number(a.guarded)},
                             {"seconds", a.seconds}});
  }
  j["s"] = std::vector<double>(reference.s.begin(), reference.s.end());
  AtomicFile file(path);
  std::ofstream out(file.draft());
  out << j.dump() << '\n';
  out.close();
  if (!out) throw FileError(path, "", "cannot be written");
  file.commit();
}

ReferenceSolution read_reference(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) throw FileError(path, "", "cannot be opened");
  try {
    const auto j = nlohmann::json::parse(in);
    const auto number = [](const nlohmann::json& x) {
      return x.is_null() ? kNaN : x.get<double>();
    };
    ReferenceSolution reference;
    reference.origin = j.at("origin");
    reference.contacts = j.at("contacts");
    reference.dim = j.at("dim");
    reference.dofs = j.at("dofs");
    reference.solver = j.at("solver");
    reference.error.epsilon = number(j.at("epsilon"));
    reference.error.eta = number(j.at("eta"));
    reference.error.raw42 = number(j.at("epsilon_raw"));
    reference.error.natural_map = number(j.at("natural_map"));
    reference.velocity_spread = number(j.at("velocity_spread"));
    for (const auto& a : j.at("attempts")) {
      reference.attempts.push_back(
          {a.at("solver"), parse_status(a.at("status")), number(a.at("guarded")), a.at("seconds")});
    }
    const std::vector<double> s = j.at("s");
    reference.s = Eigen::Map<const Vector>(s.data(), static_cast<Eigen::Index>(s.size()));
    return reference;
  } catch (const nlohmann::json::exception& e) {
    throw FileError(path, "", e.what());
  }
}

}  // namespace bipot
