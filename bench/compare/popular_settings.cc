#include "bench/compare/popular_settings.h"

#include <fmt/format.h>

#include "bench/measure/limited_solve.h"
#include "bench/measure/peer_map.h"
#include "solvers/kernels/local_coulomb.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

constexpr double kReferenceTol = 1e-10;
constexpr int kLongestRun = 3000;     // iterations, for the meaning of tolerances
constexpr double kNeverMet = 1e-300;  // of a solver that another test stops

/// The test of a setting on consecutive iterates, and what is kept of them.
class SettingWatch {
 public:
  /// `to_end`: nothing is asked for after the setting's end.
  SettingWatch(const PopularSetting& setting, const ContactProblem& p, double time_limit,
               bool to_end = false)
      : setting_(setting),
        to_end_(to_end),
        p_(p),
        delassus_(p),
        evaluate_(p),
        limit_(time_limit),
        before_(Vector::Zero(p.num_rows())),
        slip_(Vector::Zero(p.num_contacts())) {
    for (int c = 0; setting.test == PopularSetting::Test::kQuadratic && c < p.num_contacts(); ++c) {
      blocks_.push_back(delassus_.diagonal_block(c));
    }
  }

  /// After iteration k, from 1 on. True: nothing more is asked for.
  bool see(int k, const Vector& s) {
    const bool tested = setting_.test != PopularSetting::Test::kNone && k % setting_.every == 0;
    const double own = tested ? measure(s) : kNaN;
    before_ = s;
    if (row_.end.empty()) {
      row_.iterations = k;
      s_ = s;
      row_.own = own;
      if (own <= setting_.tol) row_.end = "test";
      if (row_.end.empty() && k >= setting_.most) row_.end = "most iterations";
      if (row_.end.empty() && limit_()) row_.end = "time limit";
    }
    bool all = true;
    for (std::size_t i = 0; i < SettingStudy::kTolerances.size(); ++i) {
      double& reached = row_.at_tolerance[i];
      if (std::isnan(reached) && own <= SettingStudy::kTolerances[i]) {
        reached = evaluate_(s).guarded();
      }
      all = all && !std::isnan(reached);
    }
    done_ = !row_.end.empty() && (to_end_ || setting_.test == PopularSetting::Test::kNone || all ||
                                  k >= kLongestRun || limit_());
    return done_;
  }
  bool done() const { return done_; }

  /// The impulse at the end, once finish() was called.
  const Vector& impulse() const { return s_; }

  /// The row, once the solver has ended with `last`.
  SettingStudy::Row finish(const SolveResult& last, const TrueErrorEvaluator* true_error) {
    if (row_.end.empty()) {  // it ended by itself
      row_.end = to_string(last.status);
      row_.iterations = last.iterations;
      s_ = last.s;
    }
    row_.code = setting_.code;
    row_.contacts = p_.num_contacts();
    row_.dim = p_.dim;
    row_.error = evaluate_(s_);
    if (true_error != nullptr) row_.true_error = (*true_error)(s_);
    return row_;
  }

 private:
  /// mu |u_t| of each contact.
  Vector slip_speed(const Vector& s) {
    delassus_.velocity(s, u_);
    Vector slip(p_.num_contacts());
    for (int c = 0; c < p_.num_contacts(); ++c) {
      slip[c] = p_.mu[c] * u_.segment(c * p_.dim + 1, p_.dim - 1).norm();
    }
    return slip;
  }

  double measure(const Vector& s) {
    switch (setting_.test) {
      case PopularSetting::Test::kNaturalMap:
        return peer_natural_map(p_, s);
      case PopularSetting::Test::kQuadratic:
        return dispatch_dim(p_.dim, [&](auto d) { return quadratic_norm<d()>(s); });
      case PopularSetting::Test::kAbsolute:
        return dispatch_dim(p_.dim, [&](auto d) { return absolute_residual<d()>(s); });
      case PopularSetting::Test::kFixedPoint: {
        if (p_.dim == 1) break;  // without friction no slip settles
        const Vector slip = slip_speed(s);
        const double own = (slip - slip_).norm() / (slip.norm() + 1);
        slip_ = slip;
        return own;
      }
      case PopularSetting::Test::kNone:
        break;
    }
    return kNaN;
  }

  /// With x, the impulse of each contact alone where all others stay, and DV = W_cc (s - x).
  template <int D>
  double quadratic_norm(const Vector& s) {
    delassus_.velocity(s, u_);
    double change = 0, weighted = 0, work = 0, size = 0, energy = 0;
    int active = 0;
    for (int c = 0; c < p_.num_contacts(); ++c) {
      LocalProblem<D> alone = local_problem<D>(blocks_[to_size(c)], p_.mu[c]);
      const Local<D> now = local<D>(s, c);
      alone.q = local<D>(u_, c) - alone.w * now;
      Local<D> x = now;
      solve_local(alone, x);
      const Local<D> by_now = alone.w * now, by_x = alone.w * x;
      const Local<D> dv = by_now - by_x, mean = 0.5 * (now + x);
      if (mean.squaredNorm() > 0) ++active;
      change += dv.squaredNorm();
      weighted += dv.squaredNorm() * mean.squaredNorm();
      work += mean.dot(dv);
      size += 0.5 * (by_now.squaredNorm() + by_x.squaredNorm());
      energy += 0.5 * (now.dot(by_now) + x.dot(by_x));
    }
    if (!(energy > 0)) return 0;  // nothing pushes, and nothing has to
    return std::max(
        {std::sqrt(change / size), std::sqrt(active * weighted) / energy, std::abs(work) / energy});
  }

  template <int D>
  double absolute_residual(const Vector& s) {
    delassus_.velocity(s, u_);
    double largest = (s - before_).cwiseAbs().maxCoeff();
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> u_hat = de_saxce_velocity<D>(local<D>(u_, c), p_.mu[c]);
      // Moreau: û - P_K*(û) = -P_K(-û).
      const Local<D> outside = project_coulomb_cone<D>(Local<D>(-u_hat), p_.mu[c]);
      largest =
          std::max({largest, outside.cwiseAbs().maxCoeff(), std::abs(local<D>(s, c).dot(u_hat))});
    }
    return largest;
  }

  const PopularSetting& setting_;
  const bool to_end_;
  const ContactProblem& p_;
  const DelassusOperator delassus_;
  ContactErrorEvaluator evaluate_;
  CpuLimit limit_;
  std::vector<Eigen::MatrixXd> blocks_;  // W_cc
  Vector before_, slip_, u_, s_;
  SettingStudy::Row row_;
  bool done_ = false;
};

/// A solver whose iterates are shown to the watch: each is judged, and the space of the run then
/// holds it.
SolveResult run_watched(const PopularSetting& setting, const ContactProblem& p, const Vector& s0,
                        SettingWatch& watch, const SettingStudy::Options& options) {
  SolverEntry entry = require_solver(setting.solver);
  SolveRun* running = nullptr;
  entry.run = [&, run_row = entry.run](SolveRun& run) {
    running = &run;
    run.judge_every_iteration();
    run_row(run);
  };
  SolverOptions solver{.tol = kNeverMet,
                       .max_iterations = std::max(setting.most, kLongestRun),
                       .s0 = s0,
                       .parameters = setting.parameters};
  solver.on_iteration = [&](const IterationRecord& record) {
    if (record.iteration > 0 && !watch.done()) {
      watch.see(record.iteration, running->space().impulse());
    }
  };
  solver.cancelled = [&] { return watch.done() || options.watch.stopped(); };
  return solve(entry, p, solver);
}

}  // namespace

std::string to_string(PopularSetting::Test test) {
  constexpr const char* kNames[] = {"number of iterations", "natural map (Siconos)",
                                    "quadratic norm (LMGC90)", "absolute residuals (Kamino)",
                                    "fixed point (SCoPI)"};
  return kNames[static_cast<int>(test)];
}

const std::vector<PopularSetting>& popular_settings() {
  static const std::vector<PopularSetting> settings = {
      {.code = "Siconos, its benchmark",
       .rule = "natural map 1e-2, 100 sweeps",
       .solver = "pgs",
       .parameters = {{"local", "exact"}},
       .test = PopularSetting::Test::kNaturalMap,
       .tol = 1e-2,
       .most = 100},
      {.code = "waLBerla",
       .rule = "10 sweeps, relaxation 0.75",
       .solver = "pgs",
       .parameters = {{"omega", "0.75"}},
       .most = 10},
      {.code = "LMGC90",
       .rule = "quadratic norm 1.67e-4, every 50 sweeps",
       .solver = "pgs",
       .parameters = {{"local", "exact"}},
       .test = PopularSetting::Test::kQuadratic,
       .tol = 1.67e-4,
       .most = 51000,
       .every = 50},
      {.code = "Chrono", .rule = "50 iterations, convex law", .solver = "convex", .most = 50},
      {.code = "SCoPI",
       .rule = "fixed point 1e-2, 20 rounds",
       .solver = "apgd",
       .parameters = {{"map", "followed"}, {"hold", "80"}},
       .test = PopularSetting::Test::kFixedPoint,
       .tol = 1e-2,
       .most = 20 * 80,
       .every = 80},
      {.code = "Kamino",
       .rule = "three residuals 1e-6, 200 iterations",
       .solver = "admm",
       .parameters = {{"rho", "1"}},
       .test = PopularSetting::Test::kAbsolute,
       .tol = 1e-6,
       .most = 200},
      {.code = "game engine, 8", .rule = "8 sweeps", .solver = "pgs", .most = 8},
      {.code = "game engine, 30", .rule = "30 sweeps", .solver = "pgs", .most = 30}};
  return settings;
}

SettingStudy::Row run_popular(const PopularSetting& setting, const TestProblem& given,
                              const TrueErrorEvaluator* true_error,
                              const SettingStudy::Options& options) {
  const ContactProblem& p = given.problem;
  SettingWatch watch(setting, p, options.time_limit);
  const Vector s0 = options.warm ? given.start : Vector();
  return watch.finish(run_watched(setting, p, s0, watch, options), true_error);
}

StepSolver popular_step_solver(const PopularSetting& setting,
                               const SettingStudy::Options& options) {
  return [&setting, options](const ContactProblem& p, const Vector& s0) {
    SettingWatch watch(setting, p, options.time_limit, true);
    const SettingStudy::Row row =
        watch.finish(run_watched(setting, p, s0, watch, options), nullptr);
    return StepSolution{
        .converged = row.end == "test" || setting.test == PopularSetting::Test::kNone,
        .message = row.end,
        .s = watch.impulse(),
        .error = row.error,
        .iterations = row.iterations};
  };
}

SettingStudy study_settings(const std::vector<ProblemSource>& sources,
                            const SettingStudy::Options& options) {
  SettingStudy study;
  const long total = static_cast<long>(sources.size() * popular_settings().size());
  for (const ProblemSource& source : sources) {
    std::optional<TestProblem> problem;
    try {
      problem = source.load();
      const std::string defect = validate(problem->problem);
      if (!defect.empty()) throw std::invalid_argument(defect);
      if (problem->problem.rolls()) {
        throw std::invalid_argument("popular settings know no rolling friction");
      }
    } catch (const Interrupted&) {  // in the run that makes the problem
      return study;
    } catch (const std::exception& e) {
      study.defects.push_back(fmt::format("{}: {}", source.name, e.what()));
      continue;
    }
    const ReferenceSolution reference = find_reference(*problem, options.reference_time_limit,
                                                       kReferenceTol, options.watch.interrupted);
    std::optional<TrueErrorEvaluator> true_error;
    if (reference.error.guarded() <= ReferenceSolution::kTrusted) {
      true_error.emplace(*problem, reference);
    }
    for (const PopularSetting& setting : popular_settings()) {
      if (options.watch.stopped()) return study;
      SettingStudy::Row row =
          run_popular(setting, *problem, true_error ? &*true_error : nullptr, options);
      if (options.watch.stopped()) return study;
      row.problem = source.name;
      study.rows.push_back(row);
      options.watch.tell(static_cast<long>(study.rows.size()), total,
                         fmt::format("{} {}", row.problem, row.code));
    }
  }
  if (options.overlaps) study.overlaps = popular_overlaps(options);
  study.complete = !options.watch.stopped();
  return study;
}

}  // namespace bipot
