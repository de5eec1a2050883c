#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "core/problem/contact_problem.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/packed_bodies.h"
#include "solvers/disks/disk_kernels.h"

namespace bipot {

/// D of the vector kernels for contacts of these rows.
template <ContactRows K>
inline constexpr int kKernelOf = !K.rolls       ? K.count
                                 : K.in_plane() ? kRollingDisks
                                                : kRollingSpheres;

/// The structure of rigid disks (D = kRollingDisks) or spheres (kRollingSpheres) with rolling
/// friction: that of their normal and tangential rows, where the other rows are differences of the
/// spins, all of a contact times one positive factor. Empty if the problem is another one, or walls
/// are driven: they do not roll.
template <int D>
std::optional<BodiesOf<D>> rolling_bodies(const ContactProblem& problem);

/// The bodies for the vector kernels: those that the operator has packed, which must live as long,
/// or with rolling friction those above; null: none.
template <ContactRows K>
std::shared_ptr<const BodiesOf<kKernelOf<K>>> kernel_bodies(const ContactProblem& problem,
                                                            const DelassusOperator& delassus) {
  using Bodies = BodiesOf<kKernelOf<K>>;
  if constexpr (K.rolls) {
    std::optional<Bodies> bodies = rolling_bodies<kKernelOf<K>>(problem);
    return bodies ? std::make_shared<const Bodies>(*std::move(bodies)) : nullptr;
  } else {
    const std::optional<Bodies>& bodies = delassus.bodies<K>();
    return bodies ? std::shared_ptr<const Bodies>(std::shared_ptr<const Bodies>(), &*bodies)
                  : nullptr;
  }
}

}  // namespace bipot
