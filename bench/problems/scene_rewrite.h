#pragma once

#include <map>
#include <string>

namespace bipot {

/// What is changed in a scene file.
struct SceneChanges {
  double step = 0;    ///< [time] step                                                 [s]
  int num_steps = 0;  ///< [time] steps, where the file counts them; a duration stays
  std::string solver;
  std::map<std::string, std::string> parameters;  ///< the solver's own
  double tol = 0;
  bool warm_start = true;
  std::string comment;  ///< one line, without #; stands above each changed line
};

/// The text of a scene with these changes and nothing else changed: comments, order and layout
/// stay. A changed line gets a line of comment above it that says what stood there. The stop test
/// becomes "guarded" where it was another, and parameters of another solver go. The result is
/// parsed and compared with the scene before: bodies, walls, laws and output are the same. Throws
/// SceneFileError for a text that is no scene, std::runtime_error where it is laid out in a way
/// that this does not follow.
std::string rewrite_scene(const std::string& text, const std::string& source,
                          const SceneChanges& changes);

}  // namespace bipot
