#pragma once

#include <compare>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

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

}  // namespace bipot
