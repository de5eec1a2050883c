#include "solvers/disks/disk_kernels.h"

#include <stdexcept>
#include <string>

#include "solvers/disks/disk_kernel_tables.h"

namespace bipot {

namespace {

const DiskKernelTable& table_of(SimdPath path) {
  if (!has_path(path)) {
    throw std::invalid_argument(std::string("this machine has no ") + to_string(path));
  }
#if defined(BIPOT_X86_PATHS)
  if (resolved(path) == SimdPath::kAvx512) return kAvx512DiskKernels;
  if (resolved(path) == SimdPath::kAvx2) return kAvx2DiskKernels;
#endif
  return kPortableDiskKernels;
}

}  // namespace

template <int D>
const DiskKernels<D>& disk_kernels(SimdPath path) {
  if constexpr (D == 1) return table_of(path).one;
  if constexpr (D == 2) return table_of(path).two;
  if constexpr (D == 3) return *table_of(path).three;
  if constexpr (D == kRollingDisks) return table_of(path).rolling;
  if constexpr (D == kRollingSpheres) return *table_of(path).rolling_spheres;
}
template const DiskKernels<1>& disk_kernels(SimdPath);
template const DiskKernels<2>& disk_kernels(SimdPath);
template const DiskKernels<3>& disk_kernels(SimdPath);
template const DiskKernels<kRollingDisks>& disk_kernels(SimdPath);
template const DiskKernels<kRollingSpheres>& disk_kernels(SimdPath);

const StressKernels& stress_kernels(SimdPath path) { return table_of(path).stress; }

}  // namespace bipot
