#include "bench/study/study.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>

#include "bench/measure/stopwatch.h"
#include "bench/report/csv_text.h"
#include "bench/study/study_parts.h"
#include "core/base/file_error.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

constexpr const char* kRowsHeader = "part,scene,size,seed,method,tol,x,quantity,value";
constexpr const char* kLastQuantity = "cpu";  // written last: the measurement is complete

std::string row_lines(const Study::Case& of, const Study::Values& values) {
  const std::string key = fmt::format("{},{},{},{},{},{},{}", csv_text(of.part), csv_text(of.scene),
                                      of.size, of.seed, csv_text(of.method), of.tol, of.x);
  std::string lines;
  for (const auto& [quantity, value] : values) {
    if (quantity != kLastQuantity) {
      lines += fmt::format("{},{},{:.6g}\n", key, csv_text(quantity), value);
    }
  }
  return lines +
         fmt::format("{},{},{:.4g}\n", key, csv_text(kLastQuantity), values.at(kLastQuantity));
}

template <class Number>
Number row_number(const std::string& text, const std::filesystem::path& path) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw FileError(path, "", fmt::format("'{}' is not a number", text));
  }
  return value;
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
  for (const auto& f : read_csv_table(rows, kRowsHeader, 9)) {
    const Case of{f[0],
                  f[1],
                  row_number<int>(f[2], rows),
                  row_number<int>(f[3], rows),
                  f[4],
                  row_number<double>(f[5], rows),
                  row_number<double>(f[6], rows)};
    measured[of][f[7]] = row_number<double>(f[8], rows);
  }
  std::erase_if(measured, [](const auto& entry) { return !entry.second.contains(kLastQuantity); });
  return measured;
}

bool Study::measure(const std::filesystem::path& rows, const std::vector<Job>& jobs,
                    const Stopped& stopped,
                    const std::function<void(long, long, const std::string&)>& on_job) {
  const Measured known = read(rows);
  if (!known.empty()) {  // without the rows of a measurement that was cut short
    std::string text = fmt::format("{}\n", kRowsHeader);
    for (const auto& [of, values] : known) text += row_lines(of, values);
    write_text_file(rows, text);
  }
  std::ofstream file = open_csv_table(rows, kRowsHeader);
  const long total = static_cast<long>(jobs.size());
  long done = 0;
  for (const Job& job : jobs) {
    const Case& of = job.of;
    on_job(done++, total,
           fmt::format("{} {} {} {} seed {}", of.part, of.scene, of.size, of.method, of.seed));
    if (known.contains(of)) continue;
    const CpuStopwatch watch;
    Values values = job.run(stopped);
    if (stopped()) return false;
    values.try_emplace(kLastQuantity, watch.seconds());
    file << row_lines(of, values) << std::flush;
    if (!file) throw FileError(rows, "", "cannot be written");
  }
  on_job(total, total, "");
  return true;
}

}  // namespace bipot
