#pragma once

#include "bench/experiments/paper_item.h"

namespace bipot {

Findings run_table1(const PaperContext& context);      ///< bouncing ball
Findings run_table2(const PaperContext& context);      ///< sliding cylinder
Findings run_fig10(const PaperContext& context);       ///< quasi-static arrays
Findings run_fig11(const PaperContext& context);       ///< compaction by gravity
Findings run_fig12(const PaperContext& context);       ///< isotropic compression
Findings run_stress(const PaperContext& context);      ///< mean stress tensor
Findings run_fig13(const PaperContext& context);       ///< error against iteration
Findings run_fig14(const PaperContext& context);       ///< iterations against number of particles
Findings run_stop_test(const PaperContext& context);   ///< stop tests against true errors
Findings run_warm_start(const PaperContext& context);  ///< iterations, cold and warm

}  // namespace bipot
