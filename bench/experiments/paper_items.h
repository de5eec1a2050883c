#pragma once

#include "bench/experiments/paper_item.h"

namespace bipot {

PaperResult run_table1(const PaperContext& context);     ///< bouncing ball
PaperResult run_table2(const PaperContext& context);     ///< sliding cylinder
PaperResult run_fig10(const PaperContext& context);      ///< quasi-static arrays
PaperResult run_fig11(const PaperContext& context);      ///< compaction by gravity
PaperResult run_fig12(const PaperContext& context);      ///< isotropic compression
PaperResult run_stress(const PaperContext& context);     ///< mean stress tensor
PaperResult run_fig13(const PaperContext& context);      ///< error against iteration
PaperResult run_fig14(const PaperContext& context);      ///< iterations against number of particles
PaperResult run_stop_test(const PaperContext& context);  ///< stop tests against true errors
PaperResult run_warm_start(const PaperContext& context);  ///< iterations, cold and warm

}  // namespace bipot
