#include "bench/paper_items.h"

namespace bipot {

const std::vector<PaperItem>& paper_items() {
  static const std::vector<PaperItem> items = {
      {"table1", "Table 1: bouncing ball", run_table1},
      {"table2", "Table 2: sliding cylinder", run_table2},
      {"fig10", "Fig. 10: quasi-static arrays", run_fig10},
      {"fig13", "Fig. 13: error against iteration", run_fig13},
  };
  return items;
}

}  // namespace bipot
