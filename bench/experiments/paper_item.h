#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/experiments/claim.h"

namespace bipot {

/// Input of a figure or table of the paper.
struct PaperContext {
  std::filesystem::path out;                    ///< of the report; exists
  bool quick = false;                           ///< small sizes, seconds
  std::function<void(const std::string&)> say;  ///< progress, one line; may be empty
  std::function<bool()> interrupted;            ///< asked between pieces of work; may be empty

  void report(const std::string& what) const {
    if (say) say(what);
  }
  bool stopped() const { return interrupted && interrupted(); }
};

/// A row of the table of items. An item that was asked to stop (context.interrupted) returns early;
/// its result is not shown. If it fails it throws, and the page shows the message.
struct PaperItem {
  std::string_view name;   ///< for --only
  std::string_view title;  ///< "Fig. 10: quasi-static arrays"
  Findings (*run)(const PaperContext&);
};

/// In the order of the page. Adding one: a source paper_<name>.cc, its declaration in
/// paper_items.h, a row in paper_items.cc, a line in CMakeLists.txt.
const std::vector<PaperItem>& paper_items();

}  // namespace bipot
