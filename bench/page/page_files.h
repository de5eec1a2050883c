#pragma once

#include <string_view>

namespace bipot {

/// Parts of the page that are plain files in the source tree (bench/page/player, bench/page/uplot):
/// the build puts them into the program (embed.cmake).
struct PageFiles {
  std::string_view page, style, script;  ///< HTML with marks, CSS, JavaScript
};
PageFiles page_files();

}  // namespace bipot
