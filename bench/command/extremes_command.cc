#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/watched.h"
#include "bench/compare/extreme_matrix.h"
#include "bench/compare/extreme_report.h"
#include "bench/compare/random_problem.h"
#include "bench/compare/random_sets.h"
#include "bench/report/json_output.h"
#include "bench/report/labels.h"
#include "core/files/atomic_file.h"
#include "core/problem_files/fclib_file.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

struct ExtremesFlags : OutputFlags {
  std::vector<std::string> solvers;  ///< empty: all
  std::string only;                  ///< a case, or how its name begins
  bool quick = false;
  double tol = 1e-8;
  std::optional<double> time_limit;  ///< CPU seconds of a cell
  std::string dump_problem;  ///< FCLIB file for the one problem that --only or --first names
  int random_problems = 0, random_scenes = 0;
  std::uint64_t seed = 1;
  int first = 0;
};

namespace fs = std::filesystem;

std::vector<std::string> solvers_of(const ExtremesFlags& flags) {
  if (flags.solvers.empty()) return solver_names();
  require_solvers(flags.solvers);
  return flags.solvers;
}

/// The one problem that the flags name, as a file for `bipot solve`.
int dump(const ExtremesFlags& flags) {
  ContactProblem problem;
  std::string title;
  if (flags.random_problems == 1) {
    RandomProblem random = random_problem(flags.seed, flags.first);
    problem = std::move(random.problem);
    title = random.description;
  } else {
    for (const ExtremeCase& c : extreme_cases()) {
      if (c.name != flags.only) continue;
      if (!c.problem) throw std::invalid_argument(c.name + " is a run, not one problem");
      problem = c.problem();
      title = c.what;
    }
  }
  if (problem.num_contacts() == 0) {
    throw std::invalid_argument(
        "--dump-problem takes one problem: --only with the whole name of a case, or "
        "--random-problems 1 with --first");
  }
  write_fclib(flags.dump_problem, problem, {.title = title, .description = "bipot extremes"});
  if (!flags.quiet) fmt::print("{}: {}\n", flags.dump_problem, title);
  return kExitConverged;
}

int random_sets(const ExtremesFlags& flags) {
  const InterruptGuard interrupt;
  RandomSets::Options options{.first = flags.first,
                              .seed = flags.seed,
                              .tol = flags.tol,
                              .time_limit = flags.time_limit.value_or(2),
                              .solvers = solvers_of(flags)};
  bool sound = true;
  Document page{.made = provenance("extremes", typed_command())};
  const auto table = [](const char* key, std::initializer_list<const char*> columns) {
    Table made{.key = key};
    for (const char* name : columns) made.columns.push_back({name});
    return made;
  };
  Table findings = table("findings", {"set", "kind", "index", "solver", "message", "again"});
  Table sets = table(
      "sets", {"set", "done", "certificates", "false_certificates", "poor_plants", "energy_grew"});
  Table tallies = table(
      "tallies", {"set", "solver", "tried", "planted", "planted_solved", "other", "other_solved",
                  "none_proved", "exists_unsolved", "undecided", "missed_by_first", "false_claims",
                  "not_finite", "crashed", "hung", "cpu_seconds"});
  const auto run = [&](int count, const char* what, const char* flag, auto* measure) {
    if (count == 0) return;
    options.count = count;
    const RandomSets result = watched(flags.silent(), [&, options](const Watch& watch) mutable {
      options.watch = watch;
      return measure(options);
    });
    sound = sound && result.sound() && result.energy_grew == 0;
    if (!flags.silent()) fmt::print("{}", to_text(result, what));
    sets.add({what, result.done, result.certificates, result.false_certificates, result.poor_plants,
              result.energy_grew});
    for (const RandomSets::Tally& t : result.tallies) {
      tallies.add({what, t.solver, t.tried - t.refused, t.planted, t.planted_solved, t.other,
                   t.other_solved, t.none_proved, t.exists_unsolved, t.undecided, t.missed_by_first,
                   t.false_claims, t.not_finite, t.crashed, t.hung, t.cpu_seconds});
    }
    for (const RandomSets::Finding& f : result.findings) {
      const std::string again =
          fmt::format("bipot extremes --{} 1 --seed {} --first {} --tol {} --time-limit {}{}", flag,
                      flags.seed, f.index, short_exponent(fmt::format("{}", options.tol)),
                      options.time_limit, f.solver.empty() ? "" : " --solver " + f.solver);
      findings.add({what, f.kind, f.index, f.solver, f.message, again});
      if (!flags.silent() && f.kind != "planted, not solved" && f.kind != "exists, not solved") {
        fmt::print("  {}: {}\n    {}\n", f.kind, again, f.message);
      }
    }
  };
  run(flags.random_problems, "random problems", "random-problems", &run_random_problems);
  run(flags.random_scenes, "random scenes", "random-scenes", &run_random_scenes);
  if (!flags.out.empty()) write_text_file(fs::path(flags.out) / "random.csv", to_csv(findings));
  page.add(std::move(sets));
  page.add(std::move(tallies));
  page.add(std::move(findings));
  Json json = to_json(page);
  json["complete"] = !InterruptGuard::requested();
  flags.deliver(json, "");
  if (!json["complete"]) return kExitInterrupted;
  return sound ? kExitConverged : kExitNotConverged;
}

int matrix(const ExtremesFlags& flags) {
  const InterruptGuard interrupt;
  ExtremeMatrix::Options options{.solvers = solvers_of(flags),
                                 .only = flags.only,
                                 .quick = flags.quick,
                                 .tol = flags.tol,
                                 .time_limit = flags.time_limit.value_or(flags.quick ? 0.2 : 2)};
  const ExtremeMatrix result = watched(flags.silent(), [&, options](const Watch& watch) mutable {
    options.watch = watch;
    return measure_extremes(options);
  });
  const Document page = extremes_page(result, provenance("extremes", typed_command()));
  Json json = to_json(page);
  json["complete"] = result.complete;
  if (!flags.out.empty()) {
    const fs::path out(flags.out);
    write_text_file(out / "extremes.csv", to_csv(cells_table(result)));
    write_text_file(out / "extremes.md", to_markdown(result));
    write_text_file(out / "extremes.html", to_html(page));
    write_json(json, (out / "extremes.json").string());
  }
  if (!flags.json.empty()) write_json(json, flags.json);
  if (!flags.silent()) {
    fmt::print("{}", to_text(result));
    for (const ExtremeMatrix::Case& of : result.cases) {
      if (result.cases.size() > 3) break;
      fmt::print("{}: {}.\n  known: {}\n", of.name, of.what, of.known);
      if (!of.existence.empty()) fmt::print("  proved: {}\n", of.existence);
      for (const ExtremeCell& c : result.cells) {
        if (c.name != of.name) continue;
        fmt::print(
            "  {}: {} ({}), guarded {:.2e}, true error {:.2e}, energy created {:.2e}, {} "
            "iterations, {:.3g} s\n",
            c.solver, c.status, c.message, c.guarded, c.true_error, c.energy_error, c.iterations,
            c.cpu_seconds);
      }
    }
    if (!flags.out.empty()) fmt::print("results in {}\n", flags.out);
  }
  if (!result.complete) return kExitInterrupted;
  return count_cells(result, ExtremeCell::kWrong) == 0 ? kExitConverged : kExitNotConverged;
}

CommandDeclaration add_extremes(CommandLine& line, ExtremesFlags& flags) {
  CommandDeclaration command = line.add_command(
      "extremes", "Where solvers hold and where they break: extreme cases, random problems");
  command.option("--only", flags.only, "One case, or all whose names begin so");
  command.option("--solver,--solvers NAMES", flags.solvers, "Solvers (default: all)");
  command.flag("--quick", flags.quick, "A tenth of the time a cell, without the large case");
  command.option("--tol", flags.tol, "Tolerance", {.show_default = true, .positive = true});
  command.option("--time-limit SECONDS", flags.time_limit,
                 "CPU seconds of a cell (2; quick 0.2) or of a random problem (2)",
                 {.positive = true});
  command.option("--dump-problem FILE", flags.dump_problem,
                 "Write the one problem as an FCLIB file instead of solving it");
  const char* group = "Random sets (instead of the cases)";
  command.option("--random-problems N", flags.random_problems,
                 "So many problems: the first solver sees all, the others share them",
                 {.group = group, .positive = true});
  command.option("--random-scenes N", flags.random_scenes,
                 "So many scenes, 20 steps each, by the first solver",
                 {.group = group, .positive = true});
  command.option("--seed", flags.seed, "Of the sets", {.show_default = true, .group = group});
  command.option("--first", flags.first, "Index to begin with",
                 {.show_default = true, .group = group, .not_negative = true});
  add_output_flags(command, flags, "Folder for extremes.csv, .json and .html, random.csv");
  command.footer(
      "Ends with 0 when nothing was wrong (no false claim of convergence, NaN, crash, hang or energy\n"
      "against theory), with 1 otherwise; a problem that is not solved and says so is not wrong.\n"
      "Examples:\n"
      "  bipot extremes --quick --out out/extremes\n"
      "  bipot extremes --only wedge --solver auto,ipm\n"
      "  bipot extremes --random-problems 10000 --random-scenes 1000 --seed 1\n"
      "  bipot extremes --random-problems 1 --first 7 --dump-problem out/seventh.hdf5");
  return command;
}

/// Throws std::invalid_argument for flags that would have no effect.
void require_effect(const ExtremesFlags& flags) {
  const ExtremesFlags none;
  const bool random = flags.random_problems + flags.random_scenes > 0;
  const bool dumps = !flags.dump_problem.empty();
  const auto refuse = [](bool given, const char* flag, const char* why) {
    if (given) throw std::invalid_argument(fmt::format("{} has no effect {}", flag, why));
  };
  refuse(random && !flags.only.empty(), "--only", "on random sets");
  refuse(random && flags.quick, "--quick", "on random sets");
  refuse(!random && flags.seed != none.seed, "--seed", "without random sets");
  refuse(!random && flags.first != none.first, "--first", "without random sets");
  refuse(flags.random_scenes > 0 && flags.random_problems == 0 && flags.solvers.size() > 1,
         "a second --solver", "on random scenes: the first one runs them all");
  refuse(dumps && !flags.out.empty(), "--out", "with --dump-problem");
  refuse(dumps && flags.quick, "--quick", "with --dump-problem");
  refuse(dumps && flags.random_scenes > 0, "--random-scenes", "with --dump-problem");
  refuse(dumps && !flags.solvers.empty(), "--solver", "with --dump-problem");
  refuse(dumps && flags.tol != none.tol, "--tol", "with --dump-problem");
  refuse(dumps && flags.time_limit, "--time-limit", "with --dump-problem");
  refuse(dumps && !flags.json.empty(), "--json", "with --dump-problem");
}

int run_extremes(const ExtremesFlags& flags) {
  require_effect(flags);
  if (!flags.dump_problem.empty()) return dump(flags);
  flags.prepare();
  if (flags.random_problems + flags.random_scenes > 0) return random_sets(flags);
  return matrix(flags);
}

}  // namespace

ProgramCommand extremes_command(CommandLine& line) {
  return make_command(line, &add_extremes, &run_extremes);
}

}  // namespace bipot
