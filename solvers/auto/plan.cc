#include "solvers/auto/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "core/base/file_error.h"
#include "core/base/nearest_name.h"
#include "core/base/number_text.h"
#include "solvers/auto/plan_text.h"
#include "solvers/parameters.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

constexpr struct {
  std::string_view name;
  PlanMark mark;
} kMarks[] = {{"warm", kWarm},
              {"cold", kCold},
              {"disks", kDisks},
              {"no_disks", kNoDisks},
              {"vectors", kVectors},
              {"no_vectors", kNoVectors},
              {"unequal", kUnequal},
              {"bodies", kBodies},
              {"w_alone", kWAlone},
              {"plane", kInPlane},
              {"space", kInSpace},
              {"parallel", kInParallel},
              {"any_forces", kAnyForces},
              {"close_packed", kClosePacked}};

constexpr std::string_view kStarts[] = {"own", "caller", "last", "best"};
constexpr const char* kStartsExpected =
    "from: expected own, caller, last or best, or a factor and one of them, as \"0.98 last\", or "
    "a list of such";

using Names = std::vector<std::string>;

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  return {std::istream_iterator<std::string>(stream), {}};
}

/// Reads a plan, with the line of each fault.
class PlanReader {
 public:
  PlanReader(std::string_view text, const std::string& source) : text_(text) {
    plan_.source = source;
  }

  AutoPlan read() {
    toml::table root;
    try {
      root = toml::parse(text_, plan_.source);
    } catch (const toml::parse_error& e) {
      fail(e.source().begin.line, std::string(e.description()));
    }
    check_keys(root, {"why", "list", "class"});
    if (const toml::table* why = table_of(root, "why")) {
      for (const auto& [name, node] : *why) why_[std::string(name)] = text_of(node);
    }
    if (const toml::table* lists = table_of(root, "list")) {
      for (const auto& [name, node] : *lists) {
        list_names_.emplace_back(name);
        if (!node.is_table()) fail(node, "expected [list.NAME]");
      }
      if (lists->contains(kShippedList)) {
        fail(*lists->get(kShippedList), "the list 'shipped' is that of the program");
      }
      for (const auto& [name, node] : *lists) {
        check_keys(*node.as_table(), {"stages"});
        plan_.lists[std::string(name)] = rows_of(*node.as_table());
      }
    }
    const toml::node* classes = root.get("class");
    if (classes == nullptr || !classes->is_array_of_tables()) {
      fail(classes == nullptr ? 1 : classes->source().begin.line, "expected a [[class]]");
    }
    for (const toml::node& node : *classes->as_array()) add_class(*node.as_table());
    for (const AutoPlan::Class& of : plan_.classes) check_depth(of.rows, of.name, 0);
    return std::move(plan_);
  }

 private:
  using Line = decltype(toml::source_position::line);

  [[noreturn]] void fail(Line line, const std::string& reason) const {
    throw std::invalid_argument(fmt::format("{}:{}: {}", plan_.source, line, reason));
  }
  [[noreturn]] void fail(const toml::node& node, const std::string& reason) const {
    fail(node.source().begin.line, reason);
  }

  void check_keys(const toml::table& table, const Names& valid) const {
    for (const auto& [key, node] : table) {
      if (std::find(valid.begin(), valid.end(), key.str()) == valid.end()) {
        fail(node, unknown_name_message("key", key.str(), valid));
      }
    }
  }
  const toml::table* table_of(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (node != nullptr && !node->is_table()) fail(*node, fmt::format("{}: expected a table", key));
    return node == nullptr ? nullptr : node->as_table();
  }
  std::string text_of(const toml::node& node) const {
    const auto text = node.value_exact<std::string>();
    if (!text) fail(node, "expected a text");
    return *text;
  }
  std::string text_at(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    return node == nullptr ? std::string() : text_of(*node);
  }
  double number_of(const toml::node& node, double least) const {
    const auto number = node.value<double>();
    if (!node.is_number() || !number || !(*number >= least)) {
      fail(node, fmt::format("expected a number, at least {:g}", least));
    }
    return *number;
  }
  double number_at(const toml::table& table, std::string_view key, double least,
                   double fallback) const {
    const toml::node* node = table.get(key);
    return node == nullptr ? fallback : number_of(*node, least);
  }
  int integer_at(const toml::table& table, std::string_view key, int least, int fallback) const {
    const double number = number_at(table, key, least, fallback);
    if (number != std::floor(number) || number > 1e9) fail(*table.get(key), "expected an integer");
    return static_cast<int>(number);
  }
  /// Two numbers; the first is smaller.
  void range_at(const toml::table& table, std::string_view key, double& from, double& to) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return;
    const toml::array* pair = node->as_array();
    if (pair == nullptr || pair->size() != 2) {
      fail(*node, fmt::format("{}: expected two numbers, as [0, inf]", key));
    }
    from = number_of(*pair->get(0), -1);
    to = number_of(*pair->get(1), -1);
    if (!(from < to)) fail(*node, fmt::format("{}: the first number must be smaller", key));
  }

  /// N, or [factor, power], or [factor, power, least].
  AutoPlan::Row::Count count_at(const toml::table& table, std::string_view key,
                                AutoPlan::Row::Count fallback) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return fallback;
    if (!node->is_array()) return {number_of(*node, 0), 0, 0};
    const toml::array& parts = *node->as_array();
    if (parts.size() != 2 && parts.size() != 3) {
      fail(*node, fmt::format("{}: expected [factor, power] or [factor, power, least]", key));
    }
    return {number_of(*parts.get(0), 0), number_of(*parts.get(1), 0),
            parts.size() == 3 ? number_of(*parts.get(2), 0) : 0};
  }

  PlanConditions conditions_of(const toml::table& table) const {
    PlanConditions made;
    range_at(table, "contacts", made.above, made.up_to);
    range_at(table, "tol", made.tol_from, made.tol_below);
    try {
      made.marks = marks_of_words(text_at(table, "when"));
    } catch (const std::invalid_argument& e) {
      fail(*table.get("when"), e.what());
    }
    return made;
  }

  std::vector<AutoPlan::Row> rows_of(const toml::table& table) const {
    const toml::node* stages = table.get("stages");
    if (stages == nullptr || !stages->is_array()) fail(table, "expected stages = [...]");
    std::vector<AutoPlan::Row> rows;
    for (const toml::node& node : *stages->as_array()) {
      if (!node.is_table()) fail(node, "expected a stage, as {solver = \"pgs\", most = 500}");
      add_rows(*node.as_table(), rows);
    }
    return rows;
  }

  /// One row for each start, and after each the list `then`. Multiples of the caller's start differ
  /// if that is warm.
  void add_rows(const toml::table& table, std::vector<AutoPlan::Row>& rows) const {
    const AutoPlan::Row row = row_of(table);
    const toml::array* starts = table.get_as<toml::array>("from");
    const std::size_t count = starts == nullptr ? 1 : starts->size();
    if (count == 0) fail(*starts, kStartsExpected);
    for (std::size_t k = 0; k < count; ++k) {
      rows.push_back(row);
      if (const toml::node* from = starts == nullptr ? table.get("from") : starts->get(k)) {
        set_start(*from, rows.back());
      }
      if (k > 0 && rows.back().start == AutoPlan::Row::Start::kCaller) {
        rows.back().conditions.marks |= kWarm;
      }
      if (!table.contains("then")) continue;
      AutoPlan::Row list;
      list.conditions = rows.back().conditions;
      list.list = list_at(table, "then");
      rows.push_back(std::move(list));
    }
  }

  std::string list_at(const toml::table& table, std::string_view key) const {
    std::string name = text_at(table, key);
    const bool known = std::find(list_names_.begin(), list_names_.end(), name) != list_names_.end();
    if (!known && name != kShippedList) {
      Names known_names = list_names_;
      known_names.emplace_back(kShippedList);
      fail(*table.get(key), unknown_name_message("list", name, known_names));
    }
    return name;
  }

  AutoPlan::Row row_of(const toml::table& table) const {
    AutoPlan::Row row;
    row.conditions = conditions_of(table);
    if (table.contains("list")) {
      check_keys(table, {"list", "repeat", "growth", "contacts", "tol", "when"});
      row.list = list_at(table, "list");
      row.repeat = integer_at(table, "repeat", 1, 1);
      row.growth = number_at(table, "growth", 1, 1);
      return row;
    }
    check_keys(table, {"solver", "with", "from", "then", "least", "most", "near", "contacts", "tol",
                       "when", "error", "whole", "why"});
    set_solver(table, row);
    row.most = count_at(table, "most", {kInfinity, 0, 0});
    row.least = count_at(table, "least", row.most);
    row.near = count_at(table, "near", row.most);
    row.largest_error = number_at(table, "error", 0, kInfinity);
    const std::string whole = text_at(table, "whole");
    if (!whole.empty() && whole != "first" && whole != "only") {
      fail(*table.get("whole"), "whole: expected first or only");
    }
    row.before_cutting = !whole.empty();
    row.on_whole_only = whole == "only";
    const std::string why = text_at(table, "why");
    const auto reason = why_.find(why);
    row.reason = reason == why_.end() ? why : reason->second;
    return row;
  }

  void set_solver(const toml::table& table, AutoPlan::Row& row) const {
    row.solver = text_at(table, "solver");
    if (row.solver.empty()) fail(table, "a stage needs a solver or a list");
    row.parameters = text_at(table, "with");
    const SolverEntry* entry = find_solver(row.solver);
    if (entry == nullptr && row.solver != "newton") {  // which not every build has
      fail(*table.get("solver"), unknown_solver_message(row.solver));
    }
    if (row.solver == "auto") fail(*table.get("solver"), "a stage of auto cannot be auto");
    if (entry == nullptr) return;
    try {
      Parameters(stage_parameters(row.parameters), entry->parameters);
    } catch (const std::invalid_argument& e) {
      fail(*table.get("with"), e.what());
    }
  }

  void set_start(const toml::node& from, AutoPlan::Row& row) const {
    const Names words = words_of(text_of(from));
    const std::string name = words.empty() ? "" : words.back();
    const auto* start = std::find(std::begin(kStarts), std::end(kStarts), name);
    bool number = true;
    if (words.size() == 2) {
      row.of_start = whole_number<double>(words[0]).value_or(kNaN);
      number = std::isfinite(row.of_start);
    }
    if (start == std::end(kStarts) || words.size() > 2 || !number) {
      fail(from, kStartsExpected);
    }
    row.start = static_cast<AutoPlan::Row::Start>(start - std::begin(kStarts));
  }

  void add_class(const toml::table& table) {
    check_keys(table, {"name", "contacts", "tol", "when", "solved", "stages"});
    AutoPlan::Class made;
    made.name = text_at(table, "name");
    if (made.name.empty()) fail(table, "a class needs a name");
    made.conditions = conditions_of(table);
    double solved = 0, measured = 0;
    if (const toml::node* odds = table.get("solved")) {
      const toml::array* pair = odds->as_array();
      if (pair == nullptr || pair->size() != 2) fail(*odds, "solved: expected [solved, measured]");
      solved = number_of(*pair->get(0), 0);
      measured = number_of(*pair->get(1), solved);
    }
    made.solved = static_cast<int>(std::min(solved, 1e9));
    made.measured = static_cast<int>(std::min(measured, 1e9));
    made.rows = rows_of(table);
    plan_.classes.push_back(std::move(made));
  }

  /// Refuses lists that name each other in a circle.
  void check_depth(const std::vector<AutoPlan::Row>& rows, const std::string& name,
                   int depth) const {
    if (depth > 8) {
      throw std::invalid_argument(
          fmt::format("{}: lists within lists without end, in '{}'", plan_.source, name));
    }
    for (const AutoPlan::Row& row : rows) {
      const auto list = plan_.lists.find(row.list);
      if (list != plan_.lists.end()) check_depth(list->second, row.list, depth + 1);
    }
  }

  std::string_view text_;
  AutoPlan plan_;
  Names list_names_;
  std::map<std::string, std::string> why_;
};

}  // namespace

int AutoPlan::Row::Count::of(int contacts, double times) const {
  const double count = times * std::max(least, factor * std::pow(contacts, power));
  return static_cast<int>(std::min<double>(count, std::numeric_limits<int>::max()));
}

std::string mark_words(unsigned marks) {
  Names words;
  for (const auto& mark : kMarks) {
    if (marks & mark.mark) words.emplace_back(mark.name);
  }
  return fmt::format("{}", fmt::join(words, " "));
}

unsigned marks_of_words(std::string_view words) {
  unsigned marks = 0;
  for (const std::string& word : words_of(words)) {
    marks |= find_named("property", word, kMarks).mark;
  }
  return marks;
}

std::string PlanConditions::to_text() const {
  Names parts;
  if (above >= 0) parts.push_back(fmt::format("N > {:g}", above));
  if (up_to < kInfinity) parts.push_back(fmt::format("N <= {:g}", up_to));
  if (tol_from > 0) parts.push_back("tol >= " + tolerance_label(tol_from));
  if (tol_below < kInfinity) parts.push_back("tol < " + tolerance_label(tol_below));
  if (marks != 0) parts.push_back(mark_words(marks));
  return fmt::format("{}", fmt::join(parts, ", "));
}

const AutoPlan::Class* AutoPlan::class_of(const ProblemTraits& problem) const {
  const auto found = std::find_if(classes.begin(), classes.end(),
                                  [&](const Class& of) { return of.conditions.hold(problem); });
  return found == classes.end() ? nullptr : &*found;
}

std::map<std::string, std::string> stage_parameters(std::string_view text) {
  std::map<std::string, std::string> parameters;
  for (const std::string& word : words_of(text)) {
    const std::size_t equals = word.find('=');
    parameters[word.substr(0, equals)] =
        equals == std::string::npos ? std::string() : word.substr(equals + 1);
  }
  return parameters;
}

AutoPlan parse_plan(std::string_view text, const std::string& source) {
  return PlanReader(text, source).read();
}

std::shared_ptr<const AutoPlan> read_plan(const std::filesystem::path& path) {
  std::ifstream file;
  std::error_code none;
  if (std::filesystem::is_regular_file(path, none)) file.open(path, std::ios::binary);  // no pipes
  std::ostringstream text;
  text << file.rdbuf();
  if (!file.is_open() || !file) throw FileError(path, "", "cannot be read");
  return std::make_shared<AutoPlan>(parse_plan(text.str(), path.string()));
}

std::shared_ptr<const AutoPlan> named_plan(const std::map<std::string, std::string>& parameters) {
  const auto named = parameters.find("plan");
  if (named == parameters.end() || named->second.empty()) return nullptr;
  return read_plan(named->second);
}

const AutoPlan& shipped_plan() {
  static const AutoPlan plan = parse_plan(shipped_plan_text(), "solvers/auto/plan.toml");
  return plan;
}

}  // namespace bipot
