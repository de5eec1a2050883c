#define BIPOT_WIDTH 4
#include "solvers/disks/sphere_kernel_body.h"

namespace bipot {

const DiskKernels<kRollingSpheres> kAvx2RollingSphereKernels = kKernels<kRollingSpheres>;

}  // namespace bipot
