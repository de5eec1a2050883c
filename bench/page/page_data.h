#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bench/page/page_curves.h"
#include "bench/report/json_output.h"
#include "core/run_files/film.h"

namespace bipot {

/// Parts of a page's data, in the names that the scripts of the player read.

/// The bytes in the zlib format (RFC 1950), which browsers call "deflate". The same bytes give the
/// same result with one version of zlib. Throws std::bad_alloc.
std::string deflated(std::string_view bytes);
std::string base64(std::string_view bytes);
/// The bytes deflated, in base64.
std::string packed_text(std::string_view bytes);

/// summary.json of a run; null if there is none, or none that is whole.
Json page_summary(const std::filesystem::path& folder);

/// Steps that a reader must know of: unsolved and of the largest overlap, by the ledger; with
/// several exact answers, by the folders of `solve --several` in that of the run.
Json page_marks(const std::filesystem::path& folder, const std::vector<CurveTable>& curves);

/// Most points of a curve: of a whole run, and of one that goes on, which are sent again and again.
inline constexpr std::size_t kCurvePoints = 10000, kLiveCurvePoints = 2400;

/// Columns in single precision, one after the other, with at most so many points; their description
/// goes into `about`.
std::string packed_curves(const std::vector<CurveTable>& curves, std::size_t points, Json& about);

/// What changes from frame to frame and is short, into `about`.
void describe_frames(const Film& film, std::size_t dim, Json& about);

}  // namespace bipot
