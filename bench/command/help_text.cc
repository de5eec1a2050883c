#include "bench/command/help_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>

namespace bipot {

std::size_t num_characters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

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
  return num_characters(text) > kLongest ? first_characters(text, kLongest) + " …" : text;
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::istringstream words(text);
  std::string out;
  std::size_t column = indent;
  for (std::string word; words >> word;) {
    const bool first = column == indent;
    if (!first && column + 1 + num_characters(word) > width) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += num_characters(word);
  }
  return out;
}

}  // namespace bipot
