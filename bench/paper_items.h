#pragma once

#include "bench/paper_item.h"

namespace bipot {

PaperResult run_table1(const PaperContext& context);  ///< bouncing ball
PaperResult run_table2(const PaperContext& context);  ///< sliding cylinder
PaperResult run_fig11(const PaperContext& context);   ///< compaction by gravity

}  // namespace bipot
