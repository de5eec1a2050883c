#include "bench/report/json_output.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/base/file_error.h"
#include "core/files/atomic_file.h"

namespace bipot {

void add_error(Json& json, const ContactError& error) {
  json["epsilon"] = error.epsilon;
  json["eta"] = error.eta;
  json["epsilon_raw"] = error.raw42;
  json["natural_map"] = error.natural_map;
  const int worst = error.eta > error.epsilon ? error.worst_eta : error.worst_epsilon;
  json["worst_contact"] = worst >= 0 ? Json(worst) : Json(nullptr);
}

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

double number_or_nan(const Json& json) { return json.is_null() ? kNaN : json.get<double>(); }

void require_writable(const std::string& destination) {
  if (destination.empty() || destination == "-") return;
  std::error_code none;
  const auto status = std::filesystem::status(destination, none);
  const bool there = std::filesystem::exists(status);
  if (std::filesystem::is_directory(status)) {
    throw FileError(destination, "", "cannot be written: it is a folder");
  }
  // Opening a pipe would wait for its reader.
  if (there && !std::filesystem::is_regular_file(status)) return;
  const bool writable = std::ofstream(destination, std::ios::app).is_open();
  const std::string reason = std::strerror(errno);
  // Through a link to nothing, what it names was made.
  if (!there) std::filesystem::remove(std::filesystem::canonical(destination, none), none);
  if (!writable) throw FileError(destination, "", "cannot be written: " + reason);
}

void require_apart(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read) {
  const auto same = [](const NamedFile& one, const NamedFile& other) {
    if (one.path.empty() || one.path == "-" || other.path.empty()) return false;
    std::error_code none;
    const auto place = [&](const std::string& path) {
      return std::filesystem::weakly_canonical(path, none);
    };
    return std::filesystem::equivalent(one.path, other.path, none) ||
           place(one.path) == place(other.path);
  };
  std::vector<NamedFile> others = read;
  for (const NamedFile& file : written) {
    for (const NamedFile& other : others) {
      if (!same(file, other)) continue;
      throw std::invalid_argument(file.option + " and " + other.option +
                                  " name the same file: " + file.path);
    }
    others.push_back(file);
  }
}

void write_json(const Json& json, const std::string& destination) {
  if (destination == "-") {
    errno = 0;
    std::cout << json_text(json, 2) << std::endl;
    if (!std::cout) throw FileError("standard output", "", std::strerror(errno));
    return;
  }
  write_text_file(destination, json_text(json, 2) + '\n');
}

}  // namespace bipot
