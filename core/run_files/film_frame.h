#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// A number in 16 bits: its sign, and its logarithm in steps of 1/327 octave. The relative error is
/// at most 0.11 %. Magnitudes below 2^-50 and NaN become 0; the largest is 2^50.
std::uint16_t log_code(double x);
double log_value(std::uint16_t code);

/// An angle in 16 bits, modulo 2π; the error is at most 4.8e-5 rad.
std::uint16_t angle_code(double angle);
double angle_value(std::uint16_t code);
/// Of the codes of x, y and z; w >= 0.
Eigen::Quaterniond quaternion_value(const std::uint16_t* codes);

/// A unit vector in 32 bits: its place on an octahedron that is folded to a square (Meyer et al.,
/// "On Floating-Point Normal Vectors", Computer Graphics Forum 29 (2010)). Error below 1e-4.
std::array<std::uint16_t, 2> direction_code(const Vec3& n);
Vec3 direction_value(std::uint16_t first, std::uint16_t second);

/// A state for the eye: what a player shows, in few bits. Data of D components stand one body or
/// contact after the other. Positions are places of a grid and lie in the periodic cell.
struct FilmFrame {
  /// Components of a frame's vectors in D dimensions.
  struct Widths {
    explicit Widths(int dim) : x(to_size(dim)), spin(dim == 2 ? 1 : 3), n(to_size(dim - 1)) {}
    std::size_t x, spin, n;  ///< spin: also turn and force_t
  };
  /// j of a contact with wall w is kWall + w.
  static constexpr std::int32_t kWall = 1 << 30;

  std::int32_t step = 0;
  double time = 0;                              ///< [s]
  std::array<double, 3> cell{};                 ///< width, height, offset; 0: none      [m]
  std::vector<double> walls;                    ///< a, b and presence (1, 0) of each    [m]
  std::vector<std::uint16_t> wall_turn;         ///< angle_code; empty where none turns
  std::vector<std::int32_t> number;             ///< of each body in the run, increasing
  std::vector<float> radius, mass;              ///< only where bodies come or go        [m, kg]
  std::vector<std::uint8_t> material;           ///< likewise
  std::vector<std::int32_t> x;                  ///< places of the grid
  std::vector<std::uint16_t> turn;              ///< angle_code; 3D: x, y, z of the quaternion
  std::vector<std::uint16_t> v, spin;           ///< log_code                        [m/s, rad/s]
  std::vector<std::int32_t> i, j;               ///< numbers of bodies, increasing (i, j)
  std::vector<std::uint16_t> n;                 ///< from j to i: angle_code or direction_code
  std::vector<std::uint16_t> gap;               ///< log_code                            [m]
  std::vector<std::uint16_t> force_n, force_t;  ///< log_code; 3D: force_t is a vector   [N]
  std::vector<std::uint8_t> status;             ///< ContactStatus
};

/// The positions of a film: whole numbers of `quantum` from `origin`, up to `kLast` in size.
struct FilmGrid {
  static constexpr std::int32_t kLast = std::numeric_limits<std::int32_t>::max();
  double quantum = 0;                 ///< [m]
  std::array<double, 3> origin = {};  ///< [m]

  bool operator==(const FilmGrid&) const = default;
  /// The nearest place to x; beyond the grid its last one.
  std::int32_t place(double x, std::size_t component) const;
  double position(std::int32_t place, std::size_t component) const {
    return origin[component] + place * quantum;
  }
};

/// The grid of a run, about the middle of its bodies. Its step is 1/1024 of the smallest radius, or
/// what lets the grid hold eight times the size of the scene.
template <int D>
FilmGrid film_grid(const Scene<D>& scene);

/// `step`: size of the time step, by which impulses become forces [s]. `gates`: bodies may come or
/// go. Without the turns of walls, which depend on the scene.
template <int D>
FilmFrame film_frame(const State<D>& state, const FilmGrid& grid, double step, bool gates);

/// The frame as bytes, little end first, and back. Throws std::invalid_argument for other bytes.
std::string to_bytes(const FilmFrame& frame);
FilmFrame frame_of_bytes(std::string_view bytes);

}  // namespace bipot
