#include "bench/compare/comparison_several.h"

#include <fmt/format.h>

#include "bench/compare/comparison_success.h"
#include "bench/measure/statistics.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

double largest(const std::vector<double>& x) {
  double most = kNaN;
  for (const double value : x) most = std::fmax(most, value);
  return most;
}

SeveralShare share_of(const Comparison& comparison, const SuccessCurve::SizeClass& size) {
  SeveralShare share{.size = size.name};
  std::vector<double> velocity, force, energy;
  for (const Comparison::Problem& p : comparison.problems) {
    if (!size.has(p.contacts) || p.answers == 0) continue;
    ++share.problems;
    if (!p.several_velocities()) continue;
    ++share.several;
    velocity.push_back(p.reference.spread.velocity);
    force.push_back(p.reference.spread.force);
    energy.push_back(p.reference.spread.energy);
  }
  share.median_velocity = median(velocity);
  share.largest_velocity = largest(velocity);
  share.median_force = median(force);
  share.largest_force = largest(force);
  share.largest_energy = largest(energy);
  return share;
}

}  // namespace

std::vector<SeveralShare> several_shares(const Comparison& comparison) {
  std::vector<SeveralShare> shares;
  for (const SuccessCurve::SizeClass& size : size_classes()) {
    const SeveralShare share = share_of(comparison, size);
    if (share.problems > 0) shares.push_back(share);
  }
  if (!shares.empty()) {
    shares.push_back(share_of(comparison, {"all", 0, std::numeric_limits<int>::max()}));
  }
  return shares;
}

Table several_shares_table(const std::vector<SeveralShare>& shares) {
  Table table{.columns = {{"size", "contacts"},
                          {"problems", "problems", count_label},
                          {"several", "several", count_label},
                          {"share", "share", share_label},
                          {"median_velocity", "velocity, median", error_label},
                          {"largest_velocity", "most", error_label},
                          {"median_force", "force, median", error_label},
                          {"largest_force", "most", error_label},
                          {"largest_energy", "energy, most", error_label}},
              .key = "several",
              .note = "Problems: those with a reference below 1e-9."};
  for (const SeveralShare& s : shares) {
    table.add({s.size, s.problems, s.several, s.share(), s.median_velocity, s.largest_velocity,
               s.median_force, s.largest_force, s.largest_energy});
  }
  return table;
}

Table several_problems_table(const Comparison& comparison) {
  Table table{.columns = {{"problem", "problem"},
                          {"contacts", "contacts", count_label},
                          {"answers", "answers known", count_label},
                          {"velocity", "velocities apart", error_label},
                          {"force", "force on a body", error_label},
                          {"energy", "dissipated energy", error_label}},
              .note =
                  "Velocities: in the energy norm, over the change that contacts make. Force "
                  "on a body: largest difference of a resultant, over the largest resultant. "
                  "Energy: of what contacts dissipate. `bipot solve FILE --several N` looks "
                  "for more."};
  for (const Comparison::Problem& p : comparison.problems) {
    if (!p.several_velocities()) continue;
    table.add({Table::Cell(p.name).shown(comparison.link_to(p)), p.contacts, p.answers,
               p.reference.spread.velocity, p.reference.spread.force, p.reference.spread.energy});
  }
  return table;
}

std::string several_text(const Comparison& comparison) {
  const std::vector<SeveralShare> shares = several_shares(comparison);
  if (shares.empty() || shares.back().several == 0) return {};
  std::string text;
  for (const Comparison::Problem& p : comparison.problems) {
    if (!p.several_velocities()) continue;
    text += fmt::format("{}: {} exact answers known, apart by {} in velocity, {} in force\n",
                        p.name, p.answers, error_label(p.reference.spread.velocity),
                        error_label(p.reference.spread.force));
  }
  return text + fmt::format(
                    "{} of {} problems with a reference have several exact answers; errors are "
                    "distances to the nearest\n",
                    shares.back().several, shares.back().problems);
}

}  // namespace bipot
