#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/json_output.h"
#include "core/base/counted.h"
#include "core/base/file_error.h"
#include "core/base/version.h"
#include "core/criterion/impulse_verdict.h"
#include "core/files/hdf5_file.h"
#include "core/problem_files/impulse_file.h"
#include "core/problem_files/problem_file.h"

namespace bipot {
namespace {

struct JudgeFlags : OutputFlags {
  std::string problem;   ///< FCLIB HDF5 or Siconos text
  std::string impulses;  ///< empty: /solution of the problem file
  double tol = 1e-8;
  std::string order;  ///< "contact", "component"; empty: of the shape, else "contact"
  ImpulseLayout layout;
  int worst = 5;                   ///< contacts that are named
  bool accept_indefinite = false;  ///< take a W that is no Delassus operator
};

ImpulseVerdict verdict_of(const JudgeFlags& flags, const ProblemFile& file) {
  const std::string& path = flags.impulses.empty() ? flags.problem : flags.impulses;
  if (flags.impulses.empty() && !file.r) {
    throw std::invalid_argument(flags.problem +
                                ": no /solution to judge; name a file with --impulses");
  }
  ImpulseLayout layout = flags.layout;
  if (flags.order == "contact") layout.order = ImpulseLayout::Order::kContact;
  if (flags.order == "component") layout.order = ImpulseLayout::Order::kComponent;
  const Vector s = readable(path, [&] { return read_impulses(path, file.problem, layout); });
  try {
    return judge(file.problem, s, flags.worst);
  } catch (const std::invalid_argument& e) {
    throw std::invalid_argument(path + ": " + e.what());
  }
}

/// Null for no contact.
Json contact_or_null(int contact) { return contact >= 0 ? Json(contact) : Json(nullptr); }

Json to_json(const JudgedContact& contact) {
  const auto fault_json = [](const ContactFault& fault) {
    return Json{{"kind", to_string(fault.kind)}, {"size", fault.size}, {"energy", fault.energy}};
  };
  return {{"contact", contact.contact},
          {"mu", contact.mu},
          {"s", std::vector<double>(contact.s.begin(), contact.s.end())},
          {"u", std::vector<double>(contact.u.begin(), contact.u.end())},
          {"share", contact.share},
          {"faults", json_list(contact.faults, fault_json)},
          {"message", sentence(contact)}};
}

Json to_json(const JudgeFlags& flags, const ContactProblem& p, const ImpulseVerdict& v, int code) {
  Json j{{"command", "judge"},
         {"version", program_version()},
         {"problem", flags.problem},
         {"impulses", flags.impulses.empty() ? flags.problem : flags.impulses},
         {"status", code == kExitConverged ? "within" : "not within"},
         {"message", sentence(v, flags.tol)},
         {"exit_code", code},
         {"tol", flags.tol}};
  add_error(j, v.error);
  j["guarded"] = v.guarded();
  j["siconos_map"] = v.siconos_map;
  j["cone"] = v.cone;
  j["cone_violation"] = v.cone_violation;
  j["cone_contact"] = contact_or_null(v.cone_contact);
  j["penetration_velocity"] = v.penetration_velocity;
  j["penetration_contact"] = contact_or_null(v.penetration_contact);
  j["contacts"] = p.num_contacts();
  j["dim"] = p.dim;
  j["take_off"] = v.count.take_off;
  j["stick"] = v.count.stick;
  j["slip"] = v.count.slip;
  j["worst"] = json_list(v.worst, [](const auto& contact) { return to_json(contact); });
  return j;
}

std::string at_contact(int contact) {
  return contact >= 0 ? fmt::format(" (contact {})", contact) : std::string();
}

void print(const JudgeFlags& flags, const ContactProblem& p, const ImpulseVerdict& v) {
  fmt::print("{}: {}, d = {}\n", flags.problem, counted(p.num_contacts(), "contact"), p.dim);
  fmt::print("  {}: {}\n", flags.impulses.empty() ? "its /solution" : flags.impulses,
             sentence(v, flags.tol));
  fmt::print(
      "  energy ε {:.3e}, residual η {:.3e}, the paper's (42) {:.3e}, natural map {:.3e}, Siconos' {:.3e}\n",
      v.error.epsilon, v.error.eta, v.error.raw42, v.error.natural_map, v.siconos_map);
  fmt::print("  distance to the cone {:.3e}, of one contact at most {:.3e} N s{}\n", v.cone,
             v.cone_violation, at_contact(v.cone_contact));
  fmt::print("  penetration at most {:.3e} m/s{}\n", v.penetration_velocity,
             at_contact(v.penetration_contact));
  fmt::print("  open {}, stick {}, slip {}\n", v.count.take_off, v.count.stick, v.count.slip);
  if (!v.worst.empty()) fmt::print("  worst contacts, with their share of the error:\n");
  for (const JudgedContact& contact : v.worst) {
    fmt::print("  {:>5.1f} %  {}\n", 100 * contact.share, sentence(contact));
  }
}

CommandDeclaration add_judge(CommandLine& line, JudgeFlags& flags) {
  CommandDeclaration command = line.add_command(
      "judge", "How wrong is an impulse that any code computed for a problem file, and where");
  command.option("problem", flags.problem,
                 "Problem file (FCLIB HDF5, Siconos text) or the name of a shipped problem",
                 {.required = true, .suggest = names_of(shipped_problems())});
  command.option("--impulses FILE", flags.impulses,
                 "The impulses: .npy, .csv, FCLIB HDF5 (/solution/r) or Siconos text; without it "
                 "the problem file's own /solution");
  command.option("--tol NUMBER", flags.tol, "Tolerance that the errors are held against",
                 {.show_default = true, .positive = true});
  const char* group = "How the file has the impulses";
  command.option("--order", flags.order,
                 "contact: all components of a contact together, as in FCLIB; component: all "
                 "contacts' first components, then the second ones (that of a table's shape, else "
                 "contact)",
                 {.group = group, .one_of = {"contact", "component"}});
  command.option("--components LETTERS", flags.layout.components,
                 "Order of the components, n normal, t and s tangential (nts; LMGC90's: tns)",
                 {.group = group});
  command.option("--negate LETTERS", flags.layout.negated,
                 "Components that point the other way: n where pushing is negative",
                 {.group = group});
  command.option("--factor NUMBER", flags.layout.factor,
                 "To N s: the time step, where the file has forces",
                 {.show_default = true, .group = group, .positive = true});
  command.option("--worst", flags.worst, "Contacts to name",
                 {.show_default = true, .between = {{0, 1000000}}});
  command.flag("--accept-indefinite", flags.accept_indefinite,
               "Take a W that is not symmetric or not positive semidefinite; each verdict says so");
  add_output_flags(command, flags, "");
  command.footer(
      "Ends with 0 where the largest of ε, η (in higher precision where rounding decides) and the\n"
      "distance to the cone is within --tol, with 1 where it is not.\n"
      "Examples:\n"
      "  bipot judge problem.hdf5\n"
      "  bipot judge problem.hdf5 --impulses mine.npy --tol 1e-4\n"
      "  bipot judge problem.dat --impulses lmgc90.csv --components tn --factor 1e-3 --json -");
  return command;
}

int run_judge(const JudgeFlags& typed) {
  JudgeFlags flags = typed;
  flags.problem = find_problem(typed.problem).string();
  require_apart({{"--json", flags.json}},
                {{"the problem", flags.problem}, {"--impulses", flags.impulses}});
  const ProblemFile file =
      readable(flags.problem, [&] { return read_problem(flags.problem, flags.accept_indefinite); });
  flags.prepare();
  ImpulseVerdict verdict = verdict_of(flags, file);
  verdict.caution = file.caution;
  const int code = verdict.guarded() <= flags.tol ? kExitConverged : kExitNotConverged;
  if (!flags.json.empty()) write_json(to_json(flags, file.problem, verdict, code), flags.json);
  if (!flags.silent()) print(flags, file.problem, verdict);
  return code;
}

}  // namespace

ProgramCommand judge_command(CommandLine& line) {
  return make_command(line, &add_judge, &run_judge);
}

}  // namespace bipot
