#define BIPOT_WIDTH 8
#include "solvers/disks/disk_gradient.h"
#include "solvers/disks/disk_sweeps.h"
#include "solvers/disks/stress_kernel_body.h"

namespace bipot {

const DiskKernelTable kAvx512DiskKernels = {
    {&sweep<1>, &gradient<1>, &extrapolate_velocity, &sweep_forth<1>, &sweep_back<1>},
    {&sweep<2>, &gradient<2>, &extrapolate_velocity, &sweep_forth<2>, &sweep_back<2>},
    &kAvx512SphereKernels,
    {&sweep<kRollingDisks>, &gradient<kRollingDisks>, &extrapolate_velocity,
     &sweep_forth<kRollingDisks>, &sweep_back<kRollingDisks>},
    &kAvx2RollingSphereKernels,
    kStressKernels};

}  // namespace bipot
