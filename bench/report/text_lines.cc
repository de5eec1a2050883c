#include "bench/report/text_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace bipot {
namespace {

bool is_aim(std::string_view aim) {
  return !aim.empty() && std::ranges::all_of(aim, [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("#_.-+").find(c) != std::string_view::npos;
  });
}

}  // namespace

std::size_t letters(std::string_view utf8) {
  return static_cast<std::size_t>(std::ranges::count_if(
      utf8, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string first_characters(const std::string& text, std::size_t count) {
  std::size_t at = 0;
  for (; at < text.size(); ++at) {
    if ((text[at] & 0xC0) != 0x80 && count-- == 0) break;
  }
  return text.substr(0, at);
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
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

std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width) {
  std::vector<std::string> lines(1);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    if (!lines.back().empty() && letters(lines.back()) + 1 + letters(word) > width) {
      lines.emplace_back();
    }
    if (!lines.back().empty()) lines.back() += ' ';
    lines.back() += word;
    if (end < text.size() && text[end] == '\n') lines.emplace_back();
    begin = end + 1;
  }
  return lines;
}

std::string hanging_text(std::string_view text, std::size_t indent) {
  return fmt::format("{}",
                     fmt::join(wrapped_lines(text, 100 - indent), "\n" + std::string(indent, ' ')));
}

std::vector<Span> spans_of(std::string_view text) {
  std::vector<Span> spans(1);
  const auto begin_span = [&spans](bool code, bool strong) {
    if (spans.back().text.empty()) spans.pop_back();
    spans.push_back({.text = {}, .code = code, .strong = strong, .aim = {}});
  };
  while (!text.empty()) {
    const Span now = spans.back();
    if (text.front() == '`') {
      begin_span(!now.code, now.strong);
      text.remove_prefix(1);
      continue;
    }
    if (!now.code && text.starts_with("**")) {
      begin_span(false, !now.strong);
      text.remove_prefix(2);
      continue;
    }
    const std::size_t middle = now.code || text.front() != '[' ? text.npos : text.find("](");
    const std::size_t end = middle == text.npos ? text.npos : text.find(')', middle);
    if (end != text.npos && text.substr(1, middle - 1).find('[') == text.npos &&
        is_aim(text.substr(middle + 2, end - middle - 2))) {
      begin_span(false, now.strong);
      spans.back().text = text.substr(1, middle - 1);
      spans.back().aim = text.substr(middle + 2, end - middle - 2);
      begin_span(false, now.strong);
      text.remove_prefix(end + 1);
      continue;
    }
    spans.back().text += text.front();
    text.remove_prefix(1);
  }
  if (spans.back().text.empty()) spans.pop_back();
  return spans;
}

std::string shell_word(std::string_view text) {
  const auto plain = [](unsigned char c) {
    return c >= 0x80 || std::isalnum(c) != 0 ||
           std::string_view("_-+=.,/:@%").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::ranges::all_of(text, plain)) return std::string(text);
  return "'" + replaced(std::string(text), "'", "'\\''") + "'";
}

std::string escape_markup(std::string_view text) {
  std::string out;
  for (const char c : text) {
    out += c == '&'   ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  }
  return out;
}

}  // namespace bipot
