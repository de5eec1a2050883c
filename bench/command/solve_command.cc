#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/exit_code.h"
#include "bench/command/run_processes.h"
#include "bench/command/say.h"
#include "bench/command/several_command.h"
#include "bench/measure/problem_target.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/json_output.h"
#include "bench/report/text_lines.h"
#include "core/base/counted.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/base/stopwatch.h"
#include "core/base/version.h"
#include "core/criterion/contact_error.h"
#include "core/files/atomic_file.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_file.h"
#include "core/problem_files/problem_geometry.h"
#include "solvers/analysis/existence.h"
#include "solvers/auto/auto_plan.h"
#include "solvers/auto/islands.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

int exit_code_of(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged:
    case SolveStatus::kNothingToDo:
      return kExitConverged;
    case SolveStatus::kInvalidInput:
      return kExitBadInput;
    case SolveStatus::kInterrupted:
      return kExitInterrupted;
    case SolveStatus::kNumericalFailure:
    case SolveStatus::kDiverged:
      return kExitNumericalFailure;
    default:
      return kExitNotConverged;
  }
}

using Certificate = std::optional<ExistenceCertificate>;
using Counts = std::optional<DistributedResult::Counts>;

int exit_code_of(SolveStatus status, const Certificate& certificate) {
  const int code = exit_code_of(status);
  const bool none = certificate && certificate->verdict == Existence::kNone;
  if (none && code == kExitNotConverged) return kExitNumericalFailure;
  const bool undecided = certificate && certificate->verdict == Existence::kUndecided;
  return undecided && InterruptGuard::requested() ? int{kExitInterrupted} : code;
}

Json to_json(const ExistenceCertificate& c) {
  return {{"verdict", to_string(c.verdict)},
          {"margin", c.margin},
          {"statement", to_text(c)},
          {"seconds", c.seconds}};
}

Json summary(const SolveFlags& flags, const std::string& solver, const ContactProblem& problem,
             const SolveResult& r, const Certificate& certificate, const Counts& counts,
             const std::string& explanation) {
  Json j{{"command", "solve"},
         {"version", program_version()},
         {"problem", flags.problem},
         {"status", to_string(r.status)},
         {"message", r.message},
         {"exit_code", exit_code_of(r.status, certificate)},
         {"solver", solver},
         {"warm", flags.warm},
         {"iterations", r.iterations},
         {"setup_seconds", r.setup_seconds},
         {"solve_seconds", r.solve_seconds}};
  add_error(j, r.error);
  const ContactCount count =
      r.s.size() == problem.num_rows() ? count_contacts(problem, r.s) : ContactCount{};
  j["contacts"] = problem.num_contacts();
  j["dim"] = problem.dim;
  j["take_off"] = count.take_off;
  j["stick"] = count.stick;
  j["slip"] = count.slip;
  if (problem.equality && r.s.size() == problem.num_rows()) {
    const Vector impulses = multipliers(problem, r.s);
    j["equality_rows"] = impulses.size();
    j["equality_residual"] = equality_residual(problem, r.s);
    j["multipliers"] = std::vector<double>(impulses.begin(), impulses.end());
  }
  if (certificate) j["existence"] = to_json(*certificate);
  if (counts) j["distributed"] = to_json(*counts);
  if (!explanation.empty()) j["explanation"] = explanation;
  return j;
}

void print_summary(const SolveFlags& flags, const std::string& solver, const ContactProblem& p,
                   const SolveResult& r, const Certificate& certificate, const Counts& counts) {
  const ContactCount count = count_contacts(p, r.s);
  fmt::print("{}: {}, d = {}\n", flags.problem, counted(p.num_contacts(), "contact"), p.dim);
  fmt::print("  {}: {} ({})\n", solver, to_string(r.status),
             flags.explain ? r.message : short_reason(r.message));
  fmt::print("  iterations {}, set-up {:.3e} s, solve {:.3e} s\n", r.iterations, r.setup_seconds,
             r.solve_seconds);
  fmt::print("  energy ε {:.3e}, residual η {:.3e}, the paper's (42) {:.3e}, natural map {:.3e}\n",
             r.error.epsilon, r.error.eta, r.error.raw42, r.error.natural_map);
  fmt::print("  open {}, stick {}, slip {}\n", count.take_off, count.stick, count.slip);
  if (p.equality) {
    fmt::print("  {}, |G v - b| {:.1e} m/s, largest impulse {:.3e} N s\n",
               counted(static_cast<int>(p.equality->b.size()), "equality row"),
               equality_residual(p, r.s), multipliers(p, r.s).cwiseAbs().maxCoeff());
  }
  if (certificate) fmt::print("  {} [{:.2g} s]\n", to_text(*certificate), certificate->seconds);
  if (counts) fmt::print("{}", to_text(*counts));
}

CommandDeclaration add_solve(CommandLine& line, SolveFlags& flags) {
  CommandDeclaration command =
      line.add_command("solve", "Solve one problem (a file: FCLIB HDF5, Siconos text)");
  command.option(
      "problem", flags.problem,
      "Problem file, name of a shipped problem, or one problem of `compare`: pyramid:12, "
      "a step of a run as drum@100 or pour:32@60",
      {.required = true, .suggest = names_of(shipped_problems())});
  command.flag("--warm", flags.warm,
               "Start from the file's first guess (FCLIB /guesses), not from s = 0");
  command.option("--several N", flags.several,
                 "Look for several exact answers from N starts; --seed S draws others",
                 {.between = {{1, 10000}}});
  command.flag("--explain", flags.explain,
               "With --solver auto: print which stages are planned, and why");
  command.flag("--accept-indefinite", flags.accept_indefinite,
               "Take a W that is not symmetric or not positive semidefinite; each verdict says so");
  command.flag("--certify", flags.certify,
               "Say whether a solution exists at all, by a proof that is checked in extended "
               "precision; the solver then gets half of --time-limit");
  add_reproducible_flag(command, flags.reproducible);
  add_common_flags(command, flags.common);
  command.option("--solution FILE", flags.solution,
                 "Write r, u (and v) into the /solution group of this FCLIB file; a file that does "
                 "not exist is created with the problem",
                 {.group = "Results"});
  command.option("--history FILE", flags.history, "Write the judged iterations as CSV",
                 {.group = "Results"});
  add_solver_flags(command, flags.solver);
  command.footer(
      "Examples:\n"
      "  bipot solve problem.hdf5\n"
      "  bipot solve problem.hdf5 --out out/problem\n"
      "  bipot solve problem.hdf5 --several 12 --out out/answers\n"
      "  bipot solve problem.hdf5 --certify\n"
      "  bipot solve pour:32@60 --warm --solver homotopy\n"
      "  bipot solve problem.dat --solver pgs --tol 1e-10 --json - --solution solved.hdf5");
  return command;
}

/// --out DIR stands for the three files in DIR, unless a flag names another place.
SolveFlags with_folder(SolveFlags flags) {
  const std::filesystem::path out = flags.common.out;
  if (out.empty()) return flags;
  flags.common.prepare();
  if (flags.common.json.empty()) flags.common.json = (out / "summary.json").string();
  if (flags.history.empty()) flags.history = (out / "history.csv").string();
  if (flags.solution.empty()) flags.solution = (out / "solution.hdf5").string();
  return flags;
}

/// Equal up to the rounding of another code's text.
bool close(const Vector& a, const Vector& b) {
  return a.size() == b.size() && (a - b).norm() <= 1e-9 * std::max(a.norm(), b.norm());
}

/// Refuses an unsuitable file for --solution before the solve: not writable, not FCLIB, or of
/// another problem.
void check_solution_file(const std::string& path, const ContactProblem& problem) {
  require_writable(path);
  if (path.empty() || !std::filesystem::exists(path)) return;
  std::optional<ProblemFile> there;
  try {
    there = read_fclib(path);
  } catch (const FileError& e) {
    throw std::invalid_argument(fmt::format("--solution: {}", e.what()));
  }
  const ContactProblem& other = there->problem;
  // Both forms give W, and a problem is W, u_free and mu; a non-uniform vector distinguishes two W.
  const auto product = [](const ContactProblem& p) {
    const DelassusOperator delassus(p);
    Vector probe(p.num_rows()), result(p.num_rows());
    for (Eigen::Index i = 0; i < probe.size(); ++i) {
      probe[i] = std::cos(1.0 + static_cast<double>(i));
    }
    delassus.apply(probe, result);
    return result;
  };
  if (other.dim != problem.dim || !close(other.u_free, problem.u_free) ||
      !close(other.mu, problem.mu) || !close(product(other), product(problem))) {
    throw std::invalid_argument(path +
                                ": --solution names a file with another problem in it; name "
                                "another file, a new one is made");
  }
}

/// The problem to solve, and its options.
struct SolveTask {
  SolveFlags flags;
  bool replaces_solution = false;  // that in --out, of another problem perhaps
  ProblemFile file;
  SolverChoice choice;
  const SolverEntry* entry = nullptr;
  SolverOptions options;
  DistributedOptions distributed;
};

/// The problem of a target that is no file. `watch`: of the command.
ProblemFile problem_of(const std::string& target, const CommonFlags& common,
                       const Stopwatch& watch) {
  refuse_on_several_processes(common, "a target that is no file");
  TargetOptions options;
  if (!common.quiet) options.warn = &warn_once;
  options.cancelled = [&] {
    return InterruptGuard::requested() || watch.seconds() >= common.time_limit;
  };
  const std::vector<ProblemSource> sources = expand_targets({target}, options);
  if (sources.size() > 1) {
    const std::string& name = sources.back().name;
    throw std::invalid_argument(fmt::format("{}: {} problems; name one, as {}{}", target,
                                            sources.size(), target, name.substr(name.rfind('@'))));
  }
  TestProblem made;
  try {
    made = sources.front().load();
  } catch (const Interrupted&) {
    if (InterruptGuard::requested()) throw;
    throw CommonCommandFailure(
        kExitNotConverged, fmt::format("{}: time limit {} s reached before the problem was made",
                                       target, common.time_limit));
  }
  ProblemFile file{.problem = std::move(made.problem), .info = {.title = made.origin}};
  if (made.start.size() != 0) file.guesses.push_back(std::move(made.start));
  return file;
}

ProblemFile read_file(const SolveFlags& flags, const Stopwatch& watch) {
  const bool exists = std::filesystem::exists(flags.problem);
  if (!exists && (flags.problem.find_first_of(":@") != std::string::npos ||
                  std::ranges::count(names_of(shipped_scenes()), flags.problem) > 0)) {
    return problem_of(flags.problem, flags.common, watch);
  }
  return readable(flags.problem,
                  [&] { return read_problem(flags.problem, flags.accept_indefinite); });
}

/// Reads and checks; files are made by the root process.
SolveTask prepare(const SolveFlags& given, const Stopwatch& watch) {
  SolveTask task;
  refuse_on_several_processes(given.common, given.explain ? "--explain" : "");
  task.file = read_file(given, watch);
  task.flags = is_speaker() ? with_folder(given) : given;
  const ContactProblem& problem = task.file.problem;
  if (is_speaker()) {
    task.replaces_solution = given.solution.empty();
    if (!task.replaces_solution) check_solution_file(given.solution, problem);
    for (const std::string& path : {task.flags.solution, task.flags.common.json}) {
      require_writable(path);
    }
    require_apart({{"--json", task.flags.common.json}, {"--history", task.flags.history}},
                  {{"the problem", given.problem}, {"--solution", task.flags.solution}});
  }
  task.choice = merged(SolverChoice{}, given.solver);
  task.entry = &require_solver(task.choice.name);
  task.options = to_options(task.choice);
  const double left = std::max(1e-9, given.common.time_limit - watch.seconds());
  task.options.time_limit = left / (given.certify ? 2 : 1);
  task.options.execution.threads = given.common.threads;
  if (given.warm) {
    if (task.file.guesses.empty()) {
      throw std::invalid_argument(given.problem +
                                  ": --warm, but the file has no guess to start from");
    }
    task.options.s0 = task.file.guesses.front();
  }
  task.distributed.reproducible = given.reproducible;
  if (on_several_processes()) {
    if (const auto geometry = read_geometry(given.problem, problem.num_contacts())) {
      task.distributed.contact_places = contact_places(geometry->state);
    }
  }
  return task;
}

/// The file of --history.
struct HistoryFile {
  std::ofstream file;
  int last = -1;  ///< iteration of the last row

  void add(int iteration, double seconds, const ContactError& error, double step,
           const ContactCount& count) {
    if (!file.is_open()) return;  // another process writes
    file << fmt::format("{},{:.6e},{:.9e},{:.9e},{:.9e},{:.9e},{:.9e},{},{},{}\n", iteration,
                        seconds, error.epsilon, error.eta, error.raw42, error.natural_map, step,
                        count.take_off, count.stick, count.slip);
    last = iteration;
  }
};

/// Opens the file of --history, which the solve fills.
void record_history(const std::string& path, HistoryFile& history, SolverOptions& options) {
  if (path.empty()) return;
  if (is_speaker()) {
    history.file.open(path);
    if (!history.file) throw FileError(path, "", "cannot be written");
    history.file
        << "iteration,seconds,epsilon,eta,epsilon_raw,natural_map,step,take_off,stick,slip\n";
  }
  options.on_iteration = [&history](const IterationRecord& r) {
    history.add(r.iteration, r.seconds, r.error, r.step, r.count());
  };
}

void write_solution(const SolveTask& task, const SolveResult& result) {
  const ContactProblem& problem = task.file.problem;
  const std::string& path = task.flags.solution;
  if (path.empty()) return;
  if (task.replaces_solution) std::filesystem::remove(path);
  if (problem.num_contacts() == 0) return;  // FCLIB has no empty problem
  // The velocities v follow from the form of the file, which may not be that of the problem.
  if (std::filesystem::exists(path)) return write_fclib_solution(path, result.s, result.u);
  AtomicFile file(path);
  write_fclib(file.draft(), problem, task.file.info);
  write_fclib_solution(file.draft(), result.s, result.u);
  file.commit();
}

std::string explanation_of(const SolveTask& task) {
  if (task.choice.name != "auto") {
    throw std::invalid_argument("--explain explains the choice of --solver auto");
  }
  return explain_islands(task.file.problem) + explain_auto(task.file.problem, task.options);
}

int run_solve(const SolveFlags& typed) {
  const Stopwatch watch;
  const InterruptGuard interrupt;
  SolveFlags given = typed;
  given.problem = find_problem(typed.problem).string();
  if (given.several) {
    together([&] { refuse_on_several_processes(given.common, "--several"); });
    return several_command(given, read_file(given, watch));
  }
  SolveTask task;
  HistoryFile history;
  together([&] {
    task = prepare(given, watch);
    // Taking part in recording depends on the flags, not on the folder, so that all processes
    // agree.
    const bool recorded = !given.history.empty() || !given.common.out.empty();
    record_history(recorded && !is_speaker() ? "elsewhere" : task.flags.history, history,
                   task.options);
  });
  const ContactProblem& problem = task.file.problem;
  const SolveFlags& flags = task.flags;
  task.options.cancelled = &InterruptGuard::requested;
  const std::string explanation = flags.explain ? explanation_of(task) : "";
  if (flags.common.json != "-") fmt::print("{}", explanation);
  SolveResult result;
  Counts counts;
  if (on_several_processes() || flags.reproducible) {
    DistributedResult distributed = distributed_solve(task.choice.name, problem, task.options,
                                                      run_processes(), task.distributed);
    result = std::move(distributed.result);
    counts = distributed.counts;
  } else {
    result = solve(*task.entry, problem, task.options);
  }
  if (!is_speaker()) return exit_code_of(result.status);
  if (!task.file.caution.empty()) result.message += "; " + task.file.caution;
  Certificate certificate;
  if (flags.certify && result.status != SolveStatus::kInvalidInput) {
    certificate = certify_existence(problem, flags.common.time_limit - watch.seconds(),
                                    &InterruptGuard::requested);
  }
  if (!flags.history.empty()) {
    // Solvers that look at their answer in the end alone; refused problems have none.
    if (result.iterations > history.last && result.s.size() > 0) {
      history.add(result.iterations, result.setup_seconds + result.solve_seconds, result.error,
                  kNaN, count_contacts(problem, result.s));
    }
    history.file.close();
    if (!history.file) throw FileError(flags.history, "", "cannot be written");
  }
  const bool refused = result.status == SolveStatus::kInvalidInput;
  if (!refused) write_solution(task, result);  // before the JSON, which a failure would double
  if (!flags.common.json.empty()) {
    write_json(summary(flags, task.choice.name, problem, result, certificate, counts, explanation),
               flags.common.json);
  }
  if (refused) {
    say("bipot: {}: {}\n", flags.problem, result.message);
    return kExitBadInput;
  }
  if (!flags.common.quiet && flags.common.json != "-") {
    print_summary(flags, task.choice.name, problem, result, certificate, counts);
  }
  return exit_code_of(result.status, certificate);
}

}  // namespace

ProgramCommand solve_command(CommandLine& line) {
  return make_command(line, &add_solve, &run_solve);
}

}  // namespace bipot
