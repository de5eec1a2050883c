#include "core/motion/warm_start.h"

namespace bipot {

Vector warm_start(const std::vector<ContactOutcome>& before, std::span<const Contact> contacts,
                  const ContactProblem& p) {
  Vector s0 = Vector::Zero(p.num_rows());
  auto old = before.begin();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto less = [&](const ContactOutcome& o) {
      return o.contact.i < contacts[c].i ||
             (o.contact.i == contacts[c].i && o.contact.j < contacts[c].j);
    };
    while (old != before.end() && less(*old)) ++old;
    if (old == before.end()) break;
    if (old->contact.i != contacts[c].i || old->contact.j != contacts[c].j) continue;
    const int row = static_cast<int>(c) * p.dim;
    const bool scaled = p.row_scale.size() != 0;
    s0[row] = old->s_n * (scaled ? p.row_scale[row] : 1.0);
    if (p.dim == 2) s0[row + 1] = old->s_t * (scaled ? p.row_scale[row + 1] : 1.0);
  }
  return s0;
}

}  // namespace bipot
