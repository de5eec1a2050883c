#include "core/linear/dense_turn.h"

namespace bipot {
namespace {

std::recursive_mutex& dense_kernels() {
  static std::recursive_mutex mutex;
  return mutex;
}

}  // namespace

DenseTurn::DenseTurn() : turn_(dense_kernels()) {}

}  // namespace bipot
