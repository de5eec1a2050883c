#include "bench/tune/measured_row.h"

#include <fmt/format.h>

#include "bench/report/csv_text.h"
#include "core/base/file_error.h"
#include "core/base/number_text.h"

namespace bipot {
namespace {

constexpr std::size_t kColumns = 11;

}  // namespace

std::string instance_of(const MeasuredRow& row) {
  return fmt::format("{} {} {:g}", row.problem, (row.traits.marks & kWarm) ? "warm" : "cold",
                     row.traits.tol);
}

std::string measured_csv_header() {
  return "problem,scene,contacts,dim,tol,properties,variant,iterations,seconds,solved,limit";
}

std::string to_csv(const MeasuredRow& row) {
  return fmt::format("{},{},{},{},{:g},{},{},{},{:.6g},{},{:g}\n", csv_text(row.problem),
                     csv_text(row.scene), row.traits.contacts, row.traits.dim, row.traits.tol,
                     csv_text(mark_words(row.traits.marks)), csv_text(row.variant), row.iterations,
                     row.seconds, row.solved ? 1 : 0, row.limit);
}

std::vector<MeasuredRow> read_measured_rows(const std::filesystem::path& path) {
  std::vector<MeasuredRow> rows;
  if (!std::filesystem::exists(path)) return rows;
  for (const auto& fields : read_csv_table(path, measured_csv_header(), kColumns)) {
    const auto value = [&](std::size_t k) { return csv_number<double>(fields[k], path); };
    MeasuredRow& row = rows.emplace_back();
    row.problem = fields[0];
    row.scene = fields[1];
    row.traits.contacts = static_cast<int>(value(2));
    row.traits.dim = static_cast<int>(value(3));
    row.traits.tol = value(4);
    row.traits.marks = marks_of_words(fields[5]);
    row.variant = fields[6];
    row.iterations = static_cast<int>(value(7));
    row.seconds = value(8);
    row.solved = value(9) != 0;
    row.limit = value(10);
  }
  return rows;
}

}  // namespace bipot
