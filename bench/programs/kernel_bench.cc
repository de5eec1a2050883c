// Nanoseconds per contact of one sweep, one gradient step, one evaluation of the criterion, one
// detection and one assembly, beside bandwidth and peak of this machine in the same run. Own flags
// beside --benchmark_*:
//   --side=100 (rows of a triangular packing, about 3 side² contacts)   --threads=1,2
//   --spheres=19 (along a side of a cubic packing, about 3 side³ contacts)
//   --path=portable,avx2,avx512 (those that the machine has)   --family=triangular
//   --roofline=DIR (a page with the kernels under the roofline of the machine)
// Counters: ns (per contact and iteration), B and flop (per contact, for a single iteration;
// several in flight share it), GB_s. data/manual/results/performance.md explains the counting and
// has the tables. Rows of different kernels are interleaved by
// --benchmark_enable_random_interleaving.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "bench/measure/kernel_work.h"
#include "bench/measure/statistics.h"
#include "bench/problems/sphere_problems.h"
#include "bench/programs/roofline_page.h"
#include "core/base/number_text.h"
#include "core/base/parallel.h"
#include "core/criterion/contact_error.h"
#include "core/motion/midpoint.h"
#include "core/motion/time_stepping.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"
#include "solvers/disks/rolling_bodies.h"
#include "solvers/disks/symmetric_sweep.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/kernels/spectral_estimate.h"

namespace bipot {
namespace {

/// A problem of disks (also kRollingDisks) or spheres with friction, and the data that the kernels
/// need.
template <int D>
struct PackedProblem {
  ContactProblem problem;
  DelassusOperator delassus;
  ContactScaling scaling;
  double lambda;
  std::optional<DiskStructure> rolling;

  explicit PackedProblem(ContactProblem given)
      : problem(std::move(given)),
        delassus(problem),
        scaling(equilibrated_scaling(problem, delassus.diagonal())),
        lambda(kSpectralMargin * largest_eigenvalue()),
        rolling(rolling_bodies<kRollingDisks>(problem)) {
    if (D == kRollingDisks ? !rolling : !delassus.is_packed() || problem.dim != D) {
      throw std::invalid_argument("not disks or spheres with friction");
    }
  }
  const BodiesOf<D>& bodies() const {
    if constexpr (D == kRollingDisks) {
      return *rolling;
    } else {
      return *delassus.template bodies<D>();
    }
  }
  Vector start() const { return Vector::Zero(problem.num_rows()); }
  double largest_eigenvalue() const {
    WholeSpace space(problem);
    return spectral_estimate(space, scaling.velocity);
  }
  double bodies_per_contact() const {
    return static_cast<double>(bodies().surroundings()) / problem.num_contacts();
  }
};

/// Disks of a scene.
struct Packing : PackedProblem<2> {
  Scene<2> scene;
  State<2> state;

  explicit Packing(const Scene<2>& given)
      : PackedProblem(step_problem(given, initial_state(given))),
        scene(given),
        state(initial_state(scene)) {}
};

/// What `make` makes for a family at a side; shared while in use.
template <class Packed, class Make>
std::shared_ptr<const Packed> shared_packing(const std::string& family, int side,
                                             const Make& make) {
  static std::map<std::pair<std::string, int>, std::weak_ptr<const Packed>> cache;
  auto& slot = cache[{family, side}];
  std::shared_ptr<const Packed> made = slot.lock();
  if (!made) slot = made = std::make_shared<const Packed>(make());
  return made;
}

/// kTogether iterations of a kernel over all contacts, for measurements. Refers to its packing.
struct MeasuredKernel {
  double contacts = 0;
  KernelWork work;  ///< a contact and iteration
  std::function<void()> call;
};

/// Iterations of one call, as many as solvers do between two judgements.
constexpr int kTogether = 32;

MeasuredKernel given_order_sweep(const Packing& p) {
  auto sweep = std::make_shared<DiskSweep<2>>(p.problem, *p.delassus.disks());
  const Vector diagonal = p.delassus.diagonal();
  sweep->reset(p.start());
  for (int c = 0; c < p.problem.num_contacts(); ++c) {
    const Local<2> w = diagonal.segment<2>(2 * c);
    sweep->set_steps(c, w.cwiseInverse(), p.problem.mu[c]);
  }
  const int contacts = p.problem.num_contacts();
  return {static_cast<double>(contacts), given_order_sweep_work(p.bodies_per_contact()),
          [sweep, contacts] {
            for (int k = 0; k < kTogether; ++k) {
              for (int c = 0; c < contacts; ++c) sweep->relax(c);
            }
          }};
}

template <int D>
MeasuredKernel tiled_sweep(const PackedProblem<D>& p, const Execution& execution) {
  auto sweep = std::make_shared<TiledSweep<D>>(p.problem, p.bodies(), p.scaling, 1, execution);
  sweep->reset(p.start());
  return {static_cast<double>(p.problem.num_contacts()),
          D == kRollingDisks ? KernelWork{} : tiled_sweep_work<D>(p.bodies_per_contact()),
          [sweep] { sweep->advance(kTogether); }};
}

template <int D>
MeasuredKernel tiled_gradient(const PackedProblem<D>& p, const Execution& execution) {
  auto gradient = std::make_shared<TiledGradient<D>>(p.problem, p.bodies(), p.scaling, execution);
  gradient->reset(p.start());
  GradientKernel::Control control{.lambda = p.lambda};
  return {static_cast<double>(p.problem.num_contacts()),
          D == kRollingDisks ? KernelWork{} : gradient_work<D>(p.bodies_per_contact()),
          [gradient, control]() mutable { gradient->advance(kTogether, control); }};
}

/// An iteration of `assor` with two sweeps each way, momentum left out.
template <int D>
MeasuredKernel symmetric_sweep(const PackedProblem<D>& p, const Execution& execution) {
  auto sweep =
      std::make_shared<SymmetricSweep<D>>(p.problem, p.bodies(), p.scaling, 1, 2, execution);
  sweep->reset(p.start());
  return {static_cast<double>(p.problem.num_contacts()), {}, [sweep] {
            for (int k = 0; k < kTogether; ++k) sweep->iterate(0);
          }};
}

void report(benchmark::State& state, double contacts, int iterations, const KernelWork& work) {
  const double visits = contacts * iterations * static_cast<double>(state.iterations());
  state.counters["contacts"] = contacts;
  // Inverted: Google Benchmark divides by the time that it measured.
  state.counters["ns"] =
      benchmark::Counter(visits * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  if (work.bytes > 0) {
    state.counters["B"] = work.bytes;
    state.counters["GB_s"] =
        benchmark::Counter(1e-9 * visits * work.bytes, benchmark::Counter::kIsRate);
  }
  if (work.flops > 0) state.counters["flop"] = work.flops;
}

void run(benchmark::State& state, const MeasuredKernel& kernel) {
  for ([[maybe_unused]] auto _ : state) kernel.call();
  report(state, kernel.contacts, kTogether, kernel.work);
}

void sweep_explicit(benchmark::State& state, const Packing& p) {
  ContactProblem with = p.problem;
  with.W = assemble_delassus(with.A, with.H, with.dim);
  const DelassusOperator delassus(with);
  LocalUpdates<2> update(with, delassus, {});
  ExplicitSweep<2> sweep(with, std::make_shared<DelassusBlocks>(with.W, 2));
  for ([[maybe_unused]] auto _ : state) {
    for (int c = 0; c < with.num_contacts(); ++c) update(c, sweep);
  }
  const double row = static_cast<double>(with.W.nonZeros()) / with.num_contacts();
  report(state, with.num_contacts(), 1, explicit_sweep_work(row));
}

template <int D>
void criterion(benchmark::State& state, const PackedProblem<D>& p, int threads) {
  ContactErrorEvaluator evaluate(p.problem, threads);
  const Vector s = p.start();
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(evaluate(s));
  report(state, p.problem.num_contacts(), 1, {});
}

void tiling(benchmark::State& state, const Packing& p) {
  for ([[maybe_unused]] auto _ : state) {
    DiskTiles<2> tiles(p.problem, *p.delassus.disks(), p.scaling);
    benchmark::DoNotOptimize(tiles);
  }
  report(state, p.problem.num_contacts(), 1, {});
}

void detection(benchmark::State& state, const Packing& p, int threads) {
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(make_midpoint(p.scene, p.state, threads));
  report(state, p.problem.num_contacts(), 1, {});
}

void assembly(benchmark::State& state, const Packing& p, int threads) {
  const Midpoint<2> mid = make_midpoint(p.scene, p.state);
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(assemble_step(p.scene, mid, threads));
  report(state, p.problem.num_contacts(), 1, {});
}

/// a <- b + 3 c, as STREAM's triad.
void triad(benchmark::State& state, int threads, double bytes) {
  const int n = static_cast<int>(bytes / triad_work().bytes);
  std::vector<double> a(to_size(n), 0.0), b(to_size(n), 1.0), c(to_size(n), 2.0);
  constexpr int kItems = 1 << 14;
  for ([[maybe_unused]] auto _ : state) {
    run_tasks(threads, (n + kItems - 1) / kItems, [&](int piece) {
      const int first = piece * kItems, last = std::min(n, first + kItems);
      for (int k = first; k < last; ++k) a[to_size(k)] = b[to_size(k)] + 3 * c[to_size(k)];
    });
    benchmark::ClobberMemory();
  }
  state.counters["GB_s"] =
      benchmark::Counter(1e-9 * triad_work().bytes * n * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
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

/// Unfused additions and multiplications of one thread, by the instructions of a path; null: scalar.
void peak(benchmark::State& state, const SimdPath* path) {
  double (*chains)() = path == nullptr ? scalar_chains : portable_chains;
  int lanes = path == nullptr ? 1 : 2;
#ifdef __x86_64__
  if (path != nullptr && *path == SimdPath::kAvx2) chains = avx2_chains, lanes = 4;
  if (path != nullptr && *path == SimdPath::kAvx512) chains = avx512_chains, lanes = 8;
#endif
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(chains());
  state.counters["Gflop_s"] =
      benchmark::Counter(2e-9 * kChains * kTurns * lanes * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
}

struct Flags {
  std::string family = "triangular", roofline;
  std::vector<int> sides = {100}, threads = {1}, sphere_sides = {19};
  std::vector<std::string> paths;
};

/// Keeps the rows for the page of --roofline; the console shows them as ever.
class RooflineReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type == Run::RT_Iteration && !run.error_occurred)
        runs_[run.run_name.function_name].push_back(run);
    }
  }

  /// Of repetitions the median.
  Roofline roofline() const {
    static const std::map<std::string, std::string> kNames = {
        {"sweep_given_order", "pgs, given order"},
        {"sweep_tiled", "pgs, tiled"},
        {"gradient", "apgd"}};
    Roofline made;
    for (const auto& [name, runs] : runs_) {
      const auto counter = [&kernel_runs = runs](const char* key) {
        std::vector<double> values;
        for (const Run& run : kernel_runs) {
          const auto at = run.counters.find(key);
          values.push_back(at == run.counters.end() ? 0 : at->second.value);
        }
        return median(values);
      };
      std::vector<std::string> words;
      std::istringstream parts(name);
      for (std::string word; std::getline(parts, word, '/');) words.push_back(word);
      const bool spheres = words[0] == "spheres";
      if (spheres) words.erase(words.begin());
      if (words[0] == "peak") made.peaks.push_back({words[1], 1e9 * counter("Gflop_s")});
      if (words[0] == "triad") {
        made.bandwidths.push_back(
            {number_at(words[1]), std::stoi(words[2]), 1e9 * counter("GB_s")});
      }
      const auto kernel = kNames.find(words[0]);
      if (kernel == kNames.end()) continue;
      made.kernels.push_back({kernel->second + (spheres ? ", spheres" : ""),
                              words[1],
                              std::stoi(words[2]),
                              counter("contacts"),
                              {counter("B"), counter("flop")},
                              counter("ns")});
    }
    return made;
  }

 private:
  std::map<std::string, std::vector<Run>> runs_;
};

template <class F>
void add(const std::string& name, int threads, const F& run) {
  auto* row = benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond);
  // One thread: its own CPU time, which depends least on other work of the machine.
  if (threads > 1) row->UseRealTime();
}

/// Rows of the kernels that disks, rolling or not, and spheres have. `get`: the packing.
template <int D, class Get>
void add_kernels(const Flags& flags, const std::string& family, int side,
                 const std::vector<SimdPath>& paths, const Get& get) {
  const auto name = [&](const std::string& what) {
    return fmt::format("{}{}/{}", family, what, side);
  };
  for (const int threads : flags.threads) {
    for (const SimdPath path : paths) {
      const Execution e{threads, path};
      const std::string how = fmt::format("{}/{}", to_string(path), threads);
      const auto measure = [&](const std::string& what, const auto& kernel) {
        add(name(what + how), threads, [=](auto& s) {
          const auto p = get();
          run(s, kernel(static_cast<const PackedProblem<D>&>(*p), e));
        });
      };
      measure("sweep_tiled/",
              [](const auto& p, const Execution& by) { return tiled_sweep(p, by); });
      measure("gradient/",
              [](const auto& p, const Execution& by) { return tiled_gradient(p, by); });
      measure("symmetric/",
              [](const auto& p, const Execution& by) { return symmetric_sweep(p, by); });
    }
    add(name(fmt::format("criterion/scalar/{}", threads)), threads, [=](auto& s) {
      const auto p = get();
      criterion(s, static_cast<const PackedProblem<D>&>(*p), threads);
    });
  }
}

void add_rows(const Flags& flags, int side, const std::vector<SimdPath>& paths) {
  const auto name = [&](const std::string& what) { return fmt::format("{}/{}", what, side); };
  const auto scene = [family = flags.family, side] {
    return make_family_scene(family, side, {.tilt_degrees = 10});
  };
  const auto get = [=, family = flags.family] {
    return shared_packing<Packing>(family, side, scene);
  };
  add(name("sweep_given_order/scalar/1"), 1, [=](auto& s) {
    const auto p = get();
    run(s, given_order_sweep(*p));
  });
  add(name("sweep_explicit_W/scalar/1"), 1, [=](auto& s) { sweep_explicit(s, *get()); });
  add(name("tiling/scalar/1"), 1, [=](auto& s) { tiling(s, *get()); });
  add_kernels<2>(flags, "", side, paths, get);
  add_kernels<kRollingDisks>(flags, "rolling/", side, paths, [=, family = flags.family] {
    return shared_packing<PackedProblem<kRollingDisks>>(family, side, [&] {
      Scene<2> rolling = scene();
      for (ContactLaw& law : rolling.laws) law.mu_r = 0.025;  // a twentieth of a radius
      return step_problem(rolling, initial_state(rolling));
    });
  });
  for (const int threads : flags.threads) {
    const std::string how = fmt::format("scalar/{}", threads);
    add(name("detection/" + how), threads, [=](auto& s) { detection(s, *get(), threads); });
    add(name("assembly/" + how), threads, [=](auto& s) { assembly(s, *get(), threads); });
  }
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  using namespace bipot;
  Flags flags;
  CLI::App app{"Kernel benchmark: nanoseconds per contact, beside the machine's bandwidth"};
  app.allow_extras();  // Google Benchmark's own
  app.add_option("--family", flags.family, "Scene family (disks with friction)");
  app.add_option("--side", flags.sides, "Disks along a side")->delimiter(',');
  app.add_option("--spheres", flags.sphere_sides, "Spheres along a side of a cubic packing")
      ->delimiter(',');
  app.add_option("--threads", flags.threads, "Numbers of threads")->delimiter(',');
  app.add_option("--path", flags.paths, "portable, avx2, avx512; all that the machine has")
      ->delimiter(',');
  app.add_option("--roofline", flags.roofline, "Folder of a page with the roofline")
      ->type_name("DIR");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  std::vector<SimdPath> paths;
  for (const SimdPath path : {SimdPath::kPortable, SimdPath::kAvx2, SimdPath::kAvx512}) {
    const bool wanted =
        flags.paths.empty() || std::ranges::find(flags.paths, to_string(path)) != flags.paths.end();
    if (wanted && has_path(path)) paths.push_back(path);
  }
  for (const int threads : flags.threads) {
    for (const double megabytes : {0.5, 3.0, 300.0}) {
      add(fmt::format("triad/{:g}MB/{}", megabytes, threads), threads,
          [=](auto& s) { triad(s, threads, 1e6 * megabytes); });
    }
  }
  add("peak/scalar/1", 1, [](auto& s) { peak(s, nullptr); });
  for (const SimdPath path : paths) {
    add(fmt::format("peak/{}/1", to_string(path)), 1, [path](auto& s) { peak(s, &path); });
  }
  for (const int side : flags.sides) add_rows(flags, side, paths);
  for (const int side : flags.sphere_sides) {
    add_kernels<3>(flags, "spheres/", side, paths, [side] {
      return shared_packing<PackedProblem<3>>("cubic", side,
                                              [side] { return sphere_box(side, 0.3, 10); });
    });
  }
  std::vector<std::string> rest = app.remaining();
  std::vector<char*> arguments{argv[0]};
  for (std::string& text : rest) arguments.push_back(text.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  if (flags.roofline.empty()) {
    benchmark::RunSpecifiedBenchmarks();
    return 0;
  }
  RooflineReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  try {
    write_roofline(flags.roofline, reporter.roofline());
  } catch (const std::exception& e) {
    fmt::print(stderr, "kernel_bench: {}\n", e.what());
    return 4;
  }
  return 0;
}
