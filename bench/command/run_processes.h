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

/// A failure that all processes of this command know of: the first one says it, all end.
class CommonCommandFailure : public CommonFailure {
 public:
  CommonCommandFailure(ExitCode code, const std::string& message)
      : CommonFailure(message), exit_code(code) {}
  ExitCode exit_code;
};

/// Whether a launcher started this command several times (mpirun -n P).
bool on_several_processes();
/// Whether this process prints and writes files: the first one.
bool is_speaker();
/// Whether others may wait for this process.
bool processes_have_met();

/// The processes of this command; the first call starts MPI where there are several.
ProcessGroup& run_processes();

/// Does something that each process does by itself, such as reading a file; where one of them fails,
/// all throw CommonCommandFailure with the first one's message and exit code. A lone process throws
/// what it threw.
void together(const std::function<void()>& prepare);

/// Before anything else: processes other than the speaker print nothing, on neither stream.
void keep_others_quiet();
/// Prints a message of any process, whoever it is.
void say_from_here(const std::string& message);

/// Throws std::invalid_argument where several processes have no use for what the flags ask: more
/// than one thread, or `flag` (empty: none).
void refuse_on_several_processes(const CommonFlags& flags, const std::string& flag);

/// Where the contacts of a state lie, in the plane or in space.
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

/// The exit code that an exception asks for.
ExitCode exit_code_for(const std::exception& e);

/// What several processes add to a summary: processes, imbalance, halo and traffic.
Json to_json(const DistributedCounts& counts);
/// The same in a line.
std::string to_text(const DistributedCounts& counts);

/// What a distributed state adds to a summary. `peak_bytes`: memory of the process with the most.
Json to_json(const DomainCounts& counts, double peak_bytes);
/// The same in lines.
std::string to_text(const DomainCounts& counts);

}  // namespace bipot
