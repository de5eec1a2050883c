#include "solvers/petsc/petsc_session.h"

#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "solvers/petsc/mpi_session.h"

namespace bipot {
namespace {

/// The PETSc library of this process.
class PetscLibrary {
 public:
  static void ensure() {
    static const PetscLibrary library;
    PetscBool alive = PETSC_FALSE;
    PetscInitialized(&alive);
    if (!alive) throw PetscFailure("PETSc: initialisation failed, or it is already finalised");
  }
  PetscLibrary(const PetscLibrary&) = delete;
  PetscLibrary& operator=(const PetscLibrary&) = delete;

 private:
  PetscLibrary() {
    PetscBool alive = PETSC_FALSE;
    PetscInitialized(&alive);
    if (alive) return;  // the host program uses PETSc itself
    ensure_mpi();
    PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
    PetscOptionsSetValue(nullptr, "-skip_petscrc", "true");
    owned_ = PetscInitializeNoArguments() == 0;
    PETSC_STDOUT = stderr;  // monitors and views must not mix with a program's own output
  }
  ~PetscLibrary() {
    PetscBool finalised = PETSC_FALSE;
    PetscFinalized(&finalised);
    if (owned_ && !finalised) PetscFinalize();
  }
  bool owned_ = false;
};

std::mutex& one_at_a_time() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

void check_petsc(int code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(static_cast<PetscErrorCode>(code), &text, nullptr);
  throw PetscFailure(fmt::format("PETSc: {} failed: {} (error {})", what,
                                 text != nullptr ? text : "unknown error", code));
}

void check_mpi(int code, const char* what) {
  if (code != MPI_SUCCESS) throw std::runtime_error(fmt::format("MPI: {} failed", what));
}

PetscOptions::PetscOptions(std::string_view prefix, const std::string& text) : prefix_(prefix) {
  std::istringstream in(text);
  std::string token;
  while (in >> token) {
    const bool is_name = token.size() > 1 && token[0] == '-' &&
                         std::isalpha(static_cast<unsigned char>(token[1])) != 0;
    if (is_name) {
      std::string name = token.substr(1);
      if (name.starts_with(prefix_)) name.erase(0, prefix_.size());
      all_.emplace_back(std::move(name), "");
    } else if (all_.empty() || !all_.back().second.empty()) {
      throw std::invalid_argument(
          fmt::format("parameter petsc: '{}' follows no option name", token));
    } else {
      all_.back().second = token;
    }
  }
  given_ = all_.size();
}

void PetscOptions::add_default(const std::string& name, const std::string& value) {
  const bool known = std::any_of(all_.begin(), all_.end(),
                                 [&](const Entry& entry) { return entry.first == name; });
  if (!known) all_.emplace_back(name, value);
}

std::string PetscOptions::key(const std::string& name) const {
  return fmt::format("-{}{}", prefix_, name);
}

PetscSession::PetscSession(PetscOptions options)
    : lock_(one_at_a_time()), options_(std::move(options)) {
  PetscLibrary::ensure();
  for (const auto& [name, value] : options_.all()) {
    BIPOT_PETSC(PetscOptionsSetValue, nullptr, options_.key(name).c_str(),
                value.empty() ? nullptr : value.c_str());
  }
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
}

PetscSession::~PetscSession() {
  PetscPopErrorHandler();
  for (const auto& [name, value] : options_.all()) {
    PetscOptionsClearValue(nullptr, options_.key(name).c_str());
  }
}

std::string PetscSession::unused_options() const {
  std::string names;
  for (const auto& [name, value] : options_.given()) {
    PetscBool used = PETSC_TRUE;
    if (PetscOptionsUsed(nullptr, options_.key(name).c_str() + 1, &used) == 0 && !used) {
      names += (names.empty() ? "-" : ", -") + name;
    }
  }
  return names;
}

}  // namespace bipot
