#include "palpate/core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "palpate/core/text.h"

namespace palpate::inline core {

std::string time_left_text(double seconds) {
  const int s = static_cast<int>(std::ceil(std::max(0.0, seconds)));
  return s < 60 ? fmt::format("{} s left", s) : fmt::format("{}:{:02d} left", s / 60, s % 60);
}

Progress::Progress(std::vector<Phase> phases)
    : phases_(std::move(phases)), on_terminal_(::isatty(STDERR_FILENO) != 0), start_(Clock::now()) {
  for (const auto& phase : phases_) total_ += phase.expected_s;
}

Progress::~Progress() { finish(); }

void Progress::begin(std::size_t phase) {
  before_ = 0.0;
  for (std::size_t i = 0; i < phase && i < phases_.size(); ++i) before_ += phases_[i].expected_s;
  phase_ = std::min(phase, phases_.size() - 1);
  share_ = 0.0;
  said_.clear();
  draw(true);
}

void Progress::say(std::string what) {
  said_ = std::move(what);
  draw(false);
}

void Progress::update(double share) {
  share_ = std::clamp(share, 0.0, 1.0);
  draw(false);
}

double Progress::share() const {
  return total_ > 0 ? (before_ + share_ * phases_[phase_].expected_s) / total_ : 0.0;
}

void Progress::draw(bool force) {
  if (!on_terminal_) return;
  const auto now = Clock::now();
  if (!force && now - last_draw_ < std::chrono::milliseconds(200)) return;
  last_draw_ = now;
  const double done = share();
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const int width = 28, filled = static_cast<int>(done * width);
  // Before something has been done there is nothing to tell the time left from.
  const std::string left = done > 0.02 ? "  (" + time_left_text(elapsed * (1.0 - done) / done) + ")" : "";
  std::fprintf(
      stderr, "\r\x1b[K[%s%s] %3d %%  %s%s", std::string(static_cast<std::size_t>(filled), '#').c_str(),
      std::string(static_cast<std::size_t>(width - filled), '.').c_str(), static_cast<int>(100.0 * done),
      one_line(said_.empty() ? phases_[phase_].name : said_).c_str(), left.c_str());
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::finish() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);
  drawn_ = false;
  on_terminal_ = false;
}

}  // namespace palpate::inline core
