#define BIPOT_WIDTH 8
#include "solvers/disks/sphere_kernel_body.h"

namespace bipot {

const DiskKernels<3> kAvx512SphereKernels = kKernels<3>;

}  // namespace bipot
