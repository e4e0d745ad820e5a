#include "tools/commands/terminal_panel.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "palpate/core/text.h"

namespace palpate::tools::commands {
namespace {

using calibration::session::PanelKey;
using calibration::session::Review;

constexpr auto kLogged = std::chrono::seconds(5);
constexpr int kLook = 100, kLookElsewhere = 20;  // ms between looks at whether to stop, and at further keys

}  // namespace

TerminalPanel::TerminalPanel(std::shared_ptr<calibration::session::InstructionFile> instructions,
                             const std::atomic<bool>& stop)
    : instructions_(std::move(instructions)), stop_(stop), draws_(isatty(STDERR_FILENO) != 0) {
  termios now{};
  if (isatty(STDIN_FILENO) == 0 || tcgetattr(STDIN_FILENO, &now) != 0) return;
  before_ = now;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // Ctrl-C stays a signal
  tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

TerminalPanel::~TerminalPanel() {
  if (draws_ && told_) std::fputc('\n', stderr);
  if (before_) tcsetattr(STDIN_FILENO, TCSAFLUSH, &*before_);
}

void TerminalPanel::line(const std::string& text) {
  std::fprintf(stderr, "%s%s\n", draws_ && told_ ? "\r\x1b[K" : "", one_line(text).c_str());
  std::fflush(stderr);
  told_ = false;
}

void TerminalPanel::begin_step(std::size_t step, std::size_t steps, const std::string& name) {
  line(fmt::format("--- {} of {}: {}", step + 1, steps, name));
  instructions_->write({{"step", name}, {"number", step + 1}, {"of", steps}});
}

void TerminalPanel::keep_step(const std::string& name, const std::string& words) {
  line(fmt::format("done before: {}: {}", name, words));
  instructions_->write({{"kept", name}, {"words", words}});
}

void TerminalPanel::show(const device::Request& request, const std::string& text) {
  line(text);
  instructions_->write(request, text);
}

void TerminalPanel::tell(const std::string& text) {
  if (!draws_) return log_told(text);
  if (told_ && text == last_told_) return;
  last_told_ = text;
  std::fprintf(stderr, "\r\x1b[K  %s", one_line(text).c_str());
  std::fflush(stderr);
  told_ = true;
}

// Where nobody sees a last line: now and then a line of its own.
void TerminalPanel::log_told(const std::string& text) {
  const auto now = std::chrono::steady_clock::now();
  if (text.empty() || text == last_told_ || now < next_told_) return;
  last_told_ = text;
  next_told_ = now + kLogged;
  line("  " + text);
}

void TerminalPanel::guided(const calibration::session::GuidanceState& state, int of) {
  const std::string text =
      fmt::format("pose {} of {}, {}", state.poses, of, calibration::session::guidance_text(state));
  if (draws_)
    tell(text);
  else
    line("  " + text);
}

void TerminalPanel::released() { instructions_->write({{"released", true}}); }

void TerminalPanel::taken() {
  if (draws_)
    std::fputc('\a', stderr);
  else
    line("  taken");
  instructions_->write({{"taken", true}});
}

std::optional<char> TerminalPanel::press(int ms) {
  if (more_keys_)
    if (const auto pressed = more_keys_()) return pressed;
  if (ended_ && !more_keys_) return 'q';
  pollfd input{ended_ ? -1 : STDIN_FILENO, POLLIN, 0};  // of -1 poll only waits
  if (poll(&input, 1, more_keys_ ? std::min(ms, kLookElsewhere) : ms) <= 0) return std::nullopt;
  char key = 0;
  const auto got = read(STDIN_FILENO, &key, 1);
  if (got < 0 && errno == EINTR) return std::nullopt;
  if (got != 1) {
    ended_ = true;
    return more_keys_ ? std::nullopt : std::optional('q');
  }
  return static_cast<char>(std::tolower(static_cast<unsigned char>(key)));
}

std::optional<PanelKey> TerminalPanel::key() {
  const auto pressed = press(0);
  if (!pressed) return std::nullopt;
  switch (*pressed) {
    case '\n':
    case '\r':
    case ' ':
      return PanelKey::proceed;
    case 'n':
      return PanelKey::no_more;
    case 's':
      return PanelKey::skip;
    case 'q':
      return PanelKey::stop;
    default:
      return std::nullopt;
  }
}

Review TerminalPanel::review(const calibration::session::StepOutcome& outcome) {
  line(fmt::format("{} {}: {}", outcome.done ? "done" : "FAILED", outcome.step, outcome.words));
  line(fmt::format("{}r: repeat it{}, q: stop", outcome.done ? "Enter: go on, " : "",
                   outcome.first ? "" : ", u: the one before, too"));
  // What was pressed before this could be read was meant for something else.
  while (const auto early = press(0))
    if (*early == 'q') return Review::stop;
  instructions_->write({{"ended", outcome.step}, {"done", outcome.done}, {"words", outcome.words}});
  while (!stop_.load()) {
    const auto pressed = press(kLook);
    if (!pressed) continue;
    if (outcome.done && (*pressed == '\n' || *pressed == '\r' || *pressed == ' ')) return Review::go_on;
    if (*pressed == 'r') return Review::repeat;
    if (*pressed == 'u' && !outcome.first) return Review::undo;
    if (*pressed == 'q') break;
  }
  return Review::stop;
}

}  // namespace palpate::tools::commands
