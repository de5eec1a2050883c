#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/exit_code.h"
#include "bench/report/json_output.h"
#include "core/motion/state.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/parallel/process_group.h"
#include "solvers/simulation/domain.h"

namespace bipot {

/// A failure that all processes of this command know of: the root process reports it, all end.
class CommonCommandFailure : public CommonFailure {
 public:
  CommonCommandFailure(ExitCode code, const std::string& message)
      : CommonFailure(message), exit_code(code) {}
  ExitCode exit_code;
};

/// True if a launcher started this command several times (mpirun -n P).
bool on_several_processes();
/// True if this process prints and writes files: the root process.
bool is_speaker();
/// True if others may wait for this process.
bool processes_have_met();

/// The processes of this command; the first call starts MPI if there are several.
ProcessGroup& run_processes();

/// Runs work that each process does by itself, such as reading a file. If one of them fails, all
/// throw CommonCommandFailure with the first one's message and exit code. A single process rethrows
/// its own exception.
void together(const std::function<void()>& prepare);

/// Call first: processes other than the root print nothing, on neither stream.
void keep_others_quiet();
/// Prints a message from any process.
void say_from_here(const std::string& message);

/// Throws std::invalid_argument for flags without use in parallel: more than one thread, or `flag`
/// (empty: none).
void refuse_on_several_processes(const CommonFlags& flags, const std::string& flag);

/// Positions of the contacts of a state, in 2D or 3D.
template <int D>
std::vector<Vec3> contact_places(const State<D>& state) {
  std::vector<Vec3> places;
  places.reserve(state.contacts.size());
  for (const ContactOutcome<D>& c : state.contacts) {
    const Body<D>& body = state.bodies[to_size(c.contact.i)];
    Vec3 place = Vec3::Zero();
    place.template head<D>() = body.x - body.radius * c.contact.n;
    places.push_back(place);
  }
  return places;
}

ExitCode exit_code_for(const std::exception& e);

/// Entries of a summary for parallel solves: processes, imbalance, halo and traffic.
Json to_json(const DistributedResult::Counts& counts);
/// The same in one line.
std::string to_text(const DistributedResult::Counts& counts);

/// Entries of a summary for a distributed state. `peak_bytes`: memory of the process with the most.
Json to_json(const DomainCounts& counts, double peak_bytes);
/// The same in lines.
std::string to_text(const DomainCounts& counts);

}  // namespace bipot
