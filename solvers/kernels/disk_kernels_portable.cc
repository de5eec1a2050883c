#define BIPOT_WIDTH 2
#include "solvers/kernels/disk_kernel_body.h"

namespace bipot {

const DiskKernelTable kPortableDiskKernels = {{&sweep<1>, &gradient<1>}, {&sweep<2>, &gradient<2>}};

}  // namespace bipot
