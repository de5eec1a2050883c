#pragma once

#include <initializer_list>

#include "core/scene_files/scene_file.h"
#include "tests/support/test.h"

namespace bipot {

/// parse(text) must throw SceneFileError with a message that begins with the file's name,
/// test.toml, and holds every one of `parts`.
template <class Parse>
void expect_scene_refused(const Parse& parse, const std::string& text,
                          std::initializer_list<const char*> parts) {
  try {
    parse(text);
    ADD_FAILURE() << "accepted:\n" << text;
  } catch (const SceneFileError& e) {
    const std::string message = e.what();
    EXPECT_EQ(message.rfind("test.toml", 0), 0u) << message;
    for (const char* part : parts) EXPECT_TRUE(says(message, part));
  }
}

/// Such a check of one part for texts that stand between `before` and `after`, in any dimension.
inline auto refused_scenes(const std::string& after, const std::string& before = "") {
  return [=](const std::string& text, const std::string& part) {
    const auto parse = [&] { parse_any_scene(before + text + after, "test.toml"); };
    EXPECT_TRUE(says(refusal_of<SceneFileError>(parse), part)) << text;
  };
}

}  // namespace bipot
