#pragma once

namespace bipot {

/// Memory traffic and arithmetic of one iteration for each contact of a packing of disks (D = 2) or
/// spheres (D = 3).
/// Bytes: those that a single iteration streams from memory, everything read and written once.
/// Iterations in flight share them (data/manual/results/performance.md, "Bytes and flops of one
/// iteration").
struct KernelWork {
  double bytes = 0;  ///< [B]
  double flops = 0;  ///< additions, multiplications, divisions and roots, one each
  constexpr double intensity() const { return flops / bytes; }  ///< [1/B]
};

/// `bodies`: bodies for each contact, 1/2 on a square lattice, 1/3 on a triangular one. Tiled pgs:
/// two bodies' places 8, g 16, spin 8, b 16, law 0.5; x in and out 32; a body's velocities and
/// masses 96.
/// Spheres: n 24, scale 8, b 24, x in and out 48; a body's row in and out 128.
template <int D>
constexpr KernelWork tiled_sweep_work(double bodies) {
  if constexpr (D == 3) return {64.5 + 48 + 128 * bodies, 124};
  return {48.5 + 32 + 96 * bodies, 39};
}
/// pgs in the given order: a record of 96 bytes, 32 of them written back; a body's 40, 24 of them
/// written.
constexpr KernelWork given_order_sweep_work(double bodies) { return {96 + 32 + 64 * bodies, 46}; }
/// apgd: as tiled pgs, with x and x⁻ in and x⁺ out; of a body two momenta in and one out, a
/// velocity in and out 160, of a sphere 320.
template <int D>
constexpr KernelWork gradient_work(double bodies) {
  if constexpr (D == 3) return {64.5 + 72 + 320 * bodies, 130 + 42 * bodies};
  return {48.5 + 48 + 160 * bodies, 49 + 24 * bodies};
}
/// pgs on an explicit W with `entries` for each contact, in blocks of four values and a number: 9
/// each; and its own problem.
constexpr KernelWork explicit_sweep_work(double entries) {
  return {9 * entries + 8 + 32 + 16 + 80, 2 * entries + 12};
}
/// STREAM's triad a <- b + 3 c, for each item.
constexpr KernelWork triad_work() { return {24, 2}; }

/// The roofline: upper bound of a kernel of that intensity [flop/s], from the bandwidth [B/s] and
/// the peak [flop/s].
constexpr double roofline(const KernelWork& work, double bandwidth, double peak) {
  const double by_memory = work.intensity() * bandwidth;
  return by_memory < peak ? by_memory : peak;
}

}  // namespace bipot
