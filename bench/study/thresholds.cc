// From which ε on is an observable right?

#include <algorithm>
#include <cmath>

#include "bench/report/labels.h"
#include "bench/study/study.h"

namespace bipot {

std::map<int, double> by_seed(const Study::Measured& measured, Study::Case of,
                              const std::string& quantity) {
  std::map<int, double> values;
  of.seed = 0;
  for (auto it = measured.lower_bound(of); it != measured.end(); ++it) {
    // Seeds stand before method, tolerance and x in the order.
    if (it->first.part != of.part || it->first.scene != of.scene || it->first.size != of.size)
      break;
    of.seed = it->first.seed;
    if (it->first != of) continue;
    const auto at = it->second.find(quantity);
    if (at != it->second.end()) values[of.seed] = at->second;
  }
  return values;
}

MeanValue over_seeds(const std::map<int, double>& values) {
  std::vector<double> x;
  for (const auto& [seed, value] : values) x.push_back(value);
  return mean_value(x);
}

Study::Geometric geometric_mean(const std::map<int, double>& values) {
  std::map<int, double> logs;
  for (const auto& [seed, value] : values) {
    if (value > 0 && std::isfinite(value)) logs[seed] = std::log(value);
  }
  const MeanValue mean = over_seeds(logs);
  return {std::exp(mean.mean), std::exp(mean.mean - mean.confidence),
          std::exp(mean.mean + mean.confidence), static_cast<int>(logs.size())};
}

MeanValue paired_difference(const std::map<int, double>& a, const std::map<int, double>& b) {
  std::map<int, double> differences;
  for (const auto& [seed, value] : a) {
    if (b.contains(seed)) differences[seed] = value - b.at(seed);
  }
  return over_seeds(differences);
}

Study::PairedError paired_error(const Study::Measured& measured, const Study::Case& of,
                                const Study::Case& reference, const std::string& quantity) {
  const auto values = by_seed(measured, of, quantity);
  const auto exact = by_seed(measured, reference, quantity);
  const MeanValue off = paired_difference(values, exact);
  const double scale = std::abs(over_seeds(exact).mean);
  return {std::abs(off.mean) / scale, off.confidence / scale, static_cast<int>(values.size())};
}

std::vector<std::string> classed_quantities(const Study::Measured& measured,
                                            const std::string& part, const std::string& scene) {
  std::vector<std::string> all;
  for (const auto& [of, values] : measured) {
    if (of.part != part || of.scene != scene) continue;
    for (const auto& [quantity, value] : values) {
      if (!Study::class_of(quantity).empty()) all.push_back(quantity);
    }
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

namespace {

constexpr double kNeverRight = 1e-12;  // in the place of a threshold, below all

const std::string kThresholds = "thresholds", kReferenceMethod = "apgd";
constexpr double kRight = 0.01;       // relative error of a right observable, beside its bar
constexpr double kDecisiveBar = 0.1;  // relative; wider bars decide nothing

/// What a size is measured with.
struct SizePlan {
  int size;
  std::vector<std::string> methods;
  std::vector<double> tols;
};

std::vector<SizePlan> size_plans(bool quick) {
  const std::vector<std::string> three = {"apgd", "pgs", "ipm"};
  if (quick) return {{64, three, {10, 1e-1, 1e-3}}};
  return {{64, three, {10, 1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6}},
          {169, {"apgd", "pgs"}, {1, 1e-1, 1e-2}},
          {441, {"apgd"}, {1, 1e-1, 1e-2}}};
}

std::vector<Study::Job> threshold_jobs(bool quick) {
  std::vector<Study::Job> jobs;
  for (const SizePlan& plan : size_plans(quick)) {
    for (int seed = 1; seed <= (quick ? 4 : 10); ++seed) {
      for (const char* scene : {"pour", "collapse", "shear"}) {
        for (const std::string& method : plan.methods) {
          for (const double tol : plan.tols) {
            const Study::Sample sample{.scene = scene, .size = plan.size, .seed = seed};
            jobs.push_back(
                {{kThresholds, scene, plan.size, seed, method, tol, 0},
                 [=](const Study::Stopped& stopped) {
                   return Study::run(
                       sample, {.solver = method, .tol = tol, .parameters = {{"islands", "off"}}},
                       stopped);
                 }});
          }
        }
      }
    }
  }
  return jobs;
}

/// One observable by one method at one size, against tolerance.
struct ErrorCurve {
  std::string scene, quantity, method;
  int size = 0;
  std::vector<double> tols;  // falling
  std::vector<Study::PairedError> errors;

  bool right(std::size_t k) const { return errors[k].error <= kRight + errors[k].bar; }
  bool decisive() const {  // at the tightest tolerance
    return !errors.empty() && errors.back().bar <= kDecisiveBar;
  }
  /// Loosest tolerance from which on all are right; NaN: none.
  double threshold() const {
    double from = kNaN;
    for (std::size_t k = tols.size(); k-- > 0 && right(k);) from = tols[k];
    return from;
  }
};

std::vector<ErrorCurve> error_curves(const Study::Measured& measured) {
  std::vector<ErrorCurve> curves;
  for (const std::string& scene : distinct(measured, kThresholds, &Study::Case::scene)) {
    const auto quantities = classed_quantities(measured, kThresholds, scene);
    for (const int size : distinct(measured, kThresholds, &Study::Case::size)) {
      const auto here = [&](const Study::Case& c) { return c.scene == scene && c.size == size; };
      auto tols = distinct<double>(measured, kThresholds, &Study::Case::tol, here);
      if (tols.empty()) continue;
      const Study::Case reference{kThresholds, scene, size, 0, kReferenceMethod, tols.front(), 0};
      std::ranges::reverse(tols);
      for (const auto& method :
           distinct<std::string>(measured, kThresholds, &Study::Case::method, here)) {
        for (const std::string& quantity : quantities) {
          ErrorCurve curve{scene, quantity, method, size, {}, {}};
          for (const double tol : tols) {
            const Study::Case of{kThresholds, scene, size, 0, method, tol, 0};
            if (of.method == reference.method && tol == reference.tol) continue;
            const Study::PairedError e = paired_error(measured, of, reference, quantity);
            if (e.seeds < 2) continue;
            curve.tols.push_back(tol);
            curve.errors.push_back(e);
          }
          if (!curve.tols.empty()) curves.push_back(std::move(curve));
        }
      }
    }
  }
  return curves;
}

/// Of the curves of a class, at a tolerance.
struct ClassError {
  int right = 0, all = 0;
  std::vector<double> errors, bars;
};
ClassError class_error(const std::vector<ErrorCurve>& curves, const std::string& of, double tol,
                       int size = 0) {
  ClassError sum;
  for (const ErrorCurve& c : curves) {
    if (Study::class_of(c.quantity) != of || !c.decisive() || (size != 0 && c.size != size))
      continue;
    for (std::size_t k = 0; k < c.tols.size(); ++k) {
      if (c.tols[k] != tol) continue;
      ++sum.all;
      sum.right += c.right(k) ? 1 : 0;
      sum.errors.push_back(c.errors[k].error);
      sum.bars.push_back(c.errors[k].bar);
    }
  }
  return sum;
}

Document thresholds_report(const Study::Measured& measured) {
  Document part;
  const std::vector<ErrorCurve> curves = error_curves(measured);
  auto tols = distinct(measured, kThresholds, &Study::Case::tol);
  std::ranges::reverse(tols);
  Table by_class{.columns = {{"class", "class"},
                             {"tol", "ε", &tolerance_label},
                             {"right", "right", &count_label},
                             {"of", "of", &count_label},
                             {"median_error", "median error", &share_label},
                             {"upper_error", "9 in 10 below", &share_label},
                             {"median_bar", "median bar", &share_label}},
                 .key = "classes"};
  Chart shares{.title = "Share of observables that are right",
               .x = {.label = "tolerance ε of every step", .kind = Chart::Axis::Kind::kLog},
               .y = {.label = "share right to 1 % or its bar", .low = 0, .high = 1.02}};
  Chart sizes{.title = "Error of the mean observable",
              .x = {.label = "tolerance ε of every step", .kind = Chart::Axis::Kind::kLog},
              .y = {.label = "median relative error", .kind = Chart::Axis::Kind::kLog}};
  shares.width = sizes.width = 520;
  int style = 0;
  for (const std::string& name : kStudyClasses) {
    Chart::Series right{name, style, {}}, error{name, style, {}};
    Chart::Series floor{
        style == 0 ? "bars of the seeds" : "", style, {}, Chart::Series::Kind::kLine};
    floor.background = true;
    for (const double tol : tols) {
      ClassError at = class_error(curves, name, tol);
      if (at.all == 0) continue;
      const double share = static_cast<double>(at.right) / at.all;
      std::ranges::sort(at.errors);
      by_class.add({name, tol, at.right, at.all, median(at.errors), quantile(at.errors, 0.9),
                    median(at.bars)});
      right.points.push_back({tol, share});
      error.points.push_back({tol, median(at.errors)});
      floor.points.push_back({tol, median(at.bars)});
    }
    shares.series.push_back(std::move(right));
    sizes.series.push_back(std::move(error));
    sizes.series.push_back(std::move(floor));
    ++style;
  }
  Table laws{.columns = {{"class", "class"},
                         {"exponent", "error ~ ε^p, p", &ratio_label},
                         {"bar", "±", &ratio_label},
                         {"points", "points", &count_label}},
             .key = "laws",
             .note = "Fitted to all errors above twice their bar at ε ≤ 1."};
  for (const std::string& name : kStudyClasses) {
    std::vector<double> x, y;
    for (const ErrorCurve& c : curves) {
      if (Study::class_of(c.quantity) != name) continue;
      for (std::size_t k = 0; k < c.tols.size(); ++k) {
        if (c.tols[k] > 1 || c.errors[k].error < 2 * c.errors[k].bar) continue;
        x.push_back(c.tols[k]);
        y.push_back(c.errors[k].error);
      }
    }
    const PowerLaw law = fit_power_law(x, y);
    laws.add({name, law.exponent, law.confidence, law.points});
  }
  Table each{.columns = {{"scene", "scene"},
                         {"quantity", "observable"},
                         {"class", "class"},
                         {"size", "disks", &count_label},
                         {"method", "solver"},
                         {"threshold", "right from", &tolerance_label},
                         {"error_at_1", "error at ε = 1", &share_label},
                         {"error_at_01", "at 0.1", &share_label},
                         {"error_at_001", "at 0.01", &share_label},
                         {"bar", "bar at the tightest", &share_label}},
             .key = "observables",
             .sortable = true};
  const auto error_at = [](const ErrorCurve& c, double tol) {
    for (std::size_t k = 0; k < c.tols.size(); ++k) {
      if (c.tols[k] == tol) return c.errors[k].error;
    }
    return kNaN;
  };
  Table worst{.columns = {{"class", "class"},
                          {"size", "disks", &count_label},
                          {"decided", "curves", &count_label},
                          {"median_threshold", "half are right from", &tolerance_label},
                          {"tight_threshold", "9 in 10 right from", &tolerance_label},
                          {"right_1", "right at ε = 1", &count_label},
                          {"of_1", "of", &count_label},
                          {"right_01", "at 0.1", &count_label},
                          {"of_01", "of", &count_label},
                          {"error_01", "median error at 0.1", &share_label},
                          {"bar_01", "median bar", &share_label}},
              .key = "thresholds"};
  for (const std::string& name : kStudyClasses) {
    for (const int size : distinct(measured, kThresholds, &Study::Case::size)) {
      std::vector<double> thresholds;
      for (const ErrorCurve& c : curves) {
        if (Study::class_of(c.quantity) != name || c.size != size || !c.decisive()) continue;
        const double t = c.threshold();
        thresholds.push_back(std::isnan(t) ? -kNeverRight : -t);  // ascending: loosest first
      }
      if (thresholds.empty()) continue;
      std::ranges::sort(thresholds);
      const ClassError at_1 = class_error(curves, name, 1, size);
      const ClassError at_01 = class_error(curves, name, 0.1, size);
      const auto from = [&](double share) {
        const double t = -quantile(thresholds, share);
        return t > kNeverRight ? t : kNaN;
      };
      worst.add({name, size, static_cast<int>(thresholds.size()), from(0.5), from(0.9), at_1.right,
                 at_1.all, at_01.right, at_01.all, median(at_01.errors), median(at_01.bars)});
    }
  }
  for (const ErrorCurve& c : curves) {
    each.add({c.scene, c.quantity, Study::class_of(c.quantity), c.size, c.method, c.threshold(),
              error_at(c, 1), error_at(c, 0.1), error_at(c, 0.01), c.errors.back().bar});
  }
  Table costs{.columns = {{"scene", "scene"},
                          {"size", "disks", &count_label},
                          {"method", "solver"},
                          {"tol", "ε", &tolerance_label},
                          {"cpu", "CPU of a run", &seconds_label},
                          {"overlap", "largest overlap over the radius", &share_label},
                          {"unsolved", "steps not solved", &share_label},
                          {"failed", "runs that ended early", &count_label}},
              .key = "costs",
              .sortable = true};
  for (const std::string& scene : distinct(measured, kThresholds, &Study::Case::scene)) {
    for (const int size : distinct(measured, kThresholds, &Study::Case::size)) {
      for (const std::string& method : distinct(measured, kThresholds, &Study::Case::method)) {
        for (const double tol : tols) {
          const Study::Case of{kThresholds, scene, size, 0, method, tol, 0};
          const auto cpu = by_seed(measured, of, "cpu");
          if (cpu.empty()) continue;
          costs.add({scene, size, method, tol, over_seeds(cpu).mean,
                     over_seeds(by_seed(measured, of, "overlap")).mean,
                     over_seeds(by_seed(measured, of, "unsolved")).mean /
                         over_seeds(by_seed(measured, of, "steps")).mean,
                     static_cast<int>(by_seed(measured, of, "failed").size())});
        }
      }
    }
  }
  part.add(Figure{.chart = shares,
                  .file = "thresholds_share.svg",
                  .caption = "Observables that are right to 1 % or within the bar of their seeds, "
                             "over all scenes, sizes and solvers."});
  part.add(Figure{.chart = sizes,
                  .file = "thresholds_error.svg",
                  .caption = "Median relative error of the means over seeds. Grey: the median bar, "
                             "below which an error cannot be seen."});
  part.add(std::move(worst));
  part.add(std::move(by_class));
  part.add(std::move(laws));
  Document details;
  details.add(std::move(each));
  details.add(std::move(costs));
  part.fold("Every observable, every cost", std::move(details));
  return part;
}

}  // namespace

Study::Part thresholds_part() {
  return {kThresholds, "Thresholds: from which ε on is an observable right?", &threshold_jobs,
          &thresholds_report};
}

}  // namespace bipot
