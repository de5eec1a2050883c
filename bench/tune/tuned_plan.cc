#include "bench/tune/tuned_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "bench/measure/statistics.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

constexpr int kParts = 10;  // of the cross-validation

/// The rows of one instance together.
struct Measured : TunedInstance {
  std::string scene, problem;
  TunedInstance::Outcome present;  // of auto
};

std::vector<Measured> instances_of(std::span<const MeasuredRow> rows,
                                   std::span<const TunedVariant> variants) {
  std::vector<Measured> made;
  std::map<std::string, std::size_t> place;
  for (const MeasuredRow& row : rows) {
    const auto [at, fresh] = place.try_emplace(instance_of(row), made.size());
    if (fresh) {
      made.push_back({{.traits = row.traits}, row.scene, row.problem});
      made.back().outcomes.resize(variants.size());
    }
    Measured& instance = made[at->second];
    TunedInstance::Outcome outcome{static_cast<double>(row.iterations), std::max(row.seconds, 1e-7),
                                   row.solved};
    if (row.variant == "auto") {
      instance.present = outcome;
      instance.limit = std::max(instance.limit, row.limit);
      continue;
    }
    const auto variant = std::ranges::find_if(
        variants, [&](const TunedVariant& v) { return v.name == row.variant; });
    if (variant == variants.end()) continue;
    outcome.work /= std::pow(row.traits.contacts, variant->power);
    instance.outcomes[to_size(variant - variants.begin())] = outcome;
    instance.limit = std::max(instance.limit, row.limit);
    if (row.solved && (instance.best == 0 || outcome.seconds < instance.best)) {
      instance.best = outcome.seconds;
    }
  }
  std::erase_if(made, [](const Measured& m) { return m.best == 0; });
  return made;
}

TunedPlan::Regret regret_row(const std::string& name, std::vector<double> ratios, int of) {
  TunedPlan::Regret row{.name = name, .solved = static_cast<int>(ratios.size()), .of = of};
  if (of == 0) return row;
  ratios.resize(to_size(of), kInfinity);
  std::ranges::sort(ratios);
  row.median = sorted_median(ratios);
  row.ninth_tenth = quantile(ratios, 0.9);
  row.worst = ratios.back();
  return row;
}

/// Where the plan has no class, or does not solve the instance, the present plan goes on.
void add_ratio(std::span<const TunedClass> classes, const Measured& m,
               std::vector<double>& ratios) {
  const TunedClass* of = class_of(classes, m.traits);
  bool solved = false;
  double seconds = of == nullptr ? 0 : seconds_of(of->schedule, m, &solved);
  if (!solved && of != nullptr) {
    seconds = 0;
    for (const auto& [variant, budget] : of->schedule) {
      seconds += m.outcomes[variant].seconds_of(budget);
    }
  }
  if (!solved) {
    seconds += m.present.seconds;
    solved = m.present.solved;
  }
  if (solved) ratios.push_back(seconds / m.best);
}

std::string condition_lines(const PlanConditions& c) {
  std::string text;
  const auto bound = [](double x) { return std::isfinite(x) ? fmt::format("{:g}", x) : "inf"; };
  if (c.above >= 0 || std::isfinite(c.up_to)) {
    text += fmt::format("contacts = [{}, {}]\n", bound(c.above), bound(c.up_to));
  }
  if (c.tol_from > 0 || std::isfinite(c.tol_below)) {
    text += fmt::format("tol = [{}, {}]\n", bound(c.tol_from), bound(c.tol_below));
  }
  if (c.marks != 0) text += fmt::format("when = \"{}\"\n", mark_words(c.marks));
  return text;
}

}  // namespace

TunedPlan tune_plan(std::span<const MeasuredRow> rows, std::span<const TunedVariant> variants,
                    int least_rows) {
  const std::vector<Measured> all = instances_of(rows, variants);
  TunedPlan plan;
  plan.variants.assign(variants.begin(), variants.end());
  plan.classes = class_tree(std::vector<TunedInstance>(all.begin(), all.end()), least_rows);
  const int count = static_cast<int>(all.size());

  const bool one_scene =
      std::ranges::all_of(all, [&](const Measured& m) { return m.scene == all.front().scene; });
  const auto part_of = [&](const Measured& m) { return one_scene ? m.problem : m.scene; };
  std::set<std::string> names;
  for (const Measured& m : all) names.insert(part_of(m));
  const std::vector<std::string> scenes(names.begin(), names.end());
  std::vector<double> ratios;
  const int parts = std::min(kParts, static_cast<int>(scenes.size()));
  for (int part = 0; part < parts; ++part) {
    std::set<std::string> left_out;
    for (std::size_t k = to_size(part); k < scenes.size(); k += to_size(parts)) {
      left_out.insert(scenes[k]);
    }
    std::vector<TunedInstance> kept;
    for (const Measured& m : all) {
      if (!left_out.contains(part_of(m))) kept.push_back(m);
    }
    const std::vector<TunedClass> classes = class_tree(kept, least_rows);
    for (const Measured& m : all) {
      if (left_out.contains(part_of(m))) add_ratio(classes, m, ratios);
    }
  }
  plan.regret.push_back(
      regret_row(one_scene ? "tuned, problems left out" : "tuned, scenes left out", ratios, count));
  ratios.clear();
  for (const Measured& m : all) add_ratio(plan.classes, m, ratios);
  plan.regret.push_back(regret_row("tuned, all scenes", ratios, count));
  ratios.clear();
  for (const Measured& m : all) {
    if (m.present.solved) ratios.push_back(m.present.seconds / m.best);
  }
  plan.regret.push_back(regret_row("auto, present plan", ratios, count));
  for (std::size_t v = 0; v < variants.size(); ++v) {
    ratios.clear();
    int ran = 0;
    for (const Measured& m : all) {
      const TunedInstance::Outcome& outcome = m.outcomes[v];
      ran += outcome.work > 0;
      if (outcome.solved) ratios.push_back(outcome.seconds / m.best);
    }
    plan.regret.push_back(regret_row(variants[v].name, ratios, ran));
  }
  return plan;
}

std::string plan_text(const TunedPlan& plan, const std::string& comment) {
  std::string text = comment;
  int number = 0;
  for (const TunedClass& of : plan.classes) {
    text += fmt::format("\n[[class]]\nname = \"measured {}\"\n{}solved = [{}, {}]\nstages = [\n",
                        ++number, condition_lines(of.conditions), of.solved, of.measured);
    std::map<std::size_t, double> done;
    for (const auto& [variant, budget] : of.schedule) {
      const TunedVariant& v = plan.variants[variant];
      const std::size_t space = v.name.find(' ');
      const std::string with = space == std::string::npos
                                   ? ""
                                   : fmt::format(", with = \"{}\"", v.name.substr(space + 1));
      const double more = budget - std::exchange(done[variant], budget);
      const std::string most = v.power == 0
                                   ? fmt::format("{:.0f}", std::ceil(more))
                                   : fmt::format("[{:.4g}, {:g}, 1]", 1.02 * more, v.power);
      // Measured on the whole: there it comes before the shipped stages, and not again on islands.
      text += fmt::format("  {{solver = \"{}\"{}, most = {}, whole = \"only\"}},\n",
                          v.name.substr(0, space), with, most);
    }
    text += fmt::format("  {{list = \"{}\"}},\n]\n", kShippedList);
  }
  return text;
}

std::string regret_text(const TunedPlan& plan) {
  std::string text = fmt::format("{:<32} {:>9} {:>8} {:>8} {:>8}\n", "time over the best row's",
                                 "solved", "median", "9 of 10", "worst");
  for (const TunedPlan::Regret& row : plan.regret) {
    text += fmt::format("{:<32} {:>9} {:>8} {:>8} {:>8}\n", row.name,
                        fmt::format("{}/{}", row.solved, row.of), ratio_label(row.median),
                        ratio_label(row.ninth_tenth), ratio_label(row.worst));
  }
  return text;
}

}  // namespace bipot
