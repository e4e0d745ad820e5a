#include "palpate/core/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>

#include "palpate/core/system_error.h"

extern char** environ;

namespace palpate::inline core {
namespace {

constexpr int kSignalled = 128;       // exit codes from here on stand for signals
constexpr int kReportDescriptor = 9;  // of the child

// This process's environment with where the reports go, as posix_spawn takes it.
class Environment {
 public:
  Environment() {
    const std::string variable = std::string(kReportVariable) + "=";
    for (char** one = environ; *one != nullptr; ++one)
      if (!std::string_view(*one).starts_with(variable)) pointers_.push_back(*one);
    report_ = variable + std::to_string(kReportDescriptor);
    pointers_.push_back(report_.data());
    pointers_.push_back(nullptr);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  char** get() { return pointers_.data(); }

 private:
  std::string report_;
  std::vector<char*> pointers_;
};

}  // namespace

Expected<ChildProcess> ChildProcess::start(const std::filesystem::path& program,
                                           const std::vector<std::string>& arguments,
                                           const std::filesystem::path& log) {
  std::string name = program.string(), log_name = log.string();
  std::vector<std::string> copy = arguments;
  std::vector<char*> argv{name.data()};
  for (auto& argument : copy) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
    return refused("{}: cannot be started ({})", name, reason_of(errno));
  ReportReader reports{FileDescriptor(pipe[0])};
  FileDescriptor childs(pipe[1]);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, log_name.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, childs.get(), kReportDescriptor);
  pid_t pid = -1;
  Environment environment;
  const int code = ::posix_spawn(&pid, name.c_str(), &actions, nullptr, argv.data(), environment.get());
  posix_spawn_file_actions_destroy(&actions);
  childs.close();
  if (code != 0) return refused("{}: cannot be started ({})", name, reason_of(code));
  return ChildProcess(pid, std::move(reports), log);
}

bool ChildProcess::running() { return !wait(std::chrono::milliseconds(0)).has_value(); }

std::optional<int> ChildProcess::wait(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!status_ && pid_ > 0) {
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) == pid_) {
      status_ = WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
      break;
    }
    if (std::chrono::steady_clock::now() >= until) return std::nullopt;
    reports_.read();  // a full pipe would hold it up
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return status_;
}

void ChildProcess::ask_to_stop() {
  if (pid_ > 0 && !status_) ::kill(pid_, SIGTERM);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      status_(other.status_),
      log_(std::move(other.log_)),
      reports_(std::move(other.reports_)) {}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0 || status_) return;
  ask_to_stop();
  if (!wait(std::chrono::seconds(3))) {
    ::kill(pid_, SIGKILL);
    wait(std::chrono::seconds(3));
  }
}

const ReportReader& ChildProcess::reports() {
  reports_.read();
  return reports_;
}

std::string ChildProcess::why_it_ended() {
  if (const auto& error = reports().error()) return *error;
  if (status_ && *status_ > kSignalled)
    return std::string("it was ended by signal ") + std::to_string(*status_ - kSignalled) + " (" +
           ::strsignal(*status_ - kSignalled) + ")";
  return "it told nothing; its log: " + log_.string();
}

}  // namespace palpate::inline core
