#include "bench/page/page_frames.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

/// What player/frames.js does, in the words of page_frames.h.
class Unpacker {
 public:
  Unpacker(std::string bytes, int dim) : bytes_(std::move(bytes)), widths_(dim) {}

  template <class T>
  std::vector<T> planes(std::size_t count) {
    std::vector<T> values(count, 0);
    for (std::size_t plane = 0; plane < sizeof(T); ++plane) {
      for (std::size_t k = 0; k < count; ++k) {
        const auto byte = static_cast<unsigned char>(bytes_.at(next_ + plane * count + k));
        values[k] = static_cast<T>(values[k] | static_cast<T>(byte) << (8 * plane));
      }
    }
    next_ += count * sizeof(T);
    return values;
  }

  /// Items of this frame by key; each has its components together.
  template <class T, class Key>
  std::vector<T> differences(const std::vector<Key>& keys,
                             const std::map<Key, std::vector<T>>& before, std::size_t width) {
    using Unsigned = std::make_unsigned_t<T>;
    const auto folded = planes<Unsigned>(keys.size() * width);
    std::vector<T> values(folded.size());
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const auto found = before.find(keys[k]);
      for (std::size_t c = 0; c < width; ++c) {
        const Unsigned f = folded[c * keys.size() + k];
        const auto difference =
            static_cast<Unsigned>((f >> 1) ^ static_cast<Unsigned>(f & 1 ? -1 : 0));
        const Unsigned base =
            found == before.end() ? Unsigned{0} : static_cast<Unsigned>(found->second[c]);
        values[k * width + c] = static_cast<T>(static_cast<Unsigned>(difference + base));
      }
    }
    return values;
  }

  bool at_end() const { return next_ == bytes_.size(); }
  const FilmFrame::Widths& widths() const { return widths_; }

 private:
  std::string bytes_;
  std::size_t next_ = 0;
  FilmFrame::Widths widths_;
};

template <class T, class Key>
std::map<Key, std::vector<T>> by_key(const std::vector<Key>& keys, const std::vector<T>& values,
                                     std::size_t width) {
  std::map<Key, std::vector<T>> map;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    map[keys[k]].assign(values.begin() + static_cast<std::ptrdiff_t>(k * width),
                        values.begin() + static_cast<std::ptrdiff_t>((k + 1) * width));
  }
  return map;
}

using Pair = std::pair<std::int32_t, std::int32_t>;
std::vector<Pair> pairs(const FilmFrame& frame) {
  std::vector<Pair> all;
  for (std::size_t k = 0; k < frame.i.size(); ++k) all.emplace_back(frame.i[k], frame.j[k]);
  return all;
}

/// The frames of packed_frames(); numbers of bodies and contacts are those of `like`.
std::vector<FilmFrame> unpacked(const std::string& bytes, std::size_t bodies, int dim, bool gates,
                                const std::vector<FilmFrame>& like) {
  Unpacker in(bytes, dim);
  in.planes<std::uint32_t>(2 * bodies);
  in.planes<std::uint8_t>(2 * bodies);
  in.planes<std::uint32_t>(bodies);
  std::vector<FilmFrame> frames;
  FilmFrame before;
  const FilmFrame::Widths& w = in.widths();
  for (const FilmFrame& model : like) {
    FilmFrame now;
    if (gates) {
      std::int32_t last = 0;
      for (const std::uint32_t step : in.planes<std::uint32_t>(model.number.size())) {
        now.number.push_back(last += static_cast<std::int32_t>(step));
      }
    } else {
      now.number = model.number;
    }
    const auto bodies_of = [&](auto FilmFrame::*part, std::size_t width) {
      now.*part = in.differences(now.number, by_key(before.number, before.*part, width), width);
    };
    bodies_of(&FilmFrame::x, w.x);
    bodies_of(&FilmFrame::turn, w.spin);
    bodies_of(&FilmFrame::v, w.x);
    bodies_of(&FilmFrame::spin, w.spin);
    std::map<Pair, int> contacts;
    const auto kept = in.planes<std::uint8_t>(before.i.size());
    for (std::size_t k = 0; k < kept.size(); ++k) {
      if (kept[k] != 0) contacts[{before.i[k], before.j[k]}];
    }
    const std::size_t fresh = in.planes<std::uint32_t>(1)[0];
    const auto new_i = in.planes<std::uint32_t>(fresh), new_j = in.planes<std::uint32_t>(fresh);
    std::int32_t last = 0;
    for (std::size_t k = 0; k < fresh; ++k) {
      last += static_cast<std::int32_t>(new_i[k]);
      contacts[{last, static_cast<std::int32_t>(new_j[k])}];
    }
    for (const auto& [pair, _] : contacts) {
      now.i.push_back(pair.first);
      now.j.push_back(pair.second);
    }
    const auto contacts_of = [&](auto FilmFrame::*part, std::size_t width) {
      now.*part = in.differences(pairs(now), by_key(pairs(before), before.*part, width), width);
    };
    contacts_of(&FilmFrame::n, w.n);
    contacts_of(&FilmFrame::gap, 1);
    contacts_of(&FilmFrame::force_n, 1);
    contacts_of(&FilmFrame::force_t, w.spin);
    contacts_of(&FilmFrame::status, 1);
    frames.push_back(now);
    before = now;
  }
  EXPECT_TRUE(in.at_end());
  return frames;
}

/// Frames in which bodies come and go and contacts change, with all values of the codes.
std::vector<FilmFrame> random_frames(int dim, bool gates) {
  const FilmFrame::Widths w(dim);
  std::mt19937 random(7);
  const auto codes = [&](std::size_t count) {
    std::vector<std::uint16_t> values(count);
    for (auto& value : values) value = static_cast<std::uint16_t>(random());
    return values;
  };
  std::vector<FilmFrame> frames;
  for (int f = 0; f < 4; ++f) {
    FilmFrame frame{.step = f};
    for (int number = 0; number < 9; ++number) {
      if (!gates || random() % 4 != 0) frame.number.push_back(number);
    }
    const std::size_t n = frame.number.size();
    for (std::size_t k = 0; k < w.x * n; ++k)
      frame.x.push_back(static_cast<std::int32_t>(random()));
    frame.turn = codes(w.spin * n);
    frame.v = codes(w.x * n);
    frame.spin = codes(w.spin * n);
    for (const int i : frame.number) {
      for (const int j : {i + 1, FilmFrame::kWall, FilmFrame::kWall + 3}) {
        if (random() % 2 != 0) continue;
        frame.i.push_back(i);
        frame.j.push_back(j);
        frame.status.push_back(static_cast<std::uint8_t>(random() % 3));
      }
    }
    frame.n = codes(w.n * frame.i.size());
    frame.gap = codes(frame.i.size());
    frame.force_n = codes(frame.i.size());
    frame.force_t = codes(w.spin * frame.i.size());
    frames.push_back(frame);
  }
  return frames;
}

TEST(PageFrames, ComeBackAsTheyWere) {
  for (const int dim : {2, 3}) {
    for (const bool gates : {false, true}) {
      const std::vector<FilmFrame> frames = random_frames(dim, gates);
      const std::vector<PageBody> bodies(9);
      const std::string bytes = packed_frames(bodies, frames, dim, gates);
      const auto again = unpacked(bytes, bodies.size(), dim, gates, frames);
      for (std::size_t f = 0; f < frames.size(); ++f) {
        const FilmFrame &a = frames[f], &b = again[f];
        EXPECT_EQ(a.number, b.number);
        EXPECT_EQ(a.x, b.x);
        EXPECT_EQ(a.turn, b.turn);
        EXPECT_EQ(a.v, b.v);
        EXPECT_EQ(a.spin, b.spin);
        EXPECT_EQ(pairs(a), pairs(b));
        EXPECT_EQ(a.n, b.n);
        EXPECT_EQ(a.gap, b.gap);
        EXPECT_EQ(a.force_n, b.force_n);
        EXPECT_EQ(a.force_t, b.force_t);
        EXPECT_EQ(a.status, b.status);
      }
    }
  }
}

TEST(PageFrames, ThinningKeepsTheFirstAndTheLast) {
  std::vector<FilmFrame> frames(8);
  for (int k = 0; k < 8; ++k) frames[static_cast<std::size_t>(k)].step = k;
  std::vector<int> steps;
  for (const FilmFrame& frame : thinned(frames, 3)) steps.push_back(frame.step);
  EXPECT_EQ(steps, (std::vector<int>{0, 3, 6, 7}));
}

TEST(PageFrames, WeakContactsGoFirst) {
  std::vector<FilmFrame> frames(1);
  frames[0].i = {0, 1, 2};
  frames[0].j = {1, 2, 3};
  frames[0].n = {10, 11, 12};
  frames[0].gap = {20, 21, 22};
  frames[0].force_n = {log_code(2), log_code(0.5), log_code(1)};
  frames[0].force_t = {30, 31, 32};
  frames[0].status = {1, 2, 1};
  EXPECT_NEAR(drop_weak_contacts(frames, 2, 0.5), 1, 2e-3);  // the second of three
  EXPECT_EQ(frames[0].i, (std::vector<std::int32_t>{0, 2}));
  EXPECT_EQ(frames[0].j, (std::vector<std::int32_t>{1, 3}));
  EXPECT_EQ(frames[0].n, (std::vector<std::uint16_t>{10, 12}));
  EXPECT_EQ(frames[0].status, (std::vector<std::uint8_t>{1, 1}));
}

}  // namespace
}  // namespace bipot
