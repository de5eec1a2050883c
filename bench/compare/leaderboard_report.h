#pragma once

#include <string>

#include "bench/compare/leaderboard.h"
#include "bench/report/document.h"

namespace bipot {

/// The part of a problem's name that its relatives share, up to its sizes or step: "2d_pour" of
/// 2d_pour14_200 and of 2d_pour_s200.
std::string family_of(const std::string& problem);

/// One line for each entry.
Table leaderboard_rows(const Leaderboard& board);
/// Solved against tolerance, time against error, solved by family.
Document leaderboard_document(const Leaderboard& board, const Provenance& made);

}  // namespace bipot
