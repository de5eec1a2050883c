#include "bench/compare/isolated_jobs.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <system_error>

#include "core/base/stopwatch.h"

namespace bipot {
namespace {

constexpr int kExceptionCode = 70;

void write_all(int file, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t done = ::write(file, at, size);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) _exit(kExceptionCode);
    at += done;
    size -= static_cast<std::size_t>(done);
  }
}

/// Work of the child: records of a length and a text. It never returns.
[[noreturn]] void work(const IsolatedJobs& jobs, int first, int out) {
  try {
    for (int k = first; k < jobs.count; ++k) {
      std::string text;
      nlohmann::json::to_cbor(jobs.job(k), text);
      const std::uint64_t size = text.size();
      write_all(out, &size, sizeof size);
      write_all(out, text.data(), text.size());
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bipot: a job ended with an exception: %s\n", e.what());
    _exit(kExceptionCode);
  }
  _exit(0);
}

/// One child and the pipe it writes to.
class Child {
 public:
  Child(const IsolatedJobs& jobs, int first) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    std::fflush(nullptr);
    pid_ = ::fork();
    if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (pid_ == 0) {
      ::close(ends[0]);
      work(jobs, first, ends[1]);
    }
    ::close(ends[1]);
    in_ = ends[0];
  }
  ~Child() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      wait();
    }
    ::close(in_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  enum class Event { kRecord, kEnd, kQuiet };

  /// Waits for the next record, the end of the child, or `seconds`.
  Event next(double seconds, std::string& text) {
    for (;;) {
      if (take_record(text)) return Event::kRecord;
      pollfd ready{.fd = in_, .events = POLLIN, .revents = 0};
      const int got = ::poll(&ready, 1, static_cast<int>(1000 * seconds));
      if (got == 0 || (got < 0 && errno == EINTR)) return Event::kQuiet;
      std::array<char, 4096> buffer{};
      const ssize_t size = ::read(in_, buffer.data(), buffer.size());
      if (size < 0 && errno == EINTR) return Event::kQuiet;
      if (size <= 0) return Event::kEnd;
      pending_.append(buffer.data(), static_cast<std::size_t>(size));
    }
  }

  /// How it ended; empty: in good order.
  std::string wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = 0;
    if (WIFSIGNALED(status)) {
      return fmt::format("killed by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
    }
    if (WEXITSTATUS(status) == kExceptionCode) return "ended with an exception";
    if (WEXITSTATUS(status) != 0) return fmt::format("exit code {}", WEXITSTATUS(status));
    return {};
  }

 private:
  bool take_record(std::string& text) {
    std::uint64_t size = 0;
    if (pending_.size() < sizeof size) return false;
    std::memcpy(&size, pending_.data(), sizeof size);
    if (pending_.size() < sizeof size + size) return false;
    text = pending_.substr(sizeof size, size);
    pending_.erase(0, sizeof size + size);
    return true;
  }

  pid_t pid_ = 0;
  int in_ = -1;
  std::string pending_;
};

}  // namespace

void run_isolated(const IsolatedJobs& jobs) {
  const auto interrupted = [&] { return jobs.interrupted && jobs.interrupted(); };
  int next = 0;
  while (next < jobs.count && !interrupted()) {
    Child child(jobs, next);
    Stopwatch since_record;
    for (bool alive = true; alive && next < jobs.count;) {
      if (interrupted()) return;
      IsolatedJobs::End end;
      std::string record;
      switch (child.next(0.1, record)) {
        case Child::Event::kRecord:
          end.result = nlohmann::json::from_cbor(record);
          break;
        case Child::Event::kEnd:
          end = {IsolatedJobs::End::Kind::kCrashed, {}, child.wait()};
          alive = false;
          break;
        case Child::Event::kQuiet:
          if (since_record.seconds() < jobs.seconds) continue;
          end = {IsolatedJobs::End::Kind::kHung,
                 {},
                 fmt::format("no end within {:g} s", jobs.seconds)};
          alive = false;
          break;
      }
      jobs.on_end(next, end);
      ++next;
      since_record = Stopwatch();
    }
  }
}

}  // namespace bipot
