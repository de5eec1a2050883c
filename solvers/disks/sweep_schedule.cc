#include "solvers/disks/sweep_schedule.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <set>
#include <utility>

#include "core/base/types.h"

namespace bipot {
namespace {

/// Least part of the time of a team that is work.
constexpr double kLeastUse = 0.65;

/// The items sweep * tiles + tile, and which of them wait for which.
class Items {
 public:
  Items(const TileLinks& links, SweepSchedule::Sweeps sweeps) : links_(links), sweeps_(sweeps) {}

  int tiles() const { return links_.tiles; }
  int size() const { return links_.tiles * sweeps_.all(); }
  int sweep_of(int item) const { return item / links_.tiles; }
  int tile_of(int item) const { return item % links_.tiles; }

  /// Calls visit(other) for the items that this one waits for.
  template <class Visit>
  void for_predecessors(int item, const Visit& visit) const {
    const int sweep = sweep_of(item), tile = tile_of(item);
    const Lists<>& own = sweep < sweeps_.up ? links_.before : links_.after;
    for (const int t : own.of(tile)) visit(sweep * links_.tiles + t);
    if (sweep == 0) return;
    const Lists<>& previous = sweep - 1 < sweeps_.up ? links_.last : links_.first;
    for (const int t : previous.of(tile)) visit((sweep - 1) * links_.tiles + t);
  }

  /// The order for one thread: the latest sweep whose next tile waits for nothing goes on.
  std::vector<int> order() const {
    std::vector<int> order;
    order.reserve(to_size(size()));
    follow(0, sweeps_.up, order);
    follow(sweeps_.up, sweeps_.all(), order);
    return order;
  }

 private:
  /// The sweeps [first, end), all of one direction.
  void follow(int first, int end, std::vector<int>& order) const {
    const bool up = first < sweeps_.up;
    const auto tile_at = [&](int place) { return up ? place : links_.tiles - 1 - place; };
    // Number of places that a sweep must have done before the next one may do a place.
    std::vector<int> ready;
    for (int place = 0; place < links_.tiles; ++place) {
      int most = place + 1;
      for (const int t : (up ? links_.last : links_.first).of(tile_at(place))) {
        most = std::max(most, tile_at(t) + 1);
      }
      ready.push_back(most);
    }
    std::vector<int> done(to_size(end - first), 0);
    for (int left = links_.tiles * (end - first); left > 0; --left) {
      int sweep = end - first - 1;
      const auto waits = [&] {
        const int place = done[to_size(sweep)];
        if (place == links_.tiles) return true;
        return sweep > 0 && done[to_size(sweep) - 1] < ready[to_size(place)];
      };
      while (waits()) --sweep;
      order.push_back((first + sweep) * links_.tiles + tile_at(done[to_size(sweep)]++));
    }
  }

  const TileLinks& links_;
  SweepSchedule::Sweeps sweeps_;
};

/// The thread and the place in its plan of each item, as if all took the time of their work.
struct Deal {
  std::vector<std::vector<int>> items;  // of each thread
  std::vector<int> thread, place;       // of each item
  double time = 0;
};

Deal deal(const Items& items, const std::vector<int>& order, const std::vector<int>& work,
          int threads) {
  const int size = items.size();
  std::vector<int> rank(to_size(size)), missing(to_size(size), 0);
  std::vector<std::vector<int>> successors(to_size(size));
  for (int k = 0; k < size; ++k) rank[to_size(order[to_size(k)])] = k;
  for (int item = 0; item < size; ++item) {
    items.for_predecessors(item, [&](int other) {
      ++missing[to_size(item)];
      successors[to_size(other)].push_back(item);
    });
  }
  // Ranks of the items that wait for nothing: those of the tiles that each thread had last, and of
  // tiles that no thread had yet.
  std::vector<std::set<int>> ready(to_size(threads) + 1);
  std::set<int>& fresh = ready.back();
  std::vector<int> latest(to_size(items.tiles()), threads);  // the thread that had a tile last
  const auto add = [&](int item) {
    ready[to_size(latest[to_size(items.tile_of(item))])].insert(rank[to_size(item)]);
  };
  for (int item = 0; item < size; ++item) {
    if (missing[to_size(item)] == 0) add(item);
  }
  Deal out{std::vector<std::vector<int>>(to_size(threads)), rank, rank};
  // The rank of the next item of a thread, `size` if all wait.
  const auto next_of = [&](int thread) {
    if (!ready[to_size(thread)].empty()) return *ready[to_size(thread)].begin();
    int next = size;
    if (const std::vector<int>& mine = out.items[to_size(thread)]; !mine.empty()) {
      for (const int item : successors[to_size(mine.back())]) {
        const int at = rank[to_size(item)];
        if (fresh.count(at) > 0) next = std::min(next, at);
      }
    }
    if (next < size) return next;
    if (!fresh.empty()) return *fresh.begin();
    for (const std::set<int>& of : ready) {
      if (!of.empty()) next = std::min(next, *of.begin());
    }
    return next;
  };
  using End = std::pair<double, int>;  // of the item of a thread
  std::priority_queue<End, std::vector<End>, std::greater<>> busy;
  std::vector<int> idle(to_size(threads));
  std::iota(idle.rbegin(), idle.rend(), 0);
  while (true) {
    while (!idle.empty()) {
      const int thread = idle.back(), next = next_of(thread);
      if (next == size) break;
      const int item = order[to_size(next)];
      int& before = latest[to_size(items.tile_of(item))];
      ready[to_size(before)].erase(next);
      before = thread;
      idle.pop_back();
      std::vector<int>& mine = out.items[to_size(thread)];
      out.thread[to_size(item)] = thread;
      out.place[to_size(item)] = static_cast<int>(mine.size());
      mine.push_back(item);
      busy.emplace(out.time + work[to_size(items.tile_of(item))], thread);
    }
    if (busy.empty()) return out;
    const auto [time, thread] = busy.top();
    busy.pop();
    out.time = time;
    idle.push_back(thread);
    for (const int item : successors[to_size(out.items[to_size(thread)].back())]) {
      if (--missing[to_size(item)] == 0) add(item);
    }
  }
}

}  // namespace

SweepSchedule::SweepSchedule(const TileLinks& links, const std::vector<int>& work, Sweeps sweeps,
                             int threads)
    : tiles_(links.tiles), order_(Items(links, sweeps).order()), plans_(1) {
  const Items items(links, sweeps);
  const double alone = 1.0 * sweeps.all() * std::accumulate(work.begin(), work.end(), 0.0);
  while (threads > 1) {
    const Deal dealt = deal(items, order_, work, threads);
    gain_ = alone / dealt.time;
    if (gain_ < kLeastUse * threads) {
      threads = static_cast<int>(gain_ / kLeastUse);
      continue;
    }
    plans_ = std::vector<Plan>(to_size(threads));
    for (int thread = 0; thread < threads; ++thread) {
      Plan& plan = plans_[to_size(thread)];
      plan.items = dealt.items[to_size(thread)];
      std::vector<int> known(to_size(threads), 0);  // counts that were waited for
      for (const int item : plan.items) {
        items.for_predecessors(item, [&](int other) {
          const int of = dealt.thread[to_size(other)], count = dealt.place[to_size(other)] + 1;
          if (of == thread || count <= known[to_size(of)]) return;
          known[to_size(of)] = count;
          plan.waits.push_back({of, count});
        });
        plan.end_of_waits.push_back(static_cast<int>(plan.waits.size()));
      }
    }
    break;
  }
  if (threads == 1) gain_ = 1;
  progress_ = std::vector<Progress>(to_size(threads));
}

}  // namespace bipot
