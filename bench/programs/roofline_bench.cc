// The roofline of this machine and the position of the kernels under it, all measured in the same
// run: bytes and flops of one iteration for each contact (bench/measure/kernel_work.h), the
// bandwidth of the triad at three sizes, and the peak of unfused additions and multiplications, as
// in the kernels. Writes index.html, roofline_N.svg for N threads and rows.csv into --out and
// prints the tables in Markdown.
//   roofline_bench [--side=10,83,400] [--threads=1,2] [--family=triangular] [--repeat=5]
//                  [--out=out/roofline]
// Times are the CPU time of one thread, or the wall time of several, which other work on the
// machine disturbs.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure/kernel_work.h"
#include "bench/measure/statistics.h"
#include "bench/measure/stopwatch.h"
#include "bench/programs/measured_kernel.h"
#include "bench/report/chart.h"
#include "bench/report/document.h"
#include "bench/report/labels.h"
#include "core/base/execution.h"
#include "core/base/parallel.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

struct Flags {
  std::string family = "triangular", out = "out/roofline";
  std::vector<int> sides{10, 83, 400}, threads{1, 2};
  int repeat = 5;
};

/// Median seconds of one call: `repeat` times as many calls as take 50 ms. CPU time of one thread,
/// wall time of several.
double seconds_of(const std::function<void()>& call, int threads, int repeat) {
  const auto time = [&](int calls) {
    const CpuStopwatch cpu;
    const Stopwatch wall;
    for (int k = 0; k < calls; ++k) call();
    return threads == 1 ? cpu.seconds() : wall.seconds();
  };
  constexpr double kLongEnough = 0.05;
  int calls = 1;
  double one = time(1);  // the first one meets cold caches: not counted
  while ((one = time(calls)) < kLongEnough) calls *= 2;
  std::vector<double> seconds;
  for (int k = 0; k < repeat; ++k) seconds.push_back(time(calls) / calls);
  return median(seconds);
}

/// a <- b + 3 c over this number of bytes [B/s].
double triad_bandwidth(double bytes, int threads, int repeat) {
  const int n = static_cast<int>(bytes / triad_work().bytes);
  std::vector<double> a(to_size(n), 0.0), b(to_size(n), 1.0), c(to_size(n), 2.0);
  constexpr int kItems = 1 << 14;
  const double seconds = seconds_of(
      [&] {
        run_tasks(threads, (n + kItems - 1) / kItems, [&](int piece) {
          const int first = piece * kItems, last = std::min(n, first + kItems);
          for (int k = first; k < last; ++k) a[to_size(k)] = b[to_size(k)] + 3 * c[to_size(k)];
        });
        asm volatile("" : : "g"(a.data()) : "memory");
      },
      threads, repeat);
  return triad_work().bytes * n / seconds;
}

// Independent chains in registers, enough to keep two multipliers and two adders busy during their
// latency. x <- 0.999 x + 0.001 stays near 1.
constexpr int kChains = 12, kTurns = 20000;
using Vector16 [[gnu::vector_size(16)]] = double;
using Vector32 [[gnu::vector_size(32)]] = double;
using Vector64 [[gnu::vector_size(64)]] = double;
#define BIPOT_CHAINS(V)                                          \
  V x[kChains];                                                  \
  for (int k = 0; k < kChains; ++k) x[k] = V{} + (1 + 0.01 * k); \
  const V m = V{} + 0.999, s = V{} + 0.001;                      \
  for (int turn = 0; turn < kTurns; ++turn) {                    \
    for (int k = 0; k < kChains; ++k) x[k] = x[k] * m + s;       \
  }                                                              \
  V sum{};                                                       \
  for (int k = 0; k < kChains; ++k) sum += x[k];                 \
  return sum[0] + sum[1]

double scalar_chains() {
  double x[kChains];
  for (int k = 0; k < kChains; ++k) x[k] = 1 + 0.01 * k;
  for (int turn = 0; turn < kTurns; ++turn) {
    for (int k = 0; k < kChains; ++k) {
      x[k] = x[k] * 0.999 + 0.001;
      asm volatile("" : "+x"(x[k]));  // one at a time
    }
  }
  double sum = 0;
  for (const double v : x) sum += v;
  return sum;
}
double portable_chains() { BIPOT_CHAINS(Vector16); }
#ifdef __x86_64__
[[gnu::target("avx2")]] double avx2_chains() { BIPOT_CHAINS(Vector32); }
[[gnu::target("avx512f")]] double avx512_chains() { BIPOT_CHAINS(Vector64); }
#endif
#undef BIPOT_CHAINS

struct Peak {
  std::string path;
  double flops = kNaN;  ///< one thread [flop/s]
};

std::vector<SimdPath> paths_here() {
  std::vector<SimdPath> paths;
  for (const SimdPath path : {SimdPath::kPortable, SimdPath::kAvx2, SimdPath::kAvx512}) {
    if (has_path(path)) paths.push_back(path);
  }
  return paths;
}

std::vector<Peak> measure_peaks(int repeat) {
  const auto peak = [&](const char* path, double (*chains)(), int lanes) {
    volatile double kept = 0;
    const double seconds = seconds_of([&] { kept = chains(); }, 1, repeat);
    return Peak{path, 2.0 * kChains * kTurns * lanes / seconds};
  };
  std::vector<Peak> peaks{peak("scalar", scalar_chains, 1)};
  for (const SimdPath path : paths_here()) {
    double (*chains)() = portable_chains;
    int lanes = 2;
#ifdef __x86_64__
    if (path == SimdPath::kAvx2) chains = avx2_chains, lanes = 4;
    if (path == SimdPath::kAvx512) chains = avx512_chains, lanes = 8;
#endif
    peaks.push_back(peak(to_string(path), chains, lanes));
  }
  return peaks;
}

struct Bandwidth {
  double megabytes = 0;
  int threads = 1;
  double bytes_a_second = kNaN;
};

struct Row {
  std::string kernel, path;
  int threads = 1;
  double contacts = 0;
  KernelWork work;
  double nanoseconds = kNaN;  ///< a contact and iteration
  double flops() const { return work.flops / nanoseconds * 1e9; }
  double bytes() const { return work.bytes / nanoseconds * 1e9; }
};

std::vector<Row> measure_kernels(const Flags& flags) {
  std::vector<Row> rows;
  for (const int side : flags.sides) {
    const auto p = tilted_packing(flags.family, side);
    const auto add = [&](const char* kernel, const char* path, int threads,
                         const MeasuredKernel& k) {
      Row row{.kernel = kernel, .path = path, .threads = threads, .contacts = k.contacts};
      row.work = k.work;
      row.nanoseconds =
          1e9 * seconds_of(k.call, threads, flags.repeat) / (k.contacts * k.iterations);
      fmt::print(stderr, "{} {} x{} {:.0f}: {:.2f} ns\n", kernel, path, threads, k.contacts,
                 row.nanoseconds);
      rows.push_back(row);
    };
    add("pgs, given order", "scalar", 1, given_order_sweep(*p));
    for (const int threads : flags.threads) {
      for (const SimdPath path : paths_here()) {
        const Execution e{threads, path};
        add("pgs, tiled", to_string(path), threads, tiled_sweep(*p, e));
        add("apgd", to_string(path), threads, tiled_gradient(*p, e));
      }
    }
  }
  return rows;
}

struct Measured {
  std::vector<Peak> peaks;
  std::vector<Bandwidth> bandwidths;
  std::vector<Row> rows;

  double bandwidth(double megabytes, int threads) const {
    for (const Bandwidth& b : bandwidths) {
      if (b.megabytes == megabytes && b.threads == threads) return b.bytes_a_second;
    }
    return kNaN;
  }
  double peak(const std::string& path) const {
    for (const Peak& p : peaks) {
      if (p.path == path) return p.flops;
    }
    return kNaN;
  }
  /// Upper bound of the row from memory, each thread with its own peak.
  double roof(const Row& row) const {
    return roofline(row.work, bandwidth(300, row.threads), row.threads * peak(row.path));
  }
};

Table bandwidth_table(const Measured& m) {
  Table t{.columns = {{"", "roof"}, {"", "threads", count_label}, {"", "measured", value_label}}};
  for (const Bandwidth& b : m.bandwidths) {
    t.add({fmt::format("triad of {:g} MB", b.megabytes), b.threads,
           fmt::format("{:.3g} GB/s", 1e-9 * b.bytes_a_second)});
  }
  for (const Peak& p : m.peaks) {
    t.add({"additions and multiplications, " + p.path, 1,
           fmt::format("{:.1f} Gflop/s", 1e-9 * p.flops)});
  }
  return t;
}

Table kernel_table(const Measured& m) {
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
  for (const Row& r : m.rows) {
    t.add({r.kernel, r.path, r.threads, r.contacts, r.work.bytes, r.work.flops, r.work.intensity(),
           r.nanoseconds, 1e-9 * r.flops(), 1e-9 * r.bytes(), r.flops() / m.roof(r)});
  }
  return t;
}

/// Flops against intensity for this number of threads: roofs of memory rise, peaks are flat.
Chart roofline_chart(const Measured& m, int threads) {
  Chart chart;
  chart.title = fmt::format("Roofline, {} thread{}", threads, threads == 1 ? "" : "s");
  chart.x = {.label = "flops a byte of one iteration", .kind = ChartAxis::Kind::kLog};
  chart.y = {.label = fmt::format("Gflop/s, {} thread{}", threads, threads == 1 ? "" : "s"),
             .kind = ChartAxis::Kind::kLog};
  chart.width = 640;
  chart.height = 400;
  constexpr double kLeast = 1.0 / 16, kMost = 4;
  double top = 0;
  for (const Peak& p : m.peaks) top = std::max(top, threads * p.flops);
  chart.x.low = kLeast;
  chart.x.high = kMost;
  int style = 0;
  for (const Bandwidth& b : m.bandwidths) {
    if (b.threads != threads) continue;
    ChartSeries roof{
        .name = fmt::format("triad of {:g} MB, {:.3g} GB/s", b.megabytes, 1e-9 * b.bytes_a_second),
        .style = style++,
        .kind = ChartSeries::Kind::kLine};
    const double ridge = std::min(top / b.bytes_a_second, kMost);
    roof.points.push_back({.x = kLeast, .y = 1e-9 * kLeast * b.bytes_a_second});
    roof.points.push_back({.x = ridge, .y = 1e-9 * ridge * b.bytes_a_second});
    chart.series.push_back(roof);
  }
  for (const Peak& p : m.peaks) {
    chart.y_lines.push_back({1e-9 * threads * p.flops, "peak, " + p.path});
  }
  for (const Row& r : m.rows) {
    if (r.threads != threads) continue;
    const auto key = std::pair(r.kernel + ", " + r.path, r.contacts);
    auto series = std::find_if(chart.series.begin(), chart.series.end(), [&](const ChartSeries& s) {
      return s.kind == ChartSeries::Kind::kPoints && s.name == key.first;
    });
    if (series == chart.series.end()) {
      chart.series.push_back(
          {.name = key.first, .style = style++, .kind = ChartSeries::Kind::kPoints});
      series = std::prev(chart.series.end());
    }
    series->points.push_back({.x = r.work.intensity(),
                              .y = 1e-9 * r.flops(),
                              .note = fmt::format("{}: {:.0f} contacts, {:.2f} ns", key.first,
                                                  r.contacts, r.nanoseconds)});
  }
  return chart;
}

void write_page(const Measured& m, const Flags& flags) {
  Document page{.title = "Roofline of the contact kernels",
                .made = provenance("roofline_bench", "roofline_bench")};
  page.say(fmt::format(
      "{} packings tilted by 10°, {} iterations a call, median of {}. Intensity counts what one "
      "iteration alone would stream from memory: several in flight share it, so that points may "
      "lie above a roof of memory. Peaks are of additions and multiplications that are not fused, "
      "as in the kernels. One thread: its CPU time; more: wall time, which other work on the "
      "machine stretches.",
      flags.family, kTogether, flags.repeat));
  for (const int threads : flags.threads) {
    page.add(Figure{.chart = roofline_chart(m, threads),
                    .file = fmt::format("roofline_{}.svg", threads)});
  }
  page.heading("Kernels");
  page.add(kernel_table(m));
  page.heading("Roofs");
  page.add(bandwidth_table(m));
  page.add(to_terms(page.made));
  const std::filesystem::path out(flags.out);
  std::filesystem::create_directories(out);
  write_figures(out, page);
  write_text_file(out / "index.html", to_html(page));
  write_text_file(out / "rows.csv", to_csv(kernel_table(m)));
}

void run(const Flags& flags) {
  require_plotting_tool();
  Measured m{.peaks = measure_peaks(flags.repeat)};
  for (const int threads : flags.threads) {
    for (const double megabytes : {0.5, 3.0, 300.0}) {
      m.bandwidths.push_back(
          {megabytes, threads, triad_bandwidth(1e6 * megabytes, threads, flags.repeat)});
    }
  }
  m.rows = measure_kernels(flags);
  fmt::print("{}\n{}\n", to_markdown(bandwidth_table(m)), to_markdown(kernel_table(m)));
  write_page(m, flags);
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  using namespace bipot;
  Flags flags;
  CLI::App app{"Where the kernels lie under the roofline of this machine"};
  app.add_option("--side", flags.sides, "Disks along a side")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--threads", flags.threads, "Numbers of threads")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--family", flags.family, "Scene family (disks with friction)");
  app.add_option("--repeat", flags.repeat, "Measurements of each, the median counts")
      ->check(CLI::Range(1, 1000));
  app.add_option("--out", flags.out, "Folder of the page");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    run(flags);
  } catch (const std::invalid_argument& e) {
    fmt::print(stderr, "roofline_bench: {}\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    fmt::print(stderr, "roofline_bench: {}\n", e.what());
    return 4;
  }
  return 0;
}
