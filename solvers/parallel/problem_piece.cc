#include "solvers/parallel/problem_piece.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "core/problem/packed_bodies.h"
#include "core/problem/problem_part.h"

namespace bipot {
namespace {

/// Cuts one piece.
class PieceCutter {
 public:
  PieceCutter(const ContactProblem& whole, const BodyNodes& nodes, const ContactOwners& owners,
              int rank)
      : whole_(whole), nodes_(nodes), owners_(owners), rank_(rank) {}

  ProblemPiece operator()() {
    piece_.whole_contacts = whole_.num_contacts();
    for (int c = 0; c < whole_.num_contacts(); ++c) {
      if (owners_.owner[to_size(c)] == rank_) piece_.number.push_back(c);
    }
    find_dofs();
    find_halo();
    cut_own();
    cut_with_halo();
    find_everywhere();
    piece_.dof_number = dofs_;
    piece_.packed = disk_structure(whole_) || sphere_structure(whole_);
    return std::move(piece_);
  }

 private:
  template <class Visit>
  void for_each_entry(int contact, Visit visit) const {
    for (int k = 0; k < whole_.dim; ++k) {
      for (SparseMatrix::InnerIterator it(whole_.H, contact * whole_.dim + k); it; ++it) {
        visit(k, static_cast<int>(it.row()), it.value());
      }
    }
  }
  bool is_everywhere(int dof) const { return nodes_.node[to_size(dof)] < 0; }

  /// All degrees of freedom of the nodes that owned contacts touch, so that rows of a body stay
  /// together; of those on every process, the touched ones.
  void find_dofs() {
    std::vector<char> node(to_size(nodes_.nodes), 0), touched(nodes_.node.size(), 0);
    for (const int c : piece_.number) {
      for_each_entry(c, [&](int, int dof, double) {
        if (is_everywhere(dof)) {
          touched[to_size(dof)] = 1;
        } else {
          node[to_size(nodes_.node[to_size(dof)])] = 1;
        }
      });
    }
    for (std::size_t dof = 0; dof < touched.size(); ++dof) {
      const int of = nodes_.node[dof];
      if (of >= 0 ? node[to_size(of)] != 0 : touched[dof] != 0) {
        dofs_.push_back(static_cast<int>(dof));
      }
    }
  }
  void find_halo() {
    std::vector<char> local(nodes_.node.size(), 0);
    for (const int dof : dofs_) local[to_size(dof)] = is_everywhere(dof) ? 0 : 1;
    std::vector<int> next(to_size(owners_.processes), 0);
    for (int c = 0; c < whole_.num_contacts(); ++c) {
      const int owner = owners_.owner[to_size(c)];
      const int place_there = next[to_size(owner)]++;
      bool needed = owner == rank_;
      if (!needed) {
        for_each_entry(c, [&](int, int dof, double) { needed |= local[to_size(dof)] != 0; });
      }
      if (!needed) continue;
      const int place = static_cast<int>(with_halo_.size());
      with_halo_.push_back(c);
      if (owner == rank_) {
        piece_.owned.push_back(place);
      } else {
        piece_.halo.push_back(place);
        piece_.copies.push_back({owner, place_there});
      }
    }
  }
  void cut_own() {
    std::vector<int> number(nodes_.node.size(), -1);
    for (std::size_t k = 0; k < dofs_.size(); ++k) number[to_size(dofs_[k])] = static_cast<int>(k);
    piece_.own = cut_problem(whole_, piece_.number, whole_.dim, dofs_, number);
    count_sharers(number);
  }
  /// Owner after owner: the last one seen at a body then tells whether this one is new there.
  void count_sharers(const std::vector<int>& number) {
    std::vector<int> order(to_size(whole_.num_contacts()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return owners_.owner[to_size(a)] < owners_.owner[to_size(b)];
    });
    // The rows of a body count as one: a body shared in x alone is shared in y as well.
    std::vector<int> group(dofs_.size());
    for (std::size_t k = 0; k < dofs_.size(); ++k) {
      const int node = nodes_.node[to_size(dofs_[k])];
      const bool goes_on = k > 0 && node >= 0 && nodes_.node[to_size(dofs_[k - 1])] == node;
      group[k] = goes_on ? group[k - 1] : static_cast<int>(k);
    }
    std::vector<int> last(dofs_.size(), -1), count(dofs_.size(), 0);
    for (const int c : order) {
      const int owner = owners_.owner[to_size(c)];
      for_each_entry(c, [&](int, int dof, double) {
        if (number[to_size(dof)] < 0) return;
        const std::size_t at = to_size(group[to_size(number[to_size(dof)])]);
        if (last[at] != owner) ++count[at];
        last[at] = owner;
      });
    }
    piece_.sharers.resize(dofs_.size());
    for (std::size_t k = 0; k < dofs_.size(); ++k) {
      piece_.sharers[k] = std::max(1, count[to_size(group[k])]);
    }
  }
  void cut_with_halo() {
    std::vector<char> node(to_size(nodes_.nodes), 0);
    for (const int c : with_halo_) {
      for_each_entry(c, [&](int, int dof, double) {
        if (!is_everywhere(dof)) node[to_size(nodes_.node[to_size(dof)])] = 1;
      });
    }
    std::vector<int> dofs, number(nodes_.node.size(), -1);
    for (std::size_t dof = 0; dof < nodes_.node.size(); ++dof) {
      const int of = nodes_.node[dof];
      if (of < 0 || node[to_size(of)] == 0) continue;
      number[dof] = static_cast<int>(dofs.size());
      dofs.push_back(static_cast<int>(dof));
    }
    piece_.with_halo = cut_problem(whole_, with_halo_, whole_.dim, dofs, number);
    for (const int dof : dofs_) piece_.dof_with_halo.push_back(number[to_size(dof)]);
  }
  void find_everywhere() {
    std::vector<int> place(nodes_.node.size(), -1);
    for (const int dof : nodes_.everywhere) {
      place[to_size(dof)] = static_cast<int>(piece_.everywhere_inverse_mass.size());
      piece_.everywhere_inverse_mass.push_back(1 / whole_.A.coeff(dof, dof));
      const auto at = std::lower_bound(dofs_.begin(), dofs_.end(), dof);
      piece_.everywhere_own_dof.push_back(
          at != dofs_.end() && *at == dof ? static_cast<int>(at - dofs_.begin()) : -1);
    }
    for (std::size_t c = 0; c < piece_.number.size(); ++c) {
      for_each_entry(piece_.number[c], [&](int k, int dof, double value) {
        if (place[to_size(dof)] < 0) return;
        const int row = static_cast<int>(c) * whole_.dim + k;
        piece_.everywhere.push_back({row, place[to_size(dof)], value});
      });
    }
  }

  const ContactProblem& whole_;
  const BodyNodes& nodes_;
  const ContactOwners& owners_;
  int rank_;
  ProblemPiece piece_;
  std::vector<int> dofs_;       // of the owned contacts
  std::vector<int> with_halo_;  // contacts of the whole, ascending
};

}  // namespace

std::string refuse_distributed(const ContactProblem& p) {
  if (!p.has_velocities()) {
    return "the problem has W alone; on several processes it must come with A and H";
  }
  if (!is_diagonal(p.A)) {
    return "A is not diagonal; on several processes every degree of freedom must have its own mass";
  }
  return {};
}

ProblemPiece cut_piece(const ContactProblem& whole, const BodyNodes& nodes,
                       const ContactOwners& owners, int rank) {
  return PieceCutter(whole, nodes, owners, rank)();
}

}  // namespace bipot
