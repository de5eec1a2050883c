#include "solvers/simulation/domain_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/release.h"
#include "solvers/simulation/body_buffer.h"

namespace bipot {
namespace {

/// Weight of each body: itself, and these contacts whose first body it is. Both ascending.
template <int D>
std::vector<double> contact_weights(const std::vector<int>& numbers,
                                    const std::vector<ContactOutcome<D>>& contacts) {
  std::vector<double> weights(numbers.size(), 1.0);
  std::size_t k = 0;
  for (const ContactOutcome<D>& c : contacts) {
    while (k < numbers.size() && numbers[k] < c.contact.i) ++k;
    if (k < numbers.size() && numbers[k] == c.contact.i) ++weights[k];
  }
  return weights;
}

/// A copy without bodies and contacts.
template <int D>
State<D> frame_of(const State<D>& state) {
  return {.time = state.time,
          .step = state.step,
          .walls = state.walls,
          .wall_work = state.wall_work,
          .friction_loss = state.friction_loss,
          .shock_loss = state.shock_loss};
}

}  // namespace

template <int D>
CellTree cut_cells(const State<D>& whole, int processes) {
  std::vector<Vec3> places;
  std::vector<int> numbers;
  for (const Body<D>& d : whole.bodies) {
    numbers.push_back(static_cast<int>(numbers.size()));
    places.push_back(in_space<D>(d.x));
  }
  return CellTree(places, contact_weights<D>(numbers, whole.contacts), processes);
}

template <int D>
DomainState<D> cut_state(const State<D>& whole, const CellTree& cells, int rank) {
  DomainState<D> state;
  state.bodies = static_cast<int>(whole.bodies.size());
  state.here = frame_of(whole);
  std::vector<char> mine(whole.bodies.size(), 0);
  for (std::size_t k = 0; k < whole.bodies.size(); ++k) {
    if (cells.cell_of(in_space<D>(whole.bodies[k].x)) != rank) continue;
    mine[k] = 1;
    state.numbers.push_back(static_cast<int>(k));
    state.here.bodies.push_back(whole.bodies[k]);
  }
  for (const ContactOutcome<D>& c : whole.contacts) {
    if (mine[to_size(c.contact.i)] != 0) state.here.contacts.push_back(c);
  }
  return state;
}

template <int D>
State<D> gather_state(const DomainState<D>& state, ProcessGroup& group) {
  std::vector<Buffer> bodies(to_size(group.size())), contacts(to_size(group.size()));
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    put(state.numbers[k], state.here.bodies[k], bodies[0]);
  }
  for (const ContactOutcome<D>& c : state.here.contacts) put(c, contacts[0]);
  bodies = group.deliver(std::move(bodies));
  contacts = group.deliver(std::move(contacts));
  State<D> whole = frame_of(state.here);
  std::string failure;
  if (group.rank() == 0) {
    whole.bodies.resize(to_size(state.bodies));
    std::vector<char> there(whole.bodies.size(), 0);
    std::size_t count = 0;
    for (Buffer& buffer : bodies) {
      for (BufferReader reader(buffer); !reader.at_end(); ++count) {
        NumberedBody<D> next = take_body<D>(reader);
        if (std::exchange(there.at(to_size(next.number)), 1) != 0) {
          failure = fmt::format("{} {} is on two processes", kBodyName<D>, next.number);
        }
        whole.bodies[to_size(next.number)] = std::move(next.body);
      }
      release(buffer);
    }
    if (failure.empty() && count != whole.bodies.size()) {
      failure = fmt::format("{} of {} {}s are on no process", whole.bodies.size() - count,
                            whole.bodies.size(), kBodyName<D>);
    }
    for (Buffer& buffer : contacts) {
      BufferReader reader(buffer);
      while (!reader.at_end()) whole.contacts.push_back(take_contact<D>(reader));
      release(buffer);
    }
    sort_by_bodies(whole.contacts);
  }
  group.fail_where_any(failure);
  return whole;
}

template <int D>
CellTree cut_cells_again(const DomainState<D>& state, ProcessGroup& group) {
  const std::vector<double> weights = contact_weights<D>(state.numbers, state.here.contacts);
  std::vector<Buffer> buffers(to_size(group.size()));
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    append(buffers[0], state.numbers[k], in_space<D>(state.here.bodies[k].x), weights[k]);
  }
  buffers = group.deliver(std::move(buffers));
  std::vector<double> tree;
  if (group.rank() == 0) {
    // In the order of the whole, so that the cells do not depend on the distribution.
    std::vector<Vec3> places(to_size(state.bodies));
    std::vector<double> weight(places.size(), 0.0);
    for (const Buffer& buffer : buffers) {
      for (BufferReader reader(buffer); !reader.at_end();) {
        const std::size_t k = to_size(reader.integer());
        reader.take(places.at(k), weight[k]);
      }
    }
    tree = CellTree(places, weight, group.size()).to_numbers();
  }
  return CellTree::from_numbers(group.gather(tree));
}

template <int D>
int migrate(const CellTree& cells, ProcessGroup& group, DomainState<D>& state) {
  std::vector<Buffer> bodies(to_size(group.size())), contacts(to_size(group.size()));
  const auto all_contacts = std::exchange(state.here.contacts, {});
  const auto all_bodies = std::exchange(state.here.bodies, {});
  const auto all_numbers = std::exchange(state.numbers, {});
  std::size_t c = 0;
  int gone = 0;
  for (std::size_t k = 0; k < all_bodies.size(); ++k) {
    const int to = cells.cell_of(in_space<D>(all_bodies[k].x));
    const bool stays = to == group.rank();
    if (stays) {
      state.numbers.push_back(all_numbers[k]);
      state.here.bodies.push_back(all_bodies[k]);
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
  std::vector<NumberedBody<D>> come;
  for (const Buffer& buffer : bodies) {
    for (BufferReader reader(buffer); !reader.at_end();) come.push_back(take_body<D>(reader));
  }
  for (const Buffer& buffer : contacts) {
    for (BufferReader reader(buffer); !reader.at_end();) {
      state.here.contacts.push_back(take_contact<D>(reader));
    }
  }
  if (come.empty()) return gone;
  for (std::size_t k = 0; k < state.numbers.size(); ++k) {
    come.push_back({state.numbers[k], state.here.bodies[k]});
  }
  std::sort(come.begin(), come.end(),
            [](const auto& a, const auto& b) { return a.number < b.number; });
  state.numbers.clear();
  state.here.bodies.clear();
  for (const NumberedBody<D>& body : come) {
    state.numbers.push_back(body.number);
    state.here.bodies.push_back(body.body);
  }
  sort_by_bodies(state.here.contacts);
  return gone;
}

template CellTree cut_cells(const State<2>&, int);
template CellTree cut_cells(const State<3>&, int);
template DomainState<2> cut_state(const State<2>&, const CellTree&, int);
template DomainState<3> cut_state(const State<3>&, const CellTree&, int);
template State<2> gather_state(const DomainState<2>&, ProcessGroup&);
template State<3> gather_state(const DomainState<3>&, ProcessGroup&);
template CellTree cut_cells_again(const DomainState<2>&, ProcessGroup&);
template CellTree cut_cells_again(const DomainState<3>&, ProcessGroup&);
template int migrate(const CellTree&, ProcessGroup&, DomainState<2>&);
template int migrate(const CellTree&, ProcessGroup&, DomainState<3>&);

}  // namespace bipot
