#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/motion/time_stepping.h"
#include "core/scene/scene_box.h"

namespace bipot {

struct ForcePictureOptions {
  /// Colours of the disks by one number each, from 0 to `high` (sequential_colour), with a colour
  /// bar.
  struct Fill {
    std::vector<double> values;  ///< one for each disk; empty: all disks alike
    std::string label, unit;     ///< "pressure in the disk", "Pa"
    double high = 0;             ///< end of the colour bar, in `unit`; 0: the largest value
  };
  double width = 1000;         ///< of the picture, SVG points; a PNG has `resolution` pixels each
  double resolution = 2;       ///< pixels of a PNG in a point
  double full_force = 0;       ///< normal force of the widest segment; 0: the largest one   [N]
  bool take_off = true;        ///< also the candidates that carry nothing, as thin dots
  bool forces = true;          ///< false: no segments at all
  std::optional<Box<2>> view;  ///< what is shown; empty: whole_view()
  Fill fill;
  std::vector<int> marked;        ///< indices into State::contacts, each marked by a ring
  std::string marked_label;       ///< text for the marks in the legend
  double time_limit = kInfinity;  ///< of the drawing; std::runtime_error if it is over      [s]
};

/// Bodies, ends of walls, pins and ropes, and the cell.
Box<2> whole_view(const Scene<2>& scene, const State<2>& state);

/// Draws a force-chain picture as in Fig. 10 to 12: disks, walls (half-planes hatched on their
/// solid side) and contacts. A contact is a segment between the centres (for a wall: centre to
/// contact point), with a width proportional to the normal force s_n / h. Sticking contacts are
/// dark blue, sliding ones light orange with a dark rim; they also differ in grey. A scene without
/// friction has one kind. Below: scale bar, force scale, legend and `caption`, wrapped. The
/// extension, .svg or .png, chooses the format; the drawing is the same. Throws FileError.
void draw_force_picture(const std::filesystem::path& path, const Scene<2>& scene,
                        const State<2>& state, const std::string& caption,
                        const ForcePictureOptions& options = {});

/// Round length or force for scales: the largest of 1, 2, 5 times a power of ten up to x > 0.
double round_below(double x);

/// "50 mm": three significant digits and a prefix that keeps the number between 1 and 1000. Words
/// have no prefix: "0.05 radii".
std::string with_prefix(double value, const std::string& unit);

}  // namespace bipot
