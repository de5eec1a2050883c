#pragma once

#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// A problem and exact impulses of it, known by hand.
struct SeveralProblem {
  ContactProblem problem;
  std::vector<Vector> answers;
};

/// Painlevé's contact, d = 2, beside an ordinary one. u = W s + b with W = (1 1; 1 3/2), b = (1, 4)
/// and mu = 2, given by W alone. Three answers, all isolated:
///   take-off  s = 0: u = b, u_n = 1 > 0;
///   slip      s = (1, -2): u = (1 - 2 + 1, 1 - 3 + 4) = (0, 2), against it s_t = -mu s_n;
///   stick     u = 0: s_n + s_t = -1, s_n + 3/2 s_t = -4, hence s = (5, -6), |s_t| < mu s_n = 10.
/// W is positive definite (det 1/2); W_nt mu > W_nn, so that sliding friction pulls the contact
/// together. The second contact, W = 1, b = (-1, 0), mu = 1/2, carries (1, 0) in all: without it
/// s = 0 would be the end of every solve.
SeveralProblem painleve_problem();

/// A body of mass 1 that slides on two contacts in one place, mu = 0.2 and 0.6, without rotation:
/// v_free = (5, -1). Only s_n1 + s_n2 = 1 is determined, and v_x = 5 - 0.2 s_n1 - 0.6 s_n2: exact
/// answers for each v_x in [4.4, 4.8], one continuous family. `answers` are its two ends.
SeveralProblem two_frictions_problem();

}  // namespace bipot
