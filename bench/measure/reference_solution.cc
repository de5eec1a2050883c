#include "bench/measure/reference_solution.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/measure/limited_solve.h"
#include "core/base/file_error.h"
#include "core/files/atomic_file.h"
#include "core/files/input_file.h"
#include "core/problem/energy_norm.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

SolveStatus parse_status(const std::string& text) {
  for (int i = 0; i <= static_cast<int>(SolveStatus::kInvalidInput); ++i) {
    if (to_string(static_cast<SolveStatus>(i)) == text) return static_cast<SolveStatus>(i);
  }
  return SolveStatus::kNotRun;
}

}  // namespace

ReferenceSolution find_reference(const TestProblem& given, double time_limit, double target,
                                 const std::function<bool()>& interrupted) {
  const double witness = std::max(ReferenceSolution::kTrusted, 10 * target);
  const ContactProblem& problem = given.problem;
  ReferenceSolution best{.origin = given.origin,
                         .contacts = problem.num_contacts(),
                         .dim = problem.dim,
                         .dofs = problem.num_dofs(),
                         .s = Vector::Zero(problem.num_rows())};
  double best_error = kInfinity;
  std::vector<Vector> trusted, attempts;
  const DelassusOperator delassus(problem);
  // On large problems round-off prevents 1e-12, newton is the slowest, and sweeps soon give a
  // witness.
  const bool large = problem.num_contacts() > ReferenceSolution::kLarge;
  const double enough = large ? 10 * target : target;
  const std::vector<const char*> names = large ? std::vector{"auto", "apgd", "ipm", "newton"}
                                               : std::vector{"auto", "newton", "ipm", "apgd"};
  for (const char* name : names) {
    const SolverEntry* entry = find_solver(name);
    if (entry == nullptr) continue;
    SolveResult result =
        solve_within(*entry, problem, {.tol = target, .cancelled = interrupted}, time_limit);
    ReferenceSolution::Attempt attempt{name, result.status, kNaN,
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
      attempts.push_back(std::move(result.s));
    }
    best.attempts.push_back(attempt);
    if (interrupted && interrupted()) break;
    if (best_error <= enough && trusted.size() >= 2) break;
  }
  if (trusted.size() >= 2) {
    const double scale = std::sqrt(energy_product(problem, delassus, best.s));
    best.velocity_spread = 0;
    for (const Vector& s : trusted) {
      const double apart = std::sqrt(energy_product(problem, delassus, s - best.s));
      best.velocity_spread = std::max(best.velocity_spread, relative_error(apart, scale));
    }
  }
  for (const Vector& s : attempts) learn_answer(problem, s, time_limit, interrupted, best);
  return best;
}

bool learn_answer(const ContactProblem& problem, const Vector& s, double time_limit,
                  const std::function<bool()>& interrupted, ReferenceSolution& reference) {
  // Answers that are nearly exact, but this many times farther away than their error explains, are
  // examined.
  constexpr double kNearlyExact = 1e-6, kSuspicious = 10;
  // In a continuous family every start ends at an answer of its own.
  constexpr std::size_t kMost = 24;
  if (reference.others.size() + 1 >= kMost || s.size() != problem.num_rows()) return false;
  DistinctAnswers known(problem);
  if (known.add(reference.s, reference.solver) < 0) return false;
  for (const Vector& other : reference.others) known.add(other, "");
  VerifiedAnswer found = known.judge(s, "");
  const auto is_far = [&](double factor) {
    for (const VerifiedAnswer& answer : known.answers()) {
      const double apart = known.distance(answer.s, found.s);
      if (!(apart > factor * (answer.explained + found.explained))) return false;
    }
    return true;
  };
  if (!(found.guarded <= kNearlyExact) || !is_far(kSuspicious)) return false;
  const auto is_new = [&] {
    return found.guarded <= DistinctAnswers::kTrusted && is_far(DistinctAnswers::kFactor);
  };
  const std::map<std::string, std::string> as_it_is{{"start_tol", "1"}};
  for (const char* name : {"homotopy", "newton", "ipm"}) {
    if (is_new() || (interrupted && interrupted())) break;
    const SolverEntry* entry = find_solver(name);
    if (entry == nullptr || !beyond_solver(*entry, problem).empty()) continue;
    SolverOptions options{
        .tol = ReferenceSolution::kTarget, .s0 = found.s, .cancelled = interrupted};
    if (std::string_view(name) == "homotopy") options.parameters = as_it_is;
    const SolveResult result = solve_within(*entry, problem, options, time_limit);
    VerifiedAnswer next = known.judge(result.s, name);
    if (next.guarded < found.guarded) found = std::move(next);
  }
  if (!is_new()) return false;
  reference.others.push_back(std::move(found.s));
  return true;
}

Json to_json(const ReferenceSolution::Spread& spread) {
  return {{"velocity", spread.velocity}, {"force", spread.force}, {"energy", spread.energy}};
}

Json to_json(const ReferenceSolution::Attempt& attempt) {
  return {{"solver", attempt.solver},
          {"status", to_string(attempt.status)},
          {"guarded", attempt.guarded},
          {"seconds", attempt.seconds}};
}

void write_reference(const std::filesystem::path& path, const std::string& problem,
                     const ReferenceSolution& reference) {
  Json j{{"problem", problem},   {"origin", reference.origin}, {"contacts", reference.contacts},
         {"dim", reference.dim}, {"dofs", reference.dofs},     {"solver", reference.solver}};
  const ProblemMark& mark = reference.mark;
  j["mark"] = {mark.velocity, mark.friction, mark.mobility};
  add_error(j, reference.error);
  j["velocity_spread"] = reference.velocity_spread;
  j["spread"] = to_json(reference.spread);
  j["attempts"] =
      json_list(reference.attempts, [](const auto& attempt) { return to_json(attempt); });
  const auto numbers = [](const Vector& x) { return std::vector<double>(x.begin(), x.end()); };
  j["s"] = numbers(reference.s);
  j["others"] = json_list(reference.others, numbers);
  write_text_file(path, json_text(j) + '\n');
}

ReferenceSolution read_reference(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  try {
    const Json j = Json::parse(text);
    ReferenceSolution reference{.origin = j.at("origin").get<std::string>(),
                                .contacts = j.at("contacts").get<int>(),
                                .dim = j.at("dim").get<int>(),
                                .dofs = j.at("dofs").get<int>(),
                                .solver = j.at("solver").get<std::string>()};
    if (j.contains("mark")) {
      const Json& mark = j["mark"];
      reference.mark = {number_or_nan(mark.at(0)), number_or_nan(mark.at(1)),
                        number_or_nan(mark.at(2))};
    }
    reference.error.epsilon = number_or_nan(j.at("epsilon"));
    reference.error.eta = number_or_nan(j.at("eta"));
    reference.error.raw42 = number_or_nan(j.at("epsilon_raw"));
    reference.error.natural_map = number_or_nan(j.at("natural_map"));
    reference.velocity_spread = number_or_nan(j.at("velocity_spread"));
    reference.spread.velocity = number_or_nan(j.at("spread").at("velocity"));
    reference.spread.force = number_or_nan(j.at("spread").at("force"));
    reference.spread.energy = number_or_nan(j.at("spread").at("energy"));
    for (const Json& a : j.at("attempts")) {
      reference.attempts.push_back({a.at("solver").get<std::string>(),
                                    parse_status(a.at("status").get<std::string>()),
                                    number_or_nan(a.at("guarded")), a.at("seconds").get<double>()});
    }
    const auto vector = [](const Json& numbers) {
      const auto x = numbers.get<std::vector<double>>();
      return Vector(Eigen::Map<const Vector>(x.data(), static_cast<Eigen::Index>(x.size())));
    };
    reference.s = vector(j.at("s"));
    for (const Json& other : j.at("others")) reference.others.push_back(vector(other));
    return reference;
  } catch (const nlohmann::json::exception& e) {
    throw FileError(path, "", e.what());
  }
}

}  // namespace bipot
