#include "core/run_files/film_frame.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <tuple>

namespace bipot {
namespace {

constexpr double kOctave = 327;  // codes of log_code in an octave
constexpr double kLowest = -50;  // power of two of the smallest magnitude
constexpr int kMagnitudes = 0x7fff;

/// A number in [-1, 1] in 16 bits.
std::uint16_t unit_code(double x) {
  return static_cast<std::uint16_t>(std::lround((std::clamp(x, -1.0, 1.0) + 1) * 32767));
}
double unit_value(std::uint16_t code) { return code / 32767.0 - 1; }

/// The lower half of the octahedron goes to the corners of the square, and back.
void fold(double& x, double& y) {
  const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
  y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
  x = folded;
}

/// Appends the bytes of numbers, their count first.
template <class T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
void put(std::string& bytes, const std::vector<T>& values) {
  put(bytes, static_cast<std::uint32_t>(values.size()));
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  void take(T& value) {
    take(&value, sizeof value);
  }
  template <class T>
  void take(std::vector<T>& values) {
    std::uint32_t count = 0;
    take(count);
    if (count > rest_.size() / sizeof(T)) throw std::invalid_argument("a film frame is cut off");
    values.resize(count);
    take(values.data(), count * sizeof(T));
  }
  bool at_end() const { return rest_.empty(); }

 private:
  void take(void* to, std::size_t size) {
    if (size > rest_.size()) throw std::invalid_argument("a film frame is cut off");
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  std::string_view rest_;
};

/// What a frame consists of, in the order of its bytes.
template <class Frame>
auto fields(Frame& f) {
  return std::tie(f.step, f.time, f.cell, f.walls, f.wall_turn, f.number, f.radius, f.mass,
                  f.material, f.x, f.turn, f.v, f.spin, f.i, f.j, f.n, f.gap, f.force_n, f.force_t,
                  f.status);
}

template <int N>
void add_logs(std::vector<std::uint16_t>& codes, const Eigen::Matrix<double, N, 1>& x) {
  for (const double value : x) codes.push_back(log_code(value));
}
void add_logs(std::vector<std::uint16_t>& codes, double x) { codes.push_back(log_code(x)); }

void add_turn(std::vector<std::uint16_t>& codes, const Disk& disk) {
  codes.push_back(angle_code(disk.angle));
}
void add_turn(std::vector<std::uint16_t>& codes, const Sphere& sphere) {
  const auto& q = sphere.orientation;
  const double sign = q.w() < 0 ? -1 : 1;  // q and -q are one rotation; w follows from the others
  for (const double x : {q.x(), q.y(), q.z()}) codes.push_back(unit_code(sign * x));
}

void add_direction(std::vector<std::uint16_t>& codes, const Vec2& n) {
  codes.push_back(angle_code(std::atan2(n[1], n[0])));
}
void add_direction(std::vector<std::uint16_t>& codes, const Vec3& n) {
  for (const std::uint16_t code : direction_code(n)) codes.push_back(code);
}

}  // namespace

std::uint16_t log_code(double x) {
  const double size = std::abs(x);
  if (!(size >= std::exp2(kLowest))) return 0;
  const double level = std::min((std::log2(size) - kLowest) * kOctave + 1, double{kMagnitudes});
  const auto code = static_cast<std::uint16_t>(std::lround(level));
  return x < 0 ? static_cast<std::uint16_t>(code | 0x8000) : code;
}

double log_value(std::uint16_t code) {
  const int level = code & kMagnitudes;
  if (level == 0) return 0;
  const double size = std::exp2((level - 1) / kOctave + kLowest);
  return (code & 0x8000) != 0 ? -size : size;
}

std::uint16_t angle_code(double angle) {
  const double turns = angle / (2 * std::numbers::pi);
  if (!std::isfinite(turns)) return 0;
  return static_cast<std::uint16_t>(std::lround((turns - std::floor(turns)) * 65536) & 0xffff);
}

double angle_value(std::uint16_t code) { return 2 * std::numbers::pi * code / 65536; }

Eigen::Quaterniond quaternion_value(const std::uint16_t* codes) {
  const Vec3 v(unit_value(codes[0]), unit_value(codes[1]), unit_value(codes[2]));
  const double w = std::sqrt(std::max(0.0, 1 - v.squaredNorm()));
  return Eigen::Quaterniond(w, v[0], v[1], v[2]).normalized();
}

std::array<std::uint16_t, 2> direction_code(const Vec3& n) {
  const double size = n.lpNorm<1>();
  if (!(size > 0)) return {unit_code(0), unit_code(0)};
  double x = n[0] / size, y = n[1] / size;
  if (n[2] < 0) fold(x, y);
  return {unit_code(x), unit_code(y)};
}

Vec3 direction_value(std::uint16_t first, std::uint16_t second) {
  double x = unit_value(first), y = unit_value(second);
  const double z = 1 - std::abs(x) - std::abs(y);
  if (z < 0) fold(x, y);
  return Vec3(x, y, z).normalized();
}

std::int32_t FilmGrid::place(double x, std::size_t component) const {
  constexpr double last = kLast;
  return static_cast<std::int32_t>(
      std::lround(std::clamp((x - origin[component]) / quantum, -last, last)));
}

template <int D>
FilmGrid film_grid(const Scene<D>& scene) {
  FilmGrid grid;
  const double radius = smallest_radius(scene);
  if (!std::isfinite(radius)) return {.quantum = 1e-6};
  Eigen::AlignedBox<double, D> box;
  for (const Body<D>& body : scene.bodies) box.extend(body.x);
  for (const Inlet<D>& inlet : scene.inlets) box.extend(inlet.lower).extend(inlet.upper);
  grid.quantum = std::max(radius / 1024, 8 * box.sizes().maxCoeff() / FilmGrid::kLast);
  if (scene.cell.periodic()) return grid;  // from the corner of the cell
  const Vec<D> middle = box.center();
  std::copy(middle.begin(), middle.end(), grid.origin.begin());
  return grid;
}

template <int D>
FilmFrame film_frame(const State<D>& state, const FilmGrid& grid, double step, bool gates) {
  FilmFrame frame{.step = state.step, .time = state.time};
  if (state.cell.in_x) frame.cell[0] = state.cell.width.length;
  if (state.cell.in_y) frame.cell[1] = state.cell.height.length;
  if (state.cell.in_y) frame.cell[2] = state.cell.offset.length;
  for (const Wall<D>& wall : state.walls) {
    frame.walls.insert(frame.walls.end(), wall.a.begin(), wall.a.end());
    frame.walls.insert(frame.walls.end(), wall.b.begin(), wall.b.end());
    frame.walls.push_back(wall.present ? 1 : 0);
  }
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    const Body<D>& body = state.bodies[k];
    frame.number.push_back(gates ? state.population.numbers.at(k) : static_cast<int>(k));
    if (gates) {
      frame.radius.push_back(static_cast<float>(body.radius));
      frame.mass.push_back(static_cast<float>(body.mass));
      frame.material.push_back(static_cast<std::uint8_t>(std::min(body.material, 255)));
    }
    Vec<D> x = body.x;
    if (state.cell.periodic()) {
      x.template head<2>() = wrapped(state.cell, body.x.template head<2>());
    }
    for (int c = 0; c < D; ++c) frame.x.push_back(grid.place(x[c], to_size(c)));
    add_turn(frame.turn, body);
    add_logs(frame.v, body.v);
    add_logs(frame.spin, body.spin);
  }
  const auto bodies = static_cast<int>(state.bodies.size());
  for (const ContactOutcome<D>& c : state.contacts) {
    frame.i.push_back(frame.number.at(to_size(c.contact.i)));
    frame.j.push_back(c.contact.j < bodies ? frame.number[to_size(c.contact.j)]
                                           : FilmFrame::kWall + c.contact.j - bodies);
    add_direction(frame.n, c.contact.n);
    frame.gap.push_back(log_code(c.contact.gap));
    frame.force_n.push_back(log_code(c.s_n / step));
    add_logs(frame.force_t, Tangent<D>(c.s_t / step));
    frame.status.push_back(static_cast<std::uint8_t>(c.status));
  }
  return frame;
}

std::string to_bytes(const FilmFrame& frame) {
  std::string bytes;
  std::apply([&](const auto&... field) { (put(bytes, field), ...); }, fields(frame));
  return bytes;
}

FilmFrame frame_of_bytes(std::string_view bytes) {
  FilmFrame frame;
  ByteReader reader(bytes);
  std::apply([&](auto&... field) { (reader.take(field), ...); }, fields(frame));
  if (!reader.at_end()) throw std::invalid_argument("a film frame is too long");
  return frame;
}

template FilmGrid film_grid(const Scene<2>&);
template FilmGrid film_grid(const Scene<3>&);
template FilmFrame film_frame(const State<2>&, const FilmGrid&, double, bool);
template FilmFrame film_frame(const State<3>&, const FilmGrid&, double, bool);

}  // namespace bipot
