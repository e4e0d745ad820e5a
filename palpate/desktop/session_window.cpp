#include "palpate/desktop/session_window.h"

#include <pthread.h>

#include <chrono>
#include <future>
#include <utility>

#include "palpate/core/log.h"
#include "palpate/core/stop_signal.h"
#include "palpate/desktop/drawing.h"
#include "palpate/desktop/hit_sound.h"

namespace palpate::desktop {
namespace {

constexpr Size kSessionSize{1280, 800};
constexpr auto kBetweenPages = std::chrono::milliseconds(60);
constexpr double kTakenImpulse = 0.02, kEndImpulse = 0.05;  // N s, of the sounds that are borrowed from hits

}  // namespace

Expected<std::unique_ptr<SessionWindow>> SessionWindow::open(const std::string& title) {
  auto lettering = Lettering::open();
  if (!lettering) return tl::unexpected(lettering.error());
  auto window = Window::open(title, kSessionSize);
  if (!window) return tl::unexpected(window.error());
  auto sound = SoundOut::open();
  if (!sound) Log().info("{}; the window shows what is taken all the same", sound.error().message);
  return std::unique_ptr<SessionWindow>(
      new SessionWindow(std::move(*window), std::move(*lettering), sound ? std::move(*sound) : nullptr));
}

SessionWindow::SessionWindow(std::unique_ptr<Window> window, std::unique_ptr<Lettering> lettering,
                             std::unique_ptr<SoundOut> sound)
    : window_(std::move(window)), sound_(std::move(sound)), page_(std::move(lettering)) {}

Expected<void> SessionWindow::run(const std::function<Expected<void>(SessionExchange&)>& session) {
  SessionExchange exchange;
  auto done = std::async(std::launch::async, [&session, &exchange] {
    ::pthread_setname_np(::pthread_self(), "palpate-person");
    return session(exchange);
  });
  do {
    act(exchange);
    const SessionView view = exchange.view();
    sound(view);
    draw(view);
  } while (done.wait_for(kBetweenPages) != std::future_status::ready);
  return done.get();
}

void SessionWindow::act(SessionExchange& exchange) {
  const Input input = window_->poll();
  for (const char key : input.typed) exchange.press(key);
  for (const Key key : input.keys)
    if (key == Key::full_screen) window_->toggle_full_screen();
  if (!input.closed || closed_) return;
  closed_ = true;
  exchange.change([](SessionView& view) { view.ending = true; });
  stop_signal::flag.store(true, std::memory_order_relaxed);  // as Ctrl-C
}

void SessionWindow::sound(const SessionView& view) {
  if (view.taken_s && view.taken_s != heard_s_ && sound_)
    sound_->play(hit_sound(HitKind::body, kTakenImpulse));
  if (view.taken_s) heard_s_ = view.taken_s;
  if (view.outcome && !heard_outcome_ && sound_) sound_->play(hit_sound(HitKind::hand, kEndImpulse));
  heard_outcome_ = view.outcome.has_value();
}

void SessionWindow::draw(const SessionView& view) {
  const Size size = window_->framebuffer();
  if (size.width <= 0 || size.height <= 0) return;  // made an icon of
  if (view.version != drawn_ || !(size == drawn_size_)) {
    to_rgb(page_.draw(view, size), rgb_);
    window_->take_picture(rgb_, size);
    drawn_ = view.version;
    drawn_size_ = size;
  }
  HudContent nothing;
  nothing.full_force_n = 0.0;
  window_->draw(nothing);
}

}  // namespace palpate::desktop
