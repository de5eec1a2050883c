#pragma once

#include "bench/compare/page_draft.h"

namespace bipot {

/// What it costs to let `auto` choose; nothing where it was not compared.
void add_regret(PageDraft& page, const PageContent& of);
/// Share of problems solved against tolerance, by size; nothing where no tolerance is below 1e-2.
void add_success(PageDraft& page, const PageContent& of);
/// Performance profiles; nothing for a single problem.
void add_profiles(PageDraft& page, const PageContent& of);
/// Cost against size, series by series; nothing without a series.
void add_growth(PageDraft& page, const PageContent& of);

}  // namespace bipot
