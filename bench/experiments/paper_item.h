#pragma once

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bench/experiments/claim.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A row of the table of items. An item that fails or was asked to stop (context.interrupted)
/// throws; the page shows the message of a failure.
struct PaperItem {
  /// Input of a figure or table of the paper.
  struct Context {
    std::filesystem::path out;                    ///< of the report; exists
    bool quick = false;                           ///< small sizes, seconds
    std::function<void(const std::string&)> say;  ///< progress, one line; may be empty
    std::function<bool()> interrupted;            ///< asked between pieces of work; may be empty

    bool stopped() const { return interrupted && interrupted(); }
    /// Says what begins now. Throws std::runtime_error if the item was asked to stop.
    void report(const std::string& what) const {
      if (stopped()) throw std::runtime_error("interrupted");
      if (say) say(what);
    }
  };
  std::string_view name;   ///< for --only
  std::string_view title;  ///< "Fig. 10: quasi-static arrays"
  Findings (*run)(const Context&);
};

/// In the order of the page. Adding one: a source paper_<name>.cc, its declaration in
/// here, a row in paper_item.cc, a line in CMakeLists.txt.
const std::vector<PaperItem>& paper_items();

Findings run_table1(const PaperItem::Context& context);  ///< bouncing ball
Findings run_table2(const PaperItem::Context& context);  ///< sliding cylinder
Findings run_fig10(const PaperItem::Context& context);   ///< quasi-static arrays
Findings run_fig11(const PaperItem::Context& context);   ///< compaction by gravity
Findings run_fig12(const PaperItem::Context& context);   ///< isotropic compression
Findings run_fig13(const PaperItem::Context& context);   ///< error against iteration
Findings run_fig14(const PaperItem::Context& context);   ///< iterations against number of particles
Findings run_stop_test(const PaperItem::Context& context);  ///< stop tests against true errors

/// Runs a scene with its own solver choice, step by step, and returns the last state. A step that
/// does not meet the scene's tolerance throws std::runtime_error with the solver's message.
State<2> run_paper_scene(
    const Scene<2>& scene, const PaperItem::Context& context,
    const std::function<void(const State<2>&, const StepReport<2>&)>& on_step = {});

}  // namespace bipot
