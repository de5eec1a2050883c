#include "core/base/version.h"

namespace bipot {

std::string program_version() { return BIPOT_VERSION; }

}  // namespace bipot
