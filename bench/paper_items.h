#pragma once

#include "bench/paper_item.h"

namespace bipot {

PaperResult run_table1(const PaperContext& context);  ///< bouncing ball
PaperResult run_table2(const PaperContext& context);  ///< sliding cylinder
PaperResult run_fig10(const PaperContext& context);   ///< quasi-static arrays
PaperResult run_fig13(const PaperContext& context);   ///< error against iteration

}  // namespace bipot
