#pragma once

#include <string>
#include <string_view>

#include "bench/report/build_info.h"
#include "bench/report/text_lines.h"

namespace bipot {

/// A page that needs no other file, from its first byte to <body>: the title and one style sheet.
///
/// The sheet dresses what every page is made of: text, code, tables (class n: numbers; a row of
/// class bad: what failed; tables in a box of class scroll keep their first column in sight),
/// figures in a grid, lists of terms, small screens and print. `own_rules` come behind the rules
/// for wide screens and before those for small ones and print, so that a page can add to the sheet
/// or differ from it and still folds and prints like the others.
std::string page_head(std::string_view title, std::string_view own_rules);
/// Closes it.
std::string page_end();

/// A term and what it stands for, in a list <dl>; `html` is markup already.
std::string page_term(std::string_view term, std::string_view html);
/// Where numbers come from, as terms: program, compiler, flags, machine.
std::string page_terms(const BuildInfo& build);

}  // namespace bipot
