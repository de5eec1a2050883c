#define BIPOT_WIDTH 8
#include "solvers/disks/sphere_kernel_body.h"

namespace bipot {

const DiskKernels<3> kAvx512SphereKernels = {&sweep_spheres, &gradient_spheres,
                                             &extrapolate_velocity, &sweep_spheres_forth,
                                             &sweep_spheres_back};

}  // namespace bipot
