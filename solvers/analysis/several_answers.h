#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.h"
#include "core/scene/contact.h"
#include "solvers/analysis/distinct_answers.h"
#include "solvers/solver.h"

namespace bipot {

struct Answer {
  /// Relation of an answer to answers near it.
  enum class Kind {
    kIsolated,  ///< every solve from 1 % away returned to it
    kFamily,    ///< joined by exact answers to another one: velocities vary continuously
    kLeft,      ///< a solve from 1 % away ended at another answer, not joined to this one
    kUnknown    ///< no solve from 1 % away reached an exact answer, or time was up
  };
  /// Difference of two answers of a problem, relative to the first one found. Undefined measures
  /// are NaN: those of bodies need the rows of rigid bodies in H (body_rows.h).
  struct Difference {
    double velocity = kNaN;  ///< ‖v - v'‖_A / ‖v - v_free‖_A of the first answer      [-]
    double body_velocity = kNaN;  ///< largest |v_b - v_b'| over the largest |v_b|, translations [-]
    double kinetic = kNaN;  ///< |½ vᵀA v - ½ v'ᵀA v'| over that of the first answer        [-]
    double force = kNaN;    ///< largest |R_b - R_b'| over the mean |R_b|, R_b: contact impulse [-]
    /// Change of the sum of all R_b, the impulse of walls, over that of the first answer [-]
    double total = kNaN;
    int contacts = 0;  ///< whose status differs
  };
  VerifiedAnswer impulse;
  Vector u;                           ///< local velocities                              [m/s]
  std::vector<ContactStatus> status;  ///< of each contact
  int take_off = 0, stick = 0, slip = 0;
  double kinetic = kNaN;    ///< ½ vᵀ A v after the step; NaN for a problem given by W [J]
  std::vector<int> starts;  ///< that ended here
  Kind kind = Kind::kUnknown;
  int set = 0;                 ///< joined answers have the same number, from 0
  double perturbed = kNaN;     ///< relative distance of the perturbed impulse           [-]
  double came_back_to = kNaN;  ///< relative distance from there of the answer found     [-]
  Difference from_first;       ///< to answer 0
};
std::string_view to_string(Answer::Kind kind);
/// The larger of each.
Answer::Difference larger_of(const Answer::Difference& a, const Answer::Difference& b);

struct SeveralAnswers {
  /// One attempt at an answer.
  struct Start {
    std::string solver, from;  ///< "pgs", "zero"; "apgd", "multiples of answer 1, 50 %"
    std::string finished_by;   ///< the solver whose impulse counts
    ContactError error;        ///< of the best impulse
    int answer = -1;           ///< index into SeveralAnswers::answers; -1: no exact one was reached
    double seconds = 0;        ///< wall
    std::string message;       ///< of the solver that came last
  };
  struct Options {
    int starts = 10;                ///< >= 1
    std::uint64_t seed = 1;         ///< of orders, multiples and perturbations
    double tol = 1e-11;             ///< guarded error that every start is driven to
    double time_limit = kInfinity;  ///< wall seconds of everything
    Vector guess;  ///< impulse, as of the step before: the first starts begin there; or empty [N s]
    std::string solver;                             ///< every start by this one; empty: by several
    std::map<std::string, std::string> parameters;  ///< of that one
    std::function<bool()> cancelled;                ///< true ends the search
  };
  SolveStatus status = SolveStatus::kNotRun;
  std::string message;
  bool complete = false;  ///< few contacts: no case of open, stick and slip has another answer
  std::vector<Start> starts;
  std::vector<Answer> answers;  ///< in the order in which they were found
  int sets = 0;                 ///< isolated answers and families together
  Answer::Difference spread;    ///< largest over all pairs
  /// Least relative distance at which answers with the largest error here count as two.
  double resolution = kNaN;
  std::vector<int> differing_contacts;  ///< with different statuses in some answers
  double seconds = 0;                   ///< wall
};

/// Searches for several exact answers of one problem. Starts: the guess, solvers from s = 0, other
/// orders of contacts, random multiples of the impulses of an answer. Each is improved by its own
/// solver and finished by exact ones (`homotopy` for d <= 2 from the impulse as it is, `ipm`,
/// `newton`).
/// Impulses that reach DistinctAnswers::kTrusted are compared by DistinctAnswers. From each answer,
/// an impulse 1 % away is solved again. Answers whose segment is exact at 1/4, 1/2, 3/4 as well
/// form a family. (For d <= 2 and equal statuses the law is linear along the segment, and the three
/// points prove it.)
///
/// The number of answers is a lower bound, unless `complete`. Limits are in iterations, so that the same seed gives
/// the same bits unless the time limit acts. Status: kConverged if every start reached an exact
/// answer, kStalled if only some did, kTimeLimit, kInterrupted, kInvalidInput with the reason,
/// kNothingToDo without contacts.
SeveralAnswers find_several_answers(const ContactProblem& problem,
                                    const SeveralAnswers::Options& options);

}  // namespace bipot
