#include "core/linear/dense_buffer.h"

#include <sys/mman.h>

#include <cstddef>
#include <new>

#include "core/linear/dense_turn.h"

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}

namespace bipot {
namespace {

/// The buffer of Debian's OpenBLAS, and some pages for its alignment.
constexpr std::size_t kBuffer = (std::size_t{128} << 20) + (std::size_t{64} << 10);

class NoDenseBuffer : public std::bad_alloc {
 public:
  const char* what() const noexcept override {
    return "out of memory: dense factors need 128 MB of address space (raise ulimit -v)";
  }
};

bool has_room(std::size_t bytes) {
  void* const place =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (place == MAP_FAILED) return false;
  munmap(place, bytes);
  return true;
}

}  // namespace

void take_dense_buffer() {
  thread_local bool taken = false;
  if (taken) return;
  const DenseTurn turn;
  if (!has_room(kBuffer)) throw NoDenseBuffer();
  const int one = 1;  // the smallest call: OpenBLAS allocates its buffer now
  double a = 1;
  int info = 0;
  dpotrf_("L", &one, &a, &one, &info);
  taken = true;
}

}  // namespace bipot
