#include "core/files/scene_observables.h"

namespace bipot {
namespace {

int at_least_one(const SceneTable& table, std::string_view key, int fallback) {
  const int value = table.integer(key, fallback);
  if (value < 1) table.fail(key, fmt::format("expected a positive integer, got {}", value));
  return value;
}

void read_profile(const SceneTable& table, ObservableChoice& choice) {
  if (!table.has("profile")) {
    for (const char* key : {"profile_bins", "profile_range"}) {
      if (table.has(key)) table.fail(key, "belongs to a profile");
    }
    return;
  }
  ProfileChoice profile;
  profile.axis = table.one_of("profile", "y", {"x", "y"}) == "x" ? 0 : 1;
  profile.bins = at_least_one(table, "profile_bins", profile.bins);
  const std::vector<double> range = table.numbers("profile_range");
  if (range.size() != 2 || !(range[0] < range[1])) {
    table.fail("profile_range", "expected two numbers, the lower one first [m]");
  }
  profile.low = range[0];
  profile.high = range[1];
  choice.profile = profile;
}

void read_lines(const SceneTable& table, ObservableChoice& choice) {
  for (const SceneTable& line : table.tables("lines")) {
    FluxLine read;
    read.name = line.word("name", fmt::format("line{}", choice.lines.size()));
    const bool plain = std::all_of(read.name.begin(), read.name.end(), [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '_' || c == '-';
    });
    if (!plain || read.name.empty()) line.fail("name", "expected letters, digits, _ and - alone");
    for (const FluxLine& other : choice.lines) {
      if (other.name == read.name) line.fail("name", "names must differ");
    }
    const auto from = line.maybe_vec2("from"), to = line.maybe_vec2("to");
    if (!from || !to || *from == *to) line.fail("from", "give from and to, two different points");
    read.a = *from;
    read.b = *to;
    line.finish();
    choice.lines.push_back(read);
  }
}

}  // namespace

std::optional<ObservableChoice> read_observables_in_space(const SceneTable& root) {
  const auto table = root.table("observables");
  if (!table) return std::nullopt;
  ObservableChoice choice;
  choice.every = at_least_one(*table, "every", choice.every);
  choice.starts = table->number("starts", choice.starts);
  choice.force_bins = at_least_one(*table, "force_bins", choice.force_bins);
  if (table->has("force_limit")) choice.force_limit = table->positive("force_limit");
  table->finish();
  return choice;
}

std::optional<ObservableChoice> read_observables(const SceneTable& root) {
  const auto table = root.table("observables");
  if (!table) return std::nullopt;
  ObservableChoice choice;
  choice.every = at_least_one(*table, "every", choice.every);
  choice.starts = table->number("starts", choice.starts);
  if (const std::vector<double> window = table->numbers("window"); table->has("window")) {
    if (window.size() != 4 || !(window[0] < window[2]) || !(window[1] < window[3])) {
      table->fail("window", "expected [left, bottom, right, top] [m]");
    }
    choice.window = {Vec2(window[0], window[1]), Vec2(window[2], window[3])};
  }
  read_profile(*table, choice);
  read_lines(*table, choice);
  choice.force_bins = at_least_one(*table, "force_bins", choice.force_bins);
  if (table->has("force_limit")) choice.force_limit = table->positive("force_limit");
  table->finish();
  return choice;
}

}  // namespace bipot
