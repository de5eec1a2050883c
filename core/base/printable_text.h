#pragma once

#include <string>
#include <string_view>

namespace bipot {

/// The text with U+FFFD in place of what could harm a terminal or a drawing library: control
/// characters but newlines and tabs, the noncharacters of Unicode, bytes that are not UTF-8.
std::string printable(std::string_view text);

}  // namespace bipot
