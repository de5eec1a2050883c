#include "bench/experiments/claim.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "bench/report/labels.h"

namespace bipot {
namespace {

/// Calls `visit` for each text in which claims are named.
template <class Visit>
void visit_texts(Findings& findings, const Visit& visit) {
  visit(findings.paper);
  for (std::string& text : findings.ours) visit(text);
  for (Findings::Figure& f : findings.figures) visit(f.caption);
  for (Findings::Table& t : findings.tables) visit(t.caption);
}

std::string filled(const std::string& text, const std::vector<Claim>& claims) {
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
    const auto claim = std::ranges::find_if(claims, [&](const Claim& c) { return c.name == name; });
    if (claim == claims.end()) {
      throw std::invalid_argument(fmt::format("no number is called {{{}}}", name));
    }
    out += to_text(claim->measured, claim->unit, claim->digits);
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

template <class Part>
void require_own_names(const std::vector<Part>& parts, const char* what) {
  std::set<std::string> names;
  for (const Part& part : parts) {
    if (!names.insert(part.name).second) {
      throw std::invalid_argument(fmt::format("two {} are called {}", what, part.name));
    }
  }
}

template <class Part>
void give_command(std::vector<Part>& parts, const std::string& command) {
  for (Part& part : parts) {
    if (part.command.empty()) part.command = command;
  }
}

}  // namespace

double Expectation::error(double value) const {
  if (std::isnan(value)) return kNaN;
  return std::max({low - value, value - high, 0.0}) / scale;
}

std::optional<bool> decide(double off, double bar, double widest) {
  constexpr double kRefuted = 2;  // bars
  if (std::isnan(off) || off > kRefuted * bar) return false;
  if (off <= bar && bar <= widest) return true;
  return std::nullopt;
}

Claim& Findings::state(std::string name, double measured, std::string unit, std::string quantity,
                       int digits) {
  return check(std::move(name), measured, std::move(unit), std::move(quantity), {}, {}, digits);
}

Claim& Findings::check(std::string name, double measured, std::string unit, std::string quantity,
                       std::string expected, std::optional<bool> holds, int digits) {
  return claims.emplace_back(Claim{.name = std::move(name),
                                   .measured = measured,
                                   .unit = std::move(unit),
                                   .quantity = std::move(quantity),
                                   .expected = std::move(expected),
                                   .holds = holds,
                                   .digits = digits});
}

Claim& Findings::test(std::string name, double measured, std::string unit, std::string quantity,
                      std::string expected, const Expectation& range, double bar,
                      std::string bar_is, int digits) {
  const double off = range.scale * range.error(measured), widest = kWidestBar * range.scale;
  Claim& claim = check(std::move(name), measured, std::move(unit), std::move(quantity),
                       std::move(expected), decide(off, bar, widest), digits);
  claim.bar = bar;
  claim.bar_is = std::move(bar_is);
  if (!claim.holds) {
    claim.reason = off > bar ? "too few samples: off by more than one bar, less than two"
                             : "too few samples: the error bar is wider than half of the scale";
  }
  return claim;
}

void Findings::draw(std::string name, std::string caption, Chart chart, std::optional<int> after) {
  figures.push_back({.name = std::move(name),
                     .caption = std::move(caption),
                     .chart = std::move(chart),
                     .after = after});
}

void Findings::show(std::string name, std::string caption, std::optional<int> after) {
  figures.push_back(
      {.name = name, .caption = std::move(caption), .file = name + ".svg", .after = after});
}

void complete(Findings& findings, const std::string& command) {
  require_own_names(findings.claims, "numbers");
  require_own_names(findings.figures, "figures");
  for (const Findings::Figure& f : findings.figures) {
    if (f.chart.has_value() != f.file.empty()) {
      throw std::invalid_argument(
          fmt::format("figure {} must have a chart or a file, not both", f.name));
    }
  }
  give_command(findings.claims, command);
  for (Claim& claim : findings.claims) {
    if (claim.holds && claim.bar_is.empty()) claim.bar_is = "discretisation: the limit given";
  }
  give_command(findings.figures, command);
  give_command(findings.tables, command);
  visit_texts(findings, [&](std::string& text) { text = filled(text, findings.claims); });
}

std::string to_text(double value, const std::string& unit, int digits) {
  if (std::isnan(value)) return "undefined";
  std::string text;
  if (std::isinf(value)) {
    text = value > 0 ? "∞" : "−∞";
  } else if (value == std::round(value) && std::abs(value) < 1e12) {
    text = grouped(fmt::format("{:.0f}", std::abs(value) == 0 ? 0 : value));
  } else {
    text = short_exponent(fmt::format("{:.{}g}", value, digits));
    if (text.starts_with('-')) text = "−" + text.substr(1);
  }
  return unit.empty() ? text : text + "\u00a0" + unit;
}

std::string measured_text(const Claim& claim) {
  if (!(claim.bar > 0)) return to_text(claim.measured, claim.unit, claim.digits);
  return fmt::format("{} ± {}", to_text(claim.measured, "", claim.digits),
                     to_text(claim.bar, claim.unit, 2));
}

}  // namespace bipot
