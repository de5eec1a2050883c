#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/compare/comparison_report.h"

namespace bipot {

/// A part of the page that others make.
struct ReportSection {
  std::string id;     ///< of the heading, for links: letters, digits, hyphens
  std::string title;  ///< text
  std::string html;   ///< below the heading
};

/// One page that needs nothing else: no network, no other file. `sections` stand before the
/// problem-by-problem part. Throws FileError where gnuplot cannot draw (bench/report/chart.h).
std::string to_html(const Comparison& comparison, const ReportContext& context,
                    const std::vector<ReportSection>& sections = {});

/// comparison.csv, success.csv, comparison.json and report.html in a folder that exists. Throws
/// FileError.
void write_report(const std::filesystem::path& folder, const Comparison& comparison,
                  const ReportContext& context, const std::vector<ReportSection>& sections = {});

}  // namespace bipot
