#include "palpate/headset/internal/frame_loop.h"

#include "palpate/core/crash_words.h"
#include "palpate/headset/internal/openxr_session.h"
#include "palpate/time/real_time.h"

namespace palpate::headset {
namespace {

constexpr auto kIdle = std::chrono::milliseconds(10);  // between looks while the runtime wants no frames

// Waits, and ends sooner where everything is to end.
void rest(SharedState& shared, Duration how_long) {
  std::unique_lock lock(shared.mutex);
  shared.changed.wait_for(lock, how_long, [&shared] { return shared.stopping.load(); });
}

void tell_there(SharedState& shared, const OpenXrInstance& instance) {
  shared.runtime_code = instance.code();
  const std::lock_guard lock(shared.mutex);
  shared.facts.state = HeadsetState::waiting;
  shared.facts.runtime = instance.runtime();
  shared.facts.device = instance.device();
  shared.facts.absence.clear();
  shared.failure.reset();
  ++shared.attempts;
  shared.changed.notify_all();
}

// `lost`: it was there until now; `been_there`: it has been before.
void tell_absent(SharedState& shared, const Error& error, bool lost, bool been_there) {
  const std::lock_guard lock(shared.mutex);
  shared.facts.state = HeadsetState::absent;
  shared.facts.losses += lost ? 1 : 0;
  // The first words stay: why the runtime went, and not why it cannot be reached since.
  if (lost || !been_there)
    shared.facts.absence =
        fmt::format("{}; it is tried again every {:.0f} s", error.message, to_seconds(shared.settings.retry));
  shared.failure = error;
  ++shared.attempts;
  shared.changed.notify_all();
}

void tell_waiting(SharedState& shared) {
  const std::lock_guard lock(shared.mutex);
  shared.facts.state = HeadsetState::waiting;
}

// Until the runtime goes, which is the error, or all is to end.
Expected<void> show_frames(SharedState& shared, OpenXrSession& session) {
  while (!shared.stopping) {
    ++shared.beats;
    if (auto heard = session.listen(); !heard) return heard;
    if (session.running()) {
      if (auto shown = session.frame(); !shown) return shown;
    } else {
      tell_waiting(shared);
      rest(shared, kIdle);
    }
  }
  return {};
}

// From reaching the runtime, which may fail, until it goes or all is to end. That it has gone is told before session and
// context are let go: with a runtime that has died this may take long.
Expected<void> live_with_runtime(SharedState& shared, bool& been_there) {
  auto context = render::Context::of_this_thread();
  if (!context) return refused("headset: {}", context.error().message);
  auto instance = OpenXrInstance::open();
  if (!instance) return tl::unexpected(instance.error());
  auto session = OpenXrSession::open(**instance, *context, shared);
  if (!session) return tl::unexpected(session.error());
  been_there = true;
  tell_there(shared, **instance);
  if (auto ended = show_frames(shared, **session); !ended) tell_absent(shared, ended.error(), true, true);
  return {};
}

}  // namespace

bool openxr_built_in() { return true; }

void run_frame_loop(const std::shared_ptr<SharedState>& state) {
  name_and_pin_thread("palpate-headset", -1);
  give_crash_stack();
  sharpen_sleep();
  SharedState& shared = *state;
  bool been_there = false;
  while (!shared.stopping) {
    if (const auto lived = live_with_runtime(shared, been_there); !lived)
      tell_absent(shared, lived.error(), false, been_there);
    rest(shared, shared.settings.retry);
  }
}

Expected<HeadsetFacts> ask_runtime() {
  auto instance = OpenXrInstance::open();
  if (!instance) return tl::unexpected(instance.error());
  HeadsetFacts facts;
  facts.state = HeadsetState::waiting;
  facts.runtime = (*instance)->runtime();
  facts.device = (*instance)->device();
  return facts;
}

}  // namespace palpate::headset
