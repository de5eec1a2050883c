#pragma once

namespace bipot {

/// Makes OpenBLAS allocate its buffer of 128 MB of address space in this thread. If it cannot get
/// that memory at its first call, it retries for ever, and a solve would never end. Throws
/// std::bad_alloc with an explanation. After the first success in a thread it has no effect.
void take_dense_buffer();

}  // namespace bipot
