#pragma once

#include <initializer_list>

#include "core/scene_files/scene_file.h"
#include "tests/support/test.h"

namespace bipot {

/// read(text), of any dimension, must throw SceneFileError with a message that begins with the
/// file's name, test.toml, and holds every one of `parts`.
template <class Read>
void expect_scene_refused(const std::string& text, std::initializer_list<std::string> parts,
                          const Read& read) {
  const std::string message = refusal_of<SceneFileError>([&] { read(text); });
  EXPECT_EQ(message.rfind("test.toml", 0), 0u) << message << ":\n" << text;
  for (const std::string& part : parts) EXPECT_TRUE(says(message, part));
}
inline void expect_scene_refused(const std::string& text,
                                 std::initializer_list<std::string> parts) {
  expect_scene_refused(text, parts, [](const auto& t) { parse_any_scene(t, "test.toml"); });
}

/// Such a check of one part for texts that stand between `before` and `after`.
inline auto refused_scenes(const std::string& after, const std::string& before = "") {
  return [=](const std::string& text, const std::string& part) {
    expect_scene_refused(before + text + after, {part});
  };
}

}  // namespace bipot
