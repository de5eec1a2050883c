#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "bench/experiments/claim.h"
#include "core/scene/scene.h"

namespace bipot {

/// Error up to which an observable counts as right, beside its bar: the meaning of "the physics
/// holds" in "at which tolerance?".
inline constexpr double kRightTo = 1e-2;

/// Meaning of an error bar.
inline constexpr const char* kOneRun = "discretisation: one deterministic run";

/// One measurement of an observable.
struct Observation {
  double value = kNaN;
  double bar = 0;  ///< half width of the 95 % error bar of samples; NaN, infinite: unknown
  std::string note;
};

/// A claim on an observable, and its result at each tolerance. The claim has the measurement at the
/// tightest tolerance reached.
struct ValidationRow {
  /// A row at one tolerance.
  struct Point {
    double tol = 0;
    Observation seen;
    double error = kNaN;  ///< of the value, see Expectation::error
    /// Error at most kRightTo (or the allowed one, if that is more) plus the bar.
    bool right = false;
    long steps = 0, unsolved = 0;
    double seconds = 0;   ///< CPU, of the experiment: with the other rows that it measures
    std::string failure;  ///< why there is no value

    /// True if the steps were solved to the tolerance, all but kMayMiss of them, and there is a
    /// value.
    bool reached() const;
  };
  /// What is allowed at the tightest tolerance beside the error bar.
  struct Margin {
    double allowed = 0;  ///< relative error
    std::string why;     ///< time step, bisection
    std::string bar_is;  ///< meaning of the error bar
  };
  ValidationRow() = default;
  ValidationRow(std::string name, std::string quantity, std::string source, std::string formula,
                Expectation range, Margin margin);

  Claim claim;
  std::string group;   ///< heading of the page
  Expectation range;   ///< that of claim.expected
  double allowed = 0;  ///< see Margin
  std::string allowed_why;
  bool takes_tolerance = true;  ///< false: it contains no solve to a tolerance

  std::vector<Point> points;  ///< tolerances falling
  int best = -1;              ///< the tightest tolerance reached; -1: none
  double loosest = kNaN;      ///< right here and at all tighter tolerances reached
  double seconds = 0;         ///< CPU, of all tolerances, of the experiment
  int shared = 1;             ///< rows that the experiment measures

  const Point* measured() const { return best < 0 ? nullptr : &points[to_size(best)]; }
  bool holds() const { return claim.holds.value_or(false); }
  bool undecided() const { return best >= 0 && !claim.holds; }
};

/// Sets the claim's measurement and verdict, best and loosest, from the points.
void judge(ValidationRow& row);

/// 10^-first … 10^-last.
std::vector<double> decades(int first, int last);

/// Observables of one computation, which is repeated for each tolerance.
struct Experiment {
  struct Context {
    bool quick = false;             ///< fewer seeds, fewer bodies, fewer tolerances
    std::string solver = "apgd";    ///< of every step, without islands
    int max_iterations = 20000;     ///< a step
    std::function<bool()> stopped;  ///< asked between steps; may be empty

    bool interrupted() const { return stopped && stopped(); }
  };
  /// One run of an experiment, and what it finds.
  struct Trial {
    double tol = 0;
    const Context& context;
    std::vector<Observation> seen = {};  ///< one for each row
    std::vector<Findings::Figure> figures = {};
    long steps = 0;     ///< time steps (or single problems) that were solved
    long unsolved = 0;  ///< of them, those whose solver missed the tolerance

    SolverChoice choice() const;  ///< of every step
    void draw(std::string name, std::string caption, Chart chart);
    /// Throws std::runtime_error if the context has stopped it: the measurement is meaningless.
    void go_on() const;
  };
  struct Result {
    std::vector<ValidationRow> rows;        ///< judged
    std::vector<Findings::Figure> figures;  ///< of the tightest tolerance that gave some
    bool complete = true;                   ///< false: the context stopped it
  };
  std::vector<ValidationRow> rows;
  std::vector<double> tols = decades(-1, 8);        ///< falling
  std::vector<double> quick_tols = decades(-1, 8);  ///< of --quick; none: left out there
  std::function<void(Trial&)> run;
};

/// What each of the functions makes of an empty experiment.
std::vector<Experiment> made_by(std::initializer_list<void (*)(Experiment&)> makers);

/// All of them, in the order of the page.
std::vector<Experiment> validation_experiments();

/// Runs the experiment at each of its tolerances; its exceptions become part of the points.
/// `on_tolerance`: called before each.
Experiment::Result run_experiment(const Experiment& experiment, const Experiment::Context& context,
                                  const std::function<void()>& on_tolerance = {});

std::vector<Experiment> slope_experiments();          ///< one body on a floor, by hand
std::vector<Experiment> standing_experiments();       ///< three disks, four spheres, a hollow
std::vector<Experiment> impact_experiments();         ///< bouncing, swinging
std::vector<Experiment> collision_experiments();      ///< oblique, spinning, in rows
std::vector<Experiment> mfix_experiments();           ///< DEM-01 to DEM-05
std::vector<Experiment> cohesion_experiments();       ///< hanging, struck
std::vector<Experiment> chain_experiments();          ///< few sweeps look elastic
std::vector<Experiment> indeterminacy_experiments();  ///< admissible forces
std::vector<Experiment> packing_experiments();        ///< coordination, solid fraction
std::vector<Experiment> force_experiments();          ///< distribution of forces
std::vector<Experiment> flow_experiments();           ///< shear, collapse, drum
std::vector<Experiment> silo_experiments();           ///< Janssen
std::vector<Experiment> trend_experiments();          ///< heaps, a shaken box

}  // namespace bipot
