#include "core/scene/periodic_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/scene/cluster_motion.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

/// The disks in the cell (0, 0), followed by the images that can touch one of them.
template <int D>
struct CellCopy {
  std::vector<Body<D>> bodies;
  std::vector<int> original;      // of each disk in the list
  std::vector<CellNumber> image;  // of each disk in the list: it was moved by shift(image)
};

/// Images by half of the lattice: (kx, 0) with kx > 0, and (any, 1). Of two disks that touch across
/// the edge of the cell, exactly one has the image of the other beside it.
template <int D>
CellCopy<D> copy_with_images(const std::vector<Body<D>>& disks, const PeriodicCell& cell,
                             double eta) {
  CellCopy<D> copy;
  double largest = 0;
  for (const Body<D>& d : disks) largest = std::max(largest, d.radius);
  for (std::size_t k = 0; k < disks.size(); ++k) {
    const CellNumber number = cell_number(cell, disks[k].x.template head<2>());
    copy.bodies.push_back(disks[k]);
    copy.bodies.back().x -= in_dimensions<D>(cell.shift(number.kx, number.ky));
    copy.original.push_back(static_cast<int>(k));
    copy.image.push_back({-number.kx, -number.ky});
  }
  // p_y, less whole widths, has an x in [0, width): images in the row above start at -1 or -2.
  const int whole =
      cell.in_y ? static_cast<int>(std::floor(cell.offset.length / cell.width.length)) : 0;
  const std::size_t count = disks.size();
  for (int ky = 0; ky <= (cell.in_y ? 1 : 0); ++ky) {
    for (int kx = (ky == 0 ? 1 : -whole - 2); kx <= (ky == 0 ? 1 : -whole + 1); ++kx) {
      const Vec<D> shift = in_dimensions<D>(cell.shift(kx, ky));
      for (std::size_t k = 0; k < count; ++k) {
        Body<D> image = copy.bodies[k];
        image.x += shift;
        const double reach = image.radius + largest + eta;
        const Vec2 beyond(image.x[0] - cell.width.length,
                          cell.in_y ? image.x[1] - cell.height.length : 0.0);
        if (beyond[0] > reach || image.x[0] < -reach || beyond[1] > reach) continue;
        copy.bodies.push_back(image);
        copy.original.push_back(copy.original[k]);
        copy.image.push_back({copy.image[k].kx + kx, copy.image[k].ky + ky});
      }
    }
  }
  return copy;
}

/// The pair by original numbers, the smaller one first; the image is that of j as seen from i.
template <int D>
Contact<D> between_originals(const Contact<D>& found, const CellCopy<D>& copy) {
  const std::size_t a = to_size(found.i), b = to_size(found.j);
  Contact<D> contact = found;
  contact.i = copy.original[a];
  contact.j = copy.original[b];
  contact.image_x = copy.image[b].kx - copy.image[a].kx;
  contact.image_y = copy.image[b].ky - copy.image[a].ky;
  if (contact.i < contact.j || copy.bodies[b].wall >= 0) return contact;
  std::swap(contact.i, contact.j);
  contact.n = -contact.n;
  contact.image_x = -contact.image_x;
  contact.image_y = -contact.image_y;
  return contact;
}

/// Contacts of the disks with one wall, the image with the smallest gap of each.
template <int D>
void find_at_wall(const std::vector<Body<D>>& disks, const Wall<D>& wall, int j,
                  const PeriodicCell& cell, double eta, std::vector<Contact<D>>& out) {
  if (!wall.present) return;
  std::vector<Contact<D>> found;
  for (std::size_t i = 0; i < disks.size(); ++i) {
    if (disks[i].wall >= 0) continue;
    found.clear();
    visit_wall_images<D>(cell, wall, disks[i].x, [&](int kx, int ky) {
      Body<D> seen = disks[i];
      seen.x -= in_dimensions<D>(cell.shift(kx, ky));
      const std::size_t before = found.size();
      find_wall_contact<D>(seen, static_cast<int>(i), wall, j, eta, found);
      if (found.size() == before) return;
      found.back().image_x = kx;
      found.back().image_y = ky;
    });
    if (found.empty()) continue;
    out.push_back(*std::min_element(found.begin(), found.end(),
                                    [](const auto& a, const auto& b) { return a.gap < b.gap; }));
  }
}

}  // namespace

template <int D>
std::vector<Contact<D>> detect_periodic_contacts(const std::vector<Body<D>>& disks,
                                                 const std::vector<Wall<D>>& walls,
                                                 const PeriodicCell& cell, double eta,
                                                 int threads) {
  double largest = 0;
  for (const Body<D>& d : disks) largest = std::max(largest, d.radius);
  if (!(shortest_period(cell) > 4 * largest + 2 * eta)) {
    throw std::invalid_argument(fmt::format(
        "the cell repeats itself after {:.6g} m: it must be longer than two of the largest "
        "diameters, {:.6g} m, so that two disks touch once",
        shortest_period(cell), 4 * largest));
  }
  if (auto e = check_cluster_lengths<D>(disks, cell, eta); !e.empty()) {
    throw std::invalid_argument(e);
  }
  const CellCopy<D> copy = copy_with_images<D>(disks, cell, eta);
  std::vector<Contact<D>> contacts;
  const int count = static_cast<int>(disks.size());
  for (const Contact<D>& found : detect_contacts<D>(copy.bodies, {}, eta, threads)) {
    if (found.i >= count && found.j >= count)
      continue;  // both are images: their originals are met as well
    contacts.push_back(between_originals<D>(found, copy));
  }
  for (std::size_t w = 0; w < walls.size(); ++w) {
    find_at_wall<D>(disks, walls[w], count + static_cast<int>(w), cell, eta, contacts);
  }
  std::sort(contacts.begin(), contacts.end(),
            [](const auto& a, const auto& b) { return a.pair() < b.pair(); });
  return contacts;
}

template std::vector<Contact<2>> detect_periodic_contacts(const std::vector<Disk>&,
                                                          const std::vector<Wall<2>>&,
                                                          const PeriodicCell&, double, int);
template std::vector<Contact<3>> detect_periodic_contacts(const std::vector<Sphere>&,
                                                          const std::vector<Wall<3>>&,
                                                          const PeriodicCell&, double, int);

}  // namespace bipot
