#include "core/scene_files/lmgc90_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/number_text.h"
#include "core/files/input_file.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

using Entries = std::map<std::string, double>;

/// Reads the lines of a file. A record begins with RBDY2 or RBDY3 and ends with $$$$$$. It has lines
/// `WORD ... key= number ...`, of which the word may be missing.
class RecordReader {
 public:
  RecordReader(const std::filesystem::path& path, int dim)
      : path_(path), kind_(dim == 2 ? "RBDY2" : "RBDY3"), file_(read_text_file(path)) {}

  struct Record {
    int number = 0;     // as the file gives it
    Entries entries;    // before contactors
    Entries contactor;  // of the last one
    std::vector<std::string> contactors;
    std::vector<std::string> driven;  // lines `vlocy ...` and `force ...`
  };
  /// False at the end.
  bool next(Record& record) {
    bool open = false, contactors = false;
    record = {};
    for (std::string text; std::getline(file_, text);) {
      ++line_;
      std::istringstream words(text);
      std::string word;
      if (!(words >> word) || word[0] == '!') continue;
      if (word == "$$$$$$") return true;
      contactors = word == "$tacty" || (contactors && word[0] != '$');
      if (word.starts_with("RBDY")) {
        if (word != kind_) refuse(fmt::format("expected {}, got {}", kind_, word));
        if (!(words >> record.number)) refuse("the body has no number");
        open = true;
      } else if (word == "vlocy" || word == "force") {
        record.driven.push_back(text);
      } else if (contactors && word[0] != '$' && word.find('=') == std::string::npos) {
        record.contactors.push_back(word);
      }
      read_entries(text, contactors ? record.contactor : record.entries);
    }
    if (open) refuse("the last body has no end");
    return false;
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw SceneFileError(fmt::format("{}:{}: {}", path_.string(), line_, why));
  }
  double entry(const Entries& entries, const std::string& key) const {
    const auto it = entries.find(key);
    if (it == entries.end()) refuse(fmt::format("the body has no {}", key));
    return it->second;
  }

  /// Velocities of the driven degrees of freedom, from 1 on. A line `vlocy DEGREE CT AMP OMEGA PHI
  /// RAMPI RAMP` is [CT + AMP cos(OMEGA t + PHI)] times RAMPI + RAMP t, this up to 1.
  std::map<int, double> driven_velocities(const std::vector<std::string>& lines) const {
    std::map<int, double> driven;
    for (const std::string& line : lines) {
      std::istringstream words(line);
      int degree = 0;
      std::string kind, number;
      std::vector<double> of;
      words >> kind >> degree;
      while (words >> number) of.push_back(number_of(kind, number));
      if (degree < 1 || of.size() != 6) refuse("expected a degree of freedom and six numbers");
      if (of[1] != 0 || (of[0] != 0 && of[5] != 0)) refuse("only constant values are possible");
      const double value = of[0] * std::min(of[4], 1.0);
      if (kind == "vlocy") {
        driven[degree] = value;
      } else if (value != 0) {
        refuse("forces of DRV_DOF.DAT are not read: give them as a table of [[forces]]");
      }
    }
    return driven;
  }

 private:
  double number_of(const std::string& key, const std::string& text) const {
    const auto value = printed_number(text);
    if (!value || !std::isfinite(*value)) {
      refuse(fmt::format("{}: '{}' is no finite number", key, text));
    }
    return *value;
  }

  void read_entries(const std::string& text, Entries& to) const {
    constexpr const char* kBlanks = " \t\r";
    for (std::size_t at = text.find('='); at != std::string::npos; at = text.find('=', at + 1)) {
      const std::size_t last = text.find_last_not_of(kBlanks, at - (at > 0 ? 1 : 0));
      const std::size_t first = text.find_last_of(kBlanks, last);
      const std::string key = text.substr(first == std::string::npos ? 0 : first + 1, last - first);
      const std::size_t from = text.find_first_not_of(kBlanks, at + 1);
      const std::size_t end = text.find_first_of(kBlanks, from);
      to[key] = number_of(key, text.substr(std::min(from, text.size()), end - from));
    }
  }

  std::filesystem::path path_;
  std::string kind_;
  std::istringstream file_;
  int line_ = 0;
};

/// Adds displacement and velocity of a record of DOF.INI. In 3D the spin is that in the frame a, b, c
/// of the body.
void add_motion(const RecordReader& file, const Entries& of, int dim, PositionRow& row) {
  const auto get = [&](const char* name, int k) {
    return file.entry(of, fmt::format("{}({})", name, k));
  };
  for (int k = 0; k < dim; ++k) {
    row.x[k] += get("X", k + 1);
    row.v[k] = get("V", k + 1);
  }
  if (dim == 2) {
    row.spin[2] = get("V", 3);
    return;
  }
  const char* const axes[] = {"a", "b", "c"};
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) row.spin[k] += get("V", 4 + axis) * get(axes[axis], k + 1);
  }
}

/// Spins of driven spheres must be 0: their axes turn.
void drive(const RecordReader& file, const std::vector<std::string>& lines, int body, int dim,
           PositionRow& row) {
  const std::map<int, double> driven = file.driven_velocities(lines);
  if (driven.empty()) return;
  const int degrees = dim == 2 ? 3 : 6;
  row.driven = true;
  row.v = row.spin = Vec3::Zero();
  for (int k = 1; k <= degrees; ++k) {
    const auto it = driven.find(k);
    if (it == driven.end() || driven.size() != to_size(degrees)) {
      file.refuse(
          fmt::format("body {}: {} degrees of freedom are driven, of {}; a body is driven as "
                      "a whole or not",
                      body, driven.size(), degrees));
    }
    if (k <= dim) {
      row.v[k - 1] = it->second;
    } else if (dim == 2) {
      row.spin[2] = it->second;
    } else if (it->second != 0) {
      file.refuse(fmt::format("body {}: a driven sphere cannot turn", body));
    }
  }
}

}  // namespace

std::vector<PositionRow> read_lmgc90_bodies(const std::filesystem::path& path, int dim,
                                            std::map<std::string, int>* left_out) {
  const std::string round = dim == 2 ? "DISKx" : "SPHER";
  RecordReader bodies(path, dim);
  RecordReader::Record record;
  std::vector<PositionRow> rows;
  std::vector<int> row_of;  // of each body in the file, in order; -1: left out
  while (bodies.next(record)) {
    row_of.push_back(-1);
    const auto count = std::count(record.contactors.begin(), record.contactors.end(), round);
    if (count == 0) {
      for (const std::string& contactor : record.contactors) {
        if (left_out != nullptr) ++(*left_out)[contactor];
      }
      continue;
    }
    if (record.contactors.size() > 1) {
      bodies.refuse(fmt::format("body {} has {} contactors: give it as a table of [[clusters]]",
                                row_of.size(), record.contactors.size()));
    }
    row_of.back() = static_cast<int>(rows.size());
    PositionRow& row = rows.emplace_back();
    for (int k = 0; k < dim; ++k) {
      row.x[k] = bodies.entry(record.entries, fmt::format("coo{}", k + 1));
    }
    row.radius = bodies.entry(record.contactor, "byrd");
    if (!(row.radius > 0)) bodies.refuse(fmt::format("byrd= {} is not positive", row.radius));
  }
  // Calls take(file, record, row) for the bodies of another file in the folder, if it is there.
  const auto each_body = [&](const char* name, const auto& take) {
    const std::filesystem::path other = path.parent_path() / name;
    if (!std::filesystem::exists(other)) return;
    RecordReader file(other, dim);
    std::vector<bool> met(row_of.size());
    while (file.next(record)) {
      if (record.number < 1 || to_size(record.number) > row_of.size()) {
        file.refuse(
            fmt::format("there is no body {} in {}", record.number, path.filename().string()));
      }
      if (met[to_size(record.number - 1)]) {
        file.refuse(fmt::format("body {} stands there twice", record.number));
      }
      met[to_size(record.number - 1)] = true;
      const int row = row_of[to_size(record.number - 1)];
      if (row >= 0) take(file, rows[to_size(row)]);
    }
  };
  each_body("DOF.INI", [&](const RecordReader& file, PositionRow& row) {
    add_motion(file, record.entries, dim, row);
  });
  each_body("DRV_DOF.DAT", [&](const RecordReader& file, PositionRow& row) {
    drive(file, record.driven, record.number, dim, row);
  });
  return rows;
}

}  // namespace bipot
