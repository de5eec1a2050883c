#define BIPOT_WIDTH 2
#include "solvers/disks/sphere_kernel_body.h"

namespace bipot {

const DiskKernels<kRollingSpheres> kPortableRollingSphereKernels = kKernels<kRollingSpheres>;

}  // namespace bipot
