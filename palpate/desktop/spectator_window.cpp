#include "palpate/desktop/spectator_window.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "palpate/core/text.h"

namespace palpate::desktop {
namespace {

constexpr Size kMonitorSize{640, 480};
constexpr double kRadPerHeight = 3.0;  // that a drag over the window's height walks
constexpr double kStale_s = 0.25;      // without frames: warnings change all the same

}  // namespace

Expected<MonitorView> parse_monitor_view(std::string_view word) {
  for (const auto view : {MonitorView::copy, MonitorView::outside})
    if (word == monitor_view_word(view)) return view;
  return wrong_use("--monitor '{}': copy or outside is expected", excerpt(word));
}

std::string_view monitor_view_word(MonitorView view) {
  return view == MonitorView::copy ? "copy" : "outside";
}

Expected<std::unique_ptr<SpectatorWindow>> SpectatorWindow::open(MonitorView view, const Window& player,
                                                                 Outside outside,
                                                                 render::Onlooker& onlooker) {
  std::unique_ptr<SpectatorWindow> spectator(new SpectatorWindow(view, std::move(outside), onlooker));
  auto opened = Window::open("Palpate monitor", kMonitorSize, &player);
  if (!opened) return tl::unexpected(opened.error());
  spectator->window_ = std::move(*opened);
  return spectator;
}

void SpectatorWindow::show(const Sight& sight, int eye_width, const Clock<GraphicsClock>& clock) {
  const server::graphics::FrameRecord& frame = sight.frame;
  const auto begun = clock.now();
  looked_ = begun;
  const bool due = pace_.due(frame.begun, begun);
  if (!due) ++left_out_;
  if (!due || frame.rgb.empty()) return;
  if (view_ == MonitorView::outside || sight.from_outside) {
    const render::OutsidePicture& seen = outside_(frame);
    if (!seen.rgb.empty()) window_->take_picture(seen.rgb, {seen.width, seen.height});
  } else if (frame.width > eye_width) {
    const auto left = render::left_eye(frame.rgb, frame.width, frame.height, frame.width / eye_width);
    window_->take_picture(left, {eye_width, frame.height});
  } else {
    window_->take_picture(frame.rgb, {frame.width, frame.height});
  }
  draw(sight.content);
  ++drawn_;
  const Duration took = clock.now() - begun;
  took_.add(took);
  pace_.drew(begun, took);
}

void SpectatorWindow::draw(const HudContent& content) {
  HudContent theirs;  // keys, figures and force are for the hand that plays
  theirs.score = content.score;
  theirs.warnings = content.warnings;
  theirs.paused = content.paused;
  theirs.full_force_n = 0.0;
  constexpr Duration kHintStands = std::chrono::seconds(6);  // a line of the score is below it
  if (!begun_) begun_ = looked_;
  const bool fresh = *looked_ - *begun_ < kHintStands;
  if (view_ == MonitorView::outside && !walked_ && fresh)
    theirs.hint = "Drag to walk round, turn the wheel to come nearer";
  window_->draw(theirs);
}

void SpectatorWindow::walk(const Input& input) {
  const auto before = std::exchange(dragged_, input.left ? input.pointer : std::nullopt);
  if (view_ != MonitorView::outside) return;
  if (before && dragged_) {
    // What is seen follows the pointer, so that the onlooker goes the other way.
    const Eigen::Vector2d by =
        kRadPerHeight * (*dragged_ - *before) / std::max(1, window_->framebuffer().height);
    onlooker_.walk(-by.x(), by.y());
    walked_ |= by.norm() > 0.0;
  }
  if (input.wheel != 0.0) {
    onlooker_.approach(input.wheel);
    walked_ = true;
  }
}

bool SpectatorWindow::act(const HudContent& content, Instant<GraphicsClock> now) {
  const Input input = window_->poll();
  walk(input);
  for (const auto key : input.keys) {
    if (key == Key::quit || key == Key::escape) return false;
    if (key == Key::full_screen) window_->toggle_full_screen();
    if (key == Key::view) view_ = view_ == MonitorView::copy ? MonitorView::outside : MonitorView::copy;
  }
  if (looked_ && to_seconds(now - *looked_) < kStale_s) return true;
  looked_ = now;
  draw(content);
  return true;
}

Json SpectatorWindow::figures() const {
  return {{"view", monitor_view_word(view_)},
          {"pictures", drawn_},
          {"left_out", left_out_},
          {"took_us", {{"median", took_.us(0.5)}, {"p99", took_.us(0.99)}}}};
}

}  // namespace palpate::desktop
