#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/compare/comparison_measures.h"
#include "bench/compare/comparison_report.h"
#include "bench/compare/comparison_success.h"
#include "bench/report/chart.h"
#include "bench/report/text_lines.h"

namespace bipot {

/// What the sections of the page speak of.
struct PageContent {
  PageContent(const Comparison& comparison, const ReportContext& report);

  const Comparison& comparison;
  const ReportContext& report;
  std::vector<std::string> solvers;
  std::vector<double> tols;
  std::vector<Growth> growth;
  std::vector<SuccessCurve> success;

  /// Whether `auto` and others were compared.
  bool has_auto() const;
  /// Of the problem's part of the page.
  std::string id_of(const ProblemSummary& problem) const;
};

/// A page that is being written: markup, and places for charts, which gnuplot draws all at once in
/// the end.
class PageDraft {
 public:
  void add(std::string_view markup) { html_ += markup; }
  void heading(const std::string& id, const std::string& title);
  /// `caption` is markup; `command` makes the figure again, `data` says where its numbers are.
  void figure(Chart chart, const std::string& caption, const std::string& command,
              const std::string& data);
  /// The markup with its charts. Throws FileError where gnuplot cannot draw.
  std::string with_drawings() const;

 private:
  std::string html_;
  std::vector<std::size_t> places_;  // of the charts in it
  std::vector<Chart> charts_;
};

}  // namespace bipot
