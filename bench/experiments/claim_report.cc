#include "bench/experiments/claim_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/report/labels.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

constexpr std::size_t kLong = 30;  // rows from which on a table is folded

std::string seconds(double s) {
  return s < 10 ? fmt::format("{:.1f} s", s)
                : (s < 120 ? fmt::format("{:.0f} s", s) : fmt::format("{:.1f} min", s / 60));
}

const char* look(const ClaimReport::Item& item) {
  return item.status == ClaimReport::Item::Status::kNotRun ? "grey" : "bad";
}

Table::Cell verdict(const Claim& claim) {
  if (!claim.holds) {
    return claim.reason.empty() ? Table::Cell("")
                                : Table::Cell("undecided: " + claim.reason).as("weak");
  }
  if (*claim.holds) return Table::Cell("✓ holds").as("good");
  return Table::Cell("✗ does not hold" + (claim.reason.empty() ? "" : ": " + claim.reason))
      .as("bad");
}

/// Empty columns are left out. A command is shown once, above its claims.
Table claim_table(const ClaimReport::Item& item) {
  struct Column {
    const char* name;
    Table::Cell (*cell)(const Claim&);
    bool number = false;
  };
  static constexpr Column kColumns[] = {
      {"quantity", [](const Claim& c) { return Table::Cell(c.quantity); }},
      {"verdict", &verdict},
      {"source", [](const Claim& c) { return Table::Cell(c.source).as("small"); }},
      {"by theory or the paper", [](const Claim& c) { return Table::Cell(c.expected); }},
      {"here", [](const Claim& c) { return Table::Cell(measured_text(c)); }, true},
      {"error bar", [](const Claim& c) { return Table::Cell(c.bar_is).as("small"); }},
      {"note", [](const Claim& c) { return Table::Cell(c.note).as("small"); }}};
  const std::vector<Claim>& claims = item.result.claims;
  Table table;
  std::vector<const Column*> used;
  for (const Column& column : kColumns) {
    const bool any = std::ranges::any_of(
        claims, [&](const Claim& c) { return column.cell(c).value != Table::Cell("").value; });
    if (!any) continue;
    used.push_back(&column);
    table.columns.push_back({.name = column.name, .show = column.number ? &value_label : nullptr});
  }
  const std::string* command = nullptr;
  for (const Claim& claim : claims) {
    if (command == nullptr || *command != claim.command) {
      command = &claim.command;
      table.add({"made by `" + *command + "`"});
    }
    std::vector<Table::Cell> cells;
    for (const Column* column : used) cells.push_back(column->cell(claim));
    table.add(std::move(cells), {}, fmt::format("{}.{}", item.name, claim.name));
  }
  return table;
}

void add_figures(Document& page, const std::vector<Findings::Figure>& figures, int after,
                 int last) {
  for (const Findings::Figure& f : figures) {
    const bool behind_all = !f.after || *f.after < 0 || *f.after > last;
    if (behind_all ? after <= last : *f.after != after) continue;
    page.add(Figure{.chart = f.chart,
                    .file = f.chart ? f.name + ".svg" : f.file,
                    .caption = f.caption,
                    .command = f.command,
                    .wide = f.wide});
  }
}

void add_table(Document& page, const Findings::Table& from) {
  Table table;
  for (const std::string& name : from.columns) table.columns.push_back({.name = name});
  for (const auto& row : from.rows) table.add({row.begin(), row.end()});
  const std::string caption = fmt::format("{} `{}`", from.caption, from.command);
  if (from.rows.size() <= kLong) {
    table.caption = caption;
    return page.add(std::move(table));
  }
  page.fold(fmt::format("{} ({} rows)", caption, from.rows.size()), std::move(table));
}

void add_item(Document& page, const ClaimReport::Item& item) {
  page.heading(item.title, item.name);
  if (item.status != ClaimReport::Item::Status::kDone) {
    return page.say(fmt::format("This item is {}{}{}. Run `{}`.", to_string(item.status),
                                item.message.empty() ? "" : ": ", item.message, item.command),
                    look(item));
  }
  const Findings& found = item.result;
  if (!found.paper.empty()) page.say("**The paper.** " + found.paper, "quote");
  const int last = static_cast<int>(found.ours.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    page.say((i == 0 ? "**Here.** " : "") + found.ours[to_size(i)]);
    add_figures(page, found.figures, i, last);
  }
  add_figures(page, found.figures, last + 1, last);
  if (!found.claims.empty()) page.add(claim_table(item));
  for (const Findings::Table& table : found.tables) add_table(page, table);
  page.say(fmt::format("Made by `{}` in {} ({} of CPU).", item.command, seconds(item.wall_seconds),
                       seconds(item.cpu_seconds)),
           "small");
}

Table overview(const ClaimReport& report) {
  Table table;
  table.columns = {{.name = "item"}, {.name = "checks"}, {.name = "time"}};
  for (const ClaimReport::Item& item : report.items) {
    Table::Cell checks = "none";
    if (item.status != ClaimReport::Item::Status::kDone) {
      checks = Table::Cell(to_string(item.status)).as(look(item));
    } else if (item.checks() > 0) {
      const bool all = item.held() == item.checks();
      checks =
          Table::Cell(fmt::format("{} {} of {} hold", all ? "✓" : "✗", item.held(), item.checks()))
              .as(all ? "good" : "bad");
    }
    const bool run = item.status != ClaimReport::Item::Status::kNotRun;
    table.add({fmt::format("[{}](#{}){}", item.title, item.name,
                           item.quick ? " (quick: small sizes)" : ""),
               checks, run ? seconds(item.wall_seconds) : ""});
  }
  return table;
}

/// What does not hold and what is undecided, with links to the rows; before all else.
void add_verdict(Document& page, const ClaimReport& report) {
  int checks = 0, held = 0;
  std::string refuted, open;
  for (const ClaimReport::Item& item : report.items) {
    checks += item.checks();
    held += item.held();
    for (const Claim& claim : item.result.claims) {
      if (claim.holds.value_or(claim.reason.empty())) continue;
      std::string& list = claim.holds ? refuted : open;
      list += fmt::format("{}[{}](#{}.{})", list.empty() ? "" : ", ", claim.name, item.name,
                          claim.name);
    }
  }
  page.say(refuted.empty()
               ? fmt::format("**Nothing is refuted**: {} of {} decided checks hold.", held, checks)
               : "**Does not hold**: " + refuted + ".",
           refuted.empty() ? "" : "bad");
  if (!open.empty()) page.say("**Undecided**: " + open + ".");
}

/// Items kept from earlier runs may come from other programs and machines.
Terms all_terms(const ClaimReport& report) {
  Terms all{{{"last command", '`' + report.command + '`'}}};
  double total = 0;
  for (const ClaimReport::Item& item : report.items) {
    total += item.wall_seconds;
    if (item.status == ClaimReport::Item::Status::kNotRun) continue;
    for (const auto& term :
         to_terms(Provenance{.date = item.date.substr(0, 10), .build = item.build}).entries) {
      const bool known = std::ranges::find(all.entries, term) != all.entries.end();
      if (term.first != "command" && !known) all.entries.push_back(term);
    }
  }
  all.entries.emplace_back("time", seconds(total) + " for all items");
  return all;
}

}  // namespace

int ClaimReport::Item::checks() const {
  return static_cast<int>(
      std::ranges::count_if(result.claims, [](const Claim& n) { return n.holds.has_value(); }));
}

int ClaimReport::Item::held() const {
  return static_cast<int>(
      std::ranges::count_if(result.claims, [](const Claim& n) { return n.holds.value_or(false); }));
}

Document to_document(const ClaimReport& report) {
  Document page{.title = report.title};
  add_verdict(page, report);
  page.add(overview(report));
  Document about;
  about.say(report.introduction);
  page.fold("What the columns mean", std::move(about), "about", true);
  for (const ClaimReport::Item& item : report.items) add_item(page, item);
  page.heading("How this page was made");
  page.add(all_terms(report));
  return page;
}

void write_report(const std::filesystem::path& folder, const std::string& json_name,
                  const ClaimReport& report) {
  write_text_file(folder / json_name, json_text(to_json(report), 1) + "\n");
  write_text_file(folder / "index.html", to_html(to_document(report)));
}

}  // namespace bipot
