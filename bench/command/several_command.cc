#include "bench/command/several_command.h"

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>

#include "bench/command/exit_code.h"
#include "bench/problems/several_picture.h"
#include "bench/report/json_output.h"
#include "bench/report/several_report.h"
#include "core/base/counted.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/version.h"
#include "core/files/atomic_file.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_geometry.h"
#include "solvers/analysis/several_answers.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

int exit_code_of(const SeveralAnswers& found) {
  if (found.status == SolveStatus::kInvalidInput) return kExitBadInput;
  if (found.status == SolveStatus::kInterrupted) return kExitInterrupted;
  if (found.status == SolveStatus::kNothingToDo) return kExitConverged;
  return found.answers.empty() || found.status == SolveStatus::kTimeLimit ? kExitNotConverged
                                                                          : kExitConverged;
}

/// --seed is a parameter of solvers as well; here it belongs to the search.
std::uint64_t take_seed(std::map<std::string, std::string>& parameters, std::uint64_t otherwise) {
  const auto given = parameters.find("seed");
  if (given == parameters.end()) return otherwise;
  const auto seed = whole_number<std::uint64_t>(given->second);
  if (!seed) {
    throw std::invalid_argument("--seed " + given->second + ": expected an integer from 0 on");
  }
  parameters.erase(given);
  return *seed;
}

SeveralAnswers::Options options_of(const SolveFlags& flags, const ProblemFile& file) {
  SeveralAnswers::Options options{.starts = *flags.several,
                                  .tol = flags.solver.tol.value_or(SeveralAnswers::Options{}.tol),
                                  .time_limit = flags.common.time_limit,
                                  .solver = flags.solver.name.value_or(""),
                                  .parameters = flags.solver.parameters};
  options.seed = take_seed(options.parameters, options.seed);
  if (!options.parameters.empty() && options.solver.empty()) {
    throw std::invalid_argument("--several: a solver's parameters need --solver");
  }
  if (flags.explain || flags.certify || flags.reproducible || !flags.solution.empty() ||
      !flags.history.empty() || flags.solver.stop || flags.solver.max_iterations) {
    throw std::invalid_argument(
        "--several goes without --explain, --certify, --reproducible, --solution, --history, --stop "
        "and --max-iterations");
  }
  if (flags.warm) {
    if (file.guesses.empty()) {
      throw std::invalid_argument(flags.problem +
                                  ": --warm, but the file has no guess to start from");
    }
    options.guess = file.guesses.front();
  }
  return options;
}

using Place = std::optional<ProblemGeometry>;  ///< empty: of a problem without pictures

void write_folder(const fs::path& out, const std::string& problem, const ProblemFile& file,
                  const Place& place, const SeveralAnswers& found) {
  const std::string name = fs::path(problem).filename().string();
  const bool drawn = place && !found.answers.empty();
  if (!found.answers.empty() && file.problem.num_contacts() > 0) {
    std::vector<Vector> impulses;
    for (const Answer& answer : found.answers) impulses.push_back(answer.impulse.s);
    write_fclib(out / "answers.hdf5", file.problem, file.info, impulses);
  }
  for (const char* picture : {"answers.svg", "answers.png"}) {
    if (!drawn) break;
    draw_several_picture(out / picture, file.problem, *place, found,
                         fmt::format("{}, step {}", name, place->state.step));
  }
  write_text_file(out / "answers.csv", to_csv(found));
  const Document page = several_page(found, name, provenance("solve", typed_command()), drawn);
  write_text_file(out / "index.html", to_html(page));
}

}  // namespace

int several_command(const SolveFlags& flags, const ProblemFile& file) {
  SeveralAnswers::Options options = options_of(flags, file);
  const fs::path out = flags.common.out;
  std::string json = flags.common.json;
  if (!out.empty() && json.empty()) json = (out / "summary.json").string();
  flags.common.prepare();
  const InterruptGuard interrupt;
  options.cancelled = &InterruptGuard::requested;
  SeveralAnswers found = find_several_answers(file.problem, options);
  if (!file.caution.empty()) found.message += "; " + file.caution;
  if (found.status == SolveStatus::kInvalidInput) throw std::invalid_argument(found.message);
  const int code = exit_code_of(found);
  const Place place = read_geometry(flags.problem, file.problem.num_contacts());
  if (!out.empty()) write_folder(out, flags.problem, file, place, found);
  if (!json.empty()) {
    Json j{{"command", "solve"},
           {"version", program_version()},
           {"problem", flags.problem},
           {"exit_code", code},
           {"contacts", file.problem.num_contacts()},
           {"dim", file.problem.dim},
           {"several", *flags.several},
           {"seed", options.seed},
           {"warm", flags.warm},
           {"tol", options.tol}};
    if (place) j.update({{"step", place->state.step}, {"time", place->state.time}});
    j.update(to_json(found));
    write_json(j, json);
  }
  if (!flags.common.quiet && json != "-") {
    fmt::print("{}: {}, d = {}\n{}", flags.problem, counted(file.problem.num_contacts(), "contact"),
               file.problem.dim, to_text(found));
  }
  return code;
}

}  // namespace bipot
