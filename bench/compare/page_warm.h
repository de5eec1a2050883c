#pragma once

#include "bench/compare/page_draft.h"

namespace bipot {

/// What starting from the step before gains; nothing without warm rows.
void add_warm_starts(PageDraft& page, const PageContent& of);

}  // namespace bipot
