#pragma once

#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {

/// sᵀ W s for the W of the problem, in a non-negative form if there is one [J]
double energy_product(const ContactProblem& problem, const DelassusOperator& delassus,
                      const Vector& s);

/// error / reference; 0/0 is 0 (nothing to get wrong), x/0 is NaN.
double relative_error(double error, double reference);

}  // namespace bipot
