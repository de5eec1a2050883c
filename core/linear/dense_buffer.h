#pragma once

namespace bipot {

/// Has OpenBLAS take the buffer that it wants at its first call in a thread, 128 MB of address
/// space: where it gets none it asks again for ever, and a solve would never end. Throws
/// std::bad_alloc, whose what() says so. After the first success in a thread it does nothing.
void take_dense_buffer();

}  // namespace bipot
