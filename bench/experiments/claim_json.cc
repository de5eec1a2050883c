#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/experiments/claim_report.h"
#include "core/base/file_error.h"
#include "core/files/input_file.h"

namespace bipot {

NLOHMANN_JSON_SERIALIZE_ENUM(Chart::Axis::Kind, {{Chart::Axis::Kind::kLinear, "linear"},
                                                 {Chart::Axis::Kind::kLog, "log"},
                                                 {Chart::Axis::Kind::kLogSeconds, "log seconds"}})
NLOHMANN_JSON_SERIALIZE_ENUM(Chart::Series::Kind,
                             {{Chart::Series::Kind::kLinePoints, "line and points"},
                              {Chart::Series::Kind::kLine, "line"},
                              {Chart::Series::Kind::kPoints, "points"},
                              {Chart::Series::Kind::kSteps, "steps"}})
NLOHMANN_JSON_SERIALIZE_ENUM(Chart::Key, {{Chart::Key::kBelow, "below"},
                                          {Chart::Key::kRight, "right"},
                                          {Chart::Key::kNone, "none"}})
NLOHMANN_JSON_SERIALIZE_ENUM(ClaimReport::Item::Status,
                             {{ClaimReport::Item::Status::kNotRun, "not run"},
                              {ClaimReport::Item::Status::kDone, "done"},
                              {ClaimReport::Item::Status::kFailed, "failed"},
                              {ClaimReport::Item::Status::kInterrupted, "interrupted"}})

namespace {

/// Writes the fields of a value to an object, or reads them. Each type is described once, by fields().
class FieldVisitor {
 public:
  FieldVisitor(Json& json, bool reads) : json_(json), reads_(reads) {}
  bool reads() const { return reads_; }

  template <class T>
  void operator()(const char* key, T& value) {
    pass(reads_ ? json_.at(key) : json_[key], value);
  }
  /// Omitted if there is none.
  template <class T>
  void maybe(const char* key, T& value) {
    if (reads_ ? json_.contains(key) : !is_none(value)) (*this)(key, value);
  }
  void object(const char* key, const auto& visit_inside) {
    FieldVisitor inside(json_[key], reads_);
    visit_inside(inside);
  }

 private:
  template <class T>
  static bool is_none(const T& value) {
    if constexpr (requires { value.empty(); }) {
      return value.empty();
    } else if constexpr (requires { value.has_value(); }) {
      return !value.has_value();
    } else {
      return value == T();
    }
  }
  template <class T>
  void pass(Json& json, T& value) const {
    if constexpr (requires(FieldVisitor & v) { fields(v, value); }) {
      FieldVisitor inside(json, reads_);
      fields(inside, value);
    } else if (reads_) {
      value = json.get<T>();
    } else {
      json = value;
    }
  }
  void pass(Json& json, double& value) const {
    if (reads_) {
      value = number_or_nan(json);
    } else {
      json = value;
    }
  }
  template <class T>
  void pass(Json& json, std::vector<T>& values) const {
    if (reads_) {
      values.resize(json.size());
    } else {
      json = std::vector<Json>(values.size());
    }
    for (std::size_t k = 0; k < values.size(); ++k) pass(json[k], values[k]);
  }
  template <class T>
  void pass(Json& json, std::optional<T>& value) const {
    if (reads_ && !json.is_null()) value.emplace();
    if (value) pass(json, *value);
  }

  Json& json_;
  const bool reads_;
};

/// The points of a series, by columns. Throws std::out_of_range if those read do not match.
void point_columns(FieldVisitor& field, std::vector<Chart::Point>& points) {
  std::vector<double> x, y, low, high;
  std::vector<std::size_t> hollow, bare;
  std::vector<std::string> notes;
  const auto any = [&points](const auto& has) { return std::ranges::any_of(points, has); };
  const bool bars =
      any([](const Chart::Point& p) { return std::isfinite(p.y_low) || std::isfinite(p.y_high); });
  const bool noted = any([](const Chart::Point& p) { return !p.note.empty(); });
  for (const Chart::Point& p : points) {
    if (p.hollow) hollow.push_back(x.size());
    if (!p.marked) bare.push_back(x.size());
    x.push_back(p.x);
    y.push_back(p.y);
    if (bars) low.push_back(p.y_low);
    if (bars) high.push_back(p.y_high);
    if (noted) notes.push_back(p.note);
  }
  field("x", x);
  field("y", y);
  field.maybe("hollow", hollow);
  field.maybe("unmarked", bare);
  field.maybe("notes", notes);
  field.maybe("y_low", low);
  field.maybe("y_high", high);
  if (!field.reads()) return;
  for (std::size_t i = 0; i < x.size(); ++i) {
    Chart::Point& p = points.emplace_back(Chart::Point{x[i], y.at(i)});
    if (!notes.empty()) p.note = notes.at(i);
    if (!low.empty()) p.y_low = low.at(i);
    if (!high.empty()) p.y_high = high.at(i);
  }
  for (const std::size_t i : hollow) points.at(i).hollow = true;
  for (const std::size_t i : bare) points.at(i).marked = false;
}

void fields(FieldVisitor& field, Chart::Series& s) {
  field("name", s.name);
  field("style", s.style);
  field("kind", s.kind);
  point_columns(field, s.points);
}

void fields(FieldVisitor& field, Chart::Line& l) {
  field("at", l.at);
  field("label", l.label);
}

void fields(FieldVisitor& field, Chart::Axis& a) {
  field("label", a.label);
  field("scale", a.kind);
  field.maybe("low", a.low);
  field.maybe("high", a.high);
}

void fields(FieldVisitor& field, Chart& c) {
  field("title", c.title);
  field("x", c.x);
  field("y", c.y);
  field.maybe("x_lines", c.x_lines);
  field.maybe("y_lines", c.y_lines);
  field("key", c.key);
  field("width", c.width);
  field("height", c.height);
  field("series", c.series);
}

void fields(FieldVisitor& field, Claim& c) {
  field("name", c.name);
  field("value", c.measured);
  field("unit", c.unit);
  field("meaning", c.quantity);
  field("expected", c.expected);
  field("holds", c.holds);
  field("command", c.command);
  field("digits", c.digits);
  field.maybe("source", c.source);
  field.maybe("bar", c.bar);
  field.maybe("bar_is", c.bar_is);
  field.maybe("reason", c.reason);
  field.maybe("note", c.note);
}

void fields(FieldVisitor& field, Findings::Figure& f) {
  field("name", f.name);
  field("caption", f.caption);
  field("command", f.command);
  field("wide", f.wide);
  field.maybe("after", f.after);
  field.maybe("chart", f.chart);
  field.maybe("file", f.file);
}

void fields(FieldVisitor& field, Findings::Table& t) {
  field("name", t.name);
  field("caption", t.caption);
  field("command", t.command);
  field("columns", t.columns);
  field("rows", t.rows);
}

void fields(FieldVisitor& field, ClaimReport::Item& item) {
  field("name", item.name);
  field("title", item.title);
  field("status", item.status);
  field("message", item.message);
  field("command", item.command);
  field("quick", item.quick);
  field("wall_seconds", item.wall_seconds);
  field("cpu_seconds", item.cpu_seconds);
  field("date", item.date);
  field.object("program", [&](FieldVisitor& program) {
    program("version", item.build.version);
    program("commit", item.build.commit);
    program("compiler", item.build.compiler);
    program("flags", item.build.flags);
    program("build_type", item.build.build_type);
  });
  field.object("machine", [&](FieldVisitor& machine) {
    machine("cpu", item.build.cpu);
    machine("cores", item.build.cores);
  });
  int checks = item.checks(), held = item.held();
  field("checks", checks);
  field("checks_held", held);
  field("paper", item.result.paper);
  field("ours", item.result.ours);
  field("numbers", item.result.claims);
  field("figures", item.result.figures);
  field("tables", item.result.tables);
}

}  // namespace

std::string to_string(ClaimReport::Item::Status status) { return Json(status).get<std::string>(); }

Json to_json(const ClaimReport& report) {
  Json json{{"command", report.command}};
  int checks = 0, held = 0;
  bool all_done = report.complete;
  Json items = Json::array();
  for (ClaimReport::Item item : report.items) {
    checks += item.checks();
    held += item.held();
    all_done = all_done && item.status == ClaimReport::Item::Status::kDone;
    Json& row = items.emplace_back(Json::object());
    FieldVisitor visitor(row, false);
    fields(visitor, item);
  }
  json["all_items_done"] = all_done;
  json["checks"] = checks;
  json["checks_held"] = held;
  json["items"] = std::move(items);
  return json;
}

std::vector<ClaimReport::Item> read_items(const std::filesystem::path& file) {
  std::vector<ClaimReport::Item> items;
  if (!std::filesystem::exists(file)) return items;
  const std::string text = read_text_file(file);
  try {
    Json whole = Json::parse(text);
    for (Json& json : whole.at("items")) {
      FieldVisitor visitor(json, true);
      fields(visitor, items.emplace_back());
    }
  } catch (const std::exception& e) {
    throw FileError(
        file, "",
        std::string(
            "not results that this program can read (remove them or choose another folder): ") +
            e.what());
  }
  return items;
}

}  // namespace bipot
