#include "bench/report/several_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/report/labels.h"

namespace bipot {
namespace {

std::string_view word(ContactStatus status) {
  return status == ContactStatus::kTakeOff ? "open"
         : status == ContactStatus::kStick ? "stick"
                                           : "slip";
}

/// "pgs (2), apgd": the starts that ended at an answer, by solver.
std::string solvers_of(const SeveralAnswers& found, const Answer& answer) {
  std::map<std::string, int> counts;
  for (const int k : answer.starts) ++counts[found.starts[to_size(k)].solver];
  std::vector<std::string> parts;
  for (const auto& [solver, count] : counts) {
    parts.push_back(count == 1 ? solver : fmt::format("{} ({})", solver, count));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::string kind_text(const SeveralAnswers& found, const Answer& answer) {
  switch (answer.kind) {
    case Answer::Kind::kIsolated:
      return "isolated";
    case Answer::Kind::kLeft:
      return "a solve from 1 % away left it";
    case Answer::Kind::kUnknown:
      return "not known";
    case Answer::Kind::kFamily: {
      const auto members = std::ranges::count_if(
          found.answers, [&](const Answer& other) { return other.set == answer.set; });
      return members > 1 ? fmt::format("family {} with {} more", answer.set + 1, members - 1)
                         : "of a continuous family";
    }
  }
  return "";
}

Json to_json(const Answer::Difference& d) {
  return {{"velocity", d.velocity}, {"body_velocity", d.body_velocity},
          {"kinetic", d.kinetic},   {"force", d.force},
          {"total", d.total},       {"contacts", d.contacts}};
}

Json start_json(const SeveralAnswers::Start& start) {
  Json j{{"solver", start.solver},
         {"from", start.from},
         {"finished_by", start.finished_by},
         {"answer", start.answer < 0 ? Json(nullptr) : Json(start.answer + 1)},
         {"message", start.message},
         {"seconds", start.seconds}};
  add_error(j, start.error);
  return j;
}

Json answer_json(const Answer& answer) {
  Json j{{"starts", answer.starts.size()},
         {"kind", to_string(answer.kind)},
         {"set", answer.set + 1},
         {"take_off", answer.take_off},
         {"stick", answer.stick},
         {"slip", answer.slip},
         {"kinetic", answer.kinetic},
         {"perturbed", answer.perturbed},
         {"came_back_to", answer.came_back_to},
         {"from_first", to_json(answer.from_first)}};
  add_error(j, answer.impulse.error);
  return j;
}

std::string conclusion(const SeveralAnswers& found) {
  if (found.status == SolveStatus::kNothingToDo) return "One answer: no impulses.\n";
  if (found.answers.empty() && found.complete) {
    return "No answer: none in any case of open, stick and slip.\n";
  }
  if (found.answers.empty()) {
    return fmt::format("No start reached a guarded error of {:.0e}, so nothing is known.\n",
                       DistinctAnswers::kTrusted);
  }
  if (found.answers.size() == 1 && found.complete) {
    return "One answer: no case of open, stick and slip has another.\n";
  }
  if (found.answers.size() == 1) {
    return fmt::format(
        "One answer: starts agree to {} of the velocities or better. This proves nothing about\n"
        "starts that were not tried.\n",
        error_label(found.resolution));
  }
  const Answer::Difference& d = found.spread;
  std::string text = fmt::format(
      "Several answers, each exact: {} of them in {} set{}. Farthest apart (relative):\n"
      "  velocities {} in the energy norm, {} of the fastest body;\n"
      "  contact force on one body {} of the mean one, on all bodies together {};\n"
      "  kinetic energy {}; {} contacts differ in status.\n"
      "What errors explain, a hundred times over: {} at most.\n",
      found.answers.size(), found.sets, found.sets == 1 ? "" : "s", error_label(d.velocity),
      error_label(d.body_velocity), error_label(d.force), error_label(d.total),
      error_label(d.kinetic), found.differing_contacts.size(), error_label(found.resolution));
  if (d.force > 0.1) text += "The force on one body at this instant is no property of the step.\n";
  return text;
}

Table answer_table(const SeveralAnswers& found) {
  Table table{
      .columns = {{.key = "answer", .name = "answer", .show = count_label},
                  {.key = "starts", .name = "starts", .show = count_label},
                  {.key = "error", .name = "error", .show = compact_label},
                  {.key = "kinetic [J]", .name = "energy", .show = value_label, .unit = "J"},
                  {.key = "open", .name = "open", .show = count_label},
                  {.key = "stick", .name = "stick", .show = count_label},
                  {.key = "slip", .name = "slip", .show = count_label},
                  {.key = "velocity", .name = "velocity", .show = compact_label},
                  {.key = "body_velocity", .name = "fastest", .show = compact_label},
                  {.key = "kinetic", .name = "energy", .show = compact_label},
                  {.key = "force", .name = "force", .show = compact_label},
                  {.key = "contacts", .name = "contacts", .show = count_label}},
      .note =
          "From velocity on: how far from answer 1, relative: velocities in the "
          "energy norm, of the fastest body, kinetic energy, force on a body over "
          "the mean one; contacts that differ."};
  for (std::size_t k = 0; k < found.answers.size(); ++k) {
    const Answer& a = found.answers[k];
    const Answer::Difference& from = a.from_first;
    table.add({k + 1, a.starts.size(), a.impulse.error.guarded(), a.kinetic, a.take_off, a.stick,
               a.slip, from.velocity, from.body_velocity, from.kinetic, from.force, from.contacts});
  }
  return table;
}

/// A line for each answer: what kind it is, and who found it.
std::string kind_lines(const SeveralAnswers& found) {
  std::string kinds;
  for (std::size_t k = 0; k < found.answers.size(); ++k) {
    const Answer& a = found.answers[k];
    kinds += fmt::format("{}answer {}: {}; by {}", k > 0 ? "\n" : "", k + 1, kind_text(found, a),
                         solvers_of(found, a));
  }
  return kinds;
}

Table start_table(const SeveralAnswers& found) {
  Table table{.columns = {{.name = "start"},
                          {.name = "solver", .filter = true},
                          {.name = "answer", .show = count_label},
                          {.name = "error", .show = compact_label},
                          {.name = "time", .show = seconds_label},
                          {.name = "message"}},
              .sortable = true};
  for (const SeveralAnswers::Start& start : found.starts) {
    const bool finished = !start.finished_by.empty() && start.finished_by != start.solver;
    table.add({start.from, finished ? start.solver + ", then " + start.finished_by : start.solver,
               start.answer < 0 ? Table::Cell(kNaN).shown("–") : Table::Cell(start.answer + 1),
               start.error.guarded(), start.seconds, start.message});
  }
  return table;
}

Table difference_table(const SeveralAnswers& found) {
  Table table{.columns = {{.name = "contact", .show = count_label}}, .sortable = true};
  for (std::size_t k = 0; k < found.answers.size(); ++k) {
    table.columns.push_back({.name = fmt::format("answer {}", k + 1)});
  }
  for (const int c : found.differing_contacts) {
    std::vector<Table::Cell> cells = {c};
    for (const Answer& answer : found.answers) cells.emplace_back(word(answer.status[to_size(c)]));
    table.add(std::move(cells));
  }
  return table;
}

}  // namespace

std::string to_text(const SeveralAnswers& found) {
  Document d;
  d.say(fmt::format("{} ({}), {:.2f} s", to_string(found.status), found.message, found.seconds));
  if (!found.answers.empty()) {
    d.add(answer_table(found));
    d.say(kind_lines(found));
  }
  return to_text(d) + conclusion(found);
}

std::string to_csv(const SeveralAnswers& found) { return to_csv(answer_table(found)); }

Document several_page(const SeveralAnswers& found, const std::string& problem, Provenance made,
                      bool picture) {
  Document page{.title = "Answers of " + problem, .made = std::move(made)};
  page.say(conclusion(found));
  page.say(fmt::format("{} ({}), {:.2f} s", to_string(found.status), found.message, found.seconds),
           "small");
  if (!found.answers.empty()) {
    page.add(answer_table(found));
    page.say("[The table as CSV](answers.csv), [all numbers](summary.json)" +
                 std::string(picture ? ", [picture](answers.svg)." : "."),
             "small");
    page.say(kind_lines(found));
  }
  if (picture)
    page.add(Figure{.file = "answers.svg", .caption = "Forces of the answers.", .wide = true});
  const auto fold = [&page](const std::string& summary, Table table) {
    if (!table.rows.empty()) page.fold(summary, std::move(table));
  };
  fold(fmt::format("{} starts", found.starts.size()), start_table(found));
  fold(fmt::format("{} contacts that differ", found.differing_contacts.size()),
       difference_table(found));
  page.heading("How this was made", "made");
  page.add(to_terms(page.made));
  return page;
}

Json to_json(const SeveralAnswers& found) {
  const auto contact_json = [&](int c) {
    const auto word_of = [&](const Answer& answer) { return word(answer.status[to_size(c)]); };
    return Json{{"contact", c}, {"status", json_list(found.answers, word_of)}};
  };
  return {{"status", to_string(found.status)},
          {"message", found.message},
          {"seconds", found.seconds},
          {"trusted", DistinctAnswers::kTrusted},
          {"factor", DistinctAnswers::kFactor},
          {"resolution", found.resolution},
          {"sets", found.sets},
          {"spread", to_json(found.spread)},
          {"answers", json_list(found.answers, answer_json)},
          {"starts", json_list(found.starts, start_json)},
          {"differing_contacts", json_list(found.differing_contacts, contact_json)}};
}

}  // namespace bipot
