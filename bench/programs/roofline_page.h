#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/measure/kernel_work.h"
#include "core/base/types.h"

namespace bipot {

/// What a run of kernel_bench measured of the machine and of the kernels on it.
struct Roofline {
  struct Peak {
    std::string path;     ///< instructions
    double flops = kNaN;  ///< of additions and multiplications that are not fused   [flop/s]
  };
  struct Bandwidth {
    double megabytes = 0;  ///< of the triad
    int threads = 1;
    double bytes = kNaN;  ///< [B/s]
  };
  struct Kernel {
    std::string name, path;
    int threads = 1;
    double contacts = 0;
    KernelWork work;
    double nanoseconds = kNaN;  ///< a contact and iteration

    double flops() const { return work.flops / nanoseconds * 1e9; }
    double bytes() const { return work.bytes / nanoseconds * 1e9; }
  };
  std::vector<Peak> peaks;
  std::vector<Bandwidth> bandwidths;
  std::vector<Kernel> kernels;
};

/// Writes index.html, rows.csv and roofline_N.svg for N threads. Throws FileError.
void write_roofline(const std::filesystem::path& folder, const Roofline& measured);

}  // namespace bipot
