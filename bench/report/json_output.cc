#include "bench/report/json_output.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "core/base/file_error.h"

namespace bipot {
namespace {

Json finite_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

}  // namespace

void add_error(Json& json, const ContactError& error) {
  json["epsilon"] = finite_or_null(error.epsilon);
  json["eta"] = finite_or_null(error.eta);
  json["epsilon_raw"] = finite_or_null(error.raw42);
  json["natural_map"] = finite_or_null(error.natural_map);
  const int worst = error.eta > error.epsilon ? error.worst_eta : error.worst_epsilon;
  json["worst_contact"] = worst >= 0 ? Json(worst) : Json(nullptr);
}

void require_writable(const std::string& destination) {
  if (destination.empty() || destination == "-") return;
  std::error_code none;
  const bool there = std::filesystem::exists(destination, none);
  if (std::filesystem::is_directory(destination, none)) {
    throw FileError(destination, "", "cannot be written: it is a folder");
  }
  const bool writable = std::ofstream(destination, std::ios::app).is_open();
  if (!there) std::filesystem::remove(destination, none);
  if (!writable) throw FileError(destination, "", "cannot be written");
}

void write_json(const Json& json, const std::string& destination) {
  if (destination == "-") {
    std::cout << json.dump(2) << std::endl;
    return;
  }
  std::ofstream file(destination);
  file << json.dump(2) << '\n';
  file.close();
  if (!file) throw FileError(destination, "", "cannot be written");
}

}  // namespace bipot
