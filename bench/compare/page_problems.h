#pragma once

#include "bench/compare/page_draft.h"

namespace bipot {

/// Problem by problem: where it comes from, its reference and its diagrams.
void add_problems(PageDraft& page, const PageContent& of);

}  // namespace bipot
