#include "core/scene/near_pairs.h"

#include <algorithm>
#include <cmath>

#include "core/scene/contact_detection.h"
#include "core/scene/periodic_detection.h"

namespace bipot {
namespace {

/// Room that a search leaves beyond the ways: a share of them, and of the smallest radius. In a
/// periodic cell the latter is at most half of the longest way.
constexpr double kRoomOfWay = 0.5, kLeastRoom = 0.1;

template <int D>
Vec<D> place_in_cell(const Body<D>& body, const PeriodicCell& cell, const CellNumber& number) {
  if (!cell.periodic()) return body.x;
  return body.x - in_dimensions<D>(cell.shift(number.kx, number.ky));
}

}  // namespace

template <int D>
double NearPairs<D>::longest_way(const PeriodicCell& cell, double longest_body) {
  if (!cell.periodic()) return kInfinity;
  // Rooms are at most twice as long, and detection refuses bodies longer than half of the cell.
  return 0.05 * std::max(shortest_period(cell) - longest_body, 0.0);
}

template <int D>
int NearPairs<D>::most_widths(const PeriodicCell& cell) {
  if (!cell.in_y) return 2;
  return 3 + static_cast<int>(std::abs(cell.offset.length / cell.width.length));
}

template <int D>
bool NearPairs<D>::hold(std::span<const Body<D>> bodies, const PeriodicCell& cell,
                        std::span<const double> ways, double image_way) const {
  if (places_.empty() || bodies.size() != places_.size()) return false;
  Vec<D> common = Vec<D>::Zero();
  if (cell.periodic()) {
    const Vec2 moved = cell.shift(1, 0) - cell_.shift(1, 0);
    const Vec2 moved_up = cell.shift(0, 1) - cell_.shift(0, 1);
    const double images = cell.in_y ? moved_up.norm() + most_widths(cell) * moved.norm()
                                    : most_widths(cell) * moved.norm();
    if (!(images + image_way <= image_room_)) return false;
  } else {
    for (std::size_t k = 0; k < bodies.size(); ++k) common += bodies[k].x - places_[k].x;
    common /= static_cast<double>(bodies.size());
  }
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const Place& place = places_[k];
    const Vec<D> moved = place_in_cell(bodies[k], cell, place.number) - place.x - common;
    if (bodies[k].radius != place.radius) return false;
    if (!(moved.norm() + ways[k] <= place.room)) return false;
  }
  return true;
}

template <int D>
const std::vector<typename NearPairs<D>::Pair>& NearPairs<D>::within(
    std::span<const Body<D>> bodies, const PeriodicCell& cell, std::span<const double> ways,
    double image_way, int threads) {
  if (hold(bodies, cell, ways, image_way)) return pairs_;
  places_.clear();  // no list, should the search throw
  double skin = kInfinity, longest = 0;
  for (const Body<D>& d : bodies) skin = std::min(skin, kLeastRoom * d.radius);
  for (const double way : ways) longest = std::max(longest, way);
  if (cell.periodic()) skin = std::min(skin, 0.5 * longest);
  image_room_ = (1 + kRoomOfWay) * image_way;
  std::vector<Body<D>> grown(bodies.begin(), bodies.end());
  std::vector<Place> places;
  places.reserve(bodies.size());
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const CellNumber number =
        cell.periodic() ? cell_number(cell, bodies[k].x.template head<2>()) : CellNumber{};
    const double room = (1 + kRoomOfWay) * ways[k] + skin;
    places.push_back({place_in_cell(bodies[k], cell, number), number, bodies[k].radius, room});
    grown[k].radius += room;
  }
  const std::vector<Contact<D>> found =
      cell.periodic() ? detect_periodic_contacts<D>(grown, {}, cell, image_room_, threads)
                      : detect_contacts<D>(grown, {}, 0, threads);
  pairs_.clear();
  pairs_.reserve(found.size());
  for (const Contact<D>& c : found) pairs_.push_back({c.i, c.j, c.image_x, c.image_y});
  places_ = std::move(places);
  cell_ = cell;
  return pairs_;
}

template class NearPairs<2>;
template class NearPairs<3>;

}  // namespace bipot
