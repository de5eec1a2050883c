#pragma once

#include "bench/compare/page_draft.h"

namespace bipot {

/// What the measures mean.
void add_measures(PageDraft& page);
/// How the comparison was made.
void add_provenance(PageDraft& page, const PageContent& of);

}  // namespace bipot
