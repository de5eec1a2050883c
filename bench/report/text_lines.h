#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace bipot {

/// Number of letters of UTF-8 text: columns on a terminal.
std::size_t letters(std::string_view utf8);

/// The first so many characters of UTF-8.
std::string first_characters(const std::string& text, std::size_t count);

/// With each `from` replaced.
std::string replaced(std::string text, std::string_view from, std::string_view to);

/// The reason of a solver in one line: of a list of stages their number and the last one.
std::string short_reason(const std::string& message);

/// Lines of at most `width` letters, broken at spaces and at ends of lines. A longer word has its
/// own line.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width);
/// For a terminal of 100 columns: lines below each other from column `indent` on, where the first
/// one begins.
std::string hanging_text(std::string_view text, std::size_t indent);

/// A piece of a text with marks: `code`, **strong**, [words](aim).
struct Span {
  std::string text;
  bool code = false, strong = false;
  std::string aim;  ///< of a link: a file beside the page or the id of a place in it; else empty
};
/// Unpaired marks hold to the end. A link to anywhere else is plain text.
std::vector<Span> spans_of(std::string_view text);

/// A word for a shell: in single quotes where another character than those of plain names is in it.
std::string shell_word(std::string_view text);

/// & < > " as entities.
std::string escape_markup(std::string_view text);

}  // namespace bipot
