#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/support/command_line.h"

namespace bipot {

/// Runs the built command.
inline Outcome bipot(const std::string& arguments) {
  return run_command_line(BIPOT_COMMAND, arguments);
}

/// The JSON on its standard output, with nothing else there (--json - among the arguments), when it
/// ends with this exit code.
inline nlohmann::json json_of(const std::string& arguments, int code = 0) {
  const Outcome run = bipot(arguments);
  EXPECT_EQ(run.exit_code, code) << arguments;
  return nlohmann::json::parse(run.out);
}

/// A fresh folder for one test, removed at its end.
class Command : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("bipot_") + info->name() + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::filesystem::current_path(folder_);  // runs without --out write there
  }
  void TearDown() override {
    std::filesystem::current_path(folder_.parent_path());
    std::filesystem::remove_all(folder_);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
    return path(name);
  }
  std::filesystem::path folder_;
};

/// Runs bipot and interrupts it after a second; again after twenty if it lives, as a shell's
/// children in the background ignore SIGINT until they ask for it themselves. (A second one ends it
/// at once.)
inline Outcome interrupted(const std::string& arguments) {
  return bipot(arguments +
               " >/dev/null & p=$!; sleep 1; kill -INT $p; for k in $(seq 600); do sleep 0.1; "
               "kill -0 $p || break; [ $((k % 200)) = 0 ] && kill -INT $p; done; wait $p; exit $?");
}

inline std::string content(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

}  // namespace bipot
