#include "core/pictures/force_picture.h"

#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/base/file_error.h"
#include "core/base/stopwatch.h"
#include "core/files/atomic_file.h"
#include "core/motion/periodic_state.h"
#include "core/pictures/colour_map.h"
#include "core/pictures/png_image.h"
#include "core/scene/joints.h"

namespace bipot {
namespace {

// Okabe and Ito's blue, darkened, and orange. All common forms of colour vision can distinguish
// them, by lightness alone too.
constexpr Colour kStick = {0.02, 0.27, 0.48};
constexpr Colour kSlip = {0.95, 0.62, 0.04};
constexpr Colour kSlipRim = {0.42, 0.24, 0.0};
constexpr Colour kPull = {0.69, 0.09, 0.44};
constexpr Colour kTakeOff = {0.55, 0.55, 0.55};
constexpr Colour kDisk = {0.965, 0.965, 0.955};
constexpr Colour kGlued = {0.7, 0.7, 0.7};
constexpr Colour kDiskRim = {0.74, 0.74, 0.72};
constexpr Colour kJoint = {0.62, 0.68, 0.62};
constexpr Colour kWall = {0.2, 0.2, 0.2};
constexpr Colour kText = {0.13, 0.13, 0.13};
constexpr Colour kFilledRim = {0.35, 0.35, 0.35};
constexpr Colour kMark = {0.8, 0.05, 0.35};

constexpr double kMarkRadius = 6;     // of the ring around a marked contact       [points]
constexpr double kMargin = 24;        // around everything                         [points]
constexpr double kTallest = 1.25;     // height of the scene, relative to the width
constexpr double kNarrowest = 0.75;   // width of the view, relative to its height
constexpr double kFlattest = 0.3;     // height of the view, relative to its width
constexpr double kLargestDisk = 150;  // radius                                    [points]
constexpr double kWidest = 22;        // width of the widest segment               [points]
constexpr double kHatch = 9;          // spacing of the hatching                   [points]
constexpr double kLegendSize = 14, kCaptionSize = 16;
constexpr double kRowHeight = 34;
constexpr double kBarWidth = 300, kBarHeight = 14;  // of the colours             [points]
constexpr const char* kFont = "sans-serif";

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Canvas = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

void set(cairo_t* c, const Colour& colour) {
  cairo_set_source_rgb(c, colour.red, colour.green, colour.blue);
}

void stroke_line(cairo_t* c, const Vec2& a, const Vec2& b, double width, const Colour& colour,
                 cairo_line_cap_t cap = CAIRO_LINE_CAP_BUTT) {
  cairo_set_line_cap(c, cap);
  cairo_set_line_width(c, width);
  set(c, colour);
  cairo_move_to(c, a[0], a[1]);
  cairo_line_to(c, b[0], b[1]);
  cairo_stroke(c);
}

double text_width(cairo_t* c, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(c, text.c_str(), &extents);
  return extents.x_advance;
}

/// A circle as the whole path.
void trace_circle(cairo_t* c, const Vec2& centre, double radius) {
  cairo_new_path(c);
  cairo_arc(c, centre[0], centre[1], radius, 0, 2 * std::numbers::pi);
}

/// Draws the path as a line.
void stroke_path(cairo_t* c, double width, const Colour& colour) {
  set(c, colour);
  cairo_set_line_width(c, width);
  cairo_stroke(c);
}

void show_text(cairo_t* c, double x, double y, const std::string& text) {
  set(c, kText);
  cairo_move_to(c, x, y);
  cairo_show_text(c, text.c_str());
}

void use_font(cairo_t* c, double size) {
  cairo_select_font_face(c, kFont, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c, size);
}

/// The caption, wrapped into lines.
std::vector<std::string> wrap(cairo_t* c, const std::string& text, double width) {
  std::vector<std::string> lines;
  std::stringstream paragraphs(text);
  for (std::string paragraph; std::getline(paragraphs, paragraph);) {
    std::stringstream words(paragraph);
    std::string line;
    for (std::string word; words >> word;) {
      const std::string longer = line.empty() ? word : line + " " + word;
      if (!line.empty() && text_width(c, longer) > width) {
        lines.push_back(std::move(line));
        line = word;
      } else {
        line = longer;
      }
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

/// Metres to points, y upwards to y downwards.
struct Mapping {
  double scale = 1;  // points per metre
  Vec2 origin = Vec2::Zero();
  Vec2 operator()(const Vec2& x) const {
    return Vec2(origin[0] + scale * x[0], origin[1] - scale * x[1]);
  }
};

enum class Kind { kNone, kHeld, kSliding, kTension };

struct Segment {
  Vec2 a, b;  // points
  double force = 0;
  Kind kind = Kind::kNone;
  bool at_wall = false;  // b is a point of a wall
};

/// A line with round ends, or with one round end at a and a flat one at b.
void stroke_force(cairo_t* c, const Segment& s, double width, const Colour& colour) {
  stroke_line(c, s.a, s.b, width, colour, s.at_wall ? CAIRO_LINE_CAP_BUTT : CAIRO_LINE_CAP_ROUND);
  if (!s.at_wall) return;
  cairo_arc(c, s.a[0], s.a[1], 0.5 * width, 0, 2 * std::numbers::pi);
  cairo_fill(c);
}

void draw_segment(cairo_t* c, const Segment& s, double width) {
  if (s.kind == Kind::kNone) {
    const double dots[] = {1.0, 3.0};
    cairo_set_dash(c, dots, 2, 0);
    stroke_line(c, s.a, s.b, 0.9, kTakeOff);
    cairo_set_dash(c, nullptr, 0, 0);
  } else if (s.kind == Kind::kHeld) {
    stroke_force(c, s, width, kStick);
  } else if (s.kind == Kind::kTension) {
    stroke_force(c, s, width, kPull);
  } else {
    // The rim lies within the width, so that widths remain comparable.
    const double rim = std::min(1.1, 0.22 * width);
    stroke_force(c, s, width, kSlipRim);
    stroke_force(c, s, width - 2 * rim, kSlip);
  }
}

/// The solid side of a half-plane: short strokes at 45 degrees from the line.
void draw_hatching(cairo_t* c, const Vec2& first, const Vec2& last, const Vec2& outward) {
  const double length = (last - first).norm();
  if (!(length > 0)) return;
  const Vec2 along = (last - first) / length;
  const Vec2 stroke = kHatch * (along - outward);
  for (double at = 0; at < length; at += kHatch) {
    const Vec2 begin = first + at * along;
    stroke_line(c, begin, begin + stroke, 0.9, kWall);
  }
}

/// A circular wall; short strokes at 45 degrees on its solid side.
void draw_circle(cairo_t* c, const Vec2& centre, double radius, bool hollow) {
  trace_circle(c, centre, radius);
  stroke_path(c, 2, kWall);
  const int strokes = std::max(8, static_cast<int>(2 * std::numbers::pi * radius / kHatch));
  for (int k = 0; k < strokes; ++k) {
    const double angle = 2 * std::numbers::pi * k / strokes;
    const Vec2 out(std::cos(angle), std::sin(angle));
    const Vec2 begin = centre + radius * out;
    const double depth = hollow ? kHatch : -std::min(kHatch, 0.5 * radius);
    stroke_line(c, begin, begin + depth * (out + Vec2(-out[1], out[0])), 0.9, kWall);
  }
}

/// An entry of the legend: a drawing of given width and a text.
struct LegendItem {
  double width;
  std::string text;
  std::function<void(cairo_t*, double x, double y)> draw;  // at the left, middle of the row
};

/// A ring with a light edge, visible on dark and light ground.
void draw_mark(cairo_t* c, const Vec2& at) {
  for (const auto& [width, colour] : {std::pair{3.6, Colour{1, 1, 1}}, std::pair{2.0, kMark}}) {
    trace_circle(c, at, kMarkRadius);
    stroke_path(c, width, colour);
  }
}

class Picture {
 public:
  Picture(const Scene<2>& scene, const State<2>& state, const std::string& caption,
          const ForcePictureOptions& options)
      : scene_(scene), state_(state), options_(options), friction_(scene.has_friction()) {
    box_ = options.view ? *options.view : whole_view(scene, state);
    double largest = 0;
    for (const Disk& d : state.bodies) largest = std::max(largest, d.radius);
    const double width = std::max(largest * (options.width - 2 * kMargin) / kLargestDisk,
                                  kNarrowest * box_.size()[1]);
    const double height = kFlattest * std::max(width, box_.size()[0]);
    const Vec2 missing = (Vec2(width, height) - box_.size()).cwiseMax(0.0);
    box_.lower -= 0.5 * missing;
    box_.upper += 0.5 * missing;
    const double room = options.width - 2 * kMargin;
    map_.scale = std::min(room / box_.size()[0], kTallest * room / box_.size()[1]);
    const Vec2 size = map_.scale * box_.size();
    corner_ = Vec2(kMargin + 0.5 * (room - size[0]), kMargin);
    map_.origin =
        Vec2(corner_[0] - map_.scale * box_.lower[0], corner_[1] + map_.scale * box_.upper[1]);
    bottom_ = corner_[1] + size[1];
    if (!options.fill.values.empty() && options.fill.values.size() != state.bodies.size()) {
      throw std::invalid_argument(fmt::format("{} values colour {} disks",
                                              options.fill.values.size(), state.bodies.size()));
    }
    full_fill_ = options.fill.high;
    if (!(full_fill_ > 0) && !options.fill.values.empty()) {
      full_fill_ = *std::max_element(options.fill.values.begin(), options.fill.values.end());
    }
    if (options.forces) collect_segments();
    choose_widths();
    layout(caption);
  }

  double height() const { return height_; }

  void draw(cairo_t* c) const {
    cairo_set_source_rgb(c, 1, 1, 1);
    cairo_paint(c);
    cairo_save(c);
    cairo_rectangle(c, corner_[0], corner_[1], map_.scale * box_.size()[0],
                    map_.scale * box_.size()[1]);
    cairo_clip(c);
    draw_disks(c);
    draw_walls(c);
    draw_cell(c);
    for (const Segment& s : segments_) draw_segment(c, s, width_of(s.force));
    for (const int k : options_.marked) draw_mark(c, touching_point(k));
    cairo_restore(c);
    draw_legend(c);
  }

 private:
  bool near(const Vec2& x, double radius) const {
    return (x - box_.lower).minCoeff() > -radius && (box_.upper - x).minCoeff() > -radius;
  }
  double width_of(double force) const { return widest_ * force / full_force_; }

  void collect_segments() {
    const auto& disks = state_.bodies;
    for (const ContactOutcome<2>& o : state_.contacts) {
      Segment s;
      const auto j = static_cast<std::size_t>(o.contact.j);
      const auto [from, to] = drawn_branch(state_, o.contact);
      s.a = map_(from);
      s.at_wall = j >= disks.size();
      s.b = map_(to);
      s.force = o.loaded() ? std::abs(o.s_n) / scene_.step : 0.0;
      if (o.loaded() && o.s_n < 0) {
        s.kind = Kind::kTension;
      } else if (s.force > 0) {
        s.kind = friction_ && o.status == ContactStatus::kSlip ? Kind::kSliding : Kind::kHeld;
      }
      ++count_[static_cast<std::size_t>(s.kind)];
      if (s.kind == Kind::kNone && !options_.take_off) continue;
      segments_.push_back(s);
      if (!o.contact.with_image() || s.at_wall) continue;
      // At the edge of the cell: the half at the other disk as well.
      const Vec2 back = disks[j].x - to;
      s.a = map_(from + back);
      s.b = map_(disks[j].x);
      segments_.push_back(s);
    }
    // The strongest on top.
    std::stable_sort(segments_.begin(), segments_.end(),
                     [](const Segment& x, const Segment& y) { return x.force < y.force; });
  }

  /// Point of contact k, in points.
  Vec2 touching_point(int k) const {
    const Contact<2>& contact = state_.contacts.at(to_size(k)).contact;
    const Disk& i = state_.bodies[to_size(contact.i)];
    return map_(Vec2(i.x - i.radius * contact.n));
  }

  void choose_widths() {
    std::vector<double> radii;
    for (const Disk& d : state_.bodies) radii.push_back(map_.scale * d.radius);
    if (!radii.empty()) {
      const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
      std::nth_element(radii.begin(), middle, radii.end());
      widest_ = std::min(kWidest, 0.9 * *middle);
    }
    full_force_ = options_.full_force;
    if (!(full_force_ > 0)) {
      full_force_ = segments_.empty() ? 0.0 : segments_.back().force;
    }
    if (!(full_force_ > 0)) full_force_ = 1;  // nothing is drawn with it
  }

  /// The edges of a periodic cell.
  void draw_cell(cairo_t* c) const {
    const double dashes[] = {7.0, 4.0};
    cairo_set_dash(c, dashes, 2, 0);
    for (const auto& [a, b] : cell_outline(state_.cell, box_)) {
      stroke_line(c, map_(a), map_(b), 1.2, kText);
    }
    cairo_set_dash(c, nullptr, 0, 0);
  }

  void draw_disks(cairo_t* c) const {
    for (const Vec2& shift : image_shifts(state_.cell)) {
      draw_image(c, shift);
      draw_joints(c, shift);
    }
    draw_pins_and_ropes(c);
  }

  /// A pin from centre to centre through its point, a rope between its ends.
  void draw_pins_and_ropes(cairo_t* c) const {
    for (const Scene<2>::Joint& joint : scene_.joints) {
      const auto [from, to] = joint_points<2>(joint, state_.bodies);
      stroke_line(c, map_(from), map_(to), 1.5, kText, CAIRO_LINE_CAP_ROUND);
      if (joint.is_rope()) continue;
      for (const int i : {joint.i, joint.j}) {
        if (i < 0) continue;
        stroke_line(c, map_(state_.bodies[to_size(i)].x), map_(from), 1.5, kText,
                    CAIRO_LINE_CAP_ROUND);
      }
      cairo_arc(c, map_(from)[0], map_(from)[1], 2.5, 0, 2 * std::numbers::pi);
      cairo_fill(c);
    }
  }

  /// From the centre of mass of each cluster to its disks.
  void draw_joints(cairo_t* c, const Vec2& shift) const {
    for (const Disk& d : state_.bodies) {
      if (d.cluster < 0 || (shift != Vec2::Zero() && !near(d.x + shift, d.radius))) continue;
      const Vec2& centre = state_.clusters.bodies[to_size(d.cluster)].x;
      const double width = std::clamp(0.2 * map_.scale * d.radius, 0.6, 6.0);
      stroke_line(c, map_(centre + shift), map_(d.x + shift), width, kJoint, CAIRO_LINE_CAP_ROUND);
    }
  }

  /// Draws the disks, or an image of them as far as it is in the picture.
  void draw_image(cairo_t* c, const Vec2& shift) const {
    const std::vector<double>& fill = options_.fill.values;
    for (std::size_t k = 0; k < state_.bodies.size(); ++k) {
      const Disk& d = state_.bodies[k];
      if (watch_.seconds() > options_.time_limit) {
        throw std::runtime_error("the time limit is over");
      }
      if (shift != Vec2::Zero() && !near(d.x + shift, d.radius)) continue;
      const Vec2 x = map_(d.x + shift);
      const double radius = map_.scale * d.radius;
      const double rim = std::clamp(0.06 * radius, 0.15, 1.2);
      trace_circle(c, x, std::max(radius - 0.5 * rim, 0.1));
      set(c, fill.empty() ? (d.wall >= 0 ? kGlued : kDisk)
                          : sequential_colour(full_fill_ > 0 ? fill[k] / full_fill_ : 0));
      cairo_fill_preserve(c);
      stroke_path(c, rim, fill.empty() ? kDiskRim : kFilledRim);
    }
  }

  void draw_walls(cairo_t* c) const {
    const auto lines = wall_lines(state_.walls, box_);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const Wall<2>& w = state_.walls[k];
      if (!w.present) continue;
      if (w.is_circle()) {
        draw_circle(c, map_(w.a), map_.scale * w.radius, w.shape == Wall<2>::Shape::kHollowCircle);
        continue;
      }
      const Vec2 a = map_(lines[k].first), b = map_(lines[k].second);
      if (w.shape == Wall<2>::Shape::kHalfPlane) {
        draw_hatching(c, a, b, Vec2(w.normal[0], -w.normal[1]));
        stroke_line(c, a, b, 2, kWall);
      } else {
        stroke_line(c, a, b, 3, kWall, CAIRO_LINE_CAP_ROUND);
      }
    }
  }

  std::vector<LegendItem> legend_items() const {
    std::vector<LegendItem> items;
    const double length = round_below(0.22 * box_.size()[0]);
    const double bar = map_.scale * length;
    items.push_back({bar, with_prefix(length, "m"), [bar](cairo_t* c, double x, double y) {
                       stroke_line(c, Vec2(x, y), Vec2(x + bar, y), 2, kText);
                       for (double end : {x, x + bar}) {
                         stroke_line(c, Vec2(end, y - 5), Vec2(end, y + 5), 1.4, kText);
                       }
                     }});
    if (!options_.marked.empty()) {
      items.push_back(
          {2 * kMarkRadius, fmt::format("{} ({})", options_.marked_label, options_.marked.size()),
           [](cairo_t* c, double x, double y) { draw_mark(c, Vec2(x + kMarkRadius, y)); }});
    }
    if (!options_.forces) return items;
    const double loaded = count_[1] + count_[2] + count_[3];
    const auto sample = [this](Kind kind, double force) {
      return [this, kind, force](cairo_t* c, double x, double y) {
        const double inset = kind == Kind::kNone ? 0 : 0.5 * width_of(force);
        draw_segment(c, {Vec2(x + inset, y), Vec2(x + kSample - inset, y), force, kind, false},
                     width_of(force));
      };
    };
    const auto add_kind = [&](const char* name, Kind kind, double force) {
      const int count = count_[static_cast<std::size_t>(kind)];
      items.push_back({kSample, fmt::format("{} ({})", name, count), sample(kind, force)});
    };
    if (loaded > 0) {
      const double force = round_below(full_force_);
      items.push_back(
          {kSample, "normal force " + with_prefix(force, "N"), sample(Kind::kHeld, force)});
      const double shown = std::min(full_force_, full_force_ * 6 / widest_);
      add_kind(friction_ ? "stick" : "contact", Kind::kHeld, shown);
      if (friction_) add_kind("slip", Kind::kSliding, shown);
      if (count_[3] > 0) add_kind("tension", Kind::kTension, shown);
    } else {
      items.push_back({0, "no contact forces", [](cairo_t*, double, double) {}});
    }
    if (options_.take_off && count_[0] > 0) add_kind("open", Kind::kNone, 0);
    return items;
  }

  void layout(const std::string& caption) {
    const Surface scratch(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, 1, 1),
                          cairo_surface_destroy);
    const Canvas canvas(cairo_create(scratch.get()), cairo_destroy);
    cairo_t* c = canvas.get();
    use_font(c, kLegendSize);
    double x = kMargin, y = bottom_ + 14 + 0.5 * kRowHeight;
    for (LegendItem& item : legend_items()) {
      const double width = item.width + (item.width > 0 ? 8 : 0) + text_width(c, item.text);
      if (x > kMargin && x + width > options_.width - kMargin) {
        x = kMargin;
        y += kRowHeight;
      }
      legend_.emplace_back(Vec2(x, y), std::move(item));
      x += width + 34;
    }
    y += 0.5 * kRowHeight;
    if (!options_.fill.values.empty()) {
      bar_at_ = Vec2(kMargin, y + 4);
      y += 4 + kBarHeight + 1.6 * kLegendSize;
    }
    use_font(c, kCaptionSize);
    caption_ = wrap(c, caption, options_.width - 2 * kMargin);
    caption_at_ = y + 8 + kCaptionSize;
    height_ = std::ceil(caption_.empty()
                            ? y + kMargin
                            : caption_at_ +
                                  1.4 * kCaptionSize * static_cast<double>(caption_.size() - 1) +
                                  kMargin);
  }

  void draw_legend(cairo_t* c) const {
    use_font(c, kLegendSize);
    for (const auto& [at, item] : legend_) {
      item.draw(c, at[0], at[1]);
      show_text(c, at[0] + item.width + (item.width > 0 ? 8 : 0), at[1] + 0.36 * kLegendSize,
                item.text);
    }
    if (!options_.fill.values.empty()) draw_colour_bar(c);
    use_font(c, kCaptionSize);
    double y = caption_at_;
    for (const std::string& line : caption_) {
      show_text(c, kMargin, y, line);
      y += 1.4 * kCaptionSize;
    }
  }

  /// Colours from 0 to the full value, with numbers below and the quantity beside.
  void draw_colour_bar(cairo_t* c) const {
    const double x = bar_at_[0], y = bar_at_[1];
    cairo_pattern_t* colours = cairo_pattern_create_linear(x, 0, x + kBarWidth, 0);
    constexpr int kStops = 32;
    for (int k = 0; k <= kStops; ++k) {
      const double at = static_cast<double>(k) / kStops;
      const Colour colour = sequential_colour(at);
      cairo_pattern_add_color_stop_rgb(colours, at, colour.red, colour.green, colour.blue);
    }
    cairo_rectangle(c, x, y, kBarWidth, kBarHeight);
    cairo_set_source(c, colours);
    cairo_fill_preserve(c);
    cairo_pattern_destroy(colours);
    stroke_path(c, 0.8, kText);
    const std::vector<double>& values = options_.fill.values;
    const double largest = *std::max_element(values.begin(), values.end());
    for (const double at : {0.0, 0.5, 1.0}) {
      const double tick = x + at * kBarWidth;
      stroke_line(c, Vec2(tick, y + kBarHeight), Vec2(tick, y + kBarHeight + 4), 1, kText);
      std::string label = with_prefix(at * full_fill_, options_.fill.unit);
      const std::string most = with_prefix(largest, options_.fill.unit);
      if (at == 1 && largest > full_fill_ && most != label) {
        label += " and more, at most " + most;
      }
      const double left = at == 0.5 ? tick - 0.5 * text_width(c, label) : tick - 4;
      show_text(c, at == 0 ? tick : left, y + kBarHeight + 4 + kLegendSize, label);
    }
    show_text(c, x + kBarWidth + 12, y + 0.85 * kBarHeight, options_.fill.label);
  }

  static constexpr double kSample = 44;  // length of the legend's segments

  const Stopwatch watch_;
  const Scene<2>& scene_;
  const State<2>& state_;
  const ForcePictureOptions& options_;
  bool friction_;
  Box<2> box_;
  Mapping map_;
  Vec2 corner_ = Vec2::Zero();
  double bottom_ = 0;
  std::vector<Segment> segments_;
  std::array<int, 4> count_ = {};  // by Kind
  double widest_ = kWidest;
  double full_force_ = 1;
  double full_fill_ = 0;
  Vec2 bar_at_ = Vec2::Zero();
  std::vector<std::pair<Vec2, LegendItem>> legend_;
  std::vector<std::string> caption_;
  double caption_at_ = 0;
  double height_ = 0;
};

void require(cairo_status_t status, const std::filesystem::path& path) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw FileError(path, "", std::string("cannot draw: ") + cairo_status_to_string(status));
  }
}

/// Pixels of an image surface of the format RGB24: 32 bits each, the upper eight unused.
RgbImage pixels_of(cairo_surface_t* surface) {
  RgbImage image{.width = cairo_image_surface_get_width(surface),
                 .height = cairo_image_surface_get_height(surface),
                 .bytes = {}};
  image.bytes.resize(3 * static_cast<std::size_t>(image.width) *
                     static_cast<std::size_t>(image.height));
  const unsigned char* row = cairo_image_surface_get_data(surface);
  unsigned char* out = image.bytes.data();
  for (int i = 0; i < image.height; ++i, row += cairo_image_surface_get_stride(surface)) {
    for (int j = 0; j < image.width; ++j, out += 3) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, row + 4 * j, sizeof pixel);
      out[0] = static_cast<unsigned char>(pixel >> 16);
      out[1] = static_cast<unsigned char>(pixel >> 8);
      out[2] = static_cast<unsigned char>(pixel);
    }
  }
  return image;
}

}  // namespace

Box<2> whole_view(const Scene<2>& scene, const State<2>& state) {
  Box<2> box = view_box(state.bodies, state.walls);
  for (const Scene<2>::Joint& joint : scene.joints) {
    const auto [from, to] = joint_points<2>(joint, state.bodies);
    box.include(from);
    box.include(to);
  }
  for (const auto& [a, b] : cell_outline(state.cell, box)) {
    box.include(a);
    box.include(b);
  }
  return box;
}

double round_below(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (double digit : {5.0, 2.0, 1.0}) {
    if (digit * power <= x * (1 + 1e-12)) return digit * power;
  }
  return power;
}

std::string with_prefix(double value, const std::string& unit) {
  static constexpr std::array<std::string_view, 9> kPrefixes = {"p", "n", "µ", "m", "",
                                                                "k", "M", "G", "T"};
  if (!(std::abs(value) > 0)) return fmt::format("0 {}", unit);
  if (unit.size() > 3) return fmt::format("{:.3g} {}", value, unit);
  // From 999.5 on three digits show the next thousand.
  const double thousands = std::floor(std::log10(std::abs(value) / 0.9995) / 3 + 1e-9);
  const double index = std::clamp(thousands, -4.0, 4.0);
  return fmt::format("{:.3g} {}{}", value * std::pow(10.0, -3 * index),
                     kPrefixes[static_cast<std::size_t>(index + 4)], unit);
}

void draw_force_picture(const std::filesystem::path& path, const Scene<2>& scene,
                        const State<2>& state, const std::string& caption,
                        const ForcePictureOptions& options) {
  const std::string format = path.extension().string();
  if (format != ".svg" && format != ".png") {
    throw FileError(path, "", "the name of a picture ends in .svg or .png");
  }
  const State<2> inside = wrapped_state(state);
  const Picture picture(scene, inside, caption, options);
  std::optional<AtomicFile> svg;  // written while it is drawn
  if (format == ".svg") svg.emplace(path);
  const double width = options.width, height = picture.height();
  const double zoom = format == ".png" ? options.resolution : 1.0;
  const Surface surface(svg ? cairo_svg_surface_create(svg->draft().c_str(), width, height)
                            : cairo_image_surface_create(
                                  CAIRO_FORMAT_RGB24, static_cast<int>(std::lround(zoom * width)),
                                  static_cast<int>(std::lround(zoom * height))),
                        cairo_surface_destroy);
  require(cairo_surface_status(surface.get()), path);
  {
    const Canvas canvas(cairo_create(surface.get()), cairo_destroy);
    cairo_scale(canvas.get(), zoom, zoom);
    picture.draw(canvas.get());
    require(cairo_status(canvas.get()), path);
  }
  if (!svg) {
    cairo_surface_flush(surface.get());
    write_text_file(path, encode_png(pixels_of(surface.get())));
    return;
  }
  cairo_surface_finish(surface.get());
  require(cairo_surface_status(surface.get()), path);
  svg->commit();
}

}  // namespace bipot
