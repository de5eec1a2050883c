#include "bench/command/progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench/command/say.h"
#include "bench/report/text_lines.h"
#include "core/base/printable_text.h"
#include "core/base/types.h"

namespace bipot {
namespace {

int terminal_columns() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

}  // namespace

std::string progress_line(long done, long total, double seconds_left, const std::string& note,
                          int columns) {
  const long width = columns < 70 ? 8 : 24;
  const long filled = width * done / total;
  const std::string line =
      fmt::format("[{}{}] {} %  {}{}", std::string(static_cast<std::size_t>(filled), '#'),
                  std::string(static_cast<std::size_t>(width - filled), '.'), 100 * done / total,
                  std::isnan(seconds_left) ? "" : about(seconds_left) + "  ", printable(note));
  return first_characters(line, static_cast<std::size_t>(std::max(columns - 1, 1)));
}

ProgressBar::ProgressBar(long total, bool quiet)
    : total_(std::max(total, 1L)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      remaining_(total_) {}

ProgressBar::~ProgressBar() {
  if (!quiet_ && terminal_) bipot::say("\r\033[K");
}

void ProgressBar::update(long done, const std::string& note) {
  if (quiet_) return;
  const double elapsed = watch_.seconds();
  remaining_.add(done, elapsed);
  if (terminal_) {
    if (elapsed - drawn_ < 0.1 && done < total_) return;
    drawn_ = elapsed;
    bipot::say("\r\033[K{}", progress_line(done, total_, done > 0 ? remaining_.seconds() : kNaN,
                                           note, terminal_columns()));
  } else {
    const long tenths = 10 * done / total_;
    if (tenths <= tenths_ || elapsed < 1) return;
    tenths_ = tenths;
    bipot::say("{:3} %  {} left  {}\n", 10 * tenths, about(remaining_.seconds()), printable(note));
  }
  std::fflush(stderr);
}

void ProgressBar::say(const std::string& lines) {
  if (!quiet_) bipot::say("{}{}", terminal_ ? "\r\033[K" : "", lines);
}

void ProgressBar::RemainingTime::add(long done, double seconds) {
  constexpr long kMarks = 200;  // of the whole
  const Mark now{done, seconds};
  if (marks_.size() > 1 && done - marks_[marks_.size() - 2].done < std::max(total_ / kMarks, 1L)) {
    marks_.back() = now;
  } else if (done > marks_.back().done) {
    marks_.push_back(now);
  }
  while (marks_.size() > 3 && marks_[1].done <= done - total_ / 5) marks_.pop_front();
}

double ProgressBar::RemainingTime::seconds() const {
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
