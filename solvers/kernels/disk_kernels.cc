#include "solvers/kernels/disk_kernels.h"

#include <stdexcept>
#include <string>

#include "solvers/kernels/disk_kernel_tables.h"

namespace bipot {

template <int D>
const DiskKernels<D>& disk_kernels(SimdPath path) {
  if (!has_path(path)) {
    throw std::invalid_argument(std::string("this machine has no ") + to_string(path));
  }
  const auto pick = [](const DiskKernelTable& table) -> const DiskKernels<D>& {
    if constexpr (D == 1) {
      return table.one;
    } else {
      return table.two;
    }
  };
#if defined(BIPOT_X86_PATHS)
  if (resolved(path) == SimdPath::kAvx512) return pick(kAvx512DiskKernels);
  if (resolved(path) == SimdPath::kAvx2) return pick(kAvx2DiskKernels);
#endif
  return pick(kPortableDiskKernels);
}
template const DiskKernels<1>& disk_kernels<1>(SimdPath);
template const DiskKernels<2>& disk_kernels<2>(SimdPath);

}  // namespace bipot
