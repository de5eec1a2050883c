#include "solvers/disks/body_blocks.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "core/base/lists.h"
#include "solvers/disks/wavefront.h"

namespace bipot {
namespace {

/// Fewer bodies in a tile start and end kernels too often.
constexpr int kLeastBodies = 200;
/// With fewer lanes in use the contacts of a batch are loose.
constexpr int kLeastLanes = 5;
/// Number of windows after which loose contacts are written in an incomplete batch.
constexpr int kWaitingWindows = 1;
constexpr int kWindowBodies = kWindowBlocks * kLanes;

/// Positions of the bodies before they are sorted within their windows.
struct Places {
  std::vector<int> position, starts, tile;  // of bodies; of tiles; of positions

  template <class Bodies>
  explicit Places(const Bodies& packed)
      : position(body_rows(packed)),
        starts(tile_starts(packed, position, kLeastBodies)),
        tile(to_size(packed.surroundings())) {
    for (int t = 0; t < num_tiles(); ++t) {
      std::fill(tile.begin() + starts[to_size(t)], tile.begin() + starts[to_size(t) + 1], t);
    }
  }
  int num_tiles() const { return static_cast<int>(starts.size()) - 1; }
  int window(int at) const { return (at - starts[to_size(tile[to_size(at)])]) / kWindowBodies; }
  int turn(int t) const { return turn_of_tile(t, num_tiles()); }
};

struct Owned {
  int contact, other;  ///< position of the other body; -1: the surroundings
};

/// The body to which each contact belongs, by position.
template <class Bodies>
class Owners {
 public:
  Owners(const Bodies& packed, const Places& places) : packed_(packed), places_(places) {
    const int contacts = static_cast<int>(packed.contacts.size());
    std::vector<int> owner(to_size(contacts)), count(to_size(packed.surroundings()), 0);
    std::vector<int> open;
    for (int c = 0; c < contacts; ++c) {
      const auto [i, j] = ends(c);
      owner[to_size(c)] = j < 0 ? i : later(i, j);
      if (owner[to_size(c)] < 0) {
        open.push_back(c);
      } else {
        ++count[to_size(owner[to_size(c)])];
      }
    }
    for (const int c : open) {
      const auto [i, j] = ends(c);
      const auto fewer = [&](int at) { return std::tuple(count[to_size(at)], -at); };
      owner[to_size(c)] = fewer(i) < fewer(j) ? i : j;
      ++count[to_size(owner[to_size(c)])];
    }
    owned_ = make_lists<Owned>(packed.surroundings(), [&](const auto& put) {
      for (int c = 0; c < contacts; ++c) {
        const auto [i, j] = ends(c);
        const int at = owner[to_size(c)];
        put(at, {c, at == i ? j : i});
      }
    });
    // The same order for every body: its own tile first, the surroundings last. Values pushed to
    // rows of the block itself are then written long before the block's sum is added to them.
    for (int at = 0; at < owned_.count(); ++at) {
      const auto key = [&](const Owned& o) {
        const bool here = o.other >= 0 && places.tile[to_size(o.other)] == places.tile[to_size(at)];
        return std::tuple(o.other < 0 ? 2 : here ? 0 : 1, o.other, o.contact);
      };
      const std::span<Owned> own = owned_.of(at);
      std::sort(own.begin(), own.end(),
                [&](const Owned& a, const Owned& b) { return key(a) < key(b); });
    }
  }
  int count(int at) const { return static_cast<int>(owned_.of(at).size()); }
  const Owned& operator()(int at, int k) const { return owned_.of(at)[to_size(k)]; }

 private:
  std::pair<int, int> ends(int c) const {
    const auto& contact = packed_.contacts[to_size(c)];
    return {places_.position[to_size(contact.i)],
            contact.j == packed_.surroundings() ? -1 : places_.position[to_size(contact.j)]};
  }
  /// The body that the sweep reaches later, -1 within one window.
  int later(int a, int b) const {
    const auto turn = [&](int at) {
      return std::pair(places_.turn(places_.tile[to_size(at)]), places_.window(at));
    };
    return turn(a) == turn(b) ? -1 : turn(a) > turn(b) ? a : b;
  }

  const Bodies& packed_;
  const Places& places_;
  Lists<Owned> owned_;
};

template <class Bodies>
class BlockWriter {
 public:
  BlockWriter(const Owners<Bodies>& owners, BodyBlocks& out) : owners_(owners), out_(out) {}

  void begin_tile() { out_.first_block.push_back(static_cast<int>(out_.blocks.size())); }
  void write_block(int row, std::span<const int> bodies, int window) {
    BodyBlock block{.row = row_offset<RowOfBodies<Bodies>>(row), .first = out_.tiles.num_batches()};
    for (int k = 0; k < owners_.count(bodies.front()); ++k) {
      int used = 0;
      for (const int at : bodies) used += k < owners_.count(at) ? 1 : 0;
      if (used < kLeastLanes) {
        for (const int at : bodies) {
          for (int n = k; n < owners_.count(at); ++n) loose_.push_back({owners_(at, n), window});
        }
        break;
      }
      begin_batch(row);
      others_.clear();
      for (int lane = 0; lane < kLanes; ++lane) {
        const auto at = to_size(kRowOfLane[lane]);
        if (at >= bodies.size() || k >= owners_.count(bodies[at])) continue;
        const Owned& owned = owners_(bodies[at], k);
        if (std::find(others_.begin(), others_.end(), owned.other) != others_.end()) {
          loose_.push_back({owned, window});  // no second body twice in a batch
          continue;
        }
        put(lane, owned);
        if (owned.other >= 0) others_.push_back(owned.other);
      }
    }
    block.loose = out_.tiles.num_batches();
    out_.blocks.push_back(block);
  }
  /// Writes loose contacts after the last block: full batches, and those that waited long enough.
  void write_loose(int window, bool last) {
    std::size_t done = 0;
    while (done < loose_.size() && (last || loose_.size() - done >= kLanes ||
                                    window - loose_[done].window >= kWaitingWindows)) {
      begin_batch(-1);
      for (int lane = 0; lane < kLanes && done < loose_.size(); ++lane, ++done) {
        put(lane, loose_[done].owned);
      }
    }
    loose_.erase(loose_.begin(), loose_.begin() + static_cast<std::ptrdiff_t>(done));
  }
  void end() {
    BodyBlock end;
    end.first = end.loose = out_.tiles.num_batches();
    out_.first_block.push_back(static_cast<int>(out_.blocks.size()));
    out_.blocks.push_back(end);
  }

 private:
  struct Loose {
    Owned owned;
    int window;
  };
  void begin_batch(int block_row) {
    out_.tiles.contact.resize(out_.tiles.contact.size() + kLanes, -1);
    out_.tiles.block_row.push_back(block_row);
  }
  void put(int lane, const Owned& owned) {
    out_.tiles.contact[out_.tiles.contact.size() - kLanes + to_size(lane)] = owned.contact;
  }

  const Owners<Bodies>& owners_;
  BodyBlocks& out_;
  std::vector<Loose> loose_;
  std::vector<int> others_;  // second bodies of a batch
};

template <class Bodies>
BodyBlocks blocks_of(const Bodies& packed) {
  BodyBlocks out;
  const Places places(packed);
  const Owners<Bodies> owners(packed, places);
  const int bodies = packed.surroundings();
  std::vector<int> at_row(to_size(bodies));  // row of each position
  out.tiles.outside_rows = kLanes;
  out.tiles.contact.reserve(packed.contacts.size() + packed.contacts.size() / 4);
  BlockWriter<Bodies> writer(owners, out);
  std::vector<int> window;
  for (int t = 0; t < places.num_tiles(); ++t) {
    const int first = places.starts[to_size(t)], last = places.starts[to_size(t) + 1];
    ContactTiles::Tile tile;
    tile.first_row = out.tiles.num_rows;
    tile.first_batch = out.tiles.num_batches();
    writer.begin_tile();
    int row = tile.first_row;
    for (int begin = first, w = 0; begin < last; begin += kWindowBodies, ++w) {
      const int end = std::min(last, begin + kWindowBodies);
      window.resize(to_size(end - begin));
      std::iota(window.begin(), window.end(), begin);
      std::stable_sort(window.begin(), window.end(),
                       [&](int a, int b) { return owners.count(a) > owners.count(b); });
      for (std::size_t k = 0; k < window.size(); k += kLanes, row += kLanes) {
        const std::span<const int> block =
            std::span(window).subspan(k, std::min<std::size_t>(window.size() - k, kLanes));
        for (std::size_t n = 0; n < block.size(); ++n) {
          at_row[to_size(block[n])] = row + static_cast<int>(n);
        }
        writer.write_block(row, block, w);
      }
      writer.write_loose(w, end == last);
    }
    tile.last_row = out.tiles.num_rows = row + kLanes;
    tile.last_batch = out.tiles.num_batches();
    out.tiles.tiles.push_back(tile);
  }
  writer.end();
  out.tiles.row.resize(to_size(bodies));
  for (int body = 0; body < bodies; ++body) {
    out.tiles.row[to_size(body)] = at_row[to_size(places.position[to_size(body)])];
  }
  return out;
}

}  // namespace

template <class Bodies>
BodyBlocks block_contacts(const Bodies& bodies) {
  return blocks_of(bodies);
}
template BodyBlocks block_contacts(const DiskStructure&);
template BodyBlocks block_contacts(const SphereStructure&);

}  // namespace bipot
