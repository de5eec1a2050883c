#include "solvers/parallel/process_group.h"

#include "core/base/types.h"

namespace bipot {
namespace {

class LoneExchange : public ProcessGroup::Exchange {
 public:
  explicit LoneExchange(std::span<const ProcessGroup::RemoteItem> copies)
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
  std::vector<ProcessGroup::RemoteItem> copies_;
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
  std::vector<Buffer> deliver(std::vector<Buffer> buffers) override { return buffers; }
  std::string first_text(const std::string& mine) override { return mine; }
  std::unique_ptr<ProcessGroup::Exchange> make_exchange(
      int, std::span<const ProcessGroup::RemoteItem> copies) override {
    return std::make_unique<LoneExchange>(copies);
  }
  void run_on_root(const std::function<void(SystemFactor&)>& work) override {
    LocalFactor factor(SparseLU::Strategy::kSymmetric);
    try {
      work(factor);
    } catch (const std::exception& e) {
      throw CommonFailure(e.what());
    }
  }

 private:
  void count(std::size_t bytes) {
    ++traffic_->reductions;
    traffic_->reduced_bytes += static_cast<std::int64_t>(bytes);
  }
};

}  // namespace

std::unique_ptr<ProcessGroup> lone_process() { return std::make_unique<LoneProcess>(); }

}  // namespace bipot
