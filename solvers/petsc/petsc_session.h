#pragma once

#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bipot {

/// A failed PETSc call, with PETSc's text.
class PetscFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws PetscFailure unless `code`, a PetscErrorCode, is 0. `what`: the function that was called.
void check_petsc(int code, const char* what);
/// Throws std::runtime_error unless `code`, of an MPI function, says success.
void check_mpi(int code, const char* what);
// Call a function and check its code, as BIPOT_PETSC(VecDuplicate, z, &f).
#define BIPOT_PETSC(function, ...) ::bipot::check_petsc(function(__VA_ARGS__), #function)
#define BIPOT_MPI(function, ...) ::bipot::check_mpi(function(__VA_ARGS__), #function)

/// The options string of a user in PETSc's notation "-name value -name", and the defaults of a
/// solver. A name may begin with the prefix or leave it out.
class PetscOptions {
 public:
  using Entry = std::pair<std::string, std::string>;  ///< name without '-' and prefix, value or ""

  /// Throws std::invalid_argument for a value without a name before it.
  PetscOptions(std::string_view prefix, const std::string& text);

  /// Adds an option unless the user has set it.
  void add_default(const std::string& name, const std::string& value);

  std::span<const Entry> given() const { return {all_.data(), given_}; }
  const std::vector<Entry>& all() const { return all_; }  ///< given ones, then defaults
  /// Name in PETSc's database, "-prefix_name".
  std::string key(const std::string& name) const;

 private:
  std::string prefix_;
  std::vector<Entry> all_;
  std::size_t given_ = 0;  // number
};

/// The use of PETSc by one solve, with its options in PETSc's database for that time. Initialises
/// PETSc at the first use, unless the host program has: without arguments, resource files or signal
/// handlers, to be finalised at the end of the process. Sessions of several threads wait for one
/// another, since PETSc's objects are not thread-safe. During a session PETSc returns its errors,
/// instead of printing them and aborting.
class PetscSession {
 public:
  /// Throws PetscFailure if PETSc cannot be initialised or is finalised already.
  explicit PetscSession(PetscOptions options);
  ~PetscSession();
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;

  /// Names of the user's options that PETSc has not read so far, "-a, -b".
  std::string unused_options() const;

 private:
  std::unique_lock<std::mutex> lock_;
  PetscOptions options_;
};

}  // namespace bipot
