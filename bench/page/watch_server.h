#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace bipot {

/// Serves the page of a run to this machine (127.0.0.1) while the run goes on:
///   /                  live_run_page()
///   /update?after=S    page_update(), which comes once there is something new to see
/// It reads the files of the run alone, from threads of its own. It takes at most a twentieth of
/// the time. Only this file's source uses the library cpp-httplib.
class WatchServer {
 public:
  /// `port`: 0, any that is free. Throws std::invalid_argument if it is in use, or if the program
  /// was built without the library.
  explicit WatchServer(int port);
  ~WatchServer();

  std::string address() const;
  /// Begins to answer. The folder must hold a run with a film.
  void serve(const std::filesystem::path& folder);
  /// The run is over: finishes the answers under way, for at most ten seconds, and ends.
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace bipot
