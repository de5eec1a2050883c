#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A result for which a whole simulation is run.
struct TradeQuantity {
  std::string name, unit;
  std::string meaning;     ///< one line
  double exact = kNaN;     ///< where theory knows it
  double least_scale = 0;  ///< errors are divided by max(|reference|, least_scale)
  double scale(double reference) const;
};

/// Records the quantities of a run. They depend on the bodies alone, not on the time step or the
/// model:
///   a ball above a floor     heights and durations of its first two bounces (Table 1, exact)
///   a disk that slides       speed and time from which it rolls (Table 2, exact)
///   anything else            height of the sample and of its centre of mass, mean pressure, load
///                            on the floor over the weight, energy lost and its part by friction,
///                            loaded contacts, remaining speed, travel of driven walls, mass
///                            through outlets
///   frictionless columns     besides, the worst force in a column against the weight above it
/// Loads, pressure, contacts and speed are means over the last tenth of the run.
template <int D>
class OutcomeRecorder {
 public:
  explicit OutcomeRecorder(const Scene<D>& scene);
  OutcomeRecorder(const OutcomeRecorder&) = delete;
  OutcomeRecorder& operator=(const OutcomeRecorder&) = delete;
  const std::vector<TradeQuantity>& quantities() const { return quantities_; }

  void step(const State<D>& state, const StepReport<D>& report);
  /// In the order of quantities(); NaN for events that the run did not reach, and for places and
  /// pressure if all bodies have left.
  std::vector<double> values() const;

 private:
  enum class Kind { kBall, kSlider, kSample };
  double weight_of(const State<D>& state) const;
  void end_with(const State<D>& state);
  void measure(TradeQuantity quantity, std::function<double()> value);
  void plan_ball(double gap);
  void plan_slider();
  void plan_sample();
  void find_columns();

  const Scene<D>& scene_;
  Kind kind_ = Kind::kSample;
  std::vector<TradeQuantity> quantities_;
  std::vector<std::function<double()>> values_;  // theirs, at the end
  Vec<D> up_ = Vec<D>::Zero();
  double g_ = 0, weight_ = 0;
  double end_ = 0;  // duration of the run

  std::vector<double> impacts_, tops_;  // ball: ends of its flights, and their tops
  bool flies_ = false;
  double floor_ = 0;
  double slowing_ = 0, rolls_from_ = kNaN;  // slider: of its contact [m/s²]; when it stops sliding
  // Sample.
  int step_ = 0;
  double window_steps_ = 0;
  double pressure_ = 0, floor_load_ = 0, contacts_ = 0, speed2_ = 0, column_error_ = 0;
  double last_speed2_ = 0, last_kinetic_ = 0;  // at the end of the step before
  double friction_loss_ = 0, lost_ = 0;
  bool has_floor_ = false;
  std::vector<double> load_above_;  // weight on the lower contact of each disk; empty: no columns
  double base_load_ = 0;
  State<D> last_;
  bool ended_ = false;
};

}  // namespace bipot
