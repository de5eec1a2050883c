#pragma once

#include <map>
#include <string>

namespace bipot {

/// Changes to a scene file.
struct SceneChanges {
  double step = 0;      ///< [time] step                                                 [s]
  int num_steps = 0;    ///< [time] steps, if the file counts them; a duration stays
  double accuracy = 0;  ///< [time] accuracy; 0: as it is
  std::string solver;
  std::map<std::string, std::string> parameters;  ///< the solver's own
  double tol = 0;
  bool warm_start = true;
  std::string comment;  ///< one line, without #, above each changed line
};

/// The text of a scene with these changes alone: comments, order and layout stay. A changed line
/// gets a comment above it with the former text. The stop test becomes "guarded". Parameters of
/// another solver are removed. The result is parsed and compared with the scene before: bodies,
/// walls, laws and output are the same. Throws SceneFileError for a text that is no scene,
/// std::runtime_error for a layout that this cannot handle.
std::string rewrite_scene(const std::string& text, const std::string& source,
                          const SceneChanges& changes);

}  // namespace bipot
