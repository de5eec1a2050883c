#include "bench/experiments/paper_items.h"

namespace bipot {

const std::vector<PaperItem>& paper_items() {
  static const std::vector<PaperItem> items = {
      {"table1", "Table 1: bouncing ball", run_table1},
      {"table2", "Table 2: sliding cylinder", run_table2},
      {"fig10", "Fig. 10: quasi-static arrays", run_fig10},
      {"fig11", "Fig. 11: compaction by gravity", run_fig11},
      {"fig12", "Fig. 12: isotropic compression", run_fig12},
      {"stress", "Mean stress tensor", run_stress},
      {"fig13", "Fig. 13: error against iteration", run_fig13},
      {"fig14", "Fig. 14: iterations against number of particles", run_fig14},
      {"stop_test", "The stop test", run_stop_test},
      {"warm_start", "Warm start", run_warm_start},
  };
  return items;
}

}  // namespace bipot
