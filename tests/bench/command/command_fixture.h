#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>

#include "tests/support/command_line.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test.h"

namespace bipot {

/// Runs the built command.
inline Outcome bipot(const std::string& arguments) {
  return run_command_line(BIPOT_COMMAND, arguments);
}

/// The exit code alone.
inline int code_of(const std::string& arguments) { return bipot(arguments).exit_code; }

/// The JSON on its standard output, with nothing else there (--json - among the arguments), when it
/// ends with this exit code.
inline nlohmann::json json_of(const std::string& arguments, int code = 0) {
  const Outcome run = bipot(arguments);
  EXPECT_EQ(run.exit_code, code) << arguments;
  return nlohmann::json::parse(run.out);
}

/// What it says on both streams, in one text.
inline Outcome whole_output(const std::string& arguments) {
  return run_command_line(BIPOT_COMMAND, arguments + " 2>&1 #");
}

/// What it says on standard error.
inline Outcome complaints(const std::string& arguments) {
  return run_command_line(BIPOT_COMMAND, arguments + " 2>&1 >/dev/null #");
}

/// It ends with this exit code and says each of the parts, where `run` listens. All that it says.
inline std::string expect_said(const std::string& arguments, int code,
                               const std::vector<std::string>& parts,
                               Outcome (*run)(const std::string&) = &whole_output) {
  const Outcome outcome = run(arguments);
  EXPECT_EQ(outcome.exit_code, code) << arguments << ": " << outcome.out;
  for (const std::string& part : parts) EXPECT_TRUE(says(outcome.out, part)) << arguments;
  return outcome.out;
}

/// A fresh folder for one test, removed at its end. The test and its commands run in it: names of
/// files are relative to it.
class Command : public ::testing::Test {
 protected:
  Command() { fs::current_path(folder_); }
  ~Command() override { fs::current_path(folder_.parent_path()); }
  /// The name from the root, for what is asked in that form.
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string write(const std::string& name, const std::string& text) {
    std::ofstream(name) << text;
    return name;
  }
  /// Each of these files in a folder has more than `size` bytes.
  static void expect_files(const fs::path& folder, std::initializer_list<const char*> names,
                           std::size_t size = 100) {
    for (const char* name : names) {
      EXPECT_GT(fs::file_size(folder / name), size) << name;
    }
  }
  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
};

/// Runs bipot and interrupts it after a second, which it must say by its exit code; again after
/// twenty if it lives, as a shell's children in the background ignore SIGINT until they ask for it
/// themselves. (A second one ends it at once.)
inline void expect_interrupted(const std::string& arguments) {
  const int code =
      code_of(arguments +
              " >/dev/null & p=$!; sleep 1; kill -INT $p; for k in $(seq 600); do sleep 0.1; "
              "kill -0 $p || break; [ $((k % 200)) = 0 ] && kill -INT $p; done; wait $p; exit $?");
  EXPECT_EQ(code, 5) << arguments;
}

inline std::string content(const fs::path& file) { return file_text(file); }
inline nlohmann::json json_in(const fs::path& file) {
  return nlohmann::json::parse(file_text(file));
}

/// Files of this checkout.
inline std::string shipped_problem(const std::string& name) {
  return source_folder().string() + "/data/problems/" + name + ".hdf5";
}
inline std::string shipped_scene(const std::string& name) {
  return source_folder().string() + "/data/scenes/" + name + ".toml";
}

/// The text with the first occurrence of each `from` replaced.
inline std::string changed(std::string text,
                           const std::vector<std::pair<std::string, std::string>>& from_to) {
  for (const auto& [from, to] : from_to) text.replace(text.find(from), from.size(), to);
  return text;
}

}  // namespace bipot
