#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "bench/compare/comparison_charts.h"
#include "bench/compare/comparison_report.h"
#include "bench/compare/comparison_rows.h"
#include "bench/compare/comparison_several.h"
#include "bench/compare/comparison_success.h"
#include "bench/compare/warm_gain.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

constexpr const char* kMeetingRows = "cpu_min of the rows with guarded ≤ tol in comparison.csv";

/// A list of names with counts, most first: "ipm (12), auto (3)".
std::string ranked(const std::map<std::string, int>& counts, std::size_t longest) {
  std::vector<std::pair<int, std::string>> order;
  for (const auto& [name, count] : counts) order.emplace_back(-count, name);
  std::ranges::sort(order);
  std::string list;
  for (std::size_t i = 0; i < order.size() && i < longest; ++i) {
    list += fmt::format("{}**{}** ({})", i == 0 ? "" : ", ", order[i].second, -order[i].first);
  }
  return list.empty() ? "–" : list;
}

/// Statement on the uniqueness of the problem's answer.
std::string uniqueness(const Comparison::Problem& p) {
  if (p.poor_reference()) {
    return "**No trusted reference**: solvers are ranked by the guarded error.";
  }
  if (p.several_velocities()) {
    return fmt::format(
        "**Several exact answers**: {} are known, velocities up to {} apart in the energy norm, "
        "the force on a body by {} of the largest. Errors are distances to the nearest.",
        p.answers, error_label(p.reference.spread.velocity), error_label(p.reference.spread.force));
  }
  if (std::isfinite(p.reference.velocity_spread)) {
    return fmt::format("Solvers below 1e-9 agree on the velocities to {}.",
                       error_label(p.reference.velocity_spread));
  }
  return "No second solver stands below 1e-9, so nothing is known of other solutions.";
}

void figure(Document& page, Chart chart, std::string caption, std::string source,
            std::string command) {
  page.add(Figure{.chart = std::move(chart),
                  .caption = std::move(caption),
                  .command = std::move(command),
                  .source = std::move(source)});
}

void answer(const Comparison& c, Document& page) {
  if (!c.complete) page.say("**This comparison was stopped; rows are missing.**");
  page.say(fmt::format(
      "Problems: {}, solvers: {}. For each accuracy: on how many problems some solver reaches it, "
      "which solvers get there first, with the number of problems, and the tolerance that they "
      "need in the median. Errors are true ones, measured against a reference solution.",
      c.problems.size(), solvers_of(c).size()));
  Table table{.columns = {{.name = "true error"},
                          {.name = "reached on", .show = count_label},
                          {.name = "tolerance", .show = tolerance_label},
                          {.name = "fastest on"}}};
  for (double accuracy : kProfileAccuracies) {
    std::map<std::string, int> wins;
    std::vector<double> needed;
    for (const Comparison::Problem& p : c.problems) {
      if (const Comparison::Row* best = fastest_to(p, c.rows, accuracy)) {
        ++wins[best->solver];
        needed.push_back(best->tol);
      }
    }
    std::ranges::sort(needed);
    table.add({accuracy_label(accuracy), fmt::format("{} of {}", needed.size(), c.problems.size()),
               needed.empty() ? kNaN : needed[(needed.size() - 1) / 2], ranked(wins, 4)});
  }
  page.add(std::move(table));
  const Regret r = regret_of(c, "auto");
  if (r.entries.empty()) return;
  page.say(fmt::format(
      "Without a choice, **auto** takes {} times as long as the fastest other solver in the "
      "median, and {} in nine cases of ten.",
      ratio_label(r.median),
      std::isfinite(r.ninth_decile) ? "at most " + ratio_label(r.ninth_decile) + " times as long"
                                    : "does not solve all"));
}

std::string command_of(const ReportContext& context, const std::string& targets) {
  return fmt::format(fmt::runtime(context.command_of_target), targets);
}

/// The diagrams of the largest problems; all others follow problem by problem.
void work_and_precision(const ReportContext& context, const Comparison& c, Document& page) {
  constexpr std::size_t kShown = 4;
  std::vector<const Comparison::Problem*> shown;
  for (const Comparison::Problem& p : c.problems) {
    if (p.defect.empty() && p.contacts > 0) shown.push_back(&p);
  }
  if (shown.empty()) return;
  page.heading("Work and precision", "work");
  page.say(fmt::format(
      "What a solver's time buys: lower left is better, one line a solver, one marker a "
      "tolerance. An empty marker did not meet its tolerance.{}",
      shown.size() > kShown ? " The largest problems are shown; [all](#problems)." : ""));
  std::ranges::stable_sort(shown, std::greater<>(), &Comparison::Problem::contacts);
  shown.resize(std::min(shown.size(), kShown));
  for (const Comparison::Problem* p : shown) {
    figure(page, work_precision_chart(c, *p), c.link_to(*p), "comparison.csv",
           command_of(context, p->target));
  }
}

void answer_by_problem(const Comparison& c, Document& page) {
  page.heading("Fastest, by problem", "answer");
  page.say(
      "Each entry: the fastest solver, the tolerance that it needs for this true error, "
      "and its time.");
  Table table{.columns = {{.name = "problem"},
                          {.name = "contacts", .show = count_label},
                          {.name = "error in"}},
              .note =
                  "A dash: nothing that was tried got there. † several exact answers: errors "
                  "are distances to the nearest that is known. ‡ no reference with a guarded "
                  "error below 1e-9: ranked by the guarded error, because a distance to none "
                  "says nothing."};
  for (double a : kProfileAccuracies) table.columns.push_back({.name = "to " + accuracy_label(a)});
  for (const Comparison::Problem& p : c.problems) {
    const std::string_view error = ranking(p, c.rows).name();
    const char* mark = p.several_velocities() ? " †" : p.poor_reference() ? " ‡" : "";
    std::vector<Table::Cell> cells = {c.link_to(p) + mark, p.contacts,
                                      error.substr(0, error.find(' '))};
    for (double a : kProfileAccuracies) {
      const Comparison::Row* best = fastest_to(p, c.rows, a);
      cells.emplace_back(best == nullptr ? "–"
                                         : fmt::format("**{}** at {}\n{}", best->solver,
                                                       tolerance_label(best->tol),
                                                       seconds_label(best->time())));
    }
    table.add(std::move(cells));
  }
  page.add(std::move(table));
}

void several(const Comparison& c, Document& page) {
  const std::vector<SeveralShare> shares = several_shares(c);
  if (shares.empty()) return;
  page.heading("Several answers", "several");
  page.say(
      "Coulomb's law does not always decide. Two impulses prove it where both are verified to a "
      "guarded error of 1e-9 or better and their velocities are farther apart than a hundred "
      "times what these errors explain. Such a problem is marked †. Errors of its rows are "
      "distances to the nearest answer that is known. Digits below the spread say nothing about "
      "one body: energies and means over many steps or runs survive, one body's force at one "
      "instant does not. Nobody has looked for all answers: shares are lower bounds.");
  page.add(several_shares_table(shares));
  if (shares.back().several > 0) page.add(several_problems_table(c));
}

void solver_summary(const Comparison& c, Document& page) {
  page.heading("Who solves what", "solvers");
  Table table{.columns = {{.name = "solver"}},
              .note =
                  "Solved: the guarded error, recomputed from the impulses, is at most the "
                  "tolerance; not solved, too, are problems that a solver does not take. time / "
                  "best: median over the solved problems of the solver's time over the fastest "
                  "solver's. Natural map: at the tightest tolerance."};
  std::vector<std::vector<SolvedCount>> counts;
  for (double tol : tolerances_of(c)) {
    counts.push_back(count_solved(c, tol));
    table.columns.push_back({.name = "solved at " + tolerance_label(tol), .show = count_label});
    table.columns.push_back({.name = "time / best", .show = ratio_label});
  }
  table.columns.push_back({.name = "natural map ≤ 1e-8", .show = count_label});
  const std::vector<std::string> solvers = solvers_of(c);
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    std::vector<Table::Cell> cells = {solvers[s]};
    for (const auto& at_tol : counts) {
      cells.emplace_back(fmt::format("{} of {}", at_tol[s].solved, at_tol[s].problems));
      cells.emplace_back(at_tol[s].median_ratio);
    }
    const SolvedCount& last = counts.back()[s];
    cells.emplace_back(fmt::format("{} of {}", last.by_natural_map, last.problems));
    table.add(std::move(cells));
  }
  page.add(std::move(table));
}

void regret(const ReportContext& context, const Comparison& c, Document& page) {
  const std::vector<std::string> solvers = solvers_of(c);
  if (solvers.size() < 2 || std::ranges::find(solvers, "auto") == solvers.end()) return;
  page.heading("What it costs to let auto choose", "auto");
  const Regret all = regret_of(c, "auto"), longer = regret_of(c, "auto", 1e-3);
  page.say(fmt::format(
      "The time of `auto` over the time of the fastest other solver that met the same tolerance "
      "on the same problem: {} cases. Below 1, auto is faster than all others. A case that auto "
      "does not solve counts as infinite.{}",
      all.entries.size(),
      all.alone > 0 ? fmt::format(" In {} more, auto alone met the tolerance.", all.alone) : ""));
  if (all.entries.empty()) return;
  Table table{.columns = {{.name = "cases"},
                          {.name = "number", .show = count_label},
                          {.name = "not solved", .show = count_label},
                          {.name = "median", .show = ratio_label},
                          {.name = "90 % below", .show = ratio_label},
                          {.name = "worst", .show = ratio_label}}};
  const auto line = [&table](const std::string& name, const Regret& r) {
    table.add({name, r.entries.size(), r.failed, r.median, r.ninth_decile, r.worst});
  };
  line("all", all);
  line("fastest other ≥ 1 ms", longer);
  for (double tol : tolerances_of(c)) {
    Comparison part;
    for (const Comparison::Row& row : c.rows) {
      if (row.tol == tol) part.rows.push_back(row);
    }
    line("tolerance " + tolerance_label(tol), regret_of(part, "auto"));
  }
  page.add(std::move(table));
  Table worst = regret_table(all);
  worst.rows.resize(std::min(worst.rows.size(), std::size_t{10}));
  worst.caption = "The ten worst cases";
  page.add(std::move(worst));
  figure(page, regret_chart({all, longer}, {"all cases", "fastest other at least 1 ms"}),
         "How often auto is within a multiple of the fastest other solver's time.", kMeetingRows,
         context.made.command);
}

void warm_starts(const Comparison& c, Document& page) {
  const std::vector<WarmGain> gains = warm_gains(c);
  if (gains.empty()) return;
  page.heading("What a warm start gains", "warm");
  page.say(
      "The same problems from the impulses of the step before (a start that the file or the "
      "scene gives) instead of s = 0. Ratios are medians over the problems that both starts "
      "solved; all other parts of the page are about cold starts.");
  page.add(warm_table(gains));
}

void success(const ReportContext& context, const Comparison& c, Document& page) {
  const std::vector<SuccessCurve> curves = success_curves(c);
  if (curves.empty()) return;
  page.heading("Success against tolerance", "success");
  page.say(
      "The share of the problems of a size that a solver brings below a tolerance within the "
      "time limit, whatever it was asked for. The curves end at the tightest tolerance of this "
      "comparison: beyond it nobody was asked.");
  for (const SuccessCurve::SizeClass& size : size_classes()) {
    const auto first = std::ranges::find_if(
        curves, [&](const SuccessCurve& curve) { return curve.size == size.name; });
    if (first == curves.end()) continue;
    figure(page, success_chart(curves, size.name),
           fmt::format("{} problem{} of {}.", first->problems, first->problems == 1 ? "" : "s",
                       size.name),
           "success.csv", context.made.command);
  }
}

void profiles(const ReportContext& context, const Comparison& c, Document& page) {
  constexpr std::size_t kFewest = 8;  // shares of fewer problems are steps, not profiles
  if (c.problems.size() < kFewest) return;
  const std::size_t total = c.problems.size();
  page.heading("Performance profiles", "profiles");
  page.say(
      "How far up a curve starts at the left: the share of problems on which the solver is the "
      "cheapest. How high it ends at the right: the share that it solves at all, within a "
      "thousand times the least cost. In between, the share solved within that multiple of the "
      "least cost (Dolan and Moré 2002).");
  page.heading("At a fixed tolerance", "", 3);
  for (double tol : tolerances_of(c)) {
    const std::string at = tolerance_label(tol);
    figure(page,
           profile_chart(performance_profiles(c, time_at(c, tol)), "time",
                         "Time profile at tolerance " + at),
           fmt::format("Time to meet tolerance {}, {} problems.", at, total), kMeetingRows,
           context.made.command);
    figure(page,
           profile_chart(performance_profiles(c, iterations_at(c, tol)), "iterations",
                         "Iteration profile at tolerance " + at),
           fmt::format("Iterations to meet tolerance {}, {} problems. An iteration costs much "
                       "more in some solvers than in others.",
                       at, total),
           "iterations of the rows with guarded ≤ tol in comparison.csv", context.made.command);
  }
  page.heading("At a fixed true error", "", 3);
  page.say(
      "Time of each solver's cheapest row whose true error is that small, whatever its "
      "tolerance.");
  for (double accuracy : kProfileAccuracies) {
    const std::string to = accuracy_label(accuracy);
    figure(page,
           profile_chart(performance_profiles(c, time_to(c, accuracy)), "time",
                         "Time profile to a true error of " + to),
           fmt::format("Time to a true error of {}, {} problems.", to, total),
           "cpu_min and the error of the ranking (ranked_by) in comparison.csv and "
           "comparison.json",
           context.made.command);
  }
  page.heading("Within a fixed time", "", 3);
  page.say(
      "How the least true error that a solver reaches within the time is distributed over the "
      "problems: the share of problems with an error of at most that on the axis. Higher is "
      "better. Only what the tolerances of this comparison gave is counted.");
  for (double budget : kBudgets) {
    const std::string within = seconds_label(budget);
    figure(page, budget_chart(errors_within(c, budget), "Errors within " + within),
           fmt::format("True error reached within {}, {} problems.", within, total),
           "cpu_min and the error of the ranking in comparison.csv", context.made.command);
  }
}

void series(const ReportContext& context, const Comparison& c, const std::vector<Growth>& all,
            const std::string& name, Document& page) {
  const std::vector<double> tols = tolerances_of(c);
  std::string targets;
  for (const Comparison::Problem& p : c.problems) {
    if (p.series == name) targets += (targets.empty() ? "" : " ") + p.target;
  }
  Table table{.columns = {{.name = "solver"}}};
  for (double tol : tols) {
    const std::string at = ", " + tolerance_label(tol);
    table.columns.push_back({.name = "iterations" + at, .show = value_label});
    table.columns.push_back({.name = "time" + at, .show = value_label});
  }
  for (const std::string& solver : solvers_of(c)) {
    std::vector<Table::Cell> cells = {solver};
    for (double tol : tols) {
      for (const Growth& g : all) {
        if (g.series != name || g.solver != solver || g.tol != tol) continue;
        cells.emplace_back(exponent_label(g.iterations));
        cells.emplace_back(exponent_label(g.time));
      }
    }
    cells.resize(table.columns.size());
    table.add(std::move(cells));
  }
  Document inside;
  inside.add(std::move(table));
  std::vector<double> shown = {tols.front()};
  if (tols.size() > 1) shown.push_back(tols.back());
  for (double tol : shown) {
    for (Growth::Measure quantity : {Growth::Measure::kIterations, Growth::Measure::kTime}) {
      const bool time = quantity == Growth::Measure::kTime;
      figure(inside, growth_chart(all, name, tol, quantity),
             fmt::format("{} at tolerance {}, {}.", time ? "Time" : "Iterations",
                         tolerance_label(tol), name),
             fmt::format("{} in comparison.csv, dofs in comparison.json",
                         time ? "cpu_min" : "iterations"),
             command_of(context, targets));
    }
  }
  page.fold(name, std::move(inside));
}

void growth_with_size(const ReportContext& context, const Comparison& c, Document& page) {
  const std::vector<Growth> all = growth(c);
  if (all.empty()) return;
  page.heading("Growth with size", "growth");
  page.say(
      "Problems that differ in size alone. Iterations and time are fitted by N^p, N the degrees "
      "of freedom, over the sizes that the solver solved; p is given with its 95 % confidence "
      "(Student's t), which needs three sizes. Empty markers were not solved and are not fitted; "
      "a solver that was out of time is not tried on larger sizes.");
  std::vector<std::string> names;
  for (const Growth& g : all) {
    if (names.empty() || names.back() != g.series) names.push_back(g.series);
  }
  for (const std::string& name : names) series(context, c, all, name, page);
}

void problem(const ReportContext& context, const Comparison& c, const Comparison::Problem& p,
             Document& page) {
  if (!p.defect.empty()) return page.say("Not solved by anyone: " + p.defect);
  page.say(fmt::format("{}. {} contacts, d = {}. Reference by {}, guarded error {}, natural map "
                       "{}. {}",
                       p.origin, p.contacts, p.dim,
                       p.reference.solver.empty() ? "nobody" : p.reference.solver,
                       error_label(p.reference.error.guarded()),
                       error_label(p.reference.error.natural_map), uniqueness(p)),
           "small");
  if (p.contacts == 0) return;
  const Ranking rank = ranking(p, c.rows);
  auto best = pareto_rows(p, c.rows);
  std::ranges::sort(best, {}, &Comparison::Row::time);
  std::string list;
  for (const Comparison::Row* row : best) {
    list += fmt::format("{}{} at {} ({}, {})", list.empty() ? "" : "; ", row->solver,
                        tolerance_label(row->tol), seconds_label(row->time()),
                        error_label(rank.of(*row)));
  }
  if (!list.empty()) {
    page.say(fmt::format("Beaten by none in both time and {}: {}.", rank.name(), list));
  }
  const std::string column = rank.measure == Ranking::Measure::kForce      ? "force_error"
                             : rank.measure == Ranking::Measure::kVelocity ? "velocity_error"
                                                                           : "guarded";
  const std::string again = command_of(context, p.target);
  figure(page, work_precision_chart(c, p), "Work and precision, " + p.name + ".",
         "cpu_min and " + column + " in comparison.csv", again);
  figure(page, tolerance_chart(c, p), "Error against tolerance, " + p.name + ".",
         "tol and " + column + " in comparison.csv", again);
  const bool has_history = std::ranges::any_of(
      c.histories, [&p](const Comparison::History& h) { return h.problem == p.name; });
  if (has_history) {
    figure(page, history_chart(c, p), "Guarded error against iteration, " + p.name + ".",
           "history.csv", again);
  }
}

void problems(const ReportContext& context, const Comparison& c, Document& page) {
  page.heading("Problem by problem", "problems");
  page.say(
      "Open a problem for its diagrams. First: what a solver's time buys; lower left is better, "
      "one line a solver, one marker a tolerance; an empty marker did not meet its tolerance. "
      "Then what a tolerance means: the true error that comes with it. Then how the guarded "
      "error falls along one solve at the tightest tolerance that was run.");
  for (const Comparison::Problem& p : c.problems) {
    const Comparison::Row* best = fastest_to(p, c.rows, 1e-2);
    Document inside;
    problem(context, c, p, inside);
    page.fold(fmt::format("**{}** {} contacts{}", p.name, p.contacts,
                          best == nullptr ? ""
                                          : fmt::format(", to 1 %: {} at {}, {}", best->solver,
                                                        tolerance_label(best->tol),
                                                        seconds_label(best->time()))),
              std::move(inside), c.id_of(p), c.problems.size() <= 2);
  }
}

void all_rows(const Comparison& c, Document& page) {
  page.heading("All rows", "all");
  Comparison cold = c;
  cold.warm_rows.clear();
  Table table = rows_table(cold);
  table.note =
      "Click a heading to sort. The status shows the solver's own words when the "
      "pointer rests on it; rows that did not meet their tolerance are marked and stay "
      "in the table. Printed are the rows that are shown.";
  page.add(std::move(table));
}

void measures(Document& page) {
  page.heading("What the measures mean", "measures");
  page.add(Terms{
      {{"tolerance",
        "What the solver was asked for: every solver stops when the guarded error falls below "
        "it."},
       {"guarded",
        "How far the contact law is violated, as energy over energy; recomputed after the solve "
        "from the impulses alone. The larger of ε (the gap in the law plus the energy of "
        "penetration) and η (the natural map measured in energy)."},
       {"natural map",
        "The relative residual that other codes print, with one scaling for each contact."},
       {"raw (42)",
        "The plain error in the law without guards; undefined where nothing slides, and blind "
        "to penetration."},
       {"velocity error",
        "Kinetic energy norm of the difference to the reference velocities, over that of the "
        "velocity change that contacts make. 1 is as wrong as no contact forces at all."},
       {"force error",
        "Resultant contact force on a body, largest difference over all bodies, over the largest "
        "resultant. Given where the problem knows its bodies."},
       {"contact force error",
        "Worst single contact force over the largest one; given only where contact forces are "
        "unique (a packing usually holds itself in many ways) and the problem is small enough to "
        "check."},
       {"penetration",
        "Overlap that the remaining approach velocity adds in one step, as a fraction of the "
        "smallest radius. Given where step and radius are known."},
       {"energy error",
        "Relative error of the energy that the contacts take out of the free motion."},
       {"time",
        "CPU time of set-up, iteration and final check; the least of the repeats. A short solve "
        "is repeated until its repeats took long enough to be measured. All solvers ran once on "
        "a problem of one contact before the first measurement, so that none pays for the start "
        "of a library. Waiting for a core that other programs use does not count."},
       {"wall time", "The same without the final check, by the clock on the wall."},
       {"not tried",
        "The solver was out of time on a smaller problem of the same series at this tolerance or "
        "a looser one, or on this problem at a looser one. It counts as not solved."},
       {"not run again",
        "Said in the words of a row: the solver's path does not depend on the tolerance, and it "
        "was out of time at a looser one already; the row shows where it stood then."},
       {"Pareto", "No other row of the problem is both faster and more accurate."},
       {"reference",
        "Solved to 1e-12, beyond 1000 contacts to 1e-11, or as far as it goes, by auto, newton, "
        "ipm and apgd in turn until one gets there and a second one stands below 1e-9; the "
        "lowest guarded error is kept; errors below the reference's own accuracy mean nothing."},
       {"several answers",
        "What was found on the way, attempts and rows, joins the reference where it is exact to "
        "1e-9 and distinct; rows that end near 1e-6 or better far from all of them are first "
        "solved on from where they are. True errors are distances to the nearest in velocity."}}});
}

void provenance_of_rows(const ReportContext& context, const Comparison& c, Document& page) {
  page.heading("How this was made", "made");
  Terms terms = to_terms(context.made);
  const Comparison::Options& o = context.options;
  terms.entries.emplace_back(
      "limits", fmt::format("{:g} s a solve, {:g} s an attempt at a reference, CPU time; at "
                            "least {} repeat{} and {:g} s of them",
                            o.time_limit, o.reference_time_limit, o.repeat,
                            o.repeat == 1 ? "" : "s", o.min_time));
  const std::vector<std::string> commits = distinct_in_order(c.rows, &Comparison::Row::commit);
  if (commits.size() > 1) {
    terms.entries.emplace_back("rows of commits", fmt::format("{}", fmt::join(commits, ", ")));
  }
  page.add(std::move(terms));
  page.say(
      "The numbers behind all figures stand beside this page: "
      "[comparison.csv](comparison.csv) (a line a row), [history.csv](history.csv) (errors "
      "along the solves), [success.csv](success.csv) (problems solved against tolerance), "
      "[several.csv](several.csv) (problems with several answers) and "
      "[comparison.json](comparison.json) (rows, problems, success, profiles, growth, regret).",
      "small");
}

}  // namespace

Document comparison_page(const Comparison& c, const ReportContext& context, const Document& more) {
  Document page;
  page.title = "Contact solvers: what accuracy costs";
  page.made = context.made;
  page.contents = true;
  answer(c, page);
  work_and_precision(context, c, page);
  answer_by_problem(c, page);
  page.heading("What a tolerance means", "tolerance");
  page.say("The true errors of all rows that met a tolerance, whatever the solver.");
  page.add(meaning_table(c));
  several(c, page);
  solver_summary(c, page);
  regret(context, c, page);
  warm_starts(c, page);
  success(context, c, page);
  profiles(context, c, page);
  growth_with_size(context, c, page);
  page.append(more);
  problems(context, c, page);
  all_rows(c, page);
  measures(page);
  provenance_of_rows(context, c, page);
  return page;
}

}  // namespace bipot
