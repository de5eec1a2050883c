#pragma once

#include <map>
#include <span>
#include <string>

#include "solvers/solver.h"

namespace bipot {

/// A solver's parameters, resolved against its specification. The accessors throw
/// std::invalid_argument (which solve() turns into kInvalidInput) with the parameter's name, the
/// given text and the allowed values.
class Parameters {
 public:
  /// Throws on an unknown name, naming the nearest valid one.
  Parameters(const std::map<std::string, std::string>& given, std::span<const ParameterSpec> specs);

  double number(std::string_view name) const;
  int integer(std::string_view name) const;
  std::string choice(std::string_view name) const;
  std::string text(std::string_view name) const;

 private:
  const ParameterSpec& spec(std::string_view name) const;

  const std::map<std::string, std::string>& given_;
  std::span<const ParameterSpec> specs_;
};

}  // namespace bipot
