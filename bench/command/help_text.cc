#include "bench/command/help_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/report/text_lines.h"

namespace bipot {

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  return fmt::format(
      "{}", fmt::join(wrapped_lines(text, width - indent), "\n" + std::string(indent, ' ')));
}

}  // namespace bipot
