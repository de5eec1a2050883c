#pragma once

#include <string>
#include <vector>

#include "core/run_files/film_frame.h"

namespace bipot {

/// Data of a body that do not change.
struct PageBody {
  float radius = 0, mass = 0;  ///< [m], [kg]
  std::uint8_t material = 0;
  std::uint8_t glued = 0;     ///< 1: it belongs to a wall
  std::int32_t cluster = -1;  ///< -1: of none
};

/// The frames as bytes that compress well; player/frames.js reads them. Bodies come first: radius,
/// mass, material, glued, cluster, each array in planes. Then for each frame
///   numbers of bodies                                    only where they come or go
///   x, turn, v, spin                                     D, D, D components one after the other
///   for each contact before: 1 if it is still there
///   number of new contacts; their i (from the one before) and their j
///   n, gap, force_n, force_t, status
/// Everything but i and j of new contacts is the difference to the same body or contact in the frame
/// before, zero if there is none. An array of integers stands in planes: all lowest bytes, then all
/// second bytes, and so on. Differences are folded to 0, -1, 1, -2, ... = 0, 1, 2, 3, ...
std::string packed_frames(const std::vector<PageBody>& bodies, const std::vector<FilmFrame>& frames,
                          int dim, bool gates);

/// Every `stride`-th frame, and the last one.
std::vector<FilmFrame> thinned(const std::vector<FilmFrame>& frames, std::size_t stride);

/// Removes the contacts whose normal force is below this quantile of all frames. Returns that force
/// [N].
double drop_weak_contacts(std::vector<FilmFrame>& frames, int dim, double quantile);

}  // namespace bipot
