#define BIPOT_WIDTH 4
#include "solvers/disks/sphere_kernel_body.h"

namespace bipot {

const DiskKernels<3> kAvx2SphereKernels = kKernels<3>;

}  // namespace bipot
