#include "core/motion/warm_start.h"

#include "core/motion/contact_axes.h"

namespace bipot {

template <int D>
Vector warm_start(const std::vector<ContactOutcome<D>>& before,
                  std::span<const std::type_identity_t<Contact<D>>> contacts,
                  std::span<const std::type_identity_t<Wall<D>>* const> walls,
                  const ContactProblem& p) {
  Vector s0 = Vector::Zero(p.num_rows());
  auto old = before.begin();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::pair pair = contacts[c].pair();
    while (old != before.end() && old->contact.pair() < pair) ++old;
    if (old == before.end()) break;
    if (old->contact.pair() != pair) continue;
    // Of several contacts of one pair, that with the nearest normal.
    const auto towards = [&](const ContactOutcome<D>& o) { return o.contact.n.dot(contacts[c].n); };
    auto best = old;
    for (auto other = old + 1; other != before.end() && other->contact.pair() == pair; ++other) {
      if (towards(*other) > towards(*best)) best = other;
    }
    const int row = static_cast<int>(c) * p.dim;
    const bool scaled = p.row_scale.size() != 0;
    s0[row] = best->s_n * (scaled ? p.row_scale[row] : 1.0);
    if (p.dim == 1) continue;
    if constexpr (D == 2) {
      s0[row + 1] = best->s_t * (scaled ? p.row_scale[row + 1] : 1.0);
      if (p.rolls()) s0[row + 2] = best->moment * (scaled ? p.row_scale[row + 2] : 1.0);
    } else {
      const auto frame = contact_frame<D>(contacts[c].n);
      const auto axes = dual_axes<D>(contacts[c].n, walls[c]);
      for (int k = 1; k < D; ++k) {
        s0[row + k] = axes[to_size(k)].dot(best->s_t) * (scaled ? p.row_scale[row + k] : 1.0);
      }
      for (int k = D; k < p.dim; ++k) {
        const Vec3& axis = frame[to_size((k - D + 1) % D)];
        s0[row + k] = axis.dot(best->moment) * (scaled ? p.row_scale[row + k] : 1.0);
      }
    }
  }
  return s0;
}

template Vector warm_start<2>(const std::vector<ContactOutcome<2>>&, std::span<const Contact<2>>,
                              std::span<const Wall<2>* const>, const ContactProblem&);
template Vector warm_start<3>(const std::vector<ContactOutcome<3>>&, std::span<const Contact<3>>,
                              std::span<const Wall<3>* const>, const ContactProblem&);

}  // namespace bipot
