#pragma once

#include <string>

#include "bench/report/json.h"
#include "core/criterion/contact_error.h"

namespace bipot {

/// Adds epsilon, eta, epsilon_raw, natural_map and worst_contact (the contact that is worst in
/// whichever of epsilon and eta is larger; null without one). Undefined numbers become null.
void add_error(Json& json, const ContactError& error);

/// Refuses a destination that cannot be written, before the work rather than after it; a file that
/// is there is left as it is, one that is not is not left behind. Nothing for "" and "-". Throws
/// FileError.
void require_writable(const std::string& destination);

/// Writes to the file, or to standard output for "-". Throws FileError.
void write_json(const Json& json, const std::string& destination);

}  // namespace bipot
