#include "solvers/methods/load_path.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/lists.h"
#include "core/base/parallel.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/packed_motion.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

// constant     value  unit             reason
// kAcross      0.02   cosine           contacts that lean less along the order carry nothing
// kSkew        0.1    tangent          of the order to the load, if there are such contacts
// kSteep       0.35   cosine           steeper ones first: flat ones push upright rows aside
// kCommon      0.999  of the momenta   their sum: of moving bodies it is less
// kMostSweeps  400    sweeps           of the contacts of a body
// kTaskBodies  32     bodies           of a task of a thread
// kHeld        1e-15  of the velocity  what the next sweep changes, once a body is held
// kBefore      1e-12  of the velocity  more than rounding: u_free is not Hᵀ v_free
constexpr double kAcross = 0.02, kSkew = 0.1, kSteep = 0.35, kCommon = 0.999, kHeld = 1e-15;
constexpr double kBefore = 1e-12;
constexpr int kMostSweeps = 400;
constexpr int kTaskBodies = 32;

/// Degrees of freedom of the translation of a body, and of the body.
template <int D>
constexpr int kPlaces = BodyPlace<D>::kForces;
template <int D>
constexpr int kDofs = kPlaces<D> + BodyPlace<D>::kTorques;

const double* normal_of(const DiskStructure::Contact& c) { return c.n; }
const double* normal_of(const SphereStructure::Contact& c) { return c.frame[0]; }

template <int D>
class LoadPath {
 public:
  LoadPath(const ContactProblem& p, const BodiesOf<D>& bodies)
      : p_(p),
        contacts_(bodies.contacts),
        surroundings_(bodies.surroundings()),
        mass_(p.A.diagonal()) {}

  /// Empty, or why it gives up.
  std::string pass(SolveRun& run) {
    if (!find_direction()) return "the bodies have no common direction of load";
    const Vector from_bodies = p_.H.transpose() * p_.v_free;
    const double before = (p_.u_free - from_bodies).lpNorm<Eigen::Infinity>();
    if (!(before <= kBefore * from_bodies.lpNorm<Eigen::Infinity>())) {
      return "velocities before the step enter its free velocities";
    }
    list_sides();
    s_ = Vector::Zero(p_.num_rows());
    double left = 0;
    const double energy = p_.v_free.dot(mass_.cwiseProduct(p_.v_free));
    const double most = run.options().tol * run.options().tol * energy;  // as of eta
    for (std::size_t begin = 0; begin < queue_.size();) {
      if (run.out_of_time()) return "stopped";
      const std::vector<int> due(queue_.begin() + static_cast<std::ptrdiff_t>(begin), queue_.end());
      begin = queue_.size();
      const std::vector<double> motion = hold(due, run.options().execution.threads);
      for (std::size_t k = 0; k < due.size(); ++k) {
        left += motion[k];
        if (!(left <= most)) return fmt::format("body {} is not held from below", due[k]);
        release_below(due[k]);
      }
    }
    if (static_cast<int>(queue_.size()) < surroundings_) return "bodies hold each other";
    return "";
  }
  const Vector& impulse() const { return s_; }

 private:
  using Motion = Eigen::Matrix<double, kDofs<D>, 1, Eigen::DontAlign>;
  using Direction = Eigen::Matrix<double, kPlaces<D>, 1>;
  /// A contact of the present body with one below.
  struct Support {
    int contact = 0;
    bool steep = true;
    double mu = 0;
    std::array<Motion, to_size(D)> g;  ///< rows of Hᵀ that are the body's
    Local<D> step = Local<D>::Zero(), s = Local<D>::Zero();
  };

  int other_body(int contact, int body) const {
    const auto& c = contacts_[to_size(contact)];
    return c.i == body ? c.j : c.i;
  }
  Motion at(const Vector& x, int body) const {
    return x.segment<kDofs<D>>(static_cast<Eigen::Index>(body) * kDofs<D>);
  }
  /// The cosine between the load and the normal that points to the body.
  double lean(int contact, int body) const {
    const auto& c = contacts_[to_size(contact)];
    double product = 0;
    for (int k = 0; k < kPlaces<D>; ++k) product += normal_of(c)[k] * load_[k];
    return c.i == body ? product : -product;
  }

  bool find_direction() {
    double sum = 0;
    load_.setZero();
    for (int b = 0; b < surroundings_; ++b) {
      const Motion momentum = at(mass_, b).cwiseProduct(at(p_.v_free, b));
      load_ += momentum.template head<kPlaces<D>>();
      sum += momentum.template head<kPlaces<D>>().norm();
    }
    const double length = load_.norm();
    if (!(length > kCommon * sum)) return false;
    load_ /= length;
    bool across = false;
    for (int c = 0; c < p_.num_contacts() && !across; ++c) {
      const auto& contact = contacts_[to_size(c)];
      const bool wall = contact.i == surroundings_ || contact.j == surroundings_;
      across = !wall && std::abs(lean(c, contact.i)) <= kAcross;
    }
    if (across) skew();
    return true;
  }
  /// Rows across the load hand on what pushes them aside, in an order that leans along them.
  void skew() {
    Direction aside = Direction::Zero();
    if constexpr (D == 3) {
      const Direction first = load_.unitOrthogonal();
      aside = first + 0.6 * load_.cross(first);
    } else {
      aside << -load_[1], load_[0];
    }
    load_ = (load_ + kSkew * aside).normalized();
  }

  /// The contacts of each body, how many of them are with bodies above, and the bodies without.
  void list_sides() {
    sides_ = make_lists(surroundings_, [&](const auto& put) {
      for (int c = 0; c < p_.num_contacts(); ++c) {
        for (const int body : {contacts_[to_size(c)].i, contacts_[to_size(c)].j}) {
          if (body != surroundings_) put(body, c);
        }
      }
    });
    for (int b = 0; b < surroundings_; ++b) {
      const auto of = sides_.of(b);
      const auto carried = std::count_if(of.begin(), of.end(), [&](int c) {
        return other_body(c, b) != surroundings_ && lean(c, b) > kAcross;
      });
      above_.push_back(static_cast<int>(carried));
      if (carried == 0) queue_.push_back(b);
    }
  }

  /// Rows of Hᵀ of a contact that are the body's.
  std::array<Motion, to_size(D)> rows_of(int contact, int body) const {
    std::array<Motion, to_size(D)> g;
    const int first = body * kDofs<D>;
    for (int a = 0; a < D; ++a) {
      g[to_size(a)].setZero();
      for (SparseMatrix::InnerIterator it(p_.H, contact * D + a); it; ++it) {
        const int k = static_cast<int>(it.row()) - first;
        if (k >= 0 && k < kDofs<D>) g[to_size(a)][k] = it.value();
      }
    }
    return g;
  }

  /// Holds bodies that are due at the same time: they share no contact that carries. Returns what
  /// held() does for each.
  std::vector<double> hold(const std::vector<int>& due, int threads) {
    std::vector<double> left(due.size());
    const int bodies = static_cast<int>(due.size());
    run_tasks(threads, (bodies + kTaskBodies - 1) / kTaskBodies, [&](int task) {
      std::vector<Support> supports;
      const int first = task * kTaskBodies, last = std::min(bodies, first + kTaskBodies);
      for (int k = first; k < last; ++k) left[to_size(k)] = held(due[to_size(k)], supports);
    });
    return left;
  }
  /// The body is held: those below that wait for no other one are due.
  void release_below(int body) {
    for (const int c : sides_.of(body)) {
      const int other = other_body(c, body);
      if (other == surroundings_ || !(lean(c, body) < -kAcross)) continue;
      if (--above_[to_size(other)] == 0) queue_.push_back(other);
    }
  }
  /// Finds the body's supports, sets their impulses. Returns twice the energy of the motion left.
  double held(int body, std::vector<Support>& supports) {
    const Motion mass = at(mass_, body), inverse = mass.cwiseInverse();
    Motion v = at(p_.v_free, body);
    supports.clear();
    for (const int c : sides_.of(body)) {
      const double leans = lean(c, body);
      const bool wall = other_body(c, body) == surroundings_;
      if (!wall && std::abs(leans) <= kAcross) continue;
      const std::array<Motion, to_size(D)> g = rows_of(c, body);
      if (!wall && leans > 0) {
        for (int a = 0; a < D; ++a) v += s_[c * D + a] * inverse.cwiseProduct(g[to_size(a)]);
        continue;
      }
      Support support{.contact = c, .steep = wall || leans < -kSteep, .mu = p_.mu[c], .g = g};
      for (int a = 0; a < D; ++a) {
        support.step[a] = 1 / g[to_size(a)].dot(inverse.cwiseProduct(g[to_size(a)]));
      }
      supports.push_back(std::move(support));
    }
    const double free = v.dot(mass.cwiseProduct(v)), settled = kHeld * kHeld * free;
    double left = free;
    for (const auto& [friction, flat_too] :
         {std::pair{false, false}, {false, true}, {true, true}}) {
      for (int sweep = 0; sweep < kMostSweeps && left > settled; ++sweep) {
        const Motion before = v;
        for (Support& support : supports) {
          if (support.steep || flat_too) relax(support, friction, inverse, v);
        }
        left = v.dot(mass.cwiseProduct(v));
        const Motion change = v - before;
        if (change.dot(mass.cwiseProduct(change)) <= settled) break;
      }
    }
    for (const Support& support : supports) {
      s_.segment<D>(static_cast<Eigen::Index>(support.contact) * D) = support.s;
    }
    return left;
  }

  /// One update of `pgs` of a contact, with the body below at rest.
  static void relax(Support& support, bool friction, const Motion& inverse, Motion& v) {
    Local<D> next = support.s;
    next[0] = positive_part(next[0] - support.step[0] * support.g[0].dot(v));
    const auto move = [&](int a) {
      v += (next[a] - support.s[a]) * inverse.cwiseProduct(support.g[to_size(a)]);
    };
    move(0);
    if (friction) {
      for (int a = 1; a < D; ++a) next[a] -= support.step[a] * support.g[to_size(a)].dot(v);
      cut_off_parts<D>(next, support.mu);
      for (int a = 1; a < D; ++a) move(a);
    }
    support.s = next;
  }

  const ContactProblem& p_;
  const LargeVector<typename BodiesOf<D>::Contact>& contacts_;
  const int surroundings_;
  const Vector mass_;
  Vector s_;
  Direction load_;          // of the order, along the load or nearly so
  Lists<> sides_;           // the contacts of each body, in their order
  std::vector<int> above_;  // contacts of each body with bodies above that are not done
  std::vector<int> queue_;  // bodies that are due, or done
};

}  // namespace

void solve_load_path(SolveRun& run) {
  const ContactProblem& p = run.problem();
  Vector s = Vector::Zero(p.num_rows());
  if (run.stop(0, s)) return;
  std::string refused = "the bodies are no disks or spheres on fixed walls";
  if (run.delassus().is_packed()) {
    dispatch_rows(p, [&](auto d) {
      if constexpr (!d().rolls) {
        const auto& bodies = *run.delassus().bodies<d()>();
        if (bodies.walls > 0) return;
        LoadPath<d()> path(p, bodies);
        refused = path.pass(run);
        if (refused.empty()) s = path.impulse();
      }
    });
  }
  run.end_setup();
  if (refused.empty()) {
    if (run.stop(1, s)) return;
    refused = run.options().stop == StopTest::kImpulse
                  ? "one iterate, where the stop test compares two"
                  : fmt::format("an error of {:.1e} is left", run.last_error());
  }
  if (run.end_if_out_of_time(0)) return;
  run.end(SolveStatus::kStalled, "no path of the load: " + refused);
}

}  // namespace bipot
