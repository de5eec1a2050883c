#include "solvers/domains/domain_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/release.h"
#include "solvers/domains/body_parcel.h"

namespace bipot {
namespace {

/// What each body brings along: itself, and these contacts that it comes first in. Both ascending.
template <int D>
std::vector<double> contact_weights(const std::vector<int>& numbers,
                                    const std::vector<ContactOutcomeIn<D>>& contacts) {
  std::vector<double> weights(numbers.size(), 1.0);
  std::size_t k = 0;
  for (const ContactOutcomeIn<D>& c : contacts) {
    while (k < numbers.size() && numbers[k] < c.contact.i) ++k;
    if (k < numbers.size() && numbers[k] == c.contact.i) ++weights[k];
  }
  return weights;
}

/// All but bodies and contacts.
template <int D>
StateIn<D> frame_of(const StateIn<D>& state) {
  StateIn<D> frame;
  frame.time = state.time;
  frame.step = state.step;
  frame.walls = state.walls;
  frame.wall_work = state.wall_work;
  frame.friction_loss = state.friction_loss;
  frame.shock_loss = state.shock_loss;
  return frame;
}

template <int D>
void put_contacts(const std::vector<ContactOutcomeIn<D>>& contacts, Parcel& parcel) {
  for (const ContactOutcomeIn<D>& c : contacts) put(c, parcel);
}

}  // namespace

template <int D>
CellTree cut_cells(const StateIn<D>& whole, int processes) {
  std::vector<Vec3> places;
  std::vector<int> numbers;
  for (const BodyIn<D>& d : whole.disks) {
    numbers.push_back(static_cast<int>(numbers.size()));
    places.push_back(in_space<D>(d.x));
  }
  return CellTree(places, contact_weights<D>(numbers, whole.contacts), processes);
}

template <int D>
DomainStateIn<D> cut_state(const StateIn<D>& whole, const CellTree& cells, int rank) {
  DomainStateIn<D> state;
  state.bodies = static_cast<int>(whole.disks.size());
  state.here = frame_of(whole);
  std::vector<char> mine(whole.disks.size(), 0);
  for (std::size_t k = 0; k < whole.disks.size(); ++k) {
    if (cells.cell_of(in_space<D>(whole.disks[k].x)) != rank) continue;
    mine[k] = 1;
    state.numbers.push_back(static_cast<int>(k));
    state.here.disks.push_back(whole.disks[k]);
  }
  for (const ContactOutcomeIn<D>& c : whole.contacts) {
    if (mine[to_size(c.contact.i)] != 0) state.here.contacts.push_back(c);
  }
  return state;
}

template <int D>
StateIn<D> gather_state(const DomainStateIn<D>& state, ProcessGroup& group) {
  std::vector<Parcel> bodies(to_size(group.size())), contacts(to_size(group.size()));
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    put(state.numbers[k], state.here.disks[k], bodies[0]);
  }
  put_contacts(state.here.contacts, contacts[0]);
  bodies = group.deliver(std::move(bodies));
  contacts = group.deliver(std::move(contacts));
  StateIn<D> whole = frame_of(state.here);
  std::string failure;
  if (group.rank() == 0) {
    whole.disks.resize(to_size(state.bodies));
    std::vector<char> there(whole.disks.size(), 0);
    std::size_t count = 0;
    for (Parcel& parcel : bodies) {
      for (ParcelReader reader(parcel); !reader.at_end(); ++count) {
        NumberedBodyIn<D> next = take_body<D>(reader);
        if (std::exchange(there.at(to_size(next.number)), 1) != 0) {
          failure = fmt::format("{} {} is on two processes", kBodyName<D>, next.number);
        }
        whole.disks[to_size(next.number)] = std::move(next.body);
      }
      release(parcel);
    }
    if (failure.empty() && count != whole.disks.size()) {
      failure = fmt::format("{} of {} {}s are on no process", whole.disks.size() - count,
                            whole.disks.size(), kBodyName<D>);
    }
    for (Parcel& parcel : contacts) {
      ParcelReader reader(parcel);
      while (!reader.at_end()) whole.contacts.push_back(take_contact<D>(reader));
      release(parcel);
    }
    sort_by_bodies(whole.contacts);
  }
  group.fail_where_any(failure);
  return whole;
}

template <int D>
CellTree cut_cells_again(const DomainStateIn<D>& state, ProcessGroup& group) {
  const std::vector<double> weights = contact_weights<D>(state.numbers, state.here.contacts);
  std::vector<Parcel> parcels(to_size(group.size()));
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    const Vec3 x = in_space<D>(state.here.disks[k].x);
    parcels[0].insert(parcels[0].end(),
                      {static_cast<double>(state.numbers[k]), x[0], x[1], x[2], weights[k]});
  }
  parcels = group.deliver(std::move(parcels));
  std::vector<double> tree;
  if (group.rank() == 0) {
    // In the order of the whole, so that the cells do not depend on who has whom.
    std::vector<Vec3> places(to_size(state.bodies));
    std::vector<double> weight(places.size(), 0.0);
    for (const Parcel& parcel : parcels) {
      for (ParcelReader reader(parcel); !reader.at_end();) {
        const std::size_t k = to_size(reader.integer());
        places.at(k) = reader.vector<3>();
        weight[k] = reader.number();
      }
    }
    tree = CellTree(places, weight, group.size()).to_numbers();
  }
  return CellTree::from_numbers(group.gather(tree));
}

template <int D>
int migrate(const CellTree& cells, ProcessGroup& group, DomainStateIn<D>& state) {
  std::vector<Parcel> bodies(to_size(group.size())), contacts(to_size(group.size()));
  const auto all_contacts = std::exchange(state.here.contacts, {});
  const auto all_bodies = std::exchange(state.here.disks, {});
  const auto all_numbers = std::exchange(state.numbers, {});
  std::size_t c = 0;
  int gone = 0;
  for (std::size_t k = 0; k < all_bodies.size(); ++k) {
    const int to = cells.cell_of(in_space<D>(all_bodies[k].x));
    const bool stays = to == group.rank();
    if (stays) {
      state.numbers.push_back(all_numbers[k]);
      state.here.disks.push_back(all_bodies[k]);
    } else {
      put(all_numbers[k], all_bodies[k], bodies[to_size(to)]);
      ++gone;
    }
    for (; c < all_contacts.size() && all_contacts[c].contact.i == all_numbers[k]; ++c) {
      if (stays) {
        state.here.contacts.push_back(all_contacts[c]);
      } else {
        put(all_contacts[c], contacts[to_size(to)]);
      }
    }
  }
  bodies = group.deliver(std::move(bodies));
  contacts = group.deliver(std::move(contacts));
  std::vector<NumberedBodyIn<D>> come;
  for (const Parcel& parcel : bodies) {
    for (ParcelReader reader(parcel); !reader.at_end();) come.push_back(take_body<D>(reader));
  }
  for (const Parcel& parcel : contacts) {
    for (ParcelReader reader(parcel); !reader.at_end();) {
      state.here.contacts.push_back(take_contact<D>(reader));
    }
  }
  if (come.empty()) return gone;
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    come.push_back({state.numbers[k], state.here.disks[k]});
  }
  std::sort(come.begin(), come.end(),
            [](const auto& a, const auto& b) { return a.number < b.number; });
  state.numbers.clear();
  state.here.disks.clear();
  for (const NumberedBodyIn<D>& body : come) {
    state.numbers.push_back(body.number);
    state.here.disks.push_back(body.body);
  }
  sort_by_bodies(state.here.contacts);
  return gone;
}

template CellTree cut_cells(const State&, int);
template CellTree cut_cells(const StateIn<3>&, int);
template DomainState cut_state(const State&, const CellTree&, int);
template DomainStateIn<3> cut_state(const StateIn<3>&, const CellTree&, int);
template State gather_state(const DomainState&, ProcessGroup&);
template StateIn<3> gather_state(const DomainStateIn<3>&, ProcessGroup&);
template CellTree cut_cells_again(const DomainState&, ProcessGroup&);
template CellTree cut_cells_again(const DomainStateIn<3>&, ProcessGroup&);
template int migrate(const CellTree&, ProcessGroup&, DomainState&);
template int migrate(const CellTree&, ProcessGroup&, DomainStateIn<3>&);

}  // namespace bipot
