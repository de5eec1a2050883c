#pragma once

#include "bench/compare/page_draft.h"

namespace bipot {

/// The title, and for each accuracy who gets there first.
void add_answer(PageDraft& page, const PageContent& of);
/// The fastest solver for each problem and accuracy.
void add_answer_by_problem(PageDraft& page, const PageContent& of);
/// The true errors behind each tolerance.
void add_tolerance_meaning(PageDraft& page, const PageContent& of);
/// How many problems each solver solves, and how fast.
void add_solver_summary(PageDraft& page, const PageContent& of);

}  // namespace bipot
