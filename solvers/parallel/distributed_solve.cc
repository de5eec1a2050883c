#include "solvers/parallel/distributed_solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/base/stopwatch.h"
#include "solvers/parallel/cell_tree.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/whole_problem.h"
#include "solvers/registry.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

const std::string kIslands(kIslandsParameter.name);

/// The same options without `islands = off`, which is how several processes solve anyway; empty
/// if they are without it.
std::optional<SolverOptions> without_islands(const SolverOptions& options) {
  const auto named = options.parameters.find(kIslands);
  if (named == options.parameters.end() || named->second != "off") return std::nullopt;
  SolverOptions others = options;
  others.parameters.erase(kIslands);
  return others;
}

/// A sentence if the solve is refused, else empty. `p`: the whole, or the part of this process.
std::string refuse_input(std::string_view name, const ContactProblem& p, const SolverOptions& o,
                         const DistributedOptions& extra) {
  const SolverEntry* const entry = find_solver(name);
  if (entry == nullptr) return unknown_solver_message(name);
  if (o.islands.value_or(false) || o.parameters.contains(kIslands)) {
    return "islands are solved one by one on one process only";
  }
  if (auto defect = refusal(*entry, p, o); !defect.empty()) return defect;
  if (p.num_contacts() > 0) {
    if (auto defect = refuse_distributed(p); !defect.empty()) return defect;
  }
  if (!extra.contact_places.empty() &&
      static_cast<int>(extra.contact_places.size()) != p.num_contacts()) {
    return fmt::format("{} places for {} contacts", extra.contact_places.size(), p.num_contacts());
  }
  if (extra.reproducible && runs_on_parts(*entry, o) != Parallel::kReproducible) {
    return fmt::format(
        "the iterates of {} depend on the processes; --reproducible takes apgd, uzawa and classical "
        "with refresh = jacobi, and anderson with map = gradient",
        name);
  }
  return {};
}

/// Throws on all processes if these numbers differ among them.
void require_same(std::span<const double> figures, ProcessGroup& group) {
  std::vector<double> both;
  for (const double x : figures) {
    both.push_back(x);
    both.push_back(-x);
  }
  group.largest(both);
  bool same = true;
  for (std::size_t k = 0; k < figures.size(); ++k) {
    same &= both[2 * k] == figures[k] && both[2 * k + 1] == -figures[k];
  }
  group.fail_where_any(same ? "" : "the processes were given different problems");
}

/// Throws on all processes if they were given different problems.
void require_one_problem(const ContactProblem& p, const SolverOptions& o, ProcessGroup& group) {
  const double s0 = o.s0.size() > 0 ? o.s0.sum() : 0;
  const double figures[] = {static_cast<double>(p.num_rows()),
                            static_cast<double>(p.num_dofs()),
                            p.u_free.sum(),
                            p.v_free.sum(),
                            p.mu.sum(),
                            s0,
                            o.tol};
  require_same(figures, group);
}

DistributedResult::Counts counts_since(const ProcessGroup::Traffic& before,
                                       const ProblemPiece& piece, ProcessGroup& group) {
  DistributedResult::Counts counts;
  counts.processes = group.size();
  counts.traffic.add_since(before, group.traffic());
  Buffer most{static_cast<double>(piece.halo.size())};
  counts.traffic.append_to(most);
  group.largest(most);
  const double here[1] = {static_cast<double>(piece.own.num_contacts())};
  const std::vector<double> contacts = group.gather(here);
  counts.imbalance = imbalance(contacts);
  counts.most_contacts = static_cast<int>(*std::max_element(contacts.begin(), contacts.end()));
  BufferReader reader(most);
  reader.take(counts.most_halo);
  counts.traffic.read(reader);
  return counts;
}

/// Sets the refusal of the first process that has one. False: none has.
bool is_refused(const std::string& mine, ProcessGroup& group, SolveResult& result) {
  result.message = group.first_text(mine);
  if (result.message.empty()) return false;
  result.status = SolveStatus::kInvalidInput;
  return true;
}

SolveResult without_contacts(const ContactProblem& p) {
  return {.status = SolveStatus::kNothingToDo,
          .message = "no contacts",
          .error = contact_error(p, Vector())};
}

}  // namespace

DistributedResult distributed_solve(std::string_view name, const ContactProblem& problem,
                                    const SolverOptions& options, ProcessGroup& group,
                                    const DistributedOptions& extra) {
  if (const auto others = without_islands(options)) {
    return distributed_solve(name, problem, *others, group, extra);
  }
  DistributedResult out;
  out.counts.processes = group.size();
  if (is_refused(refuse_input(name, problem, options, extra), group, out.result)) return out;
  if (!group.any(problem.num_contacts() > 0)) {
    out.result = without_contacts(problem);
    return out;
  }
  require_one_problem(problem, options, group);
  const Stopwatch watch;
  const BodyNodes nodes = body_nodes(problem);
  const ContactOwners owners = contact_owners(problem, nodes, extra.contact_places, group.size());
  const ProblemPiece piece = cut_piece(problem, nodes, owners, group.rank());
  KnownWhole whole(problem, owners, group);
  DistributedSpace space(piece, group, extra.reproducible, &whole, extra.shared_factor_rows);
  SolverOptions here = options;
  if (options.s0.size() != 0) here.s0 = whole.mine(options.s0);
  const ProcessGroup::Traffic before = group.traffic();
  out.result = solve_in(space, require_solver(name), here, watch);
  out.counts = counts_since(before, piece, group);
  out.result.s = whole.join(out.result.s);
  out.result.u = whole.join(out.result.u);
  return out;
}

PieceResult distributed_solve(std::string_view name, const ProblemPiece& piece,
                              const SolverOptions& options, ProcessGroup& group,
                              const DistributedOptions& extra) {
  if (const auto others = without_islands(options)) {
    return distributed_solve(name, piece, *others, group, extra);
  }
  PieceResult out;
  out.counts.processes = group.size();
  if (is_refused(refuse_input(name, piece.own, options, extra), group, out.result)) return out;
  const double figures[] = {static_cast<double>(piece.whole_contacts),
                            static_cast<double>(piece.own.dim),
                            static_cast<double>(piece.everywhere_inverse_mass.size()), options.tol};
  require_same(figures, group);
  out.with_halo = Vector::Zero(piece.with_halo.num_rows());
  if (piece.whole_contacts == 0) {
    out.result = without_contacts(piece.own);
    return out;
  }
  const Stopwatch watch;
  DistributedSpace space(piece, group, extra.reproducible, nullptr, extra.shared_factor_rows);
  const ProcessGroup::Traffic before = group.traffic();
  out.result = solve_in(space, require_solver(name), options, watch);
  out.counts = counts_since(before, piece, group);
  space.with_halo(out.result.s, out.with_halo);
  out.everywhere_momentum = space.everywhere_momentum(out.result.s);
  return out;
}

}  // namespace bipot
