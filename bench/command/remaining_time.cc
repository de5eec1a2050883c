#include "bench/command/remaining_time.h"

#include <fmt/format.h>

#include <algorithm>

namespace bipot {

void RemainingTime::add(long done, double seconds) {
  constexpr long kMarks = 200;  // of the whole
  const Mark now{done, seconds};
  if (marks_.size() > 1 && done - marks_[marks_.size() - 2].done < std::max(total_ / kMarks, 1L)) {
    marks_.back() = now;
  } else if (done > marks_.back().done) {
    marks_.push_back(now);
  }
  while (marks_.size() > 3 && marks_[1].done <= done - total_ / 5) marks_.pop_front();
}

double RemainingTime::seconds() const {
  const Mark& first = marks_.front();
  const Mark& last = marks_.back();
  const Mark& middle = marks_[marks_.size() / 2];
  const auto left = static_cast<double>(total_ - last.done);
  const auto cost = [](const Mark& from, const Mark& to) {
    return (to.seconds - from.seconds) / static_cast<double>(std::max(to.done - from.done, 1L));
  };
  if (marks_.size() < 3) return left * cost(first, last);
  const double before = cost(first, middle), now = cost(middle, last);
  const double growth = 2 * (now - before) / static_cast<double>(last.done - first.done);
  const double latest = now + growth * static_cast<double>(last.done - middle.done) / 2;
  const double mean = cost(first, last);
  return left * std::clamp(latest + growth * left / 2, mean / 2, 2 * mean);
}

std::string about(double seconds) {
  if (seconds < 100) return fmt::format("about {:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("about {:.0f} min", seconds / 60);
  return fmt::format("about {:.0f} h", seconds / 3600);
}

}  // namespace bipot
