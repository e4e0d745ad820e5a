#include "palpate/calibration/session/recorder.h"

namespace palpate::calibration::session {
namespace {
constexpr Duration kTick = std::chrono::milliseconds(1);
}

void Recorder::tick() {
  const auto now = context_.clock.now();
  if (!next_ || *next_ < now) next_ = now;
  *next_ += kTick;
  context_.clock.sleep_until(*next_);
  const auto read_at = context_.clock.now();
  const Duration waited = read_at - last_look_.value_or(read_at);
  last_look_ = read_at;
  // How long a sample has waited is counted until it was asked for; a look at the clock after that may be late, as what comes
  // from devices is, but never early.
  const device::ArmSample arm = context_.arm.read();
  const auto arm_read = context_.clock.now();
  if (control_) control_(arm);
  streams_.add(arm, arm_read - arm.waited, waited);
  const auto tracked = context_.tracker.poll();
  const auto polled = context_.clock.now();
  context_.person.watch(polled.seconds(), arm, tracked);
  for (const auto& sample : tracked) streams_.add(sample, polled - sample.waited, waited);
}

void Recorder::run(double seconds_long) {
  const auto end = context_.clock.now() + seconds(seconds_long);
  while (context_.clock.now() < end && !context_.stopped()) tick();
}

Expected<void> Recorder::run_until_ready() {
  const auto patience = context_.person.patience();
  const auto began = context_.clock.now();
  while (true) {
    const auto ready = context_.person.ready();
    if (!ready) return tl::unexpected(ready.error());
    if (*ready) return {};
    if (context_.stopped()) return refused(ErrorCode::stopped, "stopped");
    if (patience && context_.clock.now() >= began + seconds(*patience))
      return refused(ErrorCode::timed_out, "not begun within {} s; start again when you are ready",
                     *patience);
    tick();
  }
}

void Recorder::clear() { streams_.clear(); }

}  // namespace palpate::calibration::session
