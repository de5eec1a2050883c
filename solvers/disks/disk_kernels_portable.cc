#define BIPOT_WIDTH 2
#include "solvers/disks/disk_gradient.h"
#include "solvers/disks/disk_sweeps.h"
#include "solvers/disks/stress_kernel_body.h"

namespace bipot {

const DiskKernelTable kPortableDiskKernels = {kKernels<1>,
                                              kKernels<2>,
                                              &kPortableSphereKernels,
                                              kKernels<kRollingDisks>,
                                              &kPortableRollingSphereKernels,
                                              kStressKernels};

}  // namespace bipot
