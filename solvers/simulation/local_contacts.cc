#include "solvers/simulation/local_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/release.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

/// The bodies whose contacts a process needs: its own, and those of its own contacts. Glued bodies
/// are left out: their impulses act on the wall.
template <int D>
std::vector<char> bodies_to_follow(const LocalBodies<D>& local, const std::vector<Body<D>>& disks,
                                   int rank, const std::vector<Contact<D>>& contacts) {
  std::vector<char> follow(disks.size(), 0);
  const auto mark = [&](std::size_t k) { follow[k] = disks[k].wall < 0 ? 1 : 0; };
  for (const int k : local.own) mark(to_size(k));
  for (const Contact<D>& c : contacts) {
    if (local.owner[to_size(c.i)] == rank && to_size(c.j) < disks.size()) mark(to_size(c.j));
  }
  return follow;
}

/// The ranges of bodies for which processes count contacts, of nearly equal size.
class BodyRanges {
 public:
  BodyRanges(int bodies, int processes) : bodies_(bodies), processes_(processes) {}
  int first(int rank) const { return static_cast<int>(std::int64_t{bodies_} * rank / processes_); }
  int of(int body) const {
    // first(rank) <= body < first(rank + 1)
    auto rank = static_cast<int>((std::int64_t{body} * processes_) / std::max(bodies_, 1));
    while (rank + 1 < processes_ && first(rank + 1) <= body) ++rank;
    while (rank > 0 && first(rank) > body) --rank;
    return rank;
  }

 private:
  int bodies_, processes_;
};

/// Sets the numbers of the own contacts in the whole: the contacts of all bodies with smaller
/// numbers come first. Each process receives the counts for the bodies in its range.
template <int D>
void number_contacts(const LocalBodies<D>& local, int bodies, ProcessGroup& group,
                     LocalContacts<D>& contacts) {
  const BodyRanges ranges(bodies, group.size());
  std::vector<Buffer> buffers(to_size(group.size()));
  std::vector<int> counts, range_of;  // of each body with own contacts, ascending
  for (std::size_t c = 0; c < contacts.own.size();) {
    std::size_t end = c;
    while (end < contacts.own.size() && contacts.own[end].i == contacts.own[c].i) ++end;
    const int body = local.numbers[to_size(contacts.own[c].i)];
    counts.push_back(static_cast<int>(end - c));
    range_of.push_back(ranges.of(body));
    append(buffers[to_size(range_of.back())], body, end - c);
    c = end;
  }
  buffers = group.deliver(std::move(buffers));
  const int first = ranges.first(group.rank()), end = ranges.first(group.rank() + 1);
  std::vector<int> before(to_size(end - first) + 1, 0);
  for (const Buffer& buffer : buffers) {
    for (BufferReader reader(buffer); !reader.at_end();) {
      const int body = reader.integer();
      before.at(to_size(body - first) + 1) = reader.integer();
    }
  }
  for (std::size_t k = 1; k < before.size(); ++k) before[k] += before[k - 1];
  const double here[1] = {static_cast<double>(before.back())};
  const std::vector<double> totals = group.gather(here);
  const double lower = std::accumulate(totals.begin(), totals.begin() + group.rank(), 0.0);
  const double whole = std::accumulate(totals.begin(), totals.end(), 0.0);
  if (whole > std::numeric_limits<int>::max()) throw CommonFailure("more than 2^31 contacts");
  contacts.whole = static_cast<int>(whole);
  for (Buffer& buffer : buffers) {
    Buffer answer;
    for (BufferReader reader(buffer); !reader.at_end(); reader.number()) {
      answer.push_back(lower + before[to_size(reader.integer() - first)]);
    }
    buffer = std::move(answer);
  }
  buffers = group.deliver(std::move(buffers));
  std::vector<std::size_t> next(buffers.size(), 0);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const std::size_t r = to_size(range_of[k]);
    const int number = static_cast<int>(buffers[r].at(next[r]++));
    for (int c = 0; c < counts[k]; ++c) contacts.number.push_back(number + c);
  }
}

/// Sets the positions of the halo's contacts on their owners.
template <int D>
void find_places(const LocalBodies<D>& local, int bodies, ProcessGroup& group,
                 LocalContacts<D>& contacts) {
  const auto bodies_of = [&](const Contact<D>& c) {
    const std::size_t j = to_size(c.j), here = local.numbers.size();
    return std::pair(local.numbers[to_size(c.i)],
                     j < here ? local.numbers[j] : bodies + static_cast<int>(j - here));
  };
  std::vector<Buffer> buffers(to_size(group.size()));
  for (const int k : contacts.halo) {
    const Contact<D>& c = contacts.all[to_size(k)];
    const auto [i, j] = bodies_of(c);
    append(buffers[to_size(local.owner[to_size(c.i)])], i, j);
  }
  buffers = group.deliver(std::move(buffers));
  std::string failure;
  for (Buffer& buffer : buffers) {
    Buffer answer;
    for (BufferReader reader(buffer); !reader.at_end();) {
      const int i = reader.integer();
      const std::pair wanted(i, reader.integer());
      const auto at = std::lower_bound(
          contacts.own.begin(), contacts.own.end(), wanted,
          [&](const Contact<D>& c, const std::pair<int, int>& w) { return bodies_of(c) < w; });
      if (at == contacts.own.end() || bodies_of(*at) != wanted) {
        failure = fmt::format("a process sees a contact of {} {} with {} that its owner does not",
                              kBodyName<D>, wanted.first, wanted.second);
      }
      answer.push_back(static_cast<double>(at - contacts.own.begin()));
    }
    buffer = std::move(answer);
  }
  group.fail_where_any(failure);
  buffers = group.deliver(std::move(buffers));
  std::vector<std::size_t> next(buffers.size(), 0);
  for (const int k : contacts.halo) {
    const int owner = local.owner[to_size(contacts.all[to_size(k)].i)];
    const std::size_t r = to_size(owner);
    contacts.copies.push_back({owner, static_cast<int>(buffers[r].at(next[r]++))});
  }
}

/// An error of detection in the numbers of the whole: two bodies in one place; else its own text.
template <int D>
std::string refusal(const LocalBodies<D>& local, const std::vector<Body<D>>& disks,
                    const std::string& said) {
  std::vector<int> order(disks.size());
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](int k) -> const Vec<D>& { return disks[to_size(k)].x; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::lexicographical_compare(place(a).begin(), place(a).end(), place(b).begin(),
                                        place(b).end());
  });
  for (std::size_t k = 1; k < order.size(); ++k) {
    if (place(order[k - 1]) != place(order[k])) continue;
    return fmt::format("{}s {} and {} have the same centre: their contact has no normal",
                       kBodyName<D>, local.numbers[to_size(order[k - 1])],
                       local.numbers[to_size(order[k])]);
  }
  return said + " (numbers among the bodies of one process)";
}

}  // namespace

template <int D>
LocalContacts<D> find_local_contacts(const Scene<D>& scene, const LocalBodies<D>& local,
                                     const Midpoint<D>& mid, int bodies, ProcessGroup& group) {
  std::vector<Contact<D>> found;
  std::string failure;
  try {
    found = detect_contacts<D>(mid.bodies, mid.walls, scene.contact_distance);
  } catch (const std::invalid_argument& e) {
    failure = refusal<D>(local, mid.bodies, e.what());
  }
  group.fail_where_any(failure);
  const std::vector<char> follow = bodies_to_follow(local, mid.bodies, group.rank(), found);
  LocalContacts<D> contacts;
  contacts.all.reserve(found.size());
  contacts.own.reserve(found.size());
  for (const Contact<D>& c : found) {
    const bool own = local.owner[to_size(c.i)] == group.rank();
    const bool needed =
        follow[to_size(c.i)] != 0 || (to_size(c.j) < follow.size() && follow[to_size(c.j)] != 0);
    if (!own && !needed) continue;
    (own ? contacts.owned : contacts.halo).push_back(static_cast<int>(contacts.all.size()));
    contacts.all.push_back(c);
    if (own) contacts.own.push_back(c);
  }
  release(found);
  number_contacts(local, bodies, group, contacts);
  find_places(local, bodies, group, contacts);
  return contacts;
}

template LocalContacts<2> find_local_contacts(const Scene<2>&, const LocalBodies<2>&,
                                              const Midpoint<2>&, int, ProcessGroup&);
template LocalContacts<3> find_local_contacts(const Scene<3>&, const LocalBodies<3>&,
                                              const Midpoint<3>&, int, ProcessGroup&);

}  // namespace bipot
