#include "bench/page/watch_server.h"

#include <stdexcept>

#ifdef BIPOT_WITH_HTTPLIB
#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "bench/page/run_page.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#endif

namespace bipot {

#ifdef BIPOT_WITH_HTTPLIB
namespace {

using Seconds = std::chrono::duration<double>;

constexpr const char* kHost = "127.0.0.1";
constexpr double kLeastWait = 0.4;   // between the updates of a page                       [s]
constexpr double kWorkShare = 0.05;  // of the time, at most, for updates
constexpr double kFarewell = 10.0;   // at most, for answers under way when the run ends     [s]
constexpr std::size_t kThreads = 8;  // pages wait in one each

/// Lives until the answer is sent, or cannot be: the library drops one under way when it stops.
using Answering = std::shared_ptr<void>;

/// As it is: the data in it are compressed already, and the library would try for seconds.
void send(httplib::Response& response, std::string content, const std::string& type,
          const Answering& answering) {
  const auto text = std::make_shared<const std::string>(std::move(content));
  response.set_content_provider(
      text->size(), type,
      [text, answering](std::size_t begin, std::size_t size, httplib::DataSink& sink) {
        return sink.write(text->data() + begin, size);
      });
}

}  // namespace

struct WatchServer::Parts {
  httplib::Server http;
  int port = 0;
  std::filesystem::path folder;
  std::thread thread;

  std::mutex working;  // one answer is made at a time
  std::mutex mutex;    // of what follows
  std::condition_variable changed;
  double wait = kLeastWait;  // [s]
  int under_way = 0;         // answers
  bool ended = false;        // the run
  bool closed = false;       // no further answers

  /// Empty once the server closes: status 503.
  Answering begin(httplib::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (closed) {
      response.status = 503;
      return {};
    }
    ++under_way;
    return Answering(this, [](Parts* parts) {
      const std::lock_guard<std::mutex> ending(parts->mutex);
      --parts->under_way;
      parts->changed.notify_all();
    });
  }
  /// Answers when the last answer's cost is a small share of the time, at once at the end.
  std::string update(int after) {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait_for(lock, Seconds(wait), [this] { return ended; });
    const bool over = ended;
    lock.unlock();
    std::unique_lock<std::mutex> turn(working);
    const Stopwatch watch;
    std::string answer = page_update(folder, after, over);
    const double cost = watch.seconds();
    turn.unlock();
    lock.lock();
    wait = std::max(kLeastWait, cost / kWorkShare);
    return answer;
  }
};

WatchServer::WatchServer(int port) : parts_(std::make_unique<Parts>()) {
  httplib::Server& http = parts_->http;
  // The library's own choice lets two programs share a port.
  http.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  http.set_keep_alive_max_count(1);
  http.set_keep_alive_timeout(1);
  http.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  parts_->port = port;
  if (port == 0) {
    parts_->port = http.bind_to_any_port(kHost);
  } else if (!http.bind_to_port(kHost, port)) {
    throw std::invalid_argument(
        fmt::format("--port {} is in use: another number, or 0 for any free port", port));
  }
}

WatchServer::~WatchServer() { finish(); }

std::string WatchServer::address() const {
  return fmt::format("http://{}:{}/", kHost, parts_->port);
}

void WatchServer::serve(const std::filesystem::path& folder) {
  Parts& parts = *parts_;
  parts.folder = folder;
  // A page of another site may name this machine as its own; it cannot name the host.
  parts.http.set_pre_routing_handler(
      [&parts](const httplib::Request& request, httplib::Response& response) {
        using Handled = httplib::Server::HandlerResponse;
        const std::string host = request.get_header_value("Host");
        for (const char* own : {kHost, "localhost"}) {
          if (host == fmt::format("{}:{}", own, parts.port)) return Handled::Unhandled;
        }
        response.status = 403;
        return Handled::Handled;
      });
  parts.http.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, std::exception_ptr thrown) {
        response.status = 500;
        try {
          std::rethrow_exception(thrown);
        } catch (const std::exception& defect) {
          response.set_content(defect.what(), "text/plain; charset=utf-8");
        }
      });
  parts.http.Get("/", [&parts](const httplib::Request&, httplib::Response& response) {
    const Answering answering = parts.begin(response);
    if (!answering) return;
    const std::lock_guard<std::mutex> turn(parts.working);
    send(response, live_run_page(parts.folder), "text/html; charset=utf-8", answering);
  });
  parts.http.Get("/update", [&parts](const httplib::Request& request, httplib::Response& response) {
    const Answering answering = parts.begin(response);
    if (!answering) return;
    send(response, parts.update(whole_number<int>(request.get_param_value("after")).value_or(-1)),
         "application/json", answering);
  });
  const InterruptBlock block;
  parts.thread = std::thread([&parts] { parts.http.listen_after_bind(); });
}

void WatchServer::finish() {
  Parts& parts = *parts_;
  if (!parts.thread.joinable()) return;
  {
    std::unique_lock<std::mutex> lock(parts.mutex);
    parts.ended = true;
    parts.changed.notify_all();
    parts.changed.wait_for(lock, Seconds(kFarewell), [&parts] { return parts.under_way == 0; });
    parts.closed = true;
  }
  parts.http.stop();
  parts.thread.join();
}

#else

struct WatchServer::Parts {};
WatchServer::WatchServer(int) {
  throw std::invalid_argument("--watch: this program was built without cpp-httplib");
}
WatchServer::~WatchServer() = default;
std::string WatchServer::address() const { return {}; }
void WatchServer::serve(const std::filesystem::path&) {}
void WatchServer::finish() {}

#endif

}  // namespace bipot
