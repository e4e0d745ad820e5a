#include "palpate/core/child_report.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include "palpate/core/no_pipe_signal.h"

namespace palpate::inline core {
namespace {

// How long a child waits for a parent that does not read.
constexpr int kPatienceMs = 2000;

// The descriptor that a parent left for this process; -1: none.
int taken_over() {
  const char* text = std::getenv(kReportVariable);
  if (text == nullptr) return -1;
  int descriptor = -1;
  const char* end = text + std::strlen(text);
  const auto [stopped, code] = std::from_chars(text, end, descriptor);
  ::unsetenv(kReportVariable);
  // Whoever sets it by hand may name anything: only a pipe is written to.
  struct stat what {};
  if (code != std::errc{} || stopped != end || descriptor <= STDERR_FILENO ||
      ::fstat(descriptor, &what) != 0 || !S_ISFIFO(what.st_mode))
    return -1;
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  return descriptor;
}

std::mutex one_at_a_time;

// Taken over by the first caller; threads may tell until the process ends. one_at_a_time is held.
FileDescriptor& to_parent() {
  static auto& descriptor = *new FileDescriptor(taken_over());
  return descriptor;
}

}  // namespace

void tell_parent(const Json& report) {
  const std::lock_guard lock(one_at_a_time);
  auto& descriptor = to_parent();
  if (!descriptor) return;
  const std::string line = report.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  if (line.size() > kLongestReport) return;
  const NoPipeSignal quiet;  // a parent that is gone must not end the child
  for (std::string_view rest = line; !rest.empty();) {
    const ssize_t written = ::write(descriptor.get(), rest.data(), rest.size());
    if (written > 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
      continue;
    }
    if (errno == EINTR) continue;
    pollfd room{descriptor.get(), POLLOUT, 0};
    if (errno == EAGAIN && ::poll(&room, 1, kPatienceMs) > 0 && (room.revents & POLLOUT) != 0) continue;
    // Nobody reads: nothing more is told, as half a line is on its way.
    descriptor.close();
    return;
  }
}

void end_with_parent() {
  const std::lock_guard lock(one_at_a_time);
  if (!to_parent()) return;
  // One of its own: tell_parent() may close the other.
  const int watched = ::fcntl(to_parent().get(), F_DUPFD_CLOEXEC, 0);
  if (watched < 0) return;
  sigset_t all, before;  // signals stay with the threads that had them
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([watched] {
    pollfd reader{watched, 0, 0};  // an error is told always: that nobody can read any more
    while (::poll(&reader, 1, -1) < 0 && errno == EINTR) {
    }
    ::kill(::getpid(), SIGTERM);
  }).detach();
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void tell_parent_ready() { tell_parent({{"event", "ready"}}); }
void tell_parent_error(const std::string& message) {
  tell_parent({{"event", "error"}, {"message", message}});
}
void tell_parent_result(const Json& figures) { tell_parent({{"event", "result"}, {"figures", figures}}); }

void ReportReader::read() {
  std::array<char, 16384> some;
  while (descriptor_) {
    pollfd readable{descriptor_.get(), POLLIN, 0};
    if (::poll(&readable, 1, 0) <= 0) return;
    const ssize_t count = ::read(descriptor_.get(), some.data(), some.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    begun_.append(some.data(), static_cast<std::size_t>(count));
    std::size_t from = 0;
    for (auto end = begun_.find('\n'); end != std::string::npos; end = begun_.find('\n', from)) {
      take(std::string_view(begun_).substr(from, end - from));
      from = end + 1;
    }
    begun_.erase(0, from);
    if (begun_.size() > kLongestReport) begun_.clear();
  }
}

void ReportReader::take(std::string_view line) {
  const Json report = Json::parse(line, nullptr, false);
  if (!report.is_object()) return;
  const auto event = report.find("event"), message = report.find("message"), figures = report.find("figures");
  if (event == report.end()) return;
  if (*event == "ready") ready_ = true;
  if (*event == "error" && message != report.end() && message->is_string())
    error_ = message->get<std::string>();
  if (*event == "result" && figures != report.end()) result_ = *figures;
}

}  // namespace palpate::inline core
