#include "solvers/distributed/process_group.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>

#include "core/types.h"

namespace bipot {
namespace {

class LoneExchange : public Exchange {
 public:
  explicit LoneExchange(std::span<const RemoteItem> copies)
      : copies_(copies.begin(), copies.end()) {}

  void copy(std::span<const double> originals, std::span<double> copies, int block) override {
    for (std::size_t k = 0; k < copies_.size(); ++k) {
      for (int i = 0; i < block; ++i) copies[place(k, i, block)] = originals[original(k, i, block)];
    }
  }
  void add(std::span<const double> copies, std::span<double> originals, int block) override {
    for (std::size_t k = 0; k < copies_.size(); ++k) {
      for (int i = 0; i < block; ++i) {
        originals[original(k, i, block)] += copies[place(k, i, block)];
      }
    }
  }

 private:
  static std::size_t place(std::size_t k, int i, int block) {
    return k * to_size(block) + to_size(i);
  }
  std::size_t original(std::size_t k, int i, int block) const {
    return place(to_size(copies_[k].original), i, block);
  }
  std::vector<RemoteItem> copies_;
};

class LoneProcess : public ProcessGroup {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void sum(std::span<double> values) override { count(values.size_bytes()); }
  void sum(std::span<std::int64_t> values) override { count(values.size_bytes()); }
  void largest(std::span<double> values) override { count(values.size_bytes()); }
  std::vector<double> gather(std::span<const double> mine) override {
    return {mine.begin(), mine.end()};
  }
  std::string first_text(const std::string& mine) override { return mine; }
  std::unique_ptr<Exchange> make_exchange(int, std::span<const RemoteItem> copies) override {
    return std::make_unique<LoneExchange>(copies);
  }

 private:
  void count(std::size_t bytes) {
    ++traffic_->reductions;
    traffic_->reduced_bytes += static_cast<std::int64_t>(bytes);
  }
};

/// A number in the environment, or -1.
int from_environment(const char* name) {
  const char* text = std::getenv(name);
  int value = -1;
  if (text == nullptr) return -1;
  const char* end = text + std::strlen(text);
  const auto [last, error] = std::from_chars(text, end, value);
  return error == std::errc() && last == end ? value : -1;
}

/// Open MPI; MPICH and its relatives; Slurm, where it speaks to MPI itself.
struct Launcher {
  const char *size, *rank;
};
constexpr Launcher kLaunchers[] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                   {"PMI_SIZE", "PMI_RANK"},
                                   {"SLURM_NTASKS", "PMIX_RANK"}};

}  // namespace

std::unique_ptr<ProcessGroup> lone_process() { return std::make_unique<LoneProcess>(); }

int launched_processes() {
  for (const Launcher& launcher : kLaunchers) {
    const int size = from_environment(launcher.size);
    if (size > 0 && from_environment(launcher.rank) >= 0) return size;
  }
  return 1;
}

int launched_rank() {
  for (const Launcher& launcher : kLaunchers) {
    const int rank = from_environment(launcher.rank);
    if (rank >= 0 && from_environment(launcher.size) > 0) return rank;
  }
  return 0;
}

}  // namespace bipot
