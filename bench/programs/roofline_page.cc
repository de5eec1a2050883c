#include "bench/programs/roofline_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "bench/report/chart.h"
#include "bench/report/document.h"
#include "bench/report/labels.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

constexpr double kLargest = 300;  // [MB], beyond all caches

/// Upper bound of the kernel from memory, each thread with its own peak.
double roof_of(const Roofline& m, const Roofline::Kernel& kernel) {
  double bandwidth = kNaN, peak = kNaN;
  for (const Roofline::Bandwidth& b : m.bandwidths) {
    if (b.megabytes == kLargest && b.threads == kernel.threads) bandwidth = b.bytes;
  }
  for (const Roofline::Peak& p : m.peaks) {
    if (p.path == kernel.path) peak = p.flops;
  }
  return roofline(kernel.work, bandwidth, kernel.threads * peak);
}

Table roof_table(const Roofline& m) {
  Table t{.columns = {{"", "roof"}, {"", "threads", count_label}, {"", "measured", value_label}}};
  for (const Roofline::Bandwidth& b : m.bandwidths) {
    t.add({fmt::format("triad of {:g} MB", b.megabytes), b.threads,
           fmt::format("{:.3g} GB/s", 1e-9 * b.bytes)});
  }
  for (const Roofline::Peak& p : m.peaks) {
    t.add({"additions and multiplications, " + p.path, 1,
           fmt::format("{:.1f} Gflop/s", 1e-9 * p.flops)});
  }
  return t;
}

Table kernel_table(const Roofline& m) {
  Table t{.columns = {{"kernel", "kernel"},
                      {"instructions", "instructions"},
                      {"threads", "threads", count_label},
                      {"contacts", "contacts", count_label},
                      {"bytes", "bytes a contact", ratio_label},
                      {"flops", "flops a contact", ratio_label},
                      {"", "flop/B", ratio_label},
                      {"ns", "ns a contact", ratio_label},
                      {"gflop_s", "Gflop/s", ratio_label},
                      {"gb_s", "GB/s if streamed", ratio_label},
                      {"of_roof", "of its roof from memory", ratio_label}}};
  for (const Roofline::Kernel& k : m.kernels) {
    t.add({k.name, k.path, k.threads, k.contacts, k.work.bytes, k.work.flops, k.work.intensity(),
           k.nanoseconds, 1e-9 * k.flops(), 1e-9 * k.bytes(), k.flops() / roof_of(m, k)});
  }
  return t;
}

/// Flops against intensity for this number of threads: roofs of memory rise, peaks are flat.
Chart roofline_chart(const Roofline& m, int threads) {
  constexpr double kLeast = 1.0 / 16, kMost = 4;
  const std::string with = fmt::format("{} thread{}", threads, threads == 1 ? "" : "s");
  Chart chart{.title = "Roofline, " + with,
              .x = {"flops a byte of one iteration", Chart::Axis::Kind::kLog, kLeast, kMost},
              .y = {"Gflop/s, " + with, Chart::Axis::Kind::kLog},
              .width = 640,
              .height = 400};
  double top = 0;
  for (const Roofline::Peak& p : m.peaks) {
    top = std::max(top, threads * p.flops);
    chart.y_lines.push_back({1e-9 * threads * p.flops, "peak, " + p.path});
  }
  int style = 0;
  for (const Roofline::Bandwidth& b : m.bandwidths) {
    if (b.threads != threads) continue;
    Chart::Series roof{
        .name = fmt::format("triad of {:g} MB, {:.3g} GB/s", b.megabytes, 1e-9 * b.bytes),
        .style = style++,
        .kind = Chart::Series::Kind::kLine};
    for (const double x : {kLeast, std::min(top / b.bytes, kMost)}) {
      roof.points.push_back({.x = x, .y = 1e-9 * x * b.bytes});
    }
    chart.series.push_back(roof);
  }
  for (const Roofline::Kernel& k : m.kernels) {
    if (k.threads != threads) continue;
    const std::string name = k.name + ", " + k.path;
    auto series =
        std::ranges::find_if(chart.series, [&](const Chart::Series& s) { return s.name == name; });
    if (series == chart.series.end()) {
      chart.series.push_back(
          {.name = name, .style = style++, .kind = Chart::Series::Kind::kPoints});
      series = std::prev(chart.series.end());
    }
    series->points.push_back(
        {.x = k.work.intensity(),
         .y = 1e-9 * k.flops(),
         .note = fmt::format("{}: {:.0f} contacts, {:.2f} ns", name, k.contacts, k.nanoseconds)});
  }
  return chart;
}

}  // namespace

void write_roofline(const std::filesystem::path& folder, const Roofline& measured) {
  require_plotting_tool();
  std::filesystem::create_directories(folder);
  Document page{.title = "Roofline of the contact kernels",
                .made = provenance("kernel_bench", "kernel_bench --roofline")};
  page.say(
      "Intensity counts what one iteration alone would stream from memory: several in flight share "
      "it, so that points may lie above a roof of memory. Peaks are of additions and "
      "multiplications that are not fused, as in the kernels. One thread: its CPU time; more: wall "
      "time, which other work on the machine stretches.");
  std::set<int> threads;
  for (const Roofline::Kernel& k : measured.kernels) threads.insert(k.threads);
  for (const int count : threads) {
    page.add(Figure{.chart = roofline_chart(measured, count),
                    .file = fmt::format("roofline_{}.svg", count)});
  }
  page.heading("Kernels");
  page.add(kernel_table(measured));
  page.heading("Roofs");
  page.add(roof_table(measured));
  page.add(to_terms(page.made));
  write_figures(folder, page);
  write_text_file(folder / "index.html", to_html(page));
  write_text_file(folder / "rows.csv", to_csv(kernel_table(measured)));
}

}  // namespace bipot
