#include "solvers/parallel/distributed_kernels.h"

#include <cmath>
#include <random>
#include <vector>

#include "solvers/kernels/spectral_estimate.h"

namespace bipot {

double distributed_spectral_estimate(DistributedSpace& space, const Vector& scale) {
  // The start of one process: the whole sequence is drawn, a few nanoseconds a row.
  const int d = space.problem().dim;
  std::mt19937 engine(1);
  Vector x(scale.size());
  int next = 0;
  for (int c = 0; c < space.piece().whole_contacts; ++c) {
    const bool here =
        next < space.problem().num_contacts() && space.piece().number[to_size(next)] == c;
    for (int k = 0; k < d; ++k) {
      const double drawn = static_cast<double>(engine()) * 0x1.0p-31 - 1;
      if (here) x[next * d + k] = drawn;
    }
    if (here) ++next;
  }
  Vector scaled, y;
  double norm = space.norm(x);
  if (norm > 0) x /= norm;
  for (int k = 0; k < kPowerIterations; ++k) {
    scaled = scale.cwiseProduct(x);
    space.apply(scaled, y);
    y.array() *= scale.array();
    norm = space.norm(y);
    if (!(norm > 0)) break;
    x = y / norm;
  }
  return norm;
}

double distributed_spectral_bound(DistributedSpace& space, const Vector& scale) {
  const ProblemPiece& piece = space.piece();
  const int d = piece.own.dim;
  Vector all;
  space.with_halo(scale, all);
  Vector sums = Vector::Zero(scale.size());
  if (piece.with_halo.has_velocities()) {
    const SparseRows W = assemble_delassus(piece.with_halo.A, piece.with_halo.H, d);
    const Vector absolute = SparseRows(W.cwiseAbs()) * all;
    for (std::size_t k = 0; k < piece.owned.size(); ++k) {
      sums.segment(static_cast<Eigen::Index>(k) * d, d) = absolute.segment(piece.owned[k] * d, d);
    }
  }
  std::vector<double> pushes(piece.everywhere_inverse_mass.size(), 0.0);
  for (const auto& e : piece.everywhere) pushes[to_size(e.dof)] += std::abs(e.value) * scale[e.row];
  if (!pushes.empty()) space.sum(pushes);
  for (const auto& e : piece.everywhere) {
    const std::size_t dof = to_size(e.dof);
    sums[e.row] += std::abs(e.value) * piece.everywhere_inverse_mass[dof] * pushes[dof];
  }
  double bound = sums.size() > 0 ? sums.cwiseProduct(scale).maxCoeff() : 0.0;
  space.group().largest({&bound, 1});
  return bound;
}

Vector DistributedProducts::products(const Eigen::MatrixXd& columns, int size,
                                     const Vector& f) const {
  Vector dots = Vector::Zero(size);
  if (space.exact()) {
    std::vector<ExactSum> sums(to_size(size));
    for (int k = 0; k < size; ++k) {
      DistributedSpace::add_products(columns.col(k), f, sums[to_size(k)]);
    }
    space.totals(sums, {dots.data(), to_size(size)});
  } else {
    dots = columns.leftCols(size).transpose() * f;
    space.sum({dots.data(), to_size(size)});
  }
  return dots;
}

}  // namespace bipot
