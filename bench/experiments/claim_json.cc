#include <algorithm>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/experiments/claim_report.h"
#include "core/base/file_error.h"
#include "core/files/input_file.h"

namespace bipot {

NLOHMANN_JSON_SERIALIZE_ENUM(ChartAxis::Kind, {{ChartAxis::Kind::kLinear, "linear"},
                                               {ChartAxis::Kind::kLog, "log"},
                                               {ChartAxis::Kind::kLogSeconds, "log seconds"}})
NLOHMANN_JSON_SERIALIZE_ENUM(ChartSeries::Kind,
                             {{ChartSeries::Kind::kLinePoints, "line and points"},
                              {ChartSeries::Kind::kLine, "line"},
                              {ChartSeries::Kind::kPoints, "points"},
                              {ChartSeries::Kind::kSteps, "steps"}})
NLOHMANN_JSON_SERIALIZE_ENUM(Chart::Key, {{Chart::Key::kBelow, "below"},
                                          {Chart::Key::kRight, "right"},
                                          {Chart::Key::kNone, "none"}})
NLOHMANN_JSON_SERIALIZE_ENUM(ReportItem::Status,
                             {{ReportItem::Status::kNotRun, "not run"},
                              {ReportItem::Status::kDone, "done"},
                              {ReportItem::Status::kFailed, "failed"},
                              {ReportItem::Status::kInterrupted, "interrupted"}})

namespace {

// Each type is described once, by list_fields(): the writer and the reader go over the same fields.

template <class T, class Type>
concept Is = std::same_as<std::remove_const_t<T>, Type>;

/// The points of a series, by columns.
struct PointColumns {
  std::vector<double> x, y, low, high;
  std::vector<std::size_t> hollow, bare;
  std::vector<std::string> notes;

  PointColumns() = default;
  explicit PointColumns(const std::vector<ChartPoint>& points) {
    const auto any = [&points](const auto& has) {
      return std::any_of(points.begin(), points.end(), has);
    };
    const bool bars =
        any([](const ChartPoint& p) { return std::isfinite(p.y_low) || std::isfinite(p.y_high); });
    const bool noted = any([](const ChartPoint& p) { return !p.note.empty(); });
    for (const ChartPoint& p : points) {
      if (p.hollow) hollow.push_back(x.size());
      if (!p.marked) bare.push_back(x.size());
      x.push_back(p.x);
      y.push_back(p.y);
      if (bars) low.push_back(p.y_low);
      if (bars) high.push_back(p.y_high);
      if (noted) notes.push_back(p.note);
    }
  }

  /// Throws std::out_of_range if the columns do not match.
  std::vector<ChartPoint> points() const {
    std::vector<ChartPoint> all;
    for (std::size_t i = 0; i < x.size(); ++i) {
      ChartPoint p{x[i], y.at(i)};
      if (!notes.empty()) p.note = notes.at(i);
      if (!low.empty()) p.y_low = low.at(i);
      if (!high.empty()) p.y_high = high.at(i);
      all.push_back(std::move(p));
    }
    for (const std::size_t i : hollow) all.at(i).hollow = true;
    for (const std::size_t i : bare) all.at(i).marked = false;
    return all;
  }
};

struct YLine {
  double value = 0;
  std::string label;
};

void list_fields(auto& field, Is<PointColumns> auto& c) {
  field("x", c.x);
  field("y", c.y);
  field.maybe("hollow", c.hollow);
  field.maybe("unmarked", c.bare);
  field.maybe("notes", c.notes);
  field.maybe("y_low", c.low);
  field.maybe("y_high", c.high);
}

void list_fields(auto& field, Is<ChartSeries> auto& s) {
  field("name", s.name);
  field("style", s.style);
  field("kind", s.kind);
  PointColumns columns(s.points);
  list_fields(field, columns);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(s)>>) s.points = columns.points();
}

void list_fields(auto& field, Is<ChartLine> auto& l) {
  field("at", l.at);
  field("label", l.label);
}

void list_fields(auto& field, Is<YLine> auto& l) {
  field("value", l.value);
  field("label", l.label);
}

void list_fields(auto& field, Is<ChartAxis> auto& a) {
  field("label", a.label);
  field("scale", a.kind);
  field.maybe("low", a.low);
  field.maybe("high", a.high);
}

void list_fields(auto& field, Is<Chart> auto& c) {
  field("title", c.title);
  field("x", c.x);
  field("y", c.y);
  std::optional<YLine> line;
  if (c.y_line) line = YLine{*c.y_line, c.y_line_label};
  field.maybe("y_line", line);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(c)>>) {
    if (line) c.y_line = line->value;
    if (line) c.y_line_label = line->label;
  }
  field.maybe("x_lines", c.x_lines);
  field.maybe("y_lines", c.y_lines);
  field("key", c.key);
  field("width", c.width);
  field("height", c.height);
  field("series", c.series);
}

void list_fields(auto& field, Is<Claim> auto& c) {
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

void list_fields(auto& field, Is<ClaimFigure> auto& f) {
  field("name", f.name);
  field("caption", f.caption);
  field("command", f.command);
  field("wide", f.wide);
  field.maybe("after", f.after);
  field.maybe("chart", f.chart);
  field.maybe("file", f.file);
}

void list_fields(auto& field, Is<ClaimTable> auto& t) {
  field("name", t.name);
  field("caption", t.caption);
  field("command", t.command);
  field("columns", t.columns);
  field("rows", t.rows);
}

void list_fields(auto& field, Is<ReportItem> auto& item) {
  field("name", item.name);
  field("title", item.title);
  field("status", item.status);
  field("message", item.message);
  field("command", item.command);
  field("quick", item.quick);
  field("wall_seconds", item.wall_seconds);
  field("cpu_seconds", item.cpu_seconds);
  field("date", item.date);
  field.object("program", [&](auto& program) {
    program("version", item.build.version);
    program("commit", item.build.commit);
    program("compiler", item.build.compiler);
    program("flags", item.build.flags);
    program("build_type", item.build.build_type);
  });
  field.object("machine", [&](auto& machine) {
    machine("cpu", item.build.cpu);
    machine("cores", item.build.cores);
  });
  field.computed("checks", item.checks());
  field.computed("checks_held", item.held());
  field("paper", item.result.paper);
  field("ours", item.result.ours);
  field("numbers", item.result.claims);
  field("figures", item.result.figures);
  field("tables", item.result.tables);
}

class Writer {
 public:
  explicit Writer(Json& json) : json_(json) {}

  template <class T>
  void operator()(const char* key, const T& value) {
    json_[key] = value_of(value);
  }
  /// Omitted if there is none.
  template <class T>
  void maybe(const char* key, const std::optional<T>& value) {
    if (value) (*this)(key, *value);
  }
  template <class T>
  void maybe(const char* key, const std::vector<T>& value) {
    if (!value.empty()) (*this)(key, value);
  }
  template <class T>
  void maybe(const char* key, const T& value) {
    if (value != T()) (*this)(key, value);
  }
  void computed(const char* key, int value) { json_[key] = value; }
  void object(const char* key, const auto& visit_inside) {
    Json inside = Json::object();
    Writer writer(inside);
    visit_inside(writer);
    json_[key] = std::move(inside);
  }

 private:
  template <class T>
  static Json value_of(const T& value) {
    if constexpr (requires(Writer & w) { list_fields(w, value); }) {
      Json json = Json::object();
      Writer writer(json);
      list_fields(writer, value);
      return json;
    } else {
      return value;
    }
  }
  template <class T>
  static Json value_of(const std::vector<T>& values) {
    Json json = Json::array();
    for (const T& value : values) json.push_back(value_of(value));
    return json;
  }
  template <class T>
  static Json value_of(const std::optional<T>& value) {
    return value ? value_of(*value) : Json(nullptr);
  }

  Json& json_;
};

class Reader {
 public:
  explicit Reader(const Json& json) : json_(json) {}

  template <class T>
  void operator()(const char* key, T& value) {
    read(json_.at(key), value);
  }
  template <class T>
  void maybe(const char* key, T& value) {
    if (json_.contains(key)) read(json_.at(key), value);
  }
  void computed(const char*, int) {}
  void object(const char* key, const auto& visit_inside) {
    Reader reader(json_.at(key));
    visit_inside(reader);
  }

 private:
  template <class T>
  static void read(const Json& json, T& value) {
    if constexpr (requires(Reader & r) { list_fields(r, value); }) {
      Reader reader(json);
      list_fields(reader, value);
    } else {
      value = json.get<T>();
    }
  }
  static void read(const Json& json, double& value) { value = number_or_nan(json); }
  template <class T>
  static void read(const Json& json, std::vector<T>& values) {
    for (const Json& entry : json) read(entry, values.emplace_back());
  }
  template <class T>
  static void read(const Json& json, std::optional<T>& value) {
    if (!json.is_null()) read(json, value.emplace());
  }

  const Json& json_;
};

}  // namespace

std::string to_string(ReportItem::Status status) { return Json(status).get<std::string>(); }

Json to_json(const ClaimReport& report) {
  Json json{{"command", report.command}};
  int checks = 0, held = 0;
  bool all_done = true;
  Json items = Json::array();
  for (const ReportItem& item : report.items) {
    checks += item.checks();
    held += item.held();
    all_done = all_done && item.status == ReportItem::Status::kDone;
    Json& row = items.emplace_back(Json::object());
    Writer writer(row);
    list_fields(writer, item);
  }
  json["all_items_done"] = all_done;
  json["checks"] = checks;
  json["checks_held"] = held;
  json["items"] = std::move(items);
  return json;
}

std::vector<ReportItem> read_items(const std::filesystem::path& file) {
  std::vector<ReportItem> items;
  if (!std::filesystem::exists(file)) return items;
  const std::string text = read_text_file(file);
  try {
    const Json whole = Json::parse(text);
    for (const Json& json : whole.at("items")) {
      Reader reader(json);
      list_fields(reader, items.emplace_back());
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
