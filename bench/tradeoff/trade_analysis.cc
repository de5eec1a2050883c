#include "bench/tradeoff/trade_analysis.h"

#include <fmt/format.h>

#include "bench/report/labels.h"

namespace bipot {
namespace {

constexpr double kRounding = 1e-12;  // relative errors of an outcome that are nobody's

std::vector<SceneTrade::Cell> cells_of(const Trade& trade, const Trade::Scene& scene) {
  std::vector<SceneTrade::Cell> cells;
  std::vector<std::vector<const Trade::Row*>> rows;
  for (const Trade::Row& row : trade.rows) {
    if (row.scene != scene.name) continue;
    const auto at = std::ranges::find_if(
        cells, [&](const SceneTrade::Cell& c) { return c.setting == row.setting; });
    const auto index = static_cast<std::size_t>(at - cells.begin());
    if (at == cells.end()) {
      cells.push_back({.setting = row.setting});
      rows.emplace_back();
    }
    rows[index].push_back(&row);
  }
  for (std::size_t k = 0; k < cells.size(); ++k) {
    SceneTrade::Cell& cell = cells[k];
    cell.means.assign(scene.quantities.size(), 0.0);
    double cpu = 0, rate = 0, iterations = 0;
    int ran = 0;
    for (const Trade::Row* row : rows[k]) {
      ++cell.runs;
      cell.completed += row->completed() ? 1 : 0;
      if (cell.status.empty() || cell.status == "completed") {
        cell.status = row->status;
        cell.message = row->message;
      }
      for (std::size_t q = 0; q < cell.means.size(); ++q) cell.means[q] += row->values[q];
      if (!std::isfinite(row->cpu) || row->steps == 0) continue;
      ++ran;
      if (row->status == "time limit") {
        cell.cpu_needed = std::fmax(cell.cpu_needed, row->cpu * row->steps_planned / row->steps);
      }
      cpu += row->cpu;
      rate += row->cpu_per_second();
      iterations += row->iterations;
      cell.penetration = std::fmax(cell.penetration, row->penetration);
      cell.worst_guarded = std::fmax(cell.worst_guarded, row->worst_guarded);
      cell.stiffness = row->stiffness;
    }
    if (ran > 0) {
      cell.cpu = cpu / ran;
      cell.cpu_per_second = rate / ran;
      cell.iterations = iterations / ran;
    }
    for (double& mean : cell.means) mean = cell.done() ? mean / cell.runs : kNaN;
  }
  return cells;
}

/// Standard deviation of a quantity between replicas, pooled over the nonsmooth settings with the
/// scene's time step; 0 with single runs.
double spread(const Trade& trade, const SceneTrade& s, std::size_t q) {
  double sum = 0;
  int freedom = 0;
  for (const SceneTrade::Cell& cell : s.cells) {
    if (!cell.setting.equal_steps() || cell.setting.step_factor != 1 || !cell.done() ||
        cell.runs < 2) {
      continue;
    }
    for (const Trade::Row& row : trade.rows) {
      if (row.scene != s.scene->name || !(row.setting == cell.setting)) continue;
      const double difference = row.values[q] - cell.means[q];
      sum += difference * difference;
    }
    freedom += cell.runs - 1;
  }
  return freedom > 0 ? std::sqrt(sum / freedom) : 0;
}

const SceneTrade::Cell* at_step(const SceneTrade& s, double factor) {
  return s.find({.solver = s.solver, .tol = s.step_tol, .step_factor = factor});
}

void time_step_error(const SceneTrade& s, std::size_t q, SceneTrade::Errors& e) {
  const TradeQuantity& quantity = s.scene->quantities[q];
  const SceneTrade::Cell* own = at_step(s, 1);
  if (own == nullptr || !own->done()) return;
  const double value = own->means[q];
  e.reference = value;
  e.reference_kind = "the scene's step, no shorter one was completed";
  const auto usable = [&](const SceneTrade::Cell* c) {
    return c != nullptr && c->done() && std::isfinite(c->means[q]);
  };
  double shortest = 1, apart = 0;  // the latter: from shorter steps, at most
  for (const SceneTrade::Cell& cell : s.cells) {
    const RunSetting& setting = cell.setting;
    if (!setting.equal_steps() || setting.solver != s.solver || setting.tol != s.step_tol) continue;
    if (setting.step_factor >= 1 || !usable(&cell)) continue;
    apart = std::max(apart, std::abs(value - cell.means[q]));
    if (setting.step_factor >= shortest) continue;
    shortest = setting.step_factor;
    e.reference = cell.means[q];
    e.reference_kind = fmt::format("h/{:g}, tol {}", 1 / shortest, tolerance_label(s.step_tol));
  }
  if (std::isfinite(quantity.exact)) {
    e.reference = quantity.exact;
    e.reference_kind = "exact";
    e.step_error = std::abs(value - quantity.exact) / quantity.scale(quantity.exact);
    e.step_error_kind = "against the exact value";
    return;
  }
  const double scale = quantity.scale(e.reference);
  const SceneTrade::Cell *half = at_step(s, 0.5), *quarter = at_step(s, 0.25),
                         *twice = at_step(s, 2);
  if (usable(half) && usable(quarter)) {
    const double first = value - half->means[q], second = half->means[q] - quarter->means[q];
    const double ratio = first / second;
    // Accepts orders between 0.6 and 3, and differences larger than those of replicas.
    if (ratio > 1.5 && ratio < 8 && std::abs(first) / scale > e.noise) {
      e.step_error = std::abs(first) * ratio / (ratio - 1) / scale;
      e.step_error_kind = fmt::format("Richardson, order {:.1f}", std::log2(ratio));
      return;
    }
  }
  if (shortest < 1) {
    e.step_error = apart / scale;
    e.step_error_kind = "largest difference to shorter steps";
  } else if (usable(twice)) {
    e.step_error = std::abs(value - twice->means[q]) / scale;
    e.step_error_kind = "difference to twice the step";
  }
}

/// Solvers at the tightest tolerance of the first one, with another outcome.
void choice_error(const SceneTrade& s, std::size_t q, SceneTrade::Errors& e) {
  const double scale = s.scene->quantities[q].scale(e.reference);
  const SceneTrade::Cell* own = s.find({.solver = s.solver, .tol = s.tols.back()});
  for (const SceneTrade::Cell& cell : s.cells) {
    const RunSetting& setting = cell.setting;
    if (!setting.equal_steps() || setting.solver == s.solver || setting.step_factor != 1) continue;
    if (setting.tol != s.tols.back() || !cell.done()) continue;
    const double apart = std::abs(cell.means[q] - own->means[q]) / scale;
    if (!std::isfinite(apart) || apart <= e.choice) continue;
    e.choice = apart;
    e.other_solver = setting.solver;
  }
}

void solver_errors(const SceneTrade& s, std::size_t q, SceneTrade::Errors& e) {
  const double scale = s.scene->quantities[q].scale(e.reference);
  const SceneTrade::Cell* tightest = s.find({.solver = s.solver, .tol = s.tols.back()});
  for (const double tol : s.tols) {
    const SceneTrade::Cell* cell = s.find({.solver = s.solver, .tol = tol});
    e.solver_error.push_back(std::abs(cell->means[q] - tightest->means[q]) / scale);
  }
  const double bound = e.bound();
  if (s.tols.size() < 2) return;
  for (std::size_t k = s.tols.size(); k-- > 0;) {
    if (!(e.solver_error[k] <= bound)) break;
    e.sufficient_tol = s.tols[k];
  }
}

SceneTrade analyse_scene(const Trade& trade, const Trade::Scene& scene) {
  SceneTrade s{.scene = &scene, .cells = cells_of(trade, scene)};
  for (const SceneTrade::Cell& cell : s.cells) {
    if (cell.setting.equal_steps() && s.solver.empty()) s.solver = cell.setting.solver;
    if (!cell.setting.equal_steps() || cell.setting.solver != s.solver) continue;
    if (cell.setting.step_factor != 1) {
      s.step_tol = cell.setting.tol;
    } else if (cell.done()) {
      s.tols.push_back(cell.setting.tol);
    }
  }
  s.quantities.resize(scene.quantities.size());
  if (s.tols.empty()) return s;
  if (!std::isfinite(s.step_tol)) s.step_tol = s.tols.back();
  bool all_known = true;
  for (std::size_t q = 0; q < s.quantities.size(); ++q) {
    SceneTrade::Errors& e = s.quantities[q];
    e.negligible = trade.negligible;
    const SceneTrade::Cell* own = s.find({.solver = s.solver, .tol = s.step_tol});
    const double size = own == nullptr ? kNaN : own->means[q];
    if (scene.replicas > 1) {
      e.noise = 2 * spread(trade, s, q) * std::sqrt(2.0 / scene.replicas) /
                scene.quantities[q].scale(size);
    }
    time_step_error(s, q, e);
    choice_error(s, q, e);
    solver_errors(s, q, e);
    if (!e.sufficient_tol) {
      all_known = false;
    } else if (!s.sufficient_tol || *e.sufficient_tol < *s.sufficient_tol) {
      s.sufficient_tol = e.sufficient_tol;
      s.decided_by = scene.quantities[q].name;
    }
  }
  if (!all_known) s.sufficient_tol.reset();
  const auto cost = [&](double tol) {
    return s.find({.solver = s.solver, .tol = tol})->cpu_per_second;
  };
  s.cpu_tightest = cost(s.tols.back());
  if (s.sufficient_tol) s.cpu_sufficient = cost(*s.sufficient_tol);
  return s;
}

}  // namespace

double SceneTrade::Errors::bound() const {
  return std::isnan(step_error) ? kNaN
                                : std::max({step_error, noise, negligible, std::fmax(choice, 0)});
}

const SceneTrade::Cell* SceneTrade::find(const RunSetting& setting) const {
  for (const Cell& cell : cells) {
    if (cell.setting == setting) return &cell;
  }
  return nullptr;
}

const SceneTrade::Cell* SceneTrade::sufficient_cell() const {
  return tols.empty() ? nullptr
                      : find({.solver = solver, .tol = sufficient_tol.value_or(tols.back())});
}

double SceneTrade::error(const Cell& cell, std::size_t q) const {
  if (!cell.done()) return kNaN;
  const double reference = quantities[q].reference;
  return std::abs(cell.means[q] - reference) / scene->quantities[q].scale(reference);
}

double SceneTrade::worst_error(const Cell& cell, std::size_t* which) const {
  double worst = kNaN;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    const double e = error(cell, q);
    if (std::isnan(e) || e <= worst) continue;
    worst = e;
    if (which != nullptr) *which = q;
  }
  return worst;
}

std::string SceneTrade::choice_sentence() const {
  const Errors* most = nullptr;
  std::size_t which = 0;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    const Errors& e = quantities[q];
    if (!e.bound_by_choice() || (most != nullptr && e.choice <= most->choice)) continue;
    most = &e;
    which = q;
  }
  if (most == nullptr) return {};
  std::string text =
      fmt::format(" At tolerance {} {} ends {:.2g} % away in '{}'", tolerance_label(tols.back()),
                  most->other_solver, 100 * most->choice, scene->quantities[which].name);
  const std::size_t count = most->solver_error.size();
  const bool beyond = count > 1 && most->choice > 3 * most->solver_error[count - 2];
  text +=
      beyond
          ? fmt::format(
                ", more than tolerances of {} explain: several exact answers of a step, chaos, or "
                "a count at its threshold. No digits below that are paid for.",
                solver)
          : "; no digits below that are paid for.";
  return text;
}

std::string SceneTrade::accuracy_sentence() const {
  const Cell* fixed = find({.solver = solver, .tol = step_tol});
  if (fixed == nullptr || !fixed->done()) return {};
  // The cheapest of those with smaller overlaps, else that with the smallest.
  const Cell* best = nullptr;
  for (const Cell& cell : cells) {
    if (!cell.setting.cut() || !cell.done()) continue;
    const auto rank = [&](const Cell& c) {
      return std::pair(std::max(c.penetration, fixed->penetration), c.cpu_per_second);
    };
    if (best == nullptr || rank(cell) < rank(*best)) best = &cell;
  }
  if (best == nullptr) return {};
  return fmt::format(
      " Parts of steps with --accuracy {:g} cost {:.2g} times as much as the scene's steps, with "
      "overlaps up to {} in place of {} and a worst error of {} in place of {}.",
      best->setting.accuracy, best->cpu_per_second / fixed->cpu_per_second,
      share_label(best->penetration), share_label(fixed->penetration),
      share_label(worst_error(*best)), share_label(worst_error(*fixed)));
}

std::string SceneTrade::what_is_needed() const {
  double needed = 0;
  for (const Cell& cell : cells) {
    if (cell.setting.solver == solver) needed = std::fmax(needed, cell.cpu_needed);
  }
  if (!(needed > 0)) return {};
  // A reserve, to one digit: later steps often cost more.
  const double unit = std::pow(10, std::floor(std::log10(2 * needed)));
  return fmt::format(": give --time-limit {:g}", std::ceil(2 * needed / unit) * unit);
}

std::string SceneTrade::answer() const {
  if (tols.size() < 2) {
    return fmt::format(
        "Undecided: {} completed {}, so that nothing can be compared{}.",
        solver.empty() ? "the run" : solver,
        tols.empty() ? "no tolerance" : "only tolerance " + tolerance_label(tols.front()),
        what_is_needed());
  }
  if (!sufficient_tol) {
    return fmt::format(
        "Undecided: neither a shorter time step nor twice the scene's was completed, so that its "
        "error is not known{}.",
        what_is_needed());
  }
  bool all_same = true;
  double step = 0, floor = 0;
  for (const Errors& e : quantities) {
    step = std::fmax(step, e.step_error);
    floor = std::max(e.negligible, kRounding);
    for (const double x : e.solver_error) all_same &= x == 0;
  }
  if (all_same) {
    return fmt::format(
        "Every tolerance from {} to {} gives the same outcomes to the last bit: {} "
        "solves these contacts exactly. {}{}",
        tolerance_label(tols.front()), tolerance_label(tols.back()), solver,
        step > floor ? "Only the time step matters."
                     : fmt::format("The time step adds less than {}.", tolerance_label(floor)),
        accuracy_sentence());
  }
  const double ratio = cpu_tightest / cpu_sufficient;
  std::string text;
  if (*sufficient_tol == tols.back()) {
    text = fmt::format(
        "Tolerance {}, the tightest that was completed, is needed: at {} the solver still adds "
        "more to '{}' than the time step does.",
        tolerance_label(tols.back()), tolerance_label(tols[tols.size() - 2]), decided_by);
    text += choice_sentence();
  } else {
    text =
        fmt::format("Tolerance {} is enough at this time step", tolerance_label(*sufficient_tol));
    text += *sufficient_tol == tols.front() ? ", the loosest that was tried: "
                                            : fmt::format(" ('{}' decides): ", decided_by);
    text += "from there on the solver's error is below that of the time step";
    if (scene->replicas > 1) text += ", below what nearby runs differ by";
    if (std::ranges::any_of(quantities, [](const Errors& e) { return e.bound_by_choice(); })) {
      text += ", below what solvers differ by";
    }
    if (!quantities.empty() && quantities[0].negligible > 0) {
      text += fmt::format(" or below {} of the outcome", tolerance_label(quantities[0].negligible));
    }
    text += ".";
    text += choice_sentence();
    if (ratio > 1.1) {
      text +=
          fmt::format(" Tolerance {} costs {:.2g} times as much for digits that are lost anyway.",
                      tolerance_label(tols.back()), ratio);
    }
    const Cell* loosest = find({.solver = solver, .tol = tols.front()});
    if (loosest->cpu_per_second > 1.1 * cpu_sufficient) {
      text += fmt::format(
          " It even costs less than {}: what a loose step leaves undone, the next ones must mend.",
          tolerance_label(tols.front()));
    }
    double noise = 0;
    for (const Errors& e : quantities) noise = std::max(noise, e.noise);
    if (noise > 0) {
      text += fmt::format(
          " With {} runs of each setting, differences below {:.2g} % (the worst outcome) cannot "
          "be seen.",
          scene->replicas, 100 * noise);
    }
  }
  return text + accuracy_sentence();
}

std::vector<SceneTrade> analyse_trade(const Trade& trade) {
  std::vector<SceneTrade> scenes;
  for (const Trade::Scene& scene : trade.scenes) scenes.push_back(analyse_scene(trade, scene));
  return scenes;
}

}  // namespace bipot
