#pragma once

#include <algorithm>
#include <compare>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/measure/statistics.h"
#include "bench/measure/watch.h"
#include "bench/report/document.h"
#include "bench/tradeoff/run_setting.h"
#include "core/base/types.h"
#include "core/scene/scene.h"

namespace bipot {

/// The measurements behind "How exact must a contact solver be?" (data/study/study.md). They are
/// kept as rows of a CSV file, from which figures and tables are drawn again in seconds.
struct Study {
  /// One measurement: of a scene of `size` disks, drawn by the seed, with a method to a tolerance.
  struct Case {
    std::string part, scene;
    int size = 0, seed = 0;
    std::string method;
    double tol = 0;  ///< 0: none
    double x = 0;    ///< the part's own variable: a speed, a height, a step factor
    auto operator<=>(const Case&) const = default;
  };
  using Values = std::map<std::string, double>;  ///< by quantity; "cpu" in each  [s]
  using Measured = std::map<Case, Values>;
  using Stopped = std::function<bool()>;  ///< polled inside solves; never empty
  struct Job {
    Case of;
    std::function<Values(const Stopped&)> run;
  };
  struct Part {
    std::string name, title;
    std::function<std::vector<Job>(bool quick)> jobs;  ///< in the order in which they are run
    std::function<Document(const Measured&)> report;   ///< of the measurements there are
  };
  /// In the order of the document.
  static const std::vector<Part>& parts();

  /// A scene of the study in the plane.
  struct Sample {
    std::string scene;  ///< pour, collapse, shear or drum
    int size = 100, seed = 1;
    double drive = 1;   ///< speed of the shear (inertial number 0.1 drive) or of the drum
    double mu = 0.4;    ///< friction coefficient
    double spread = 1;  ///< of the radii: 0: all equal
    Scene<2> make() const;
    double averages_from(const Scene<2>& made) const;  ///< begin of time averages             [s]
  };
  /// Difference of means over seeds, relative to the reference.
  struct PairedError {
    double error = kNaN, bar = kNaN;  ///< |mean difference| and its 95 % bar over |mean reference|
    int seeds = 0;
  };
  /// A geometric mean with its 95 % interval (Student's t of the logarithms).
  struct Geometric {
    double mean = kNaN, low = kNaN, high = kNaN;
    int seeds = 0;
  };
  /// The class of a quantity: geometry, stress, forces or kinematics; empty: it has none.
  static std::string class_of(const std::string& quantity);
  /// Means of the quantities over the end of a run.
  class Observer {
   public:
    /// `made`: the scene as it is run; `step_factor`: its step over the sample's.
    Observer(const Sample& sample, const Scene<2>& made, double step_factor);
    void see(const State<2>& state);
    /// `end`: the last state.
    Values values(const State<2>& end) const;

   private:
    const Sample& sample_;
    const Scene<2>& scene_;
    double from_, start_energy_;
    int every_;
    std::map<std::string, std::pair<double, long>> sums_;
    std::vector<double> forces_;
    double peak_ = 0, loss_ = 0, loss_time_ = -1;
  };
  /// Runs the sample and returns its quantities with cpu, steps, unsolved, iterations and overlap;
  /// of a run that did not end, cpu and failed = 1 alone.
  static Values run(const Sample& sample, const RunSetting& setting, const Stopped& stopped);

  /// A line for each measurement; none if there is no file. Throws FileError.
  static Measured read(const std::filesystem::path& rows);
  /// Runs the jobs that `rows` lacks and adds them to it. False if it was interrupted; what was
  /// done is kept.
  static bool measure(const std::filesystem::path& rows, const std::vector<Job>& jobs,
                      const Watch& watch);
};

Study::Part thresholds_part();  ///< from which ε on is an observable right?
Study::Part depth_part();       ///< does the number of sweeps saturate with the depth?
Study::Part answers_part();     ///< how many steps have several exact answers?
Study::Part ensembles_part();   ///< do statistics depend on the answer that is taken?
Study::Part plane_part();       ///< error over step and tolerance
Study::Part paths_part();       ///< the same of paths, and rigid contacts against springs

/// Values of a quantity by seed, over the cases that agree with `of` in all but the seed.
std::map<int, double> by_seed(const Study::Measured& measured, Study::Case of,
                              const std::string& quantity);
/// Mean and 95 % bar over seeds.
MeanValue over_seeds(const std::map<int, double>& values);
/// The geometric mean over seeds; seeds with a value that is not finite and positive are left out.
Study::Geometric geometric_mean(const std::map<int, double>& values);
/// Mean and bar of the differences a - b of the seeds that both have.
MeanValue paired_difference(const std::map<int, double>& a, const std::map<int, double>& b);
/// Differences of a quantity from a reference, by means over the seeds.
Study::PairedError paired_error(const Study::Measured& measured, const Study::Case& of,
                                const Study::Case& reference, const std::string& quantity);
/// Distinct values of a member over the cases of a part, increasing.
template <class Member>
std::vector<Member> distinct(const Study::Measured& measured, const std::string& part,
                             Member Study::Case::*member,
                             const std::function<bool(const Study::Case&)>& holds = {}) {
  std::vector<Member> all;
  for (const auto& [of, values] : measured) {
    if (of.part == part && (!holds || holds(of))) all.push_back(of.*member);
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}
/// Quantities with a class that the cases of the part have.
std::vector<std::string> classed_quantities(const Study::Measured& measured,
                                            const std::string& part, const std::string& scene);
inline const std::vector<std::string> kStudyClasses = {"geometry", "stress", "forces",
                                                       "kinematics"};

}  // namespace bipot
