#include "solvers/analysis/several_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/number_text.h"
#include "core/base/portable_random.h"
#include "core/base/stopwatch.h"
#include "core/problem/body_rows.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "solvers/analysis/case_enumeration.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

// Iterations of a start's own solver; exact solvers then continue from its result.
struct Recipe {
  const char* solver;
  int iterations;
  std::map<std::string, std::string> parameters = {};
};
constexpr int kSweeps = 2000, kGradients = 5000, kSplittings = 3000, kNewtons = 400;
constexpr int kPivots = 30000, kInteriors = 400;
constexpr int kFromGuess = 2;  // starts from the guess, by the first solvers of the list
constexpr double kPerturbation = 0.01;
constexpr double kAtRest = 1e-9;  // velocity over the largest one without impulses
// Largest number of perturbed answers: each costs a solve.
constexpr int kPerturbed = 12;

/// Each contact's impulse times 1 + amount * uniform(-1, 1): still on the cone.
Vector random_multiples(const Vector& s, int dim, double amount, PortableRandom& random) {
  Vector r = s;
  for (Eigen::Index row = 0; row < s.size(); row += dim) {
    r.segment(row, dim) *= 1 + amount * random.symmetric();
  }
  return r;
}

/// By the rule of count_contacts().
std::vector<ContactStatus> statuses(const ContactProblem& p, const Vector& s) {
  const int contacts = p.num_contacts();
  std::vector<ContactStatus> all(to_size(contacts), ContactStatus::kStick);
  dispatch_dim(p.dim, [&](auto d) {
    for (int c = 0; c < contacts; ++c) {
      const auto x = local<d()>(s, c);
      if (x[0] <= 0) {
        all[to_size(c)] = ContactStatus::kTakeOff;
      } else if (on_edge<d()>(x, p.mu[c])) {
        all[to_size(c)] = ContactStatus::kSlip;
      }
    }
  });
  return all;
}

/// The search for one problem.
class AnswerSearch {
 public:
  AnswerSearch(const ContactProblem& p, const SeveralAnswers::Options& options)
      : p_(p), options_(options), distinct_(p), delassus_(p), random_(options.seed) {}

  SeveralAnswers run() {
    for (int k = 0; k < options_.starts && !stopped(); ++k) {
      const Stopwatch watch;
      SeveralAnswers::Start made = begin_start(k);
      if (invalid_) break;
      if (stopped() && made.answer < 0) break;  // cut short: says nothing
      made.seconds = watch.seconds();
      found_.starts.push_back(std::move(made));
    }
    if (!invalid_) {
      look_at_all_cases();
      describe_answers();
      perturb_answers();
      join_answers();
      measure();
    }
    close();
    return std::move(found_);
  }

 private:
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  bool stopped() const { return cancelled() || watch_.seconds() >= options_.time_limit; }

  bool usable(std::string_view name) const {
    const SolverEntry* entry = find_solver(name);
    return entry != nullptr && beyond_solver(*entry, p_).empty();
  }

  SolveResult attempt(std::string_view solver, const Vector& s0, int iterations,
                      std::map<std::string, std::string> parameters) const {
    SolverOptions options{.tol = options_.tol,
                          .max_iterations = iterations,
                          .time_limit = std::max(1e-9, options_.time_limit - watch_.seconds()),
                          .s0 = s0,
                          .parameters = std::move(parameters),
                          .cancelled = options_.cancelled};
    return solve(solver, p_, options);
  }

  /// Replaces the result by one of this solver from there, if that is better.
  void improve(SolveResult& result, std::string& by, const char* solver, int iterations,
               std::map<std::string, std::string> parameters) const {
    if (result.error.guarded() <= options_.tol || stopped() || !usable(solver)) return;
    SolveResult next = attempt(solver, result.s, iterations, std::move(parameters));
    if (!(next.error.guarded() < result.error.guarded())) return;
    result = std::move(next);
    by = solver;
  }

  /// Solver and start number k.
  SeveralAnswers::Start begin_start(int k) {
    SeveralAnswers::Start made;
    made.from = "zero";
    Vector s0;
    Recipe recipe = recipe_of(k, made.from, s0);
    made.solver = recipe.solver;
    for (const char* told : {"order", "map"}) {
      const auto given = recipe.parameters.find(told);
      if (given != recipe.parameters.end()) made.solver += ", " + given->second;
    }
    drive(recipe, s0, made);
    return made;
  }

  /// The guess, the solvers of the list from zero, then shuffled orders and random multiples
  /// alternately.
  Recipe recipe_of(int k, std::string& from, Vector& s0) {
    const auto begin_at_guess = [&] {
      from = "guess";
      s0 = options_.guess;
    };
    const bool guess = options_.guess.size() > 0;
    if (!options_.solver.empty()) {
      const Recipe own{options_.solver.c_str(), kSweeps + kGradients, options_.parameters};
      if (k > 0) {
        s0 = start_away(k, from);
      } else if (guess) {
        begin_at_guess();
      }
      return own;
    }
    std::vector<Recipe> list;
    for (const Recipe& r :
         {Recipe{"pgs", kSweeps}, Recipe{"apgd", kGradients}, Recipe{"ipm", kInteriors},
          Recipe{"newton", kNewtons}, Recipe{"admm", kSplittings}, Recipe{"homotopy", kPivots},
          Recipe{"anderson", kSweeps}, Recipe{"apgd", kGradients, {{"map", "split"}}},
          Recipe{"convex", kGradients}}) {
      if (usable(r.solver)) list.push_back(r);
    }
    if (guess && k < kFromGuess) {
      begin_at_guess();
      return list[to_size(k)];
    }
    if (guess) k -= kFromGuess;
    const int solvers = static_cast<int>(list.size());
    if (k < solvers) return list[to_size(k)];
    k -= solvers;
    if (k % 3 == 0) {
      return {"pgs",
              kSweeps,
              {{"order", "shuffled"}, {"seed", std::to_string(1 + random_.below(1000000))}}};
    }
    s0 = start_away(k, from);
    return list[k % 3 == 1 ? 1 : 0];
  }

  /// Random multiples of the impulses of an answer: by 10 % and by 50 %.
  Vector start_away(int k, std::string& from) {
    const auto& answers = distinct_.answers();
    if (answers.empty()) return {};
    const double amount = k % 2 == 0 ? 0.5 : 0.1;
    const std::size_t of = to_size(k) % answers.size();
    from = fmt::format("multiples of answer {}, {:g} %", of + 1, 100 * amount);
    return random_multiples(answers[of].s, p_.dim, amount, random_);
  }

  /// Runs the start's own solver, then exact ones from its result, until one is trusted.
  void drive(const Recipe& recipe, const Vector& s0, SeveralAnswers::Start& made) {
    SolveResult result = attempt(recipe.solver, s0, recipe.iterations, recipe.parameters);
    if (result.status == SolveStatus::kInvalidInput) {
      invalid_ = true;
      found_.message = result.message;
      return;
    }
    made.finished_by = recipe.solver;
    improve(result, made.finished_by, "homotopy", kPivots, {{"start_tol", "1"}});
    for (const auto& [solver, iterations] :
         {std::pair{"homotopy", kPivots}, {"newton", kNewtons}, {"ipm", kInteriors}}) {
      if (result.error.guarded() <= DistinctAnswers::kTrusted) break;
      improve(result, made.finished_by, solver, iterations, {});
    }
    made.error = result.error;
    made.message = result.message;
    made.answer = distinct_.add(result.s, made.solver);
    if (made.answer >= 0) show(to_size(made.answer), distinct_.judge(result.s, made.solver));
  }

  /// Contacts that stick; -1 if an impulse acts across a gap that opens.
  int sticking(const Vector& s) const {
    Vector u;
    delassus_.velocity(s, u);
    const double rest = kAtRest * p_.u_free.cwiseAbs().maxCoeff();
    const std::vector<ContactStatus> all = statuses(p_, s);
    for (std::size_t c = 0; c < all.size(); ++c) {
      const double u_n = u[static_cast<Eigen::Index>(c) * p_.dim];
      if (all[c] != ContactStatus::kTakeOff && u_n > rest) return -1;
    }
    return static_cast<int>(std::count(all.begin(), all.end(), ContactStatus::kStick));
  }

  /// Impulses with the velocities of an answer may differ. Shown is the one in which most contacts
  /// stick: what can stick with these velocities is at rest.
  void show(std::size_t answer, const VerifiedAnswer& found) {
    if (answer == shown_.size()) shown_.push_back(found);
    if (sticking(found.s) > sticking(shown_[answer].s)) shown_[answer] = found;
  }

  /// All cases of few contacts; answers that no start found are added with a start of their own.
  void look_at_all_cases() {
    if (!options_.solver.empty() || stopped()) return;
    const Stopwatch watch;
    const EnumeratedCases all = enumerate_cases(p_, [this] { return stopped(); });
    bool judged = true;
    for (const Vector& s : all.candidates) {
      const std::size_t before = distinct_.answers().size();
      SeveralAnswers::Start made{.solver = "cases", .from = "all cases", .finished_by = "cases"};
      made.answer = distinct_.add(s, made.solver);
      judged = judged && made.answer >= 0;
      if (distinct_.answers().size() == before) continue;
      made.error = distinct_.answers().back().error;
      made.message = "a case of open, sticking and slipping contacts";
      made.seconds = watch.seconds();
      found_.starts.push_back(std::move(made));
    }
    if (all.cases == 0) return;
    found_.complete = judged && all.undecided == 0 && all.continua == 0;
    cases_ = fmt::format("; all {} cases of open, stick and slip were looked at: ", all.cases);
    cases_ += all.undecided > 0 ? fmt::format("{} are singular and not decided", all.undecided)
                                : std::string("no others");
    if (all.continua > 0) {
      cases_ += fmt::format(", and in {} the impulses are not unique", all.continua);
    }
  }

  void describe_answers() {
    while (found_.answers.size() < distinct_.answers().size()) {
      Answer answer;
      const std::size_t k = found_.answers.size();
      answer.impulse = k < shown_.size() ? shown_[k] : distinct_.answers()[k];
      delassus_.velocity(answer.impulse.s, answer.u);
      answer.status = statuses(p_, answer.impulse.s);
      const ContactCount count = count_contacts(p_, answer.impulse.s);
      answer.take_off = count.take_off;
      answer.stick = count.stick;
      answer.slip = count.slip;
      if (p_.has_velocities()) {
        const Vector v = body_velocities(p_, answer.impulse.s);
        answer.kinetic = 0.5 * v.dot(without_equality_rows(p_).A * v);
      }
      found_.answers.push_back(std::move(answer));
    }
    for (std::size_t k = 0; k < found_.starts.size(); ++k) {
      if (found_.starts[k].answer >= 0) {
        found_.answers[to_size(found_.starts[k].answer)].starts.push_back(static_cast<int>(k));
      }
    }
  }

  /// Exact at 1/4, 1/2 and 3/4 between two exact answers.
  bool joined(const Vector& a, const Vector& b) {
    for (const double t : {0.25, 0.5, 0.75}) {
      const double error = distinct_.judge((1 - t) * a + t * b, "").guarded;
      if (!(error <= DistinctAnswers::kTrusted)) return false;
    }
    return true;
  }

  void perturb_answers() {
    const std::size_t count = std::min(found_.answers.size(), to_size(kPerturbed));
    for (std::size_t k = 0; k < count && !stopped(); ++k) {
      Answer& answer = found_.answers[k];
      const Vector& s = answer.impulse.s;
      const Vector away = random_multiples(s, p_.dim, kPerturbation, random_);
      SolveResult back = attempt("pgs", away, kSweeps, {});
      std::string by;
      improve(back, by, "homotopy", kPivots, {{"start_tol", "1"}});
      const VerifiedAnswer found = distinct_.judge(back.s, "");
      if (!(found.guarded <= DistinctAnswers::kTrusted)) continue;
      answer.perturbed = distinct_.relative(distinct_.distance(away, s));
      answer.came_back_to = distinct_.relative(distinct_.distance(found.s, s));
      answer.kind = !distinct_.are_distinct(found, answer.impulse) ? Answer::Kind::kIsolated
                    : joined(found.s, s)                           ? Answer::Kind::kFamily
                                                                   : Answer::Kind::kLeft;
    }
  }

  /// Numbers the sets of joined answers.
  void join_answers() {
    std::vector<Answer>& all = found_.answers;
    for (std::size_t k = 0; k < all.size(); ++k) all[k].set = static_cast<int>(k);
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (all[i].set == all[j].set || cancelled()) continue;
        if (!joined(all[i].impulse.s, all[j].impulse.s)) continue;
        all[i].kind = all[j].kind = Answer::Kind::kFamily;
        const int from = std::max(all[i].set, all[j].set), to = std::min(all[i].set, all[j].set);
        for (Answer& answer : all) {
          if (answer.set == from) answer.set = to;
        }
      }
    }
    std::vector<int> seen;
    for (Answer& answer : all) {
      const auto at = std::find(seen.begin(), seen.end(), answer.set);
      const int number = static_cast<int>(at - seen.begin());
      if (at == seen.end()) seen.push_back(answer.set);
      answer.set = number;
    }
    found_.sets = static_cast<int>(seen.size());
  }

  /// Velocities and resultants of the bodies, one column for each body.
  struct Bodies {
    Eigen::MatrixXd velocity, resultant;
  };
  std::optional<Bodies> bodies_of(const Vector& s) const {
    if (!rows_) return std::nullopt;
    const Vector v = body_velocities(p_, s), x = without_equality_rows(p_).H * s;
    Bodies made;
    made.velocity.resize(rows_->translations, rows_->bodies);
    made.resultant.resize(rows_->translations, rows_->bodies);
    for (int b = 0; b < rows_->bodies; ++b) {
      made.velocity.col(b) = v.segment(b * rows_->per_body, rows_->translations);
      made.resultant.col(b) = x.segment(b * rows_->per_body, rows_->translations);
    }
    return made;
  }

  Answer::Difference difference(const Answer& a, const Answer& b) const {
    Answer::Difference d{.velocity =
                             distinct_.relative(distinct_.distance(a.impulse.s, b.impulse.s))};
    const double kinetic = std::abs(a.kinetic - b.kinetic);
    if (kinetic == 0 || found_.answers.front().kinetic > 0) {
      d.kinetic = kinetic == 0 ? 0 : kinetic / found_.answers.front().kinetic;
    }
    const auto x = bodies_of(a.impulse.s), y = bodies_of(b.impulse.s);
    const auto first = bodies_of(found_.answers.front().impulse.s);
    if (first && x && y && rows_->bodies > 0) {
      const double speed = first->velocity.colwise().norm().maxCoeff();
      const double mean = first->resultant.colwise().norm().mean();
      if (speed > 0) {
        d.body_velocity = (x->velocity - y->velocity).colwise().norm().maxCoeff() / speed;
      }
      if (mean > 0) d.force = (x->resultant - y->resultant).colwise().norm().maxCoeff() / mean;
      const double total = first->resultant.rowwise().sum().norm();
      if (total > 0) {
        d.total = (x->resultant - y->resultant).rowwise().sum().norm() / total;
      }
    }
    for (std::size_t c = 0; c < a.status.size(); ++c) {
      d.contacts += a.status[c] != b.status[c] ? 1 : 0;
    }
    return d;
  }

  void measure() {
    std::vector<Answer>& all = found_.answers;
    if (all.empty()) return;
    rows_ = find_body_rows(without_equality_rows(p_));
    double explained = 0;
    for (Answer& answer : all) {
      answer.from_first = difference(all.front(), answer);
      explained = std::max(explained, answer.impulse.explained);
    }
    found_.resolution = distinct_.relative(2 * DistinctAnswers::kFactor * explained);
    found_.spread = all.size() > 1 ? difference(all[0], all[1]) : all.front().from_first;
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        found_.spread = larger_of(found_.spread, difference(all[j], all[i]));
      }
    }
    for (std::size_t c = 0; c < all.front().status.size(); ++c) {
      const bool differs = std::any_of(all.begin(), all.end(), [&](const Answer& answer) {
        return answer.status[c] != all.front().status[c];
      });
      if (differs) found_.differing_contacts.push_back(static_cast<int>(c));
    }
  }

  void close() {
    found_.seconds = watch_.seconds();
    const auto exact = static_cast<int>(
        std::count_if(found_.starts.begin(), found_.starts.end(),
                      [](const SeveralAnswers::Start& s) { return s.answer >= 0; }));
    const int made = static_cast<int>(found_.starts.size());
    if (invalid_) {
      found_.status = SolveStatus::kInvalidInput;
      return;
    }
    found_.message = fmt::format("{} of {} starts reached an exact answer", exact, made) + cases_;
    if (cancelled()) {
      found_.status = SolveStatus::kInterrupted;
      found_.message += fmt::format("; interrupted, {} starts asked for", options_.starts);
    } else if (watch_.seconds() >= options_.time_limit) {
      found_.status = SolveStatus::kTimeLimit;
      found_.message += fmt::format("; time limit {} s reached, {} starts asked for",
                                    options_.time_limit, options_.starts);
    } else {
      found_.status = exact == made ? SolveStatus::kConverged : SolveStatus::kStalled;
    }
  }

  const ContactProblem& p_;
  const SeveralAnswers::Options& options_;
  DistinctAnswers distinct_;
  std::vector<VerifiedAnswer> shown_;  // of answers that starts found
  const DelassusOperator delassus_;
  const Stopwatch watch_;
  PortableRandom random_;
  std::optional<BodyRows> rows_;
  SeveralAnswers found_;
  std::string cases_;  // the statement about all cases
  bool invalid_ = false;
};

/// Why a search is refused; empty where it is not.
std::string refusal(const ContactProblem& problem, const SeveralAnswers::Options& options) {
  if (std::string defect = validate(problem); !defect.empty()) return defect;
  if (problem.rolls()) return "several answers are not sought with rolling friction";
  if (options.starts < 1) {
    return fmt::format("starts = {}, expected at least 1", options.starts);
  }
  if (!(options.tol <= DistinctAnswers::kTrusted)) {
    return fmt::format("tol = {}: answers are told apart from {} on", tolerance_label(options.tol),
                       tolerance_label(DistinctAnswers::kTrusted));
  }
  if (options.guess.size() != 0 && options.guess.size() != problem.num_rows()) {
    return fmt::format("guess has size {}, expected {}", options.guess.size(), problem.num_rows());
  }
  const bool unknown = !options.solver.empty() && find_solver(options.solver) == nullptr;
  return unknown ? unknown_solver_message(options.solver) : "";
}

}  // namespace

std::string_view to_string(Answer::Kind kind) {
  static constexpr std::string_view kNames[] = {"isolated", "family", "left", "unknown"};
  return kNames[static_cast<int>(kind)];
}

Answer::Difference larger_of(const Answer::Difference& a, const Answer::Difference& b) {
  return {std::fmax(a.velocity, b.velocity), std::fmax(a.body_velocity, b.body_velocity),
          std::fmax(a.kinetic, b.kinetic),   std::fmax(a.force, b.force),
          std::fmax(a.total, b.total),       std::max(a.contacts, b.contacts)};
}

SeveralAnswers find_several_answers(const ContactProblem& problem,
                                    const SeveralAnswers::Options& options) {
  if (std::string refused = refusal(problem, options); !refused.empty()) {
    return {.status = SolveStatus::kInvalidInput, .message = std::move(refused)};
  }
  if (problem.num_contacts() == 0) {
    return {.status = SolveStatus::kNothingToDo, .message = "no contacts"};
  }
  return AnswerSearch(problem, options).run();
}

}  // namespace bipot
