#pragma once

#include <span>
#include <vector>

#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// All pairs (disk, disk) and (disk, wall) with gap <= eta, sorted by (i, j); j is a disk index or
/// disks.size() + wall index. Disks glued to a wall come second; they have no contacts with each
/// other or with walls. In 3D the disks are spheres.
///
/// Method: a hierarchical grid with one level per power of two of the radius. O(N log N) in the
/// number N of disks for any ratio of radii, plus N times the number of walls. Deterministic: the
/// same bits for any number of threads. Throws std::invalid_argument for disks with coincident
/// centres (no normal).
template <int D>
std::vector<Contact<D>> detect_contacts(std::span<const Body<D>> disks,
                                        std::span<const Wall<D>> walls, double eta,
                                        int threads = 1);
inline std::vector<Contact<2>> detect_contacts(std::span<const Disk> disks,
                                               std::span<const Wall<2>> walls, double eta,
                                               int threads = 1) {
  return detect_contacts<2>(disks, walls, eta, threads);
}

/// Appends the contact of disk i with the wall (body number j) if its gap is at most eta.
template <int D>
void find_wall_contact(const Body<D>& disk, int i, const Wall<D>& wall, int j, double eta,
                       std::vector<Contact<D>>& out);

/// Contacts of the same bodies step after step, bit for bit those of detect_contacts(). Pairs up to
/// a skin farther apart than eta are kept. Only their gaps are computed anew, until a body has
/// moved by more than half the skin since the search (Verlet 1967). If bodies are too fast for
/// this, it searches at each step.
template <int D>
class KeptContacts {
 public:
  std::vector<Contact<D>> operator()(std::span<const Body<D>> disks, std::span<const Wall<D>> walls,
                                     double eta, int threads = 1);
  int searches() const { return searches_; }

 private:
  bool hold(std::span<const Body<D>> disks, std::span<const Wall<D>> walls, double eta,
            int threads) const;
  void keep(std::span<const Body<D>> disks, std::span<const Wall<D>> walls, double eta,
            int threads);

  struct Pair {
    int i, j;
  };
  struct Place {
    Vec<D> x;
    double radius;
  };
  std::vector<Pair> pairs_;   // sorted by (i, j)
  std::vector<Place> disks_;  // at the search; none: there is no list
  std::vector<Wall<D>> walls_;
  double eta_ = 0, skin_ = 0;
  int lasted_ = 0;  // calls that the list has served
  int pause_ = 0;   // calls to come that make no list
  int searches_ = 0;
};

}  // namespace bipot
