#include "solvers/parallel/process_group.h"

#include "core/base/types.h"

namespace bipot {
namespace {

/// There are no items of other processes.
class LoneExchange : public ProcessGroup::Exchange {
 public:
  void copy(std::span<const double>, std::span<double>, int) override {}
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
      int, std::span<const ProcessGroup::RemoteItem>) override {
    return std::make_unique<LoneExchange>();
  }
  void run_on_root(const std::function<void(SystemFactor&)>& work) override {
    LocalFactor factor(SparseLU::Strategy::kSymmetric);
    try {
      work(factor);
    } catch (const std::exception& e) {
      throw CommonFailure(e.what());
    }
  }
};

}  // namespace

std::unique_ptr<ProcessGroup> lone_process() { return std::make_unique<LoneProcess>(); }

}  // namespace bipot
