#pragma once

#include "solvers/disks/disk_kernels.h"
#include "solvers/disks/stress_kernels.h"

namespace bipot {

/// One instantiation of disk_kernel_body.h, sphere_kernel_body.h and stress_kernel_body.h, compiled
/// for one instruction set.
struct DiskKernelTable {
  DiskKernels<1> one;
  DiskKernels<2> two;
  DiskKernels<3> three;
  StressKernels stress;
};
extern const DiskKernelTable kPortableDiskKernels;
extern const DiskKernelTable kAvx2DiskKernels;
extern const DiskKernelTable kAvx512DiskKernels;

}  // namespace bipot
