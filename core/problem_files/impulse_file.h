#pragma once

#include <filesystem>
#include <string>

#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// How another code lays out its impulses. The default is FCLIB's and this project's own: contact
/// after contact, the normal component first, s_n > 0 pushes apart.
struct ImpulseLayout {
  enum class Order {
    kContact,   ///< all components of a contact together
    kComponent  ///< all contacts' first components, then all second ones, ...
  };
  Order order = Order::kContact;
  /// Order of the components: a permutation of "n", "nt" or "nts"; empty: that order.
  std::string components;
  /// Components that point the other way there, such as "t"; empty: none.
  std::string negated;
  double factor = 1;  ///< to N s: a time step, where the file has forces
};

/// Impulses from a file of another code, in the problem's variables. The content decides the kind:
///   - .npy: m values; or c x d or d x c, which then says the order by itself unless c = d;
///   - FCLIB HDF5: /solution/r;
///   - text: m numbers between spaces, commas or semicolons, with an optional line of names before
///     them, lines that begin with #, and an optional first column that counts the contacts from 0
///     or 1 (CSV); or as Siconos writes vectors: their size before the numbers, or
///     "size = m; data= [...]".
/// A frictionless problem takes m = c values, or 2c whose tangential ones are 0 (FCLIB's form).
/// Throws FileError for a file that is none of these or has other sizes, and std::invalid_argument
/// for a layout that makes no sense.
Vector read_impulses(const std::filesystem::path& path, const ContactProblem& problem,
                     const ImpulseLayout& layout = {});

}  // namespace bipot
