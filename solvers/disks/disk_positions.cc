#include "solvers/disks/disk_positions.h"

#include <algorithm>

#include "core/base/lists.h"

namespace bipot {

DiskPositions disk_positions(const DiskStructure& disks, double apart) {
  const int bodies = disks.surroundings();
  const Lists<> contacts = make_lists(bodies, [&](const auto& put) {
    for (int c = 0; c < static_cast<int>(disks.contacts.size()); ++c) {
      const DiskStructure::Contact& contact = disks.contacts[to_size(c)];
      if (contact.j >= disks.first_wall()) continue;
      put(contact.i, c);
      put(contact.j, c);
    }
  });
  DiskPositions out{std::vector<Vec2>(to_size(bodies), Vec2::Zero()),
                    std::vector<int>(to_size(bodies), 0)};
  double right = 0;  // of the packings before
  std::vector<int> packing;
  for (int first = 0; first < bodies; ++first) {
    if (out.companions[to_size(first)] != 0) continue;
    packing.assign(1, first);
    out.companions[to_size(first)] = 1;
    double low = 0, high = 0;
    for (std::size_t at = 0; at < packing.size(); ++at) {
      const int body = packing[at];
      const Vec2 centre = out.centre[to_size(body)];
      low = std::min(low, centre.x());
      high = std::max(high, centre.x());
      for (const int c : contacts.of(body)) {
        const DiskStructure::Contact& contact = disks.contacts[to_size(c)];
        const bool is_first = contact.i == body;
        const int other = is_first ? contact.j : contact.i;
        if (out.companions[to_size(other)] != 0) continue;
        const double distance = disks.bodies[to_size(body)].arm + disks.bodies[to_size(other)].arm;
        const Vec2 from_j(distance * contact.n[0], distance * contact.n[1]);
        out.centre[to_size(other)] = is_first ? Vec2(centre - from_j) : Vec2(centre + from_j);
        out.companions[to_size(other)] = 1;
        packing.push_back(other);
      }
    }
    for (const int body : packing) {
      out.centre[to_size(body)].x() += right - low;
      out.companions[to_size(body)] = static_cast<int>(packing.size());
    }
    right += high - low + apart;
  }
  return out;
}

}  // namespace bipot
