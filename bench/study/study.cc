#include "bench/study/study.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "bench/measure/stopwatch.h"
#include "bench/report/csv_text.h"
#include "core/base/file_error.h"
#include "core/base/number_text.h"

namespace bipot {
namespace {

constexpr const char* kRowsHeader = "part,scene,size,seed,method,tol,x,values";

std::string row_line(const Study::Case& of, const Study::Values& values) {
  std::string all;
  for (const auto& [quantity, value] : values) {
    all += fmt::format("{}{}={:.6g}", all.empty() ? "" : ";", quantity, value);
  }
  return fmt::format("{},{},{},{},{},{},{},{}\n", csv_text(of.part), csv_text(of.scene), of.size,
                     of.seed, csv_text(of.method), of.tol, of.x, csv_text(all));
}

}  // namespace

const std::vector<Study::Part>& Study::parts() {
  static const std::vector<Part> all = {thresholds_part(), depth_part(), answers_part(),
                                        ensembles_part(),  plane_part(), paths_part()};
  return all;
}

Study::Measured Study::read(const std::filesystem::path& rows) {
  Measured measured;
  if (!std::filesystem::exists(rows)) return measured;
  for (const auto& f : read_csv_table(rows, kRowsHeader, 8)) {
    Values& values =
        measured[{f[0], f[1], csv_number<int>(f[2], rows), csv_number<int>(f[3], rows), f[4],
                  csv_number<double>(f[5], rows), csv_number<double>(f[6], rows)}];
    std::istringstream parts(f[7]);
    for (std::string text; std::getline(parts, text, ';');) {
      const std::size_t end = std::min(text.find('='), text.size() - 1);
      values[text.substr(0, end)] = csv_number<double>(text.substr(end + 1), rows);
    }
  }
  return measured;
}

bool Study::measure(const std::filesystem::path& rows, const std::vector<Job>& jobs,
                    const Watch& watch) {
  const Measured known = read(rows);
  std::ofstream file = open_csv_table(rows, kRowsHeader);
  const long total = static_cast<long>(jobs.size());
  long done = 0;
  for (const Job& job : jobs) {
    const Case& of = job.of;
    watch.tell(done++, total,
               fmt::format("{} {} {} {} seed {}", of.part, of.scene, of.size, of.method, of.seed));
    if (known.contains(of)) continue;
    const CpuStopwatch clock;
    Values values = job.run([&watch] { return watch.stopped(); });
    if (watch.stopped()) return false;
    values.try_emplace("cpu", clock.seconds());
    file << row_line(of, values) << std::flush;
    if (!file) throw FileError(rows, "", "cannot be written");
  }
  watch.tell(total, total, "");
  return true;
}

}  // namespace bipot
