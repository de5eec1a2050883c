#pragma once

#include "bench/compare/page_draft.h"

namespace bipot {

/// What share of the problems has several exact answers, and how far apart. Nothing where no problem
/// has a reference that is trusted.
void add_several(PageDraft& page, const PageContent& of);

}  // namespace bipot
