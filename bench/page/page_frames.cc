#include "bench/page/page_frames.h"

#include <bit>
#include <utility>

namespace bipot {
namespace {

/// 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
template <class Unsigned>
Unsigned folded(Unsigned difference) {
  using Signed = std::make_signed_t<Unsigned>;
  const auto x = static_cast<Signed>(difference);
  return static_cast<Unsigned>((difference << 1) ^ static_cast<Unsigned>(x < 0 ? -1 : 0));
}

/// Appends an array of unsigned numbers plane by plane.
template <class Unsigned>
void add_planes(std::string& bytes, const std::vector<Unsigned>& values) {
  const std::size_t count = values.size();
  const std::size_t begin = bytes.size();
  bytes.resize(begin + count * sizeof(Unsigned));
  for (std::size_t plane = 0; plane < sizeof(Unsigned); ++plane) {
    char* to = bytes.data() + begin + plane * count;
    for (std::size_t k = 0; k < count; ++k) {
      to[k] = static_cast<char>((values[k] >> (8 * plane)) & 0xff);
    }
  }
}

/// For each item its place in the frame before, -1 if it was not there. Both sorted.
template <class Key>
std::vector<std::ptrdiff_t> places_before(const std::vector<Key>& before,
                                          const std::vector<Key>& now) {
  std::vector<std::ptrdiff_t> places(now.size(), -1);
  std::size_t b = 0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    while (b < before.size() && before[b] < now[k]) ++b;
    if (b < before.size() && before[b] == now[k]) places[k] = static_cast<std::ptrdiff_t>(b);
  }
  return places;
}

/// Appends the differences to the frame before, component by component.
template <class Value>
void add_differences(std::string& bytes, const std::vector<Value>& now,
                     const std::vector<Value>& before, const std::vector<std::ptrdiff_t>& places,
                     std::size_t width) {
  using Unsigned = std::make_unsigned_t<Value>;
  std::vector<Unsigned> differences(now.size());
  for (std::size_t c = 0; c < width; ++c) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      auto difference = static_cast<Unsigned>(now[k * width + c]);
      if (places[k] >= 0) {
        difference = static_cast<Unsigned>(
            difference - static_cast<Unsigned>(before[to_size(places[k]) * width + c]));
      }
      differences[c * places.size() + k] = folded(difference);
    }
  }
  add_planes(bytes, differences);
}

std::vector<std::pair<std::int32_t, std::int32_t>> pairs_of(const FilmFrame& frame) {
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs(frame.i.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) pairs[k] = {frame.i[k], frame.j[k]};
  return pairs;
}

void add_contacts(std::string& bytes, const FilmFrame& now, const FilmFrame& before,
                  const FilmFrame::Widths& widths) {
  const auto places = places_before(pairs_of(before), pairs_of(now));
  std::vector<std::uint8_t> kept(before.i.size(), 0);
  std::vector<std::uint32_t> new_i, new_j;
  std::int32_t last = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (places[k] >= 0) {
      kept[to_size(places[k])] = 1;
      continue;
    }
    new_i.push_back(static_cast<std::uint32_t>(now.i[k] - last));
    new_j.push_back(static_cast<std::uint32_t>(now.j[k]));
    last = now.i[k];
  }
  add_planes(bytes, kept);
  add_planes(bytes, std::vector<std::uint32_t>{static_cast<std::uint32_t>(new_i.size())});
  add_planes(bytes, new_i);
  add_planes(bytes, new_j);
  add_differences(bytes, now.n, before.n, places, widths.n);
  add_differences(bytes, now.gap, before.gap, places, 1);
  add_differences(bytes, now.force_n, before.force_n, places, 1);
  add_differences(bytes, now.force_t, before.force_t, places, widths.spin);
  add_differences(bytes, now.status, before.status, places, 1);
}

template <class Get>
void add_column(std::string& bytes, const std::vector<PageBody>& bodies, Get get) {
  std::vector<decltype(get(PageBody()))> column;
  for (const PageBody& body : bodies) column.push_back(get(body));
  add_planes(bytes, column);
}

/// Keeps the marked contacts of one array.
template <class Value>
void keep(std::vector<Value>& values, const std::vector<bool>& stays, std::size_t width) {
  std::size_t to = 0;
  for (std::size_t k = 0; k < stays.size(); ++k) {
    if (!stays[k]) continue;
    for (std::size_t c = 0; c < width; ++c) values[to++] = values[k * width + c];
  }
  values.resize(to);
}

}  // namespace

std::string packed_frames(const std::vector<PageBody>& bodies, const std::vector<FilmFrame>& frames,
                          int dim, bool gates) {
  const FilmFrame::Widths widths(dim);
  std::string bytes;
  add_column(bytes, bodies,
             [](const PageBody& b) { return std::bit_cast<std::uint32_t>(b.radius); });
  add_column(bytes, bodies, [](const PageBody& b) { return std::bit_cast<std::uint32_t>(b.mass); });
  add_column(bytes, bodies, [](const PageBody& b) { return b.material; });
  add_column(bytes, bodies, [](const PageBody& b) { return b.glued; });
  add_column(bytes, bodies,
             [](const PageBody& b) { return static_cast<std::uint32_t>(b.cluster); });
  const FilmFrame none;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const FilmFrame& now = frames[f];
    const FilmFrame& before = f > 0 ? frames[f - 1] : none;
    const auto places = places_before(before.number, now.number);
    if (gates) {
      std::vector<std::uint32_t> steps;
      for (std::size_t k = 0; k < now.number.size(); ++k) {
        steps.push_back(
            static_cast<std::uint32_t>(now.number[k] - (k > 0 ? now.number[k - 1] : 0)));
      }
      add_planes(bytes, steps);
    }
    add_differences(bytes, now.x, before.x, places, widths.x);
    add_differences(bytes, now.turn, before.turn, places, widths.spin);
    add_differences(bytes, now.v, before.v, places, widths.x);
    add_differences(bytes, now.spin, before.spin, places, widths.spin);
    add_contacts(bytes, now, before, widths);
  }
  return bytes;
}

std::vector<FilmFrame> thinned(const std::vector<FilmFrame>& frames, std::size_t stride) {
  std::vector<FilmFrame> kept;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (k % stride == 0 || k + 1 == frames.size()) kept.push_back(frames[k]);
  }
  return kept;
}

double drop_weak_contacts(std::vector<FilmFrame>& frames, int dim, double quantile) {
  const FilmFrame::Widths widths(dim);
  std::vector<std::uint16_t> forces;  // codes have the order of the forces, which push
  for (const FilmFrame& frame : frames) {
    forces.insert(forces.end(), frame.force_n.begin(), frame.force_n.end());
  }
  if (forces.empty()) return 0;
  const auto place = forces.begin() +
                     static_cast<std::ptrdiff_t>(quantile * static_cast<double>(forces.size() - 1));
  std::nth_element(forces.begin(), place, forces.end());
  for (FilmFrame& frame : frames) {
    std::vector<bool> stays;
    for (const std::uint16_t force : frame.force_n) stays.push_back(force >= *place);
    keep(frame.i, stays, 1);
    keep(frame.j, stays, 1);
    keep(frame.n, stays, widths.n);
    keep(frame.gap, stays, 1);
    keep(frame.force_n, stays, 1);
    keep(frame.force_t, stays, widths.spin);
    keep(frame.status, stays, 1);
  }
  return log_value(*place);
}

}  // namespace bipot
