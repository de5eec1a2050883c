#define BIPOT_WIDTH 8
#include "solvers/disks/disk_gradient.h"
#include "solvers/disks/disk_sweeps.h"
#include "solvers/disks/stress_kernel_body.h"

namespace bipot {

const DiskKernelTable kAvx512DiskKernels = {kKernels<1>,
                                            kKernels<2>,
                                            &kAvx512SphereKernels,
                                            kKernels<kRollingDisks>,
                                            &kAvx2RollingSphereKernels,
                                            kStressKernels};

}  // namespace bipot
