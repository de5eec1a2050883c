#pragma once

#include <string_view>

#include "bench/compare/page_draft.h"

namespace bipot {

/// All rows, sortable and filtered by table_script().
void add_table(PageDraft& page, const PageContent& of);
/// The script of the page: sorts and filters the rows, opens the problems.
std::string_view table_script();

}  // namespace bipot
