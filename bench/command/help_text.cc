#include "bench/command/help_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

#include "bench/report/text_lines.h"

namespace bipot {

std::string first_characters(const std::string& text, std::size_t count) {
  std::size_t at = 0;
  for (; at < text.size(); ++at) {
    if ((text[at] & 0xC0) != 0x80 && count-- == 0) break;
  }
  return text.substr(0, at);
}

std::string short_reason(const std::string& message) {
  constexpr std::string_view kStages = "stages: ", kNext = "; ";
  constexpr std::size_t kLongest = 240;
  std::string text = message;
  if (const std::size_t begin = text.find(kStages); begin != std::string::npos) {
    const std::size_t first = begin + kStages.size();
    std::size_t count = 1, last = first;
    for (std::size_t at; (at = text.find(kNext, last)) != std::string::npos; ++count) {
      last = at + kNext.size();
    }
    if (count > 2) {
      text =
          fmt::format("{}{} stages, the last {}", text.substr(0, begin), count, text.substr(last));
    }
  }
  return letters(text) > kLongest ? first_characters(text, kLongest) + " …" : text;
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  return fmt::format(
      "{}", fmt::join(wrapped_lines(text, width - indent), "\n" + std::string(indent, ' ')));
}

}  // namespace bipot
