#include "palpate/headset/headset.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <utility>

#include "palpate/core/log.h"
#include "palpate/headset/internal/frame_loop.h"

namespace palpate::headset {
namespace {

constexpr Log kHeadsetLog("headset");

tl::unexpected<Error> without_openxr() {
  return refused(
      "headset: this program was built without OpenXR; install libopenxr-dev and libopenxr-loader1, and "
      "build it "
      "again");
}

// The loader writes its own lines on standard error unless it is told not to; what matters of them is in our errors.
void silence_loader() { setenv("XR_LOADER_DEBUG", "none", 0); }

// OpenXR's loader unloads the runtime when the program ends, under the feet of a thread that is still in there.
void keep_loaded(void* code) {
  Dl_info info{};
  if (code == nullptr || dladdr(code, &info) == 0 || info.dli_fname == nullptr) return;
  dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
}

// The rows in reverse order: OpenGL's first row is the lowest.
void copy_upside_down(std::span<const std::uint8_t> from, int width, int height, std::size_t bytes_per_pixel,
                      Pixels& to) {
  to.width = width;
  to.height = height;
  to.bytes.resize(from.size());
  const std::size_t row = static_cast<std::size_t>(width) * bytes_per_pixel;
  for (int y = 0; y < height; ++y)
    std::memcpy(to.bytes.data() + static_cast<std::size_t>(height - 1 - y) * row,
                from.data() + static_cast<std::size_t>(y) * row, row);
}

bool fits(std::size_t bytes, int width, int height, std::size_t bytes_per_pixel) {
  return width > 0 && height > 0 &&
         bytes == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * bytes_per_pixel;
}

}  // namespace

struct Headset::Impl {
  std::shared_ptr<SharedState> shared;
  std::thread thread;
  Standstill<GraphicsClock> still;
  std::uint64_t pictures = 0;

  explicit Impl(const HeadsetSettings& settings)
      : shared(std::make_shared<SharedState>(settings)), still(settings.silence) {
    thread = std::thread([state = shared] {
      run_frame_loop(state);
      const std::lock_guard lock(state->mutex);
      state->ended = true;
      state->changed.notify_all();
    });
  }

  ~Impl() {
    shared->stopping = true;
    std::unique_lock lock(shared->mutex);
    shared->changed.notify_all();
    const bool ended =
        shared->changed.wait_for(lock, shared->settings.closing, [this] { return shared->ended; });
    lock.unlock();
    if (ended) {
      thread.join();
    } else {
      keep_loaded(shared->runtime_code.load());
      kHeadsetLog.warning("the runtime does not return; it is left to itself");
      thread.detach();
    }
  }
};

bool Headset::built_in() { return openxr_built_in(); }

Expected<std::unique_ptr<Headset>> Headset::open(const HeadsetSettings& settings) {
  if (settings.eyes.empty() || settings.eyes.size() > 2)
    throw std::invalid_argument("Headset: one eye or two are expected");
  if (!built_in()) return without_openxr();
  silence_loader();
  auto impl = std::make_unique<Impl>(settings);
  SharedState& shared = *impl->shared;
  std::unique_lock lock(shared.mutex);
  const bool answered =
      shared.changed.wait_for(lock, settings.opening, [&shared] { return shared.attempts > 0; });
  const std::optional<Error> failure = shared.failure;
  lock.unlock();
  if (!answered)
    return refused(ErrorCode::timed_out,
                   "headset: the OpenXR runtime does not answer after {:.0f} s; restart it",
                   to_seconds(settings.opening));
  if (failure) return tl::unexpected(*failure);
  return std::unique_ptr<Headset>(new Headset(std::move(impl)));
}

Expected<HeadsetFacts> Headset::look_for(Duration patience) {
  if (!built_in()) return without_openxr();
  silence_loader();
  struct Answer {
    std::mutex mutex;
    std::condition_variable come;
    std::optional<Expected<HeadsetFacts>> facts;
  };
  const auto answer = std::make_shared<Answer>();
  std::thread([answer] {
    auto facts = ask_runtime();
    const std::lock_guard lock(answer->mutex);
    answer->facts = std::move(facts);
    answer->come.notify_all();
  }).detach();  // it may never come back
  std::unique_lock lock(answer->mutex);
  if (answer->come.wait_for(lock, patience, [&answer] { return answer->facts.has_value(); }))
    return *answer->facts;
  return refused(ErrorCode::timed_out,
                 "headset: the OpenXR runtime does not answer after {:.0f} s; restart it",
                 to_seconds(patience));
}

Headset::Headset(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Headset::~Headset() = default;

void Headset::show(const Picture& picture) {
  SharedState& shared = *impl_->shared;
  const auto& eyes = shared.settings.eyes;
  const int count = static_cast<int>(eyes.size());
  if (!fits(picture.rgb.size(), picture.width, picture.height, 3) ||
      picture.width != count * eyes.front().camera.width || picture.height != eyes.front().camera.height)
    throw std::invalid_argument("Headset: the picture is not as large as the eyes' cameras have it");
  if (!(picture.distance > 0.0)) throw std::invalid_argument("Headset: a distance above 0 is expected");
  std::unique_ptr<HandedPicture> handed;
  {
    const std::lock_guard lock(shared.mutex);
    handed = std::move(shared.spare_picture);
  }
  if (!handed) handed = std::make_unique<HandedPicture>();
  copy_upside_down(picture.rgb, picture.width, picture.height, 3, handed->pixels);
  handed->number = ++impl_->pictures;
  handed->image_time = picture.image_time;
  handed->distance = picture.distance;
  const std::lock_guard lock(shared.mutex);
  ++shared.facts.pictures;
  std::swap(shared.picture, handed);
  if (handed) shared.spare_picture = std::move(handed);  // nobody took it up
}

void Headset::show_panel(const WordPanel& panel) {
  auto handed = std::make_unique<HandedPanel>();
  if (!panel.rgba.empty()) {
    if (!fits(panel.rgba.size(), panel.width, panel.height, 4) || !(panel.wide > 0.0))
      throw std::invalid_argument("Headset: a panel of four bytes a pixel and a width in metres is expected");
    copy_upside_down(panel.rgba, panel.width, panel.height, 4, handed->pixels);
    handed->wide = panel.wide;
    handed->middle = panel.middle;
  }
  const std::lock_guard lock(impl_->shared->mutex);
  impl_->shared->panel = std::move(handed);
}

std::optional<std::string> Headset::trouble(Instant<GraphicsClock> now) {
  const SharedState& shared = *impl_->shared;
  const bool still = impl_->still.look(shared.beats.load(), now);
  const std::lock_guard lock(shared.mutex);
  if (shared.facts.state == HeadsetState::absent) return shared.facts.absence;
  if (!still) return std::nullopt;
  return "headset: the OpenXR runtime (" + shared.facts.runtime +
         ") no longer answers: what it shows stands still; if it does not return, restart it";
}

HeadsetFacts Headset::facts() const {
  const std::lock_guard lock(impl_->shared->mutex);
  return impl_->shared->facts;
}

HeadHistory::Head Headset::head_at(Instant<GraphicsClock> time) const {
  return impl_->shared->history.at(time);
}

Instant<GraphicsClock> Headset::display_time(Instant<GraphicsClock> handed_over) const {
  return facts().display.of_picture(handed_over);
}

std::optional<Headset::Shown> Headset::shown() const {
  const std::lock_guard lock(impl_->shared->mutex);
  return impl_->shared->shown;
}

}  // namespace palpate::headset
