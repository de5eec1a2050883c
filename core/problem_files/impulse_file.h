#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// Layout of impulses from another code. The default is that of FCLIB and of this project: contact
/// after contact, the normal component first, s_n > 0 pushes apart.
struct ImpulseLayout {
  enum class Order {
    kContact,   ///< all components of a contact together
    kComponent  ///< all contacts' first components, then all second ones, ...
  };
  std::optional<Order> order;  ///< none: that of the shape of a table, else kContact
  /// Order of the components: a permutation of "n", "nt" or "nts"; empty: that order. Moments of
  /// rolling in space follow.
  std::string components;
  /// Components with the opposite sign, such as "t"; empty: none.
  std::string negated;
  double factor = 1;  ///< to N s: the time step, if the file has forces
};

/// Reads impulses from a file of another code, in the problem's variables. The content decides the
/// kind:
///   - .npy: m values; or c x d or d x c, whose shape gives the order unless c = d. A layout with
///     the other order is refused, for text too;
///   - FCLIB HDF5: /solution/r, likewise;
///   - text: m numbers between spaces, commas or semicolons. Allowed are a line of names before
///     them, lines that begin with #, and a first column that counts contacts from 0 or 1 (CSV).
///     Names of normal and tangential columns must be in the order of the components;
///   - text of Siconos: the size before the numbers, or "size = m; data= [...]".
/// A frictionless problem takes m = c values, or 2c with tangential values 0 (FCLIB's form). Rows
/// that may be these or the numbers of contacts with impulses 0 need names. Throws
/// FileError for any other file or other sizes, and std::invalid_argument for an inconsistent
/// layout.
Vector read_impulses(const std::filesystem::path& path, const ContactProblem& problem,
                     const ImpulseLayout& layout = {});

}  // namespace bipot
