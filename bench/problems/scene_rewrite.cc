#include "bench/problems/scene_rewrite.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

/// TOML counts columns in characters, strings in bytes.
std::size_t byte_of(const std::string& line, std::size_t column) {
  std::size_t byte = 0;
  for (std::size_t characters = 1; characters < column && byte < line.size(); ++characters) {
    ++byte;
    while (byte < line.size() && (static_cast<unsigned char>(line[byte]) & 0xC0) == 0x80) ++byte;
  }
  return byte;
}

std::string indent_of(const std::string& line) {
  return line.substr(0, std::min(line.find_first_not_of(" \t"), line.size()));
}

std::string quoted(const std::string& text) { return '"' + text + '"'; }  // names have no quotes

std::string parameters_text(const std::map<std::string, std::string>& parameters) {
  std::string text = "{";
  for (const auto& [name, value] : parameters) {
    text += fmt::format("{} {} = {}", text.size() > 1 ? "," : "", name, quoted(value));
  }
  return text + (parameters.empty() ? "}" : " }");
}

/// A key of a table with its new value.
struct Edit {
  const char *table, *key;
  std::string value;
  bool only_if_present = false;
};

/// A text by lines, edited from the bottom up so that positions stay valid.
class Editor {
 public:
  Editor(const std::string& text, std::string comment) : comment_(std::move(comment)) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }

  void apply(const Edit& edit) {
    // Parsed again each time: positions move.
    const toml::table root = toml::parse(text());
    const toml::table* table = root[edit.table].as_table();
    const toml::node* node = table != nullptr ? table->get(edit.key) : nullptr;
    if (node != nullptr) return replace(edit, *node);
    if (edit.only_if_present) return;
    if (table == nullptr) return append_table(edit);
    insert(edit, *table);
  }

  std::string text() const { return fmt::format("{}\n", fmt::join(lines_, "\n")); }

 private:
  [[noreturn]] static void give_up(const Edit& edit, std::size_t line) {
    throw std::runtime_error(fmt::format(
        "line {}: [{}] {} is laid out in a way that cannot be rewritten; write it on one line",
        line, edit.table, edit.key));
  }

  /// Counted from 1, as TOML does.
  std::string& at(std::size_t line) { return lines_.at(line - 1); }
  void insert_below(std::size_t line, const std::string& text) {
    lines_.insert(lines_.begin() + static_cast<std::ptrdiff_t>(line), text);
  }

  /// Writes the former text of a line as a comment above it.
  void comment(std::size_t line, const std::string& was) {
    insert_below(line - 1, fmt::format("{}# {}; {}", indent_of(at(line)), comment_, was));
  }

  void replace(const Edit& edit, const toml::node& node) {
    const toml::source_region& place = node.source();
    const bool sub_table = node.is_table() && !node.as_table()->is_inline();
    if (place.begin.line != place.end.line || sub_table) give_up(edit, place.begin.line);
    std::string& line = at(place.begin.line);
    const std::size_t begin = byte_of(line, place.begin.column);
    const std::size_t end = byte_of(line, place.end.column);
    const std::string old = line.substr(begin, end - begin);
    if (old == edit.value) return;
    line.replace(begin, end - begin, edit.value);
    comment(place.begin.line, fmt::format("{} was {}", edit.key, old));
  }

  /// Inserts beside the table's other keys, with the same prefix ("solver." or none) and
  /// indentation.
  void insert(const Edit& edit, const toml::table& table) {
    if (table.is_inline()) {
      const toml::source_region& place = table.source();
      std::string& line = at(place.begin.line);
      const std::size_t brace = byte_of(line, place.begin.column);
      if (place.begin.line != place.end.line || brace >= line.size() || line[brace] != '{') {
        give_up(edit, place.begin.line);
      }
      line.insert(brace + 1,
                  fmt::format(" {} = {}{}", edit.key, edit.value, table.empty() ? " " : ","));
      comment(place.begin.line, fmt::format("{} was not set", edit.key));
      return;
    }
    const toml::node* last = nullptr;
    std::string last_key;
    for (const auto& [key, node] : table) {
      if (node.is_table() && !node.as_table()->is_inline()) continue;
      if (last == nullptr || node.source().begin.line > last->source().begin.line) {
        last = &node;
        last_key = key.str();
      }
    }
    if (last == nullptr) {  // an empty [table]
      insert_below(table.source().begin.line, fmt::format("{} = {}", edit.key, edit.value));
      comment(table.source().begin.line + 1, fmt::format("{} was not set", edit.key));
      return;
    }
    const std::size_t line = last->source().begin.line, below = last->source().end.line;
    const std::string& text = at(line);
    const std::size_t key = text.find(last_key);
    if (key == std::string::npos || key > text.find('=')) give_up(edit, line);
    insert_below(below, fmt::format("{}{} = {}", text.substr(0, key), edit.key, edit.value));
    comment(below + 1, fmt::format("{} was not set", edit.key));
  }

  void append_table(const Edit& edit) {
    lines_.insert(lines_.end(), {"", fmt::format("[{}]", edit.table),
                                 fmt::format("{} = {}", edit.key, edit.value)});
    comment(lines_.size(), fmt::format("{} was not set", edit.key));
  }

  std::vector<std::string> lines_;
  std::string comment_;
};

/// Empty if the scenes differ in time and solver only, else the difference.
template <int D>
std::string difference(const Scene<D>& a, const Scene<D>& b) {
  if (a.title != b.title) return "title";
  if (a.model != b.model) return "model";
  if (a.gravity != b.gravity || a.tilt != b.tilt) return "gravity";
  if (a.cell != b.cell) return "cell";
  if (a.contact_distance != b.contact_distance) return "contact distance";
  if (a.travel != b.travel) return "travel";
  if (a.accuracy != b.accuracy) return "accuracy";
  if (a.project_overlaps != b.project_overlaps || a.predict_gaps != b.predict_gaps) {
    return "overlaps";
  }
  if (a.impact != b.impact) return "law of impact";
  if (a.materials != b.materials) return "materials";
  if (a.laws != b.laws) return "contact laws";
  if (a.bodies != b.bodies) return "bodies";
  if (!std::ranges::equal(a.walls, b.walls, [](Wall<D> x, const Wall<D>& y) {
        x.mesh = y.mesh;  // each reading has its own
        return x == y;
      })) {
    return "walls";
  }
  if (a.outlets.size() != b.outlets.size() || a.inlets.size() != b.inlets.size()) return "gates";
  if (a.output != b.output) return "output";
  return {};
}

template <int D>
std::string rewritten(const Scene<D>& before, const std::string& text, const std::string& source,
                      const SceneChanges& changes) {
  Editor editor(text, changes.comment);
  if (changes.step != before.step) {
    editor.apply({"time", "step", fmt::format("{}", changes.step)});
    editor.apply({"time", "steps", fmt::format("{}", changes.num_steps), true});
  }
  if (changes.accuracy > 0 && changes.accuracy != before.accuracy) {
    editor.apply({"time", "accuracy", fmt::format("{:.2g}", changes.accuracy)});
  }
  if (changes.solver != before.solver.name) {
    editor.apply({"solver", "name", quoted(changes.solver)});
  }
  if (changes.tol != before.solver.tol) {
    editor.apply({"solver", "tol", fmt::format("{}", changes.tol)});
  }
  if (changes.warm_start != before.solver.warm_start) {
    editor.apply({"solver", "warm_start", changes.warm_start ? "true" : "false"});
  }
  if (before.solver.stop != "guarded") editor.apply({"solver", "stop", quoted("guarded")});
  if (changes.parameters != before.solver.parameters) {
    if (!changes.parameters.contains("plan")) editor.apply({"solver", "plan", quoted(""), true});
    editor.apply(
        {"solver", "parameters", parameters_text(changes.parameters), changes.parameters.empty()});
  }

  const auto after = std::get<Scene<D>>(parse_any_scene(editor.text(), source));
  const SolverChoice& s = after.solver;
  Scene<D> wanted = before;
  if (changes.accuracy > 0) {
    wanted.accuracy = after.accuracy;
    wanted.contact_distance = after.contact_distance;  // it follows
  }
  if (const std::string what = difference(wanted, after); !what.empty()) {
    throw std::runtime_error(fmt::format("{}: rewriting would change the {}", source, what));
  }
  if (after.step != changes.step || s.name != changes.solver || s.tol != changes.tol ||
      s.warm_start != changes.warm_start || s.parameters != changes.parameters ||
      s.stop != "guarded" || s.max_iterations != before.solver.max_iterations) {
    throw std::runtime_error(source + ": the scene could not be rewritten");
  }
  return editor.text();
}

}  // namespace

std::string rewrite_scene(const std::string& text, const std::string& source,
                          const SceneChanges& changes) {
  return std::visit([&](const auto& before) { return rewritten(before, text, source, changes); },
                    parse_any_scene(text, source));
}

}  // namespace bipot
