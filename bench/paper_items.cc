#include "bench/paper_items.h"

namespace bipot {

const std::vector<PaperItem>& paper_items() {
  static const std::vector<PaperItem> items = {
      {"table1", "Table 1: bouncing ball", run_table1},
      {"table2", "Table 2: sliding cylinder", run_table2},
      {"fig11", "Fig. 11: compaction by gravity", run_fig11},
  };
  return items;
}

}  // namespace bipot
