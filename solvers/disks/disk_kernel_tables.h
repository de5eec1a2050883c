#pragma once

#include "solvers/disks/disk_kernels.h"
#include "solvers/disks/stress_kernels.h"

namespace bipot {

/// The kernels for disks and for stresses, compiled for one instruction set. The kernels for
/// spheres are compiled by themselves: together g++ makes slower code of both. Those of rolling
/// spheres have no form for eight lanes: four serve.
struct DiskKernelTable {
  DiskKernels<1> one;
  DiskKernels<2> two;
  const DiskKernels<3>* three;
  DiskKernels<kRollingDisks> rolling;
  const DiskKernels<kRollingSpheres>* rolling_spheres;
  StressKernels stress;
};
extern const DiskKernelTable kPortableDiskKernels;
extern const DiskKernelTable kAvx2DiskKernels;
extern const DiskKernelTable kAvx512DiskKernels;
extern const DiskKernels<3> kPortableSphereKernels;
extern const DiskKernels<3> kAvx2SphereKernels;
extern const DiskKernels<3> kAvx512SphereKernels;
extern const DiskKernels<kRollingSpheres> kPortableRollingSphereKernels;
extern const DiskKernels<kRollingSpheres> kAvx2RollingSphereKernels;

}  // namespace bipot
