#include "tools/demo/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstring>
#include <thread>

#include "palpate/core/file.h"

extern char** environ;

namespace palpate::tools::demo {

Expected<ChildProcess> ChildProcess::start(const std::filesystem::path& program,
                                           const std::vector<std::string>& arguments,
                                           const std::filesystem::path& log) {
  std::string name = program.string(), log_name = log.string();
  std::vector<std::string> copy = arguments;
  std::vector<char*> argv{name.data()};
  for (auto& argument : copy) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, log_name.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  pid_t pid = -1;
  const int code = ::posix_spawn(&pid, name.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (code != 0) return refused("{}: cannot be started ({})", name, std::strerror(code));
  return ChildProcess(pid);
}

bool ChildProcess::running() { return !wait(std::chrono::milliseconds(0)).has_value(); }

std::optional<int> ChildProcess::wait(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!status_ && pid_ > 0) {
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) == pid_) {
      status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      break;
    }
    if (std::chrono::steady_clock::now() >= until) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return status_;
}

void ChildProcess::ask_to_stop() {
  if (pid_ > 0 && !status_) ::kill(pid_, SIGTERM);
}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0 || status_) return;
  ask_to_stop();
  if (!wait(std::chrono::seconds(3))) {
    ::kill(pid_, SIGKILL);
    wait(std::chrono::seconds(3));
  }
}

std::string last_words(const std::filesystem::path& log) {
  auto text = read_file(log);
  if (!text) return "no message";
  while (!text->empty() && text->back() == '\n') text->pop_back();
  const auto line = text->substr(text->rfind('\n') + 1);
  return line.empty() ? "no message" : line;
}

}  // namespace palpate::tools::demo
