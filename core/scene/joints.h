#pragma once

#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// The two points of a joint, where its bodies are now. [m]
template <int D>
std::pair<Vec<D>, Vec<D>> joint_points(const typename Scene<D>::Joint& joint,
                                       std::span<const std::type_identity_t<Body<D>>> bodies);

/// Removes the contacts between bodies (or clusters) that a pin joins: they do not touch each
/// other.
template <int D>
void leave_out_pinned(const Scene<D>& scene, std::vector<Contact<D>>& contacts);

/// Empty for sound joints and nothing that they exclude, else one sentence.
template <int D>
std::string check_joints(const Scene<D>& scene);

}  // namespace bipot
