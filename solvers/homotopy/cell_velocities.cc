#include "solvers/homotopy/cell_velocities.h"

namespace bipot {

CellVelocities::Compliance CellVelocities::compliance(int contact) const {
  const int n = contact * problem_.dim;
  const Column first = (*columns_)[to_size(n)];
  Compliance c{{{0, 0}, {0, 0}}};
  if (!is_impulse(first)) return c;
  c.at[0][0] = 1 / (*proximal_)[n];
  if (problem_.dim == 1) return c;
  if (is_impulse((*columns_)[to_size(n + 1)])) {
    c.at[1][1] = 1 / (*proximal_)[n + 1];
  } else {
    c.at[1][0] = problem_.tangent(contact, first) * c.at[0][0];
  }
  return c;
}

/// Calls add(row, value) for the terms of contacts in column j of K, or in row j.
template <class Add>
void CellVelocities::for_line(int j, bool transposed, const Add& add) const {
  const BodyDelassus& bodies = *problem_.bodies;
  const int d = problem_.dim;
  for (const int contact : bodies.contacts_of(j)) {
    const Compliance c = compliance(contact);
    double own[2] = {0, 0};  // row j of G
    for (int a = 0; a < d; ++a) own[a] = bodies.entry_of_G(j, contact * d + a);
    for (int a = 0; a < d; ++a) {
      double weight = 0;
      for (int b = 0; b < d; ++b) weight += (transposed ? c.at[b][a] : c.at[a][b]) * own[b];
      if (weight == 0) continue;
      bodies.for_column_of_G(contact * d + a,
                             [&](int row, double value) { add(row, value * weight); });
    }
  }
}

void CellVelocities::add_line(int j, bool transposed, FrontLine& to) const {
  to.add(j, problem_.bodies->mass(j));
  for_line(j, transposed, [&](int row, double value) { to.add(row, value); });
}

double CellVelocities::diagonal(int j) const {
  double sum = problem_.bodies->mass(j);
  for_line(j, false, [&](int row, double value) { sum += row == j ? value : 0; });
  return sum;
}

bool CellVelocities::factor(const std::vector<Column>& columns, const Vector& proximal) {
  columns_ = &columns;
  proximal_ = &proximal;
  if (!analysed_) analysed_ = fronts_.analyse(problem_.bodies->body_pattern());
  return analysed_ && fronts_.factor(*this);
}

void CellVelocities::solve(const Vector& g, Vector& x) {
  const BodyDelassus& bodies = *problem_.bodies;
  const int d = problem_.dim, contacts = problem_.num_contacts();
  momentum_.setZero(bodies.num_dofs());
  for (int contact = 0; contact < contacts; ++contact) {
    const Compliance c = compliance(contact);
    for (int a = 0; a < d; ++a) {
      double push = 0;
      for (int b = 0; b < d; ++b) push -= c.at[a][b] * g[contact * d + b];
      if (push == 0) continue;
      bodies.for_column_of_G(contact * d + a,
                             [&](int row, double value) { momentum_[row] += value * push; });
    }
  }
  fronts_.solve(momentum_, velocity_);
  x.resize(problem_.num_rows());
  for (int contact = 0; contact < contacts; ++contact) {
    const int n = contact * d;
    const Compliance c = compliance(contact);
    double gap[2] = {0, 0}, s[2] = {0, 0};  // g + Gᵀ v
    for (int a = 0; a < d; ++a) {
      gap[a] = g[n + a];
      bodies.for_column_of_G(n + a,
                             [&](int row, double value) { gap[a] += value * velocity_[row]; });
    }
    for (int a = 0; a < d; ++a) {
      for (int b = 0; b < d; ++b) s[a] -= c.at[a][b] * gap[b];
    }
    // From impulses and velocities to the parameters of the columns.
    const bool bears = is_impulse((*columns_)[to_size(n)]);
    x[n] = bears ? s[0] : gap[0];
    if (d == 1) continue;
    if (bears && is_impulse((*columns_)[to_size(n + 1)])) {
      const double ratio = s[1] / problem_.tangent(contact, (*columns_)[to_size(n + 1)]);
      x[n] = 0.5 * (s[0] - ratio);
      x[n + 1] = 0.5 * (s[0] + ratio);
    } else {
      x[n + 1] = gap[1] + (*proximal_)[n + 1] * s[1];
    }
  }
}

}  // namespace bipot
