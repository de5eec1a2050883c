#pragma once

#include "solvers/interior/interior_run.h"
#include "solvers/systems/shifted_delassus.h"

namespace bipot {

/// Proximal semismooth Newton from an accurate impulse, the last stage of the interior point.
/// Contacts that neither move nor carry end there with impulses of the order of the square root of
/// the last product. Outer loop: anchor s_k; inner Newton on
///
///     s = P(s_k - (delta W_cc)⁻¹ u(s)),
///
/// with P the projection of Alart and Curnier (1991): s_n on the half-line, then s_t on the disk of
/// radius mu s_n. The fixed points of the outer loop solve the problem for any delta. The anchor
/// moves when the inner Newton has converged; delta falls after quick convergence and grows after a
/// failure. Limit: there is no globalisation; from far away it cycles. `max_iterations`:
/// factorisations.
template <ContactRows D>
StageEnd proximal_newton(const ContactProblem& problem, const DelassusOperator& delassus,
                         ShiftedDelassus& shifted, const Vector& mobility, const Vector& start,
                         InteriorRun& run, int max_iterations);

extern template StageEnd proximal_newton<1>(const ContactProblem&, const DelassusOperator&,
                                            ShiftedDelassus&, const Vector&, const Vector&,
                                            InteriorRun&, int);
extern template StageEnd proximal_newton<2>(const ContactProblem&, const DelassusOperator&,
                                            ShiftedDelassus&, const Vector&, const Vector&,
                                            InteriorRun&, int);
extern template StageEnd proximal_newton<3>(const ContactProblem&, const DelassusOperator&,
                                            ShiftedDelassus&, const Vector&, const Vector&,
                                            InteriorRun&, int);
extern template StageEnd proximal_newton<ContactRows(3, true)>(const ContactProblem&,
                                                               const DelassusOperator&,
                                                               ShiftedDelassus&, const Vector&,
                                                               const Vector&, InteriorRun&, int);
extern template StageEnd proximal_newton<ContactRows(6, true)>(const ContactProblem&,
                                                               const DelassusOperator&,
                                                               ShiftedDelassus&, const Vector&,
                                                               const Vector&, InteriorRun&, int);

}  // namespace bipot
