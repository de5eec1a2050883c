#define BIPOT_WIDTH 2
#include "solvers/disks/sphere_kernel_body.h"

namespace bipot {

const DiskKernels<3> kPortableSphereKernels = kKernels<3>;

}  // namespace bipot
