#include "drivers/cameras/live_camera.h"

#include <pthread.h>

#include <algorithm>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::cameras {
namespace {

// Short beside the half second in which trouble is to be told.
constexpr Duration kLook = std::chrono::milliseconds(50);
constexpr Duration kRetry = std::chrono::milliseconds(250);

std::int64_t host_ns() { return MonotonicClock<GraphicsClock>::monotonic_ns(); }

// A camera so slow that it would be silent between two pictures gets two and a half of its own intervals.
std::int64_t allowed_ns(const CameraFacts& facts) {
  const double interval_s = facts.rate_hz > 0.0 ? 1.0 / facts.rate_hz : 0.0;
  return std::max(LiveCamera::kSilence, seconds(2.5 * std::max(interval_s, facts.exposure_s))).count();
}

}  // namespace

Expected<std::unique_ptr<LiveCamera>> LiveCamera::open(std::unique_ptr<FrameSource> source, int width,
                                                       int height) {
  auto facts = source->open();
  if (!facts) return tl::unexpected(facts.error());
  return std::unique_ptr<LiveCamera>(new LiveCamera(std::move(source), std::move(*facts), width, height));
}

LiveCamera::LiveCamera(std::unique_ptr<FrameSource> source, CameraFacts facts, int width, int height)
    : source_(std::move(source)),
      name_(source_->name()),
      width_(width),
      height_(height),
      silence_(allowed_ns(facts)),
      facts_(std::move(facts)),
      heard_ns_(host_ns() + kFirstPicture.count()),
      thread_() {
  status_.times_opened = 1;
  thread_ = std::thread([this] { run(); });
}

LiveCamera::~LiveCamera() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

bool LiveCamera::pause(Duration time) {
  std::unique_lock lock(mutex_);
  return !wake_.wait_for(lock, time, [this] { return stop_; });
}

void LiveCamera::set_lost(std::string words) {
  const std::lock_guard lock(mutex_);
  lost_ = std::move(words);
}

void LiveCamera::set_trouble(std::string words) {
  ++status_.damaged;
  trouble_ = fmt::format("camera {}: {}", name_, words);
  troubled_ns_ = host_ns();
}

void LiveCamera::judge() {
  const std::lock_guard lock(mutex_);
  // A plug that is pulled leaves half a picture behind: not that is what is wrong then.
  if (host_ns() - troubled_ns_ > allowed_ns(facts_)) trouble_.clear();
  silent_ = silence_.gone(host_ns(), heard_ns_);
}

void LiveCamera::run() {
  pthread_setname_np(pthread_self(), "palpate-camera");
  bool open = true;
  std::int64_t waiting_since = host_ns() + kFirstPicture.count();
  while (pause(Duration(0))) {
    if (!open) {
      auto facts = source_->open();
      if (!facts) {
        set_lost(facts.error().message);
        judge();
        if (!pause(kRetry)) break;
        continue;
      }
      open = true;
      last_number_ = 0;
      waiting_since = host_ns() + kFirstPicture.count();
      const std::lock_guard lock(mutex_);
      facts_ = std::move(*facts);
      ++status_.times_opened;
    }
    const Outcome outcome = source_->wait(kLook);
    judge();
    switch (outcome.kind) {
      case Outcome::Kind::frame:
        waiting_since = host_ns();
        take(outcome.frame);
        break;
      case Outcome::Kind::damaged: {
        waiting_since = host_ns();
        const std::lock_guard lock(mutex_);
        set_trouble(outcome.words);
        break;
      }
      case Outcome::Kind::nothing:
        // Silent for long: perhaps another camera stands there now that has to be asked anew.
        if (source_->keeps_its_own_pace() || host_ns() - waiting_since < kOpenAnew.count()) break;
        source_->close();
        open = false;
        break;
      case Outcome::Kind::lost:
        set_lost(fmt::format("camera {}: {}", name_, outcome.words));
        source_->close();
        open = false;
        break;
      case Outcome::Kind::ended: {
        source_->close();
        std::unique_lock lock(mutex_);
        ended_ = true;
        wake_.wait(lock, [this] { return stop_; });
        return;
      }
    }
  }
  if (open) source_->close();
}

void LiveCamera::take(const Frame& frame) {
  const auto& picture = frame.picture;
  const std::int64_t arrived =
      frame.arrived_ns != 0 ? frame.arrived_ns : host_ns();  // before the colours are made
  std::string words;
  if ((width_ != 0 && picture.width != width_) || (height_ != 0 && picture.height != height_)) {
    words = fmt::format(
        "its pictures are {}x{} px and the lens was calibrated at {}x{}; set the camera to that size, or "
        "calibrate it anew (palpate calibrate camera)",
        picture.width, picture.height, width_, height_);
  } else if (auto turned = to_rgb(picture, next_.rgb); !turned) {
    words = turned.error().message;
  }
  next_.mid_exposure = Instant<CameraClock>{Duration(frame.mid_exposure_ns)};
  next_.frame = frame.number;
  next_.width = picture.width, next_.height = picture.height;
  const std::lock_guard lock(mutex_);
  if (last_number_ != 0 && frame.number > last_number_ + 1)
    status_.dropped += frame.number - last_number_ - 1;
  last_number_ = frame.number;
  if (!words.empty()) {
    set_trouble(std::move(words));
    return;
  }
  ++status_.pictures;
  silent_ = false;
  lost_.clear();
  trouble_.clear();
  heard_ns_ = arrived;
  stamped_ns_ = frame.taken_ns != 0 ? frame.taken_ns : arrived;
  // What nobody took is overwritten and its memory used again.
  if (!newest_) newest_.emplace();
  std::swap(*newest_, next_);
  if (next_.rgb.capacity() == 0) next_.rgb = spare_.take();
}

void LiveCamera::take_back(device::CameraImage image) {
  const std::lock_guard lock(mutex_);
  spare_.keep(std::move(image.rgb));
}

std::optional<device::CameraImage> LiveCamera::poll() {
  const std::lock_guard lock(mutex_);
  if (newest_) newest_->waited = Duration(host_ns() - stamped_ns_);
  return std::exchange(newest_, std::nullopt);
}

CameraFacts LiveCamera::facts() const {
  const std::lock_guard lock(mutex_);
  return facts_;
}

CameraStatus LiveCamera::status() const {
  const std::lock_guard lock(mutex_);
  CameraStatus status = status_;
  const auto is = [&](device::HealthCode code, std::string words) {
    status.health = {code, std::move(words), fmt::format("camera {}: works again", name_)};
  };
  if (ended_)
    is(device::HealthCode::recording_ended,
       fmt::format("camera {}: its {} have been shown; the recording has ended", name_,
                   counted(status.pictures, "picture")));
  else if (!lost_.empty())
    is(device::HealthCode::camera_lost, lost_);
  else if (silent_ && !trouble_.empty())
    is(device::HealthCode::camera_unfit, trouble_);
  else if (silent_)
    is(device::HealthCode::camera_silent,
       fmt::format(
           "camera {}: no picture comes any more; see to its cable and power, and that nobody else uses it",
           name_));
  return status;
}

}  // namespace palpate::drivers::cameras
