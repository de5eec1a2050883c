#include "solvers/parallel/whole_problem.h"

#include <algorithm>
#include <utility>

#include "core/base/triplets.h"

namespace bipot {
namespace {

/// Message on the contacts of a process: their problem, and their numbers in the whole.
Buffer to_buffer(const ProblemPiece& piece) {
  const ContactProblem& p = piece.own;
  const int d = p.dim;
  const bool scaled = p.row_scale.size() != 0;
  Buffer buffer;
  append(buffer, d, p.num_dofs(), p.num_contacts(), scaled, p.rolls());
  const Vector mass = p.A.diagonal();
  for (int k = 0; k < p.num_dofs(); ++k) {
    append(buffer, piece.dof_number[to_size(k)], mass[k], p.v_free[k]);
  }
  for (int c = 0; c < p.num_contacts(); ++c) {
    append(buffer, piece.number[to_size(c)], p.mu[c], p.mu_r.size() > 0 ? p.mu_r[c] : 0.0,
           p.mu_spin.size() > 0 ? p.mu_spin[c] : 0.0);
    for (int row = c * d; row < (c + 1) * d; ++row) {
      const int entries = p.H.outerIndexPtr()[row + 1] - p.H.outerIndexPtr()[row];
      append(buffer, p.u_free[row], scaled ? p.row_scale[row] : 1.0, entries);
      for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
        append(buffer, it.row(), it.value());
      }
    }
  }
  return buffer;
}

/// Reads the messages of all processes on the root process.
class WholeReader {
 public:
  explicit WholeReader(const std::vector<Buffer>& buffers)
      : readers_(buffers.begin(), buffers.end()) {}

  /// `number`: of each process's contacts.
  ContactProblem read(std::vector<std::vector<int>>& number) {
    ContactProblem p;
    read_dofs(p);
    number.assign(readers_.size(), {});
    for (Vector* const of : {&p.mu, &p.mu_r, &p.mu_spin}) of->resize(contacts_);
    for (Vector* const of : {&p.u_free, &p.row_scale}) of->resize(contacts_ * p.dim);
    Triplets entries;
    for (std::size_t r = 0; r < readers_.size(); ++r) {
      BufferReader& reader = readers_[r];
      while (!reader.at_end()) {
        const int c = reader.integer();
        number[r].push_back(c);
        for (Vector* const of : {&p.mu, &p.mu_r, &p.mu_spin}) (*of)[c] = reader.number();
        for (int row = c * p.dim; row < (c + 1) * p.dim; ++row) {
          for (Vector* const of : {&p.u_free, &p.row_scale}) (*of)[row] = reader.number();
          for (int left = reader.integer(); left > 0; --left) {
            const int dof = place_[r][to_size(reader.integer())];
            entries.emplace_back(dof, row, reader.number());
          }
        }
      }
    }
    if (!rolls_) p.mu_r.resize(0);
    if (!rolls_ || p.dim < 6) p.mu_spin.resize(0);
    if (!scaled_) p.row_scale.resize(0);
    p.H = from_triplets(p.v_free.size(), contacts_ * p.dim, entries);
    return p;
  }

 private:
  /// Reads up to the contacts. A body in contacts of several processes has its rows once.
  void read_dofs(ContactProblem& p) {
    struct Dof {
      int key;
      double mass, v_free;
    };
    std::vector<std::vector<Dof>> dofs(readers_.size());
    std::vector<int> keys;
    for (std::size_t r = 0; r < readers_.size(); ++r) {
      BufferReader& reader = readers_[r];
      const int dim = reader.integer(), count = reader.integer(), contacts = reader.integer();
      const bool scaled = reader.number() > 0, rolls = reader.number() > 0;
      contacts_ += contacts;
      // A process without contacts may not know the others' rows.
      if (contacts > 0) {
        p.dim = dim;
        scaled_ = scaled;
        rolls_ = rolls;
      }
      for (int k = 0; k < count; ++k) {
        keys.push_back(reader.integer());
        const double mass = reader.number();
        dofs[r].push_back({keys.back(), mass, reader.number()});
      }
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    p.v_free.resize(static_cast<Eigen::Index>(keys.size()));
    Vector mass(p.v_free.size());
    place_.resize(readers_.size());
    for (std::size_t r = 0; r < readers_.size(); ++r) {
      for (const Dof& dof : dofs[r]) {
        const auto at = std::lower_bound(keys.begin(), keys.end(), dof.key) - keys.begin();
        place_[r].push_back(static_cast<int>(at));
        mass[at] = dof.mass;
        p.v_free[at] = dof.v_free;
      }
    }
    p.A = SparseMatrix(mass.asDiagonal());
  }

  std::vector<BufferReader> readers_;
  int contacts_ = 0;
  bool scaled_ = false, rolls_ = false;
  std::vector<std::vector<int>> place_;  // of each process's degrees of freedom
};

/// Sends everything to the root process.
std::vector<Buffer> to_first(ProcessGroup& group, Buffer buffer) {
  std::vector<Buffer> buffers(to_size(group.size()));
  buffers[0] = std::move(buffer);
  return group.deliver(std::move(buffers));
}

ContactProblem gather_with_numbers(const ProblemPiece& piece, ProcessGroup& group,
                                   std::vector<std::vector<int>>& number) {
  const std::vector<Buffer> buffers = to_first(group, to_buffer(piece));
  return group.rank() == 0 ? WholeReader(buffers).read(number) : ContactProblem{};
}

}  // namespace

Vector KnownWhole::join(const Vector& part) {
  const int d = whole_.dim;
  const std::vector<double> all = group_.gather({part.data(), to_size(part.size())});
  std::vector<std::size_t> next(to_size(owners_.processes), 0);
  for (int r = 1; r < owners_.processes; ++r) {
    next[to_size(r)] =
        next[to_size(r) - 1] + to_size(owners_.contacts[to_size(r) - 1]) * to_size(d);
  }
  Vector whole(whole_.num_rows());
  for (int c = 0; c < whole_.num_contacts(); ++c) {
    std::size_t& from = next[to_size(owners_.owner[to_size(c)])];
    for (int k = 0; k < d; ++k) whole[c * d + k] = all[from++];
  }
  return whole;
}

Vector KnownWhole::mine(const Vector& whole) const {
  const int d = whole_.dim, rank = group_.rank();
  Vector part(static_cast<Eigen::Index>(owners_.contacts[to_size(rank)]) * d);
  Eigen::Index next = 0;
  for (int c = 0; c < whole_.num_contacts(); ++c) {
    if (owners_.owner[to_size(c)] != rank) continue;
    part.segment(next, d) = whole.segment(c * d, d);
    next += d;
  }
  return part;
}

Vector KnownWhole::part(const Vector& whole) {
  const bool first = group_.rank() == 0;
  const std::vector<double> all =
      group_.gather(first ? std::span<const double>(whole.data(), to_size(whole.size()))
                          : std::span<const double>());
  return mine(Eigen::Map<const Vector>(all.data(), static_cast<Eigen::Index>(all.size())));
}

const ContactProblem& GatheredWhole::on_first() {
  if (!whole_) whole_ = gather_with_numbers(space_.piece(), space_.group(), number_);
  return *whole_;
}

Vector GatheredWhole::join(const Vector& part) {
  on_first();
  const int d = space_.problem().dim;
  const std::vector<Buffer> buffers =
      to_first(space_.group(), Buffer(part.data(), part.data() + part.size()));
  Vector whole(whole_->num_rows());
  for (std::size_t r = 0; r < number_.size(); ++r) {
    for (std::size_t c = 0; c < number_[r].size(); ++c) {
      for (int k = 0; k < d; ++k) {
        whole[number_[r][c] * d + k] = buffers[r].at(c * to_size(d) + to_size(k));
      }
    }
  }
  return whole;
}

Vector GatheredWhole::part(const Vector& whole) {
  on_first();
  const int d = space_.problem().dim;
  std::vector<Buffer> buffers(to_size(space_.group().size()));
  for (std::size_t r = 0; r < number_.size(); ++r) {
    for (const int c : number_[r]) {
      for (int k = 0; k < d; ++k) buffers[r].push_back(whole[c * d + k]);
    }
  }
  const Buffer mine = space_.group().deliver(std::move(buffers)).front();
  return Eigen::Map<const Vector>(mine.data(), static_cast<Eigen::Index>(mine.size()));
}

ProvedClaim GatheredWhole::claim(const SolverOptions& options, const Vector& s,
                                 const ContactError& error) {
  ProvedClaim claim;
  if (options.stop != StopTest::kGuarded) return claim;
  if (error.guarded() + distributed_rounding_bound(space_, s).guarded() <= options.tol) {
    return claim;
  }
  const ContactProblem& whole = on_first();
  const Vector all = join(s);
  double words[2] = {0, 0};
  const bool first = space_.group().rank() == 0;
  if (first) {
    claim = prove_claim(whole, options, all, error);
    words[0] = claim.holds ? 1 : 0;
    words[1] = claim.error;
  }
  const std::vector<double> said =
      space_.group().gather(first ? std::span<const double>(words) : std::span<const double>());
  claim.holds = said[0] > 0;
  claim.error = said[1];
  return claim;
}

ContactProblem gather_problem(const ProblemPiece& piece, ProcessGroup& group) {
  std::vector<std::vector<int>> number;
  return gather_with_numbers(piece, group, number);
}

RoundingBound distributed_rounding_bound(DistributedSpace& space, const Vector& s) {
  const ProblemPiece& piece = space.piece();
  const ContactProblem& own = piece.own;
  Vector all;
  space.with_halo(s, all);
  const RoundedMomentum halo = rounded_momentum(piece.with_halo, all);
  RoundedMomentum pushed{Vector::Zero(own.num_dofs()), Vector::Zero(own.num_dofs()),
                         Vector::Zero(own.num_dofs())};
  for (int dof = 0; dof < own.num_dofs(); ++dof) {
    const int at = piece.dof_with_halo[to_size(dof)];
    if (at < 0) continue;
    pushed.momentum[dof] = halo.momentum[at];
    pushed.size[dof] = halo.size[at];
    pushed.count[dof] = halo.count[at];
  }
  // Degrees of freedom that every process has: momentum, size and count of all.
  const std::size_t common = piece.everywhere_inverse_mass.size();
  std::vector<double> of_common(3 * common, 0.0);
  for (const ProblemPiece::EverywhereEntry& e : piece.everywhere) {
    if (s[e.row] == 0) continue;
    const std::size_t k = 3 * to_size(e.dof);
    of_common[k] += e.value * s[e.row];
    of_common[k + 1] += std::abs(e.value * s[e.row]);
    of_common[k + 2] += 1;
  }
  if (common > 0) space.sum(of_common);
  for (std::size_t k = 0; k < common; ++k) {
    const int dof = piece.everywhere_own_dof[k];
    if (dof < 0) continue;
    pushed.momentum[dof] = of_common[3 * k];
    pushed.size[dof] = of_common[3 * k + 1];
    pushed.count[dof] = of_common[3 * k + 2];
  }
  RoundedSums sums;
  if (own.num_contacts() > 0) sums = rounded_sums(own, s, pushed);
  Rounded* const all_sums[] = {&sums.friction, &sums.gap,   &sums.penetration,
                               &sums.natural,  &sums.moved, &sums.free_energy};
  Buffer totals;
  for (const Rounded* sum : all_sums) append(totals, sum->value, sum->error);
  space.sum(totals);
  BufferReader reader(totals);
  for (Rounded* sum : all_sums) reader.take(sum->value, sum->error);
  return rounding_bound(sums, piece.whole_contacts, Precision::kDouble);
}

}  // namespace bipot
