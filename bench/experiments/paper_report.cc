#include "bench/experiments/paper_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "core/base/file_error.h"
#include "core/base/types.h"

namespace bipot {
namespace {

std::string_view name_of(ChartAxis::Kind kind) {
  switch (kind) {
    case ChartAxis::Kind::kLinear:
      return "linear";
    case ChartAxis::Kind::kLog:
      return "log";
    case ChartAxis::Kind::kLogSeconds:
      return "log seconds";
  }
  return "?";
}

Json to_json(const ChartAxis& axis) {
  Json json{{"label", axis.label}, {"scale", name_of(axis.kind)}};
  if (axis.low) json["low"] = *axis.low;
  if (axis.high) json["high"] = *axis.high;
  return json;
}

ChartAxis axis_from(const Json& json) {
  ChartAxis axis;
  axis.label = json.at("label").get<std::string>();
  for (const auto kind :
       {ChartAxis::Kind::kLinear, ChartAxis::Kind::kLog, ChartAxis::Kind::kLogSeconds}) {
    if (json.at("scale") == name_of(kind)) axis.kind = kind;
  }
  if (json.contains("low")) axis.low = json.at("low").get<double>();
  if (json.contains("high")) axis.high = json.at("high").get<double>();
  return axis;
}

std::string_view name_of(ChartSeries::Kind kind) {
  switch (kind) {
    case ChartSeries::Kind::kLinePoints:
      return "line and points";
    case ChartSeries::Kind::kLine:
      return "line";
    case ChartSeries::Kind::kPoints:
      return "points";
    case ChartSeries::Kind::kSteps:
      return "steps";
  }
  return "?";
}

std::string_view name_of(Chart::Key key) {
  switch (key) {
    case Chart::Key::kBelow:
      return "below";
    case Chart::Key::kRight:
      return "right";
    case Chart::Key::kNone:
      return "none";
  }
  return "?";
}

Json to_json(const std::vector<ChartLine>& lines) {
  Json json = Json::array();
  for (const ChartLine& line : lines) json.push_back({{"at", line.at}, {"label", line.label}});
  return json;
}

std::vector<ChartLine> lines_from(const Json& json) {
  std::vector<ChartLine> lines;
  for (const Json& line : json) {
    lines.push_back({line.at("at").get<double>(), line.at("label").get<std::string>()});
  }
  return lines;
}

Json to_json(const Chart& chart) {
  Json json{{"title", chart.title}, {"x", to_json(chart.x)}, {"y", to_json(chart.y)}};
  if (chart.y_line) json["y_line"] = {{"value", *chart.y_line}, {"label", chart.y_line_label}};
  if (!chart.x_lines.empty()) json["x_lines"] = to_json(chart.x_lines);
  if (!chart.y_lines.empty()) json["y_lines"] = to_json(chart.y_lines);
  json["key"] = name_of(chart.key);
  json["width"] = chart.width;
  json["height"] = chart.height;
  json["series"] = Json::array();
  for (const ChartSeries& series : chart.series) {
    Json row{{"name", series.name}, {"style", series.style}, {"kind", name_of(series.kind)}};
    row["x"] = Json::array();
    row["y"] = Json::array();
    Json low = Json::array(), high = Json::array();
    bool any_bar = false;
    Json hollow = Json::array(), bare = Json::array(), notes = Json::array();
    bool any_note = false;
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const ChartPoint& p = series.points[i];
      row["x"].push_back(p.x);
      row["y"].push_back(p.y);
      if (p.hollow) hollow.push_back(i);
      if (!p.marked) bare.push_back(i);
      notes.push_back(p.note);
      low.push_back(p.y_low);
      high.push_back(p.y_high);
      any_bar = any_bar || std::isfinite(p.y_low) || std::isfinite(p.y_high);
      any_note = any_note || !p.note.empty();
    }
    if (!hollow.empty()) row["hollow"] = hollow;
    if (!bare.empty()) row["unmarked"] = bare;
    if (any_note) row["notes"] = notes;
    if (any_bar) {
      row["y_low"] = low;
      row["y_high"] = high;
    }
    json["series"].push_back(row);
  }
  return json;
}

Chart chart_from(const Json& json) {
  Chart chart;
  chart.title = json.at("title").get<std::string>();
  chart.x = axis_from(json.at("x"));
  chart.y = axis_from(json.at("y"));
  if (json.contains("y_line")) {
    chart.y_line = json.at("y_line").at("value").get<double>();
    chart.y_line_label = json.at("y_line").at("label").get<std::string>();
  }
  chart.x_lines = lines_from(json.value("x_lines", Json::array()));
  chart.y_lines = lines_from(json.value("y_lines", Json::array()));
  for (const auto key : {Chart::Key::kBelow, Chart::Key::kRight, Chart::Key::kNone}) {
    if (json.at("key") == name_of(key)) chart.key = key;
  }
  chart.width = json.at("width").get<double>();
  chart.height = json.at("height").get<double>();
  for (const Json& row : json.at("series")) {
    ChartSeries series{row.at("name").get<std::string>(), row.at("style").get<int>(), {}};
    for (const auto kind : {ChartSeries::Kind::kLinePoints, ChartSeries::Kind::kLine,
                            ChartSeries::Kind::kPoints, ChartSeries::Kind::kSteps}) {
      if (row.at("kind") == name_of(kind)) series.kind = kind;
    }
    for (std::size_t i = 0; i < row.at("x").size(); ++i) {
      ChartPoint point{number_or_nan(row.at("x").at(i)), number_or_nan(row.at("y").at(i))};
      if (row.contains("notes")) point.note = row.at("notes").at(i).get<std::string>();
      if (row.contains("y_low")) {
        point.y_low = number_or_nan(row.at("y_low").at(i));
        point.y_high = number_or_nan(row.at("y_high").at(i));
      }
      series.points.push_back(point);
    }
    for (const Json& i : row.value("hollow", Json::array())) {
      series.points.at(i.get<std::size_t>()).hollow = true;
    }
    for (const Json& i : row.value("unmarked", Json::array())) {
      series.points.at(i.get<std::size_t>()).marked = false;
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Json to_json(const PaperEntry& entry) {
  Json json{{"name", entry.name},
            {"title", entry.title},
            {"status", to_string(entry.status)},
            {"message", entry.message},
            {"command", entry.command},
            {"quick", entry.quick},
            {"wall_seconds", entry.wall_seconds},
            {"cpu_seconds", entry.cpu_seconds},
            {"date", entry.date},
            {"program",
             {{"version", entry.build.version},
              {"commit", entry.build.commit},
              {"compiler", entry.build.compiler},
              {"flags", entry.build.flags},
              {"build_type", entry.build.build_type}}},
            {"machine", {{"cpu", entry.build.cpu}, {"cores", entry.build.cores}}},
            {"checks", entry.checks()},
            {"checks_held", entry.held()},
            {"paper", entry.result.paper},
            {"ours", entry.result.ours}};
  for (const char* const list : {"numbers", "figures", "tables"}) json[list] = Json::array();
  for (const PaperNumber& n : entry.result.numbers) {
    json["numbers"].push_back({{"name", n.name},
                               {"value", n.value},
                               {"unit", n.unit},
                               {"meaning", n.meaning},
                               {"expected", n.expected},
                               {"holds", n.holds ? Json(*n.holds) : Json(nullptr)},
                               {"command", n.command},
                               {"digits", n.digits}});
  }
  for (const PaperFigure& f : entry.result.figures) {
    Json row{{"name", f.name}, {"caption", f.caption}, {"command", f.command}, {"wide", f.wide}};
    if (f.after) row["after"] = *f.after;
    if (f.chart) {
      row["chart"] = to_json(*f.chart);
    } else {
      row["file"] = f.file;
    }
    json["figures"].push_back(row);
  }
  for (const PaperTable& t : entry.result.tables) {
    json["tables"].push_back({{"name", t.name},
                              {"caption", t.caption},
                              {"command", t.command},
                              {"columns", t.columns},
                              {"rows", t.rows}});
  }
  return json;
}

PaperEntry entry_from(const Json& json) {
  PaperEntry entry;
  entry.name = json.at("name").get<std::string>();
  entry.title = json.at("title").get<std::string>();
  for (const auto status :
       {PaperEntry::Status::kDone, PaperEntry::Status::kFailed, PaperEntry::Status::kInterrupted}) {
    if (json.at("status") == to_string(status)) entry.status = status;
  }
  entry.message = json.at("message").get<std::string>();
  entry.command = json.at("command").get<std::string>();
  entry.quick = json.at("quick").get<bool>();
  entry.wall_seconds = json.at("wall_seconds").get<double>();
  entry.cpu_seconds = json.at("cpu_seconds").get<double>();
  entry.date = json.at("date").get<std::string>();
  const Json& program = json.at("program");
  entry.build.version = program.at("version").get<std::string>();
  entry.build.commit = program.at("commit").get<std::string>();
  entry.build.compiler = program.at("compiler").get<std::string>();
  entry.build.flags = program.at("flags").get<std::string>();
  entry.build.build_type = program.at("build_type").get<std::string>();
  entry.build.cpu = json.at("machine").at("cpu").get<std::string>();
  entry.build.cores = json.at("machine").at("cores").get<int>();
  entry.result.paper = json.at("paper").get<std::string>();
  entry.result.ours = json.at("ours").get<std::vector<std::string>>();
  for (const Json& n : json.at("numbers")) {
    PaperNumber number{n.at("name").get<std::string>(),     number_or_nan(n.at("value")),
                       n.at("unit").get<std::string>(),     n.at("meaning").get<std::string>(),
                       n.at("expected").get<std::string>(), {},
                       n.at("command").get<std::string>()};
    if (!n.at("holds").is_null()) number.holds = n.at("holds").get<bool>();
    number.digits = n.at("digits").get<int>();
    entry.result.numbers.push_back(std::move(number));
  }
  for (const Json& f : json.at("figures")) {
    PaperFigure figure{f.at("name").get<std::string>(), f.at("caption").get<std::string>(),
                       f.at("command").get<std::string>()};
    figure.wide = f.at("wide").get<bool>();
    if (f.contains("after")) figure.after = f.at("after").get<int>();
    if (f.contains("chart")) {
      figure.chart = chart_from(f.at("chart"));
    } else {
      figure.file = f.at("file").get<std::string>();
    }
    entry.result.figures.push_back(std::move(figure));
  }
  for (const Json& t : json.at("tables")) {
    entry.result.tables.push_back(
        {t.at("name").get<std::string>(), t.at("caption").get<std::string>(),
         t.at("command").get<std::string>(), t.at("columns").get<std::vector<std::string>>(),
         t.at("rows").get<std::vector<std::vector<std::string>>>()});
  }
  return entry;
}

std::string filled(const std::string& text, const std::vector<PaperNumber>& numbers) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t open = text.find('{', at);
    out += text.substr(at, open - at);
    if (open == std::string::npos) break;
    const std::size_t close = text.find('}', open);
    if (close == std::string::npos) {
      throw std::invalid_argument(fmt::format("'{{' without '}}' in \"{}\"", text));
    }
    const std::string name = text.substr(open + 1, close - open - 1);
    const auto number = std::find_if(numbers.begin(), numbers.end(),
                                     [&](const PaperNumber& n) { return n.name == name; });
    if (number == numbers.end()) {
      throw std::invalid_argument(fmt::format("no number is called {{{}}}", name));
    }
    out += to_text(number->value, number->unit, number->digits);
    at = close + 1;
  }
  return out;
}

std::string grouped(const std::string& digits) {
  const bool negative = digits.starts_with('-');
  std::string out;
  const std::size_t first = negative ? 1 : 0;
  for (std::size_t i = first; i < digits.size(); ++i) {
    if (i > first && (digits.size() - i) % 3 == 0 && digits.size() - first > 4) {
      out += "\u202f";  // narrow no-break space
    }
    out += digits[i];
  }
  return (negative ? "−" : "") + out;
}

}  // namespace

std::string_view to_string(PaperEntry::Status status) {
  switch (status) {
    case PaperEntry::Status::kNotRun:
      return "not run";
    case PaperEntry::Status::kDone:
      return "done";
    case PaperEntry::Status::kFailed:
      return "failed";
    case PaperEntry::Status::kInterrupted:
      return "interrupted";
  }
  return "?";
}

int PaperEntry::checks() const {
  return static_cast<int>(std::count_if(result.numbers.begin(), result.numbers.end(),
                                        [](const PaperNumber& n) { return n.holds.has_value(); }));
}

int PaperEntry::held() const {
  return static_cast<int>(
      std::count_if(result.numbers.begin(), result.numbers.end(),
                    [](const PaperNumber& n) { return n.holds.value_or(false); }));
}

void complete(PaperResult& result, const std::string& command) {
  std::set<std::string> names;
  for (PaperNumber& n : result.numbers) {
    if (!names.insert(n.name).second) {
      throw std::invalid_argument(fmt::format("two numbers are called {}", n.name));
    }
    if (n.command.empty()) n.command = command;
  }
  names.clear();
  for (PaperFigure& f : result.figures) {
    if (!names.insert(f.name).second) {
      throw std::invalid_argument(fmt::format("two figures are called {}", f.name));
    }
    if (f.chart.has_value() != f.file.empty()) {
      throw std::invalid_argument(
          fmt::format("figure {} must have a chart or a file, not both", f.name));
    }
    if (f.command.empty()) f.command = command;
  }
  for (PaperTable& t : result.tables) {
    if (t.command.empty()) t.command = command;
  }
  result.paper = filled(result.paper, result.numbers);
  for (std::string& text : result.ours) text = filled(text, result.numbers);
  for (PaperFigure& f : result.figures) f.caption = filled(f.caption, result.numbers);
  for (PaperTable& t : result.tables) t.caption = filled(t.caption, result.numbers);
}

std::string to_text(double value, const std::string& unit, int digits) {
  if (std::isnan(value)) return "undefined";
  std::string text;
  if (std::isinf(value)) {
    text = value > 0 ? "∞" : "−∞";
  } else if (value == std::round(value) && std::abs(value) < 1e12) {
    text = grouped(fmt::format("{:.0f}", std::abs(value) == 0 ? 0 : value));
  } else {
    text = fmt::format("{:.{}g}", value, digits);
    const std::size_t e = text.find('e');
    if (e != std::string::npos) {
      const int exponent = std::stoi(text.substr(e + 1));
      text = text.substr(0, e) + fmt::format("e{}", exponent);
    }
    if (text.starts_with('-')) text = "−" + text.substr(1);
  }
  return unit.empty() ? text : text + "\u00a0" + unit;
}

Json to_json(const PaperReport& report) {
  Json json{{"command", report.command}};
  int checks = 0, held = 0;
  bool all_done = true;
  for (const PaperEntry& entry : report.entries) {
    checks += entry.checks();
    held += entry.held();
    all_done = all_done && entry.status == PaperEntry::Status::kDone;
  }
  json["all_items_done"] = all_done;
  json["checks"] = checks;
  json["checks_held"] = held;
  json["items"] = Json::array();
  for (const PaperEntry& entry : report.entries) json["items"].push_back(to_json(entry));
  return json;
}

std::vector<PaperEntry> read_entries(const std::filesystem::path& file) {
  std::vector<PaperEntry> entries;
  if (!std::filesystem::exists(file)) return entries;
  try {
    std::ifstream in(file);
    const Json whole = Json::parse(in);
    for (const Json& json : whole.at("items")) entries.push_back(entry_from(json));
  } catch (const nlohmann::json::exception& e) {
    throw FileError(
        file, "",
        std::string(
            "not results that this program can read (remove them or choose another folder): ") +
            e.what());
  }
  return entries;
}

}  // namespace bipot
