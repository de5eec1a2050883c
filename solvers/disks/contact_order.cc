#include "solvers/disks/contact_order.h"

#include <algorithm>
#include <compare>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/lists.h"
#include "solvers/disks/free_lanes.h"

namespace bipot {
namespace {

/// Batches of a tile of an order.
constexpr int kOrderedBatches = 64;
/// Mean number of contacts of a strip at each level. A body's next contact comes two batches later,
/// so that 16 are the least; levels with fewer, at the ends of a strip, leave lanes empty.
constexpr int kStripWidth = 40;
/// Least number of strips side by side. Fewer gain little over the sweeps of an iteration that
/// follow each other, which strips let do so less closely.
constexpr int kStrips = 4;
/// Contacts of a part of a strip, which fill less than a tile.
constexpr int kPartContacts = 384;
/// Least fraction of used lanes for which the order along the rows is chosen. It needs fewer
/// iterations, which outweighs some empty lanes.
constexpr double kFilled = 0.75;

/// The contacts in the order of the rows: by their first body, those with the surroundings first,
/// then by the second.
template <class Bodies>
std::vector<int> sweep_order(const Bodies& packed, const std::vector<int>& row) {
  struct Placed {
    int second, contact;
    auto operator<=>(const Placed&) const = default;
  };
  const auto rows = [&](const auto& contact) {
    const int i = row[to_size(contact.i)];
    if (contact.j == packed.surroundings()) return std::pair(i, -1);
    const int j = row[to_size(contact.j)];
    return std::pair(std::min(i, j), std::max(i, j));
  };
  // Sorts into a list for each first body, which is short.
  Lists<Placed> placed = make_lists<Placed>(packed.surroundings(), [&](const auto& put) {
    for (std::size_t c = 0; c < packed.contacts.size(); ++c) {
      const auto [first, second] = rows(packed.contacts[c]);
      put(first, {second, static_cast<int>(c)});
    }
  });
  for (int body = 0; body < placed.count(); ++body) std::ranges::sort(placed.of(body));
  std::vector<int> order;
  order.reserve(placed.items.size());
  for (const Placed& p : placed.items) order.push_back(p.contact);
  return order;
}

/// An order of contacts, cut into parts. Each is independent of those after it.
struct CutOrder {
  std::vector<int> contacts, end;
};

/// Level of each contact: one more than those of earlier contacts of its bodies. Returns the number
/// of levels.
template <class Bodies>
int number_levels(const Bodies& packed, const std::vector<int>& order, std::vector<int>& level) {
  level.resize(order.size());
  std::vector<int> next(packed.bodies.size(), 0);
  int levels = 0;
  for (const int c : order) {
    const auto& contact = packed.contacts[to_size(c)];
    int& own = level[to_size(c)];
    own = next[to_size(contact.i)];
    if (contact.j != packed.surroundings()) own = std::max(own, next[to_size(contact.j)]);
    next[to_size(contact.i)] = own + 1;
    if (contact.j != packed.surroundings()) next[to_size(contact.j)] = own + 1;
    levels = std::max(levels, own + 1);
  }
  return levels;
}

/// Where levels are wide, cuts the order into strips and each strip into parts of consecutive
/// levels. A part then waits for the one before it in its strip and for some of earlier strips,
/// but seldom for the end of the strip before: several strips can be swept at once. (Tiling of
/// wavefronts: Wolfe, Int. J. Parallel Program. 15, 1986; levels: Anderson and Saad, Int. J. High
/// Speed Comput. 1, 1989.) Narrow orders stay whole.
template <class Bodies>
CutOrder cut_order(const Bodies& packed, const std::vector<int>& order) {
  std::vector<int> level;
  const int levels = number_levels(packed, order, level), size = static_cast<int>(order.size());
  if (size < kStrips * kStripWidth * levels) return {order, {size}};
  CutOrder out;
  out.contacts.resize(order.size());
  const auto level_at = [&](int place) { return level[to_size(order[to_size(place)])]; };
  std::vector<int> start;
  for (int begin = 0, end = 0; begin < size; begin = end) {
    int least = levels, most = 0;
    const auto take = [&] {
      least = std::min(least, level_at(end));
      most = std::max(most, level_at(end));
      ++end;
    };
    do {
      take();
    } while (end < size && end - begin < std::max(kPartContacts, kStripWidth * (most - least + 1)));
    if (2 * (size - end) < end - begin) {
      while (end < size) take();  // a short remainder
    }
    start.assign(to_size(most - least + 2), 0);
    for (int k = begin; k < end; ++k) ++start[to_size(level_at(k) - least + 1)];
    start[0] = begin;
    std::partial_sum(start.begin(), start.end(), start.begin());
    for (int k = 1, from = begin; k <= most - least + 1; ++k) {
      const int to = start[to_size(k)];
      if (to < end && (to - from < kPartContacts || end - to < kPartContacts / 2)) continue;
      out.end.push_back(from = to);
    }
    for (int k = begin; k < end; ++k) {
      out.contacts[to_size(start[to_size(level_at(k) - least)]++)] = order[to_size(k)];
    }
  }
  return out;
}

/// Batches for the contacts in this order. A part has tiles of its own, of at most `of_tile`
/// batches.
template <class Bodies>
ContactTiles batches_in_order(const Bodies& packed, const CutOrder& order, int of_tile) {
  ContactTiles out;
  const int bodies = packed.surroundings();
  FreeLanes free;
  // First batch of the part in which a body may occur again, and the part.
  struct Next {
    int part = -1, batch = 0;
  };
  std::vector<Next> next(to_size(bodies));
  std::vector<int> ends;  // of the tiles
  int first = 0;
  for (int part = 0; part < static_cast<int>(order.end.size()); ++part) {
    free.clear();
    const auto next_of = [&](int body) {
      const Next& of = next[to_size(body)];
      return of.part == part ? of.batch : 0;
    };
    for (const int last = order.end[to_size(part)]; first < last; ++first) {
      const int c = order.contacts[to_size(first)];
      const auto& contact = packed.contacts[to_size(c)];
      int wanted = next_of(contact.i);
      if (contact.j != bodies) wanted = std::max(wanted, next_of(contact.j));
      const int batch = free.first(wanted);
      free.put(batch, c);
      next[to_size(contact.i)] = {part, batch + kBatchGap};
      if (contact.j != bodies) next[to_size(contact.j)] = {part, batch + kBatchGap};
    }
    int batch = out.num_batches();
    out.contact.insert(out.contact.end(), free.lanes().begin(), free.lanes().end());
    do {
      ends.push_back(batch += std::min(of_tile, out.num_batches() - batch));
    } while (batch < out.num_batches());
  }
  // Rows in the order in which batches use them: they are then read as a stream, although a batch
  // has contacts of eight rows of the packing.
  out.row.assign(to_size(bodies), -1);
  const auto place = [&](int body) {
    if (body != bodies && out.row[to_size(body)] < 0) out.row[to_size(body)] = out.num_rows++;
  };
  for (const int end : ends) {
    ContactTiles::Tile tile;
    tile.first_batch = out.tiles.empty() ? 0 : out.tiles.back().last_batch;
    tile.last_batch = end;
    tile.first_row = out.num_rows;
    for (int lane = tile.first_batch * kLanes; lane < tile.last_batch * kLanes; ++lane) {
      const int c = out.contact[to_size(lane)];
      if (c < 0) continue;
      place(packed.contacts[to_size(c)].i);
      place(packed.contacts[to_size(c)].j);
    }
    if (end == out.num_batches()) {
      for (int body = 0; body < bodies; ++body) place(body);  // those without contacts
    }
    tile.last_row = ++out.num_rows;  // with one for the surroundings
    out.tiles.push_back(tile);
  }
  return out;
}

std::vector<int> as_given(std::size_t contacts) {
  std::vector<int> order(contacts);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

}  // namespace

template <class Bodies>
ContactTiles order_contacts(const Bodies& packed) {
  const std::vector<int> order = sweep_order(packed, body_rows(packed));
  return batches_in_order(packed, cut_order(packed, order), kOrderedBatches);
}

template <class Bodies>
ContactTiles given_order(const Bodies& packed) {
  const int contacts = static_cast<int>(packed.contacts.size());
  return batches_in_order(packed, {as_given(packed.contacts.size()), {contacts}},
                          std::numeric_limits<int>::max());
}

template <class Bodies>
ContactTiles symmetric_order(const Bodies& packed) {
  if constexpr (std::is_same_v<Bodies, SphereStructure>) {
    const std::vector<int> order = as_given(packed.contacts.size());
    return batches_in_order(packed, cut_order(packed, order), kOrderedBatches);
  }
  ContactTiles along = order_contacts(packed);
  const auto contacts = static_cast<double>(packed.contacts.size());
  return contacts >= kFilled * kLanes * along.num_batches() ? along : tile_contacts(packed);
}

#define BIPOT_ORDERS(Bodies)                           \
  template ContactTiles given_order(const Bodies&);    \
  template ContactTiles order_contacts(const Bodies&); \
  template ContactTiles symmetric_order(const Bodies&);
BIPOT_ORDERS(DiskStructure)
BIPOT_ORDERS(SphereStructure)
#undef BIPOT_ORDERS

}  // namespace bipot
