#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/base/stopwatch.h"
#include "solvers/auto/contact_islands.h"
#include "solvers/auto/few_contacts.h"
#include "solvers/auto/island_problem.h"
#include "solvers/auto/islands.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

// What the parts before the last may use up of the tolerance together with all that is settled, and
// by themselves: solvers/auto/islands.h.
constexpr double kShareBeforeLast = 0.5, kAloneFactor = 12;

// Islands of up to this many contacts, and of about one size, are tried together: making a problem
// of each takes as long as the sweeps that solve it.
constexpr std::size_t kGrouped = 200;

// A last island with this fraction of a large problem is not cut out: the copy costs much memory,
// and the others are settled and cost next to nothing.
constexpr double kNearlyAll = 0.9;
constexpr int kLargeCopy = 4000;

/// True if s = 0 obeys the law at all of these contacts: no bodies approach.
bool is_open(const ContactProblem& p, std::span<const int> contacts) {
  return std::all_of(contacts.begin(), contacts.end(),
                     [&](int c) { return p.u_free[static_cast<Eigen::Index>(c) * p.dim] >= 0; });
}

/// One solve, island by island.
class IslandRun {
 public:
  /// `best`: of an attempt on the whole, or empty.
  IslandRun(SolveRun& run, const IslandSolver& solver, const SolverOptions& options, Vector best,
            const ContactIslands& islands)
      : run_(run),
        solver_(solver),
        p_(run.problem()),
        options_(options),
        share_(run.whole().share()),
        best_(std::move(best)),
        islands_(islands),
        evaluate_(run.whole().evaluator()) {}

  /// Sets s = 0 on islands where that obeys the law, and keeps starts that are accurate enough.
  /// Returns the number of remaining contacts.
  int settle() {
    const ContactError error = evaluate_(start_of(p_, options_));
    s_ = evaluate_.impulse();
    total_ = evaluate_.sums();
    settled_ = share_.others;
    if (options_.on_iteration) {
      start_ = {.iteration = 0,
                .seconds = watch_.seconds(),
                .error = error,
                .count = [count = count_contacts(p_, s_)] { return count; }};
    }
    for (int k = 0; k < islands_.count(); ++k) {
      if (is_open(p_, islands_.of(k))) {
        ++open_;
        for (const int c : islands_.of(k)) s_.segment(c * p_.dim, p_.dim).setZero();
      } else if (settled(k)) {
        ++kept_;
      } else {
        left_.push_back(k);
      }
    }
    if (best_.size() != 0) together_ += keep_good(best_, left_);
    int contacts_left = 0;
    for (const int k : left_) contacts_left += static_cast<int>(islands_.of(k).size());
    return contacts_left;
  }

  /// Solves the islands that settle() left.
  SolveResult solve_left() {
    if (options_.on_iteration) options_.on_iteration(start_);
    solve_few();
    solve_groups();
    result_.setup_seconds = watch_.seconds();
    for (std::size_t k = 0; k < left_.size(); ++k) {
      // After a failure the whole cannot meet the tolerance: the last island is treated like the
      // others.
      const bool last = k + 1 == left_.size() && failed_ == 0;
      if (last && is_nearly_all(left_[k])) return on_the_whole(best_);
      if (!solve_island(left_[k], last)) break;
    }
    return finish();
  }

 private:
  /// How the island with these sums is judged. The free terms of M are those of the whole.
  ErrorShare share_of(int island, const ErrorSums& own, bool last) const {
    ErrorShare share;
    share.others = settled_;
    const auto rest = [](double all, double part) { return std::max(all - part, 0.0); };
    share.others.free_energy =
        share_.others.free_energy + rest(total_.free_energy, own.free_energy);
    share.others.free_impulse2 =
        share_.others.free_impulse2 + rest(total_.free_impulse2, own.free_impulse2);
    share.share = share_.share;
    if (last) return share;
    share.share *= kShareBeforeLast * islands_.start[to_size(island) + 1] / p_.num_contacts();
    share.alone = kAloneFactor;
    return share;
  }

  /// Of these contacts at the last evaluation; the free terms are always those of s = 0.
  ErrorSums sums_of(std::span<const int> contacts) const {
    ErrorSums sums;
    for (const int c : contacts) sums += evaluate_.part(c);
    return sums;
  }

  /// Marks the island as settled if its impulses of the last evaluation are accurate enough.
  bool settled(int island) {
    const ErrorSums own = sums_of(islands_.of(island));
    const ErrorShare share = share_of(island, own, false);
    ErrorSums whole = own;
    whole += share.others;
    const ContactError together = error_of(whole), alone = error_of(own);
    const auto within = [&](double with_others, double by_itself) {
      return with_others <= share.share * options_.tol || share.alone * by_itself <= options_.tol;
    };
    if (!within(together.epsilon, alone.epsilon) || !within(together.eta, alone.eta)) return false;
    settled_ += own;
    return true;
  }

  /// Takes these impulses on those of the islands where they are accurate enough, and leaves the
  /// others in the list. Returns the number of the former.
  int keep_good(const Vector& impulses, std::vector<int>& islands) {
    if (islands.empty()) return 0;
    evaluate_(impulses);
    const auto end = std::remove_if(islands.begin(), islands.end(), [&](int k) {
      if (!settled(k)) return false;
      for (const int c : islands_.of(k)) {
        s_.segment(c * p_.dim, p_.dim) = evaluate_.impulse().segment(c * p_.dim, p_.dim);
      }
      return true;
    });
    const auto kept = islands.end() - end;
    islands.erase(end, islands.end());
    return static_cast<int>(kept);
  }

  /// Solves islands of few contacts; the others remain.
  void solve_few() {
    std::vector<int> solved, others;
    FewContacts few(p_, evaluate_.delassus());
    for (const int k : left_) {
      const std::span<const int> contacts = islands_.of(k);
      const int size = static_cast<int>(contacts.size());
      const int sweeps = size <= kFewContacts ? few(contacts, s_) : 0;
      if (sweeps > 0) {
        solved.push_back(k);
        add_work(sweeps, size);
      } else {
        others.push_back(k);
      }
    }
    left_ = std::move(others);
    if (solved.empty()) return;
    few_ += keep_good(s_, solved);
    left_.insert(left_.end(), solved.begin(), solved.end());
    std::sort(left_.begin(), left_.end());
  }

  /// Tries the solver's attempt on islands of about one size at once, those without friction
  /// separately. If it fails, each is checked, and those that are not accurate enough remain, with
  /// their impulses. The last island always remains.
  void solve_groups() {
    // Sweeps over disks fill vectors; for other problems acceleration works better on each island.
    const bool pays = solver_.attempt && evaluate_.delassus().disks();
    if (!pays || best_.size() != 0 || left_.size() < 3) return;
    std::map<std::pair<int, bool>, std::vector<int>> groups;
    std::vector<int> left;
    for (std::size_t k = 0; k + 1 < left_.size(); ++k) {
      const std::span<const int> contacts = islands_.of(left_[k]);
      const bool friction =
          std::any_of(contacts.begin(), contacts.end(), [&](int c) { return p_.mu[c] != 0; });
      if (contacts.size() > kGrouped) {
        left.push_back(left_[k]);
      } else {
        groups[{std::bit_width(contacts.size()), friction}].push_back(left_[k]);
      }
    }
    left.push_back(left_.back());
    for (const auto& [kind, islands] : groups) solve_group(islands, left);
    std::sort(left.begin(), left.end());
    left_ = std::move(left);
  }

  /// One of these groups. Islands that are not settled are added to `left`.
  void solve_group(const std::vector<int>& islands, std::vector<int>& left) {
    if (islands.size() < 2 || time_left() <= 0) {
      left.insert(left.end(), islands.begin(), islands.end());
      return;
    }
    std::vector<int> contacts;
    for (const int k : islands) {
      contacts.insert(contacts.end(), islands_.of(k).begin(), islands_.of(k).end());
    }
    std::sort(contacts.begin(), contacts.end());
    const IslandProblem part = cut(contacts);
    WholeSpace space(part.problem, options_.execution.threads);
    const ErrorShare share = share_of(islands.back(), sums_of(contacts), false);
    SolveResult result;
    try {
      result = run_solver(run_.entry().with(solver_.attempt), space, inner_options(part), share);
    } catch (const std::exception& e) {
      result.message = e.what();
    }
    add_work(result.iterations, static_cast<int>(contacts.size()));
    const bool usable = result.s.size() == part.problem.num_rows() && result.s.allFinite();
    if (usable && is_success(result.status)) {
      part.scatter(result.s, p_.dim, s_);
      space.error(result.s);
      settled_ += space.evaluator().sums();
      together_ += static_cast<int>(islands.size());
      return;
    }
    if (!usable) {
      left.insert(left.end(), islands.begin(), islands.end());
      return;
    }
    if (tried_.size() == 0) tried_ = s_;
    part.scatter(result.s, p_.dim, tried_);
    std::vector<int> not_good = islands;
    together_ += keep_good(tried_, not_good);
    left.insert(left.end(), not_good.begin(), not_good.end());
    tried_of_.insert(not_good.begin(), not_good.end());
  }

  bool is_nearly_all(int island) const {
    const int size = static_cast<int>(islands_.of(island).size());
    return size >= kLargeCopy && size >= kNearlyAll * p_.num_contacts();
  }

  IslandProblem cut(std::span<const int> contacts) {
    if (!cut_) cut_.emplace(p_);
    return (*cut_)(contacts);
  }
  double time_left() const { return options_.time_limit - watch_.seconds(); }

  /// For the solver on a part.
  SolverOptions inner_options(const IslandProblem& part) const {
    SolverOptions inner = options_;
    inner.s0 = part.gather(s_);
    inner.time_limit = std::max(time_left(), 1e-9);
    inner.on_iteration = nullptr;
    return inner;
  }
  /// The solver that goes on from an attempt's impulse, as rows of the problem that it is run on.
  SolverEntry entry_from(Vector best) const {
    return run_.entry().with(
        [this, best = std::move(best)](SolveRun& run) { solver_.run(run, best); });
  }

  /// False if none is to follow.
  bool solve_island(int island, bool last) {
    const std::span<const int> contacts = islands_.of(island);
    const int size = static_cast<int>(contacts.size());
    const IslandProblem part = cut(contacts);
    WholeSpace space(part.problem, options_.execution.threads);
    SolverOptions inner = inner_options(part);
    if (last && options_.on_iteration) inner.on_iteration = history_of(part, size);
    const double before = watch_.seconds();
    SolveResult result;
    try {
      const Vector& best = tried_of_.contains(island) ? tried_ : best_;
      const ErrorShare share = share_of(island, sums_of(contacts), last);
      result = run_solver(entry_from(part.gather(best)), space, inner, share);
    } catch (const std::exception& e) {
      result.status = SolveStatus::kNumericalFailure;
      result.message = e.what();
    }
    ++by_solver_;
    add_work(result.iterations, size);
    result_.setup_seconds += watch_.seconds() - before - result.solve_seconds;
    if (result.s.size() == part.problem.num_rows() && result.s.allFinite()) {
      part.scatter(result.s, p_.dim, s_);
    }
    const std::string said = fmt::format("{} contacts: {}", size, result.message);
    const double visits = static_cast<double>(result.iterations) * size;
    if (visits >= most_visits_) {
      most_visits_ = visits;
      costliest_ = said;
    }
    if (!is_success(result.status)) {
      ++failed_;
      if (first_failure_.empty()) {
        result_.status = result.status;
        first_failure_ = said;
      }
      return result.status != SolveStatus::kTimeLimit && result.status != SolveStatus::kInterrupted;
    }
    if (!last) {
      space.error(part.gather(s_));
      settled_ += space.evaluator().sums();
    }
    return true;
  }

  /// Passes the records of the last island on: errors are those of the whole, contacts are added.
  std::function<void(const IterationRecord&)> history_of(const IslandProblem& part, int size) {
    return [this, &part, size, start = watch_.seconds()](const IterationRecord& r) {
      if (r.iteration == 0) return;
      IterationRecord record = r;
      record.iteration = iterations(r.iteration, size);
      record.seconds += start;
      record.count = [&] {
        const ContactCount all = count_contacts(p_, s_), now = r.count();
        const ContactCount own = count_contacts(part.problem, part.gather(s_));
        return ContactCount{.take_off = all.take_off - own.take_off + now.take_off,
                            .stick = all.stick - own.stick + now.stick,
                            .slip = all.slip - own.slip + now.slip};
      };
      options_.on_iteration(record);
    };
  }

  void add_work(int iterations, int contacts) {
    work_ += static_cast<double>(iterations) * contacts;
  }
  /// Number of iterations over the whole that equals the work so far, with more on some contacts.
  int iterations(int more, int contacts) const {
    const double visits = work_ + static_cast<double>(more) * contacts;
    return static_cast<int>(std::ceil(visits / p_.num_contacts()));
  }

  std::string account() const {
    std::string text = fmt::format("{} islands: {} open, {} kept, {} of few contacts, ",
                                   islands_.count(), open_, kept_, few_);
    if (together_ > 0) text += fmt::format("{} together, ", together_);
    text += fmt::format("{} by {}", by_solver_, run_.entry().name);
    if (by_solver_ == 1) text += ", " + costliest_;
    if (by_solver_ > 1) text += ", the costliest with " + costliest_;
    return text;
  }

  SolveResult finish() {
    const ContactError error = evaluate_(s_);
    s_ = evaluate_.impulse();
    result_.message = account();
    // If no solver ran on a last island, the end has not been recorded.
    if (options_.on_iteration && left_.empty()) {
      options_.on_iteration({.iteration = iterations(0, 0),
                             .seconds = watch_.seconds(),
                             .error = error,
                             .count = [this] { return count_contacts(p_, s_); }});
    }
    if (meets(options_, error) && run_.space().prove(options_, s_, error).holds) {
      result_.status = SolveStatus::kConverged;
    } else if (failed_ > 0) {
      result_.message =
          fmt::format("{} of the {}; first {}", failed_, result_.message, first_failure_);
    } else {
      // Rounding keeps the whole from a tolerance that all of its islands meet.
      return on_the_whole(Vector());
    }
    result_.s = s_;
    result_.iterations = iterations(0, 0);
    result_.solve_seconds = watch_.seconds() - result_.setup_seconds;
    return std::move(result_);
  }

  /// Continues on the whole, from the impulses of the islands.
  SolveResult on_the_whole(const Vector& best) {
    SolverOptions inner = options_;
    inner.s0 = std::move(s_);
    s_ = Vector();  // which may have got the other's memory
    evaluate_.release_scratch();
    inner.time_limit = std::max(time_left(), 1e-9);
    const int before = iterations(0, 0);
    inner.on_iteration = history_after(options_, before, watch_.seconds(), /*with_start=*/false);
    SolveResult result;
    try {
      result = run_.nested(entry_from(best), inner, share_);
    } catch (const std::exception& e) {
      result.status = SolveStatus::kNumericalFailure;
      result.message = e.what();
      result.s = std::move(inner.s0);
    }
    result.message = account() + "; then the whole: " + result.message;
    result.iterations += before;
    result.setup_seconds += result_.setup_seconds;
    result.solve_seconds = watch_.seconds() - result.setup_seconds;
    return result;
  }

  const Stopwatch watch_;
  SolveRun& run_;
  const IslandSolver& solver_;
  const ContactProblem& p_;
  const SolverOptions& options_;
  const ErrorShare share_;
  const Vector best_;  // of an attempt, or empty
  const ContactIslands& islands_;
  IterationRecord start_;  // where somebody wants it
  ContactErrorEvaluator& evaluate_;
  std::optional<IslandCutter> cut_;  // of the first part that is cut out
  ErrorSums total_;                  // of the whole at its start; its free terms do not change
  ErrorSums settled_;                // of the settled islands; its free terms are not used
  Vector s_;
  std::vector<int> left_;  // islands for the solver, the smaller ones first
  double work_ = 0;        // contacts visited
  Vector tried_;           // results of the attempts on groups, in the remaining islands
  std::set<int> tried_of_;
  int open_ = 0, kept_ = 0, few_ = 0, together_ = 0, by_solver_ = 0, failed_ = 0;
  double most_visits_ = 0;  // of a single island
  std::string costliest_, first_failure_;
  SolveResult result_;
};

/// If a warm start has settled more than a quarter of many contacts, the others are cut out.
/// Sweeps over all cost less than cutting if they converge soon, or if there are few contacts.
constexpr double kMostContacts = 0.75;
constexpr int kFewToCut = 400;

}  // namespace

void solve_islands(SolveRun& run, const IslandSolver& solver) {
  const ContactProblem& p = run.problem();
  const SolverOptions& options = run.options();
  if (options.stop != StopTest::kGuarded || options.max_iterations == 0) {
    return solver.run(run, Vector());
  }
  const ContactIslands islands = contact_islands(p);
  if (islands.count() <= 1) return solver.run(run, Vector());
  std::optional<IslandRun> parts;
  const auto settle = [&](const SolverOptions& how, const Vector& best) {
    parts.emplace(run, solver, how, best, islands);
    return parts->settle();
  };
  // A large problem is not tried as a whole: the largest part is, and the others in groups.
  const bool attempts = solver.attempt && p.num_contacts() <= kLargeCopy &&
                        islands.of(islands.count() - 1).size() > 1;
  if (!attempts || is_warm(options)) {
    const int left = settle(options, Vector());
    const bool cut = left == 0 || p.num_contacts() > kFewToCut;
    if (!attempts || (cut && left < kMostContacts * p.num_contacts())) {
      return run.take(parts->solve_left());
    }
  }
  run.space().release_scratch();
  const SolveResult first =
      run.nested(run.entry().with(solver.attempt), options, run.whole().share());
  if (first.status == SolveStatus::kNotRun) {
    settle(options, Vector());  // once more: its evaluation was released
    return run.take(parts->solve_left());
  }
  const bool over = is_success(first.status) || first.status == SolveStatus::kTimeLimit ||
                    first.status == SolveStatus::kInterrupted ||
                    first.iterations >= options.max_iterations;
  if (over) return run.take(first);
  SolverOptions rest = options;
  rest.time_limit = run.remaining_seconds();
  rest.max_iterations -= first.iterations;
  rest.on_iteration = history_after(options, first.iterations, run.seconds(), /*with_start=*/false);
  settle(rest, first.s);
  SolveResult result = parts->solve_left();
  result.message = fmt::format("the whole: {}; then {}", first.message, result.message);
  result.iterations += first.iterations;
  result.setup_seconds += first.setup_seconds;
  result.solve_seconds += first.solve_seconds;
  run.take(std::move(result));
}

SolverEntry on_islands(const SolverEntry& entry) {
  return entry.with([inner = entry.run](SolveRun& run) {
    solve_islands(run, {.run = [&](SolveRun& part, const Vector&) { inner(part); }});
  });
}

std::string explain_islands(const ContactProblem& p) {
  const ContactIslands islands = contact_islands(p);
  int open = 0, few = 0;
  for (int k = 0; k < islands.count(); ++k) {
    if (is_open(p, islands.of(k))) {
      ++open;
    } else if (islands.of(k).size() <= to_size(kFewContacts)) {
      ++few;
    }
  }
  const std::size_t largest = islands.count() > 0 ? islands.of(islands.count() - 1).size() : 0;
  if (islands.count() <= 1) return fmt::format("islands: {}\n", islands.count());
  return fmt::format(
      "islands: {}; nothing approaches in {}, {} others have up to {} contacts, the largest has {}; "
      "the plan below is that of one as large as the whole\n",
      islands.count(), open, few, kFewContacts, largest);
}

}  // namespace bipot
