#include "bench/problems/several_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "core/pictures/force_picture.h"

namespace bipot {
namespace {

/// Contacts with the impulses of an answer, in physical variables.
std::vector<ContactOutcome<2>> outcomes(const ContactProblem& p, const ProblemGeometry& geometry,
                                        const Vector& s) {
  std::vector<ContactOutcome<2>> all = geometry.state.contacts;
  for (std::size_t c = 0; c < all.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    const auto physical = [&](Eigen::Index r) {
      return s[r] / (p.row_scale.size() != 0 ? p.row_scale[r] : 1.0);
    };
    all[c].s_n = physical(row);
    all[c].s_t = p.dim > 1 ? physical(row + 1) : 0.0;
  }
  return all;
}

/// Resultant contact impulse on each disk, t = e3 x n.
std::vector<Vec2> resultants(const std::vector<ContactOutcome<2>>& contacts, std::size_t disks) {
  std::vector<Vec2> sums(disks, Vec2::Zero());
  for (const ContactOutcome<2>& o : contacts) {
    const Vec2 t(-o.contact.n[1], o.contact.n[0]);
    const Vec2 impulse = o.s_n * o.contact.n + o.s_t * t;
    sums[to_size(o.contact.i)] += impulse;
    if (to_size(o.contact.j) < disks) sums[to_size(o.contact.j)] -= impulse;
  }
  return sums;
}

}  // namespace

void draw_several_picture(const std::filesystem::path& path, const ContactProblem& p,
                          const ProblemGeometry& geometry, const SeveralAnswers& found,
                          const std::string& title) {
  if (found.answers.empty()) throw std::invalid_argument("no answers to draw");
  State<2> state = geometry.state;
  const std::size_t disks = state.bodies.size();
  std::vector<std::vector<Vec2>> sums;
  for (const Answer& answer : found.answers) {
    sums.push_back(resultants(outcomes(p, geometry, answer.impulse.s), disks));
  }
  state.contacts = outcomes(p, geometry, found.answers.front().impulse.s);
  for (std::size_t c = 0; c < state.contacts.size(); ++c) {
    state.contacts[c].status = found.answers.front().status[c];
  }
  // The bodies of the problem: the disks with a candidate contact.
  std::vector<char> touched(disks, 0);
  for (const ContactOutcome<2>& o : state.contacts) {
    touched[to_size(o.contact.i)] = 1;
    if (to_size(o.contact.j) < disks) touched[to_size(o.contact.j)] = 1;
  }
  double mean = 0;
  for (const Vec2& sum : sums.front()) mean += sum.norm();
  mean /= std::max<double>(1, static_cast<double>(std::count(touched.begin(), touched.end(), 1)));
  ForcePictureOptions options{.take_off = false};
  const bool several = sums.size() > 1;
  if (several) options.fill.values.assign(disks, 0);
  for (std::size_t a = 0; a < sums.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      for (std::size_t d = 0; d < disks && mean > 0; ++d) {
        options.fill.values[d] =
            std::max(options.fill.values[d], 100 * (sums[a][d] - sums[b][d]).norm() / mean);
      }
    }
  }
  options.fill.unit = "%";
  options.fill.label = "difference of the force on the disk, over the mean force";
  options.marked = found.differing_contacts;
  options.marked_label = "status differs";
  draw_force_picture(
      path, geometry.scene, state,
      several
          ? fmt::format("{}: {} exact answers, velocities up to {:.1e} apart in the energy norm. "
                        "Segments: normal forces of answer 1",
                        title, found.answers.size(), found.spread.velocity)
          : title + ": one exact answer was found. Segments: its normal forces",
      options);
}

}  // namespace bipot
