#include "palpate/server/graphics/conditions.h"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::server::graphics {
namespace {

// Long enough that a dropped image, a late thread or a blink of an LED is no news.
constexpr Duration kAllowed = std::chrono::milliseconds(250);
// While nothing has ever come, devices may still be starting.
constexpr Duration kAllowedAtFirst = std::chrono::milliseconds(400);
constexpr double kIntervals = 3.0;
// Pictures without landmarks; the first two know the tracker's clock from too few samples.
constexpr int kMissed = 3;
// How long a jump stays told: the clock estimate needs about that long to be good again.
constexpr Duration kJumpTold = std::chrono::seconds(1);
// An interval's weight in the smoothed one.
constexpr double kSmooth = 0.1;
constexpr Duration kLongestInterval = std::chrono::seconds(5);

}  // namespace

const char* name_of(ConditionKind kind) {
  switch (kind) {
    case ConditionKind::camera_silent:
      return "camera_silent";
    case ConditionKind::image_size:
      return "image_size";
    case ConditionKind::camera_clock:
      return "camera_clock";
    case ConditionKind::tracker_silent:
      return "tracker_silent";
    case ConditionKind::tracker_clock:
      return "tracker_clock";
    case ConditionKind::tracker_blind:
      return "tracker_blind";
    case ConditionKind::landmarks_lost:
      return "landmarks_lost";
    case ConditionKind::right_eye_lost:
      return "right_eye_lost";
    case ConditionKind::board_lost:
      return "board_lost";
  }
  return "";
}

const char* end_of(ConditionKind kind) {
  switch (kind) {
    case ConditionKind::camera_silent:
      return "camera: images come again";
    case ConditionKind::image_size:
      return "camera: images have the calibrated size again";
    case ConditionKind::camera_clock:
      return "camera: its clock is known again";
    case ConditionKind::tracker_silent:
      return "tracker: samples come again";
    case ConditionKind::tracker_clock:
      return "tracker: its clock is known again";
    case ConditionKind::tracker_blind:
      return "tracker: sees the head's marker again";
    case ConditionKind::landmarks_lost:
      return "landmarks: they steady the picture again";
    case ConditionKind::right_eye_lost:
      return "right camera: each eye has its own picture again";
    case ConditionKind::board_lost:
      return "board: found again";
  }
  return "";
}

bool ConditionWatch::image(Instant<GraphicsClock> now, int width, int height) {
  if (images_.heard) {
    const Duration step = now - images_.last;
    if (interval_ == Duration(0)) interval_ = step;
    if (step < kLongestInterval)
      interval_ +=
          Duration(static_cast<Duration::rep>(kSmooth * static_cast<double>((step - interval_).count())));
  }
  images_.hear(now);
  const bool wrong = width != width_ || height != height_;
  if (wrong && !wrong_size_) wrong_since_ = now;
  wrong_size_ = wrong;
  wrong_width_ = width, wrong_height_ = height;
  return !wrong;
}

bool ConditionWatch::right_image(int width, int height) {
  const bool good = width == width_ && height == height_;
  right_wrong_width_ = good ? 0 : width, right_wrong_height_ = good ? 0 : height;
  return good;
}

void ConditionWatch::right_eye(Instant<GraphicsClock> now, bool there) {
  two_eyes_ = true, right_there_ = there;
  if (there) right_.hear(now);
}

void ConditionWatch::tracker_sample(Instant<GraphicsClock> now, bool is_head_marker, bool seen) {
  samples_.hear(now);
  if (is_head_marker && seen) head_.hear(now);
}

void ConditionWatch::landmarks(Instant<GraphicsClock> now, int predicted, int used, bool refined) {
  predicted_ = predicted, used_ = used;
  // Nobody misses landmarks where none should be in view.
  const bool content = refined || predicted == 0;
  missed_ = content ? 0 : missed_ + 1;
  if (content) carried_.hear(now);
}

void ConditionWatch::board(Instant<GraphicsClock> now, bool found, std::string why) {
  if (found)
    board_.hear(now);
  else
    board_why_ = std::move(why);
}

void ConditionWatch::look(Instant<GraphicsClock> now) {
  if (!begun_known_) begun_ = now, begun_known_ = true;
  const auto allowed = [](const Source& source) { return source.heard ? kAllowed : kAllowedAtFirst; };
  const auto since = [this](const Source& source) { return source.heard ? source.last : begun_; };

  const Duration patience =
      std::max(allowed(images_),
               Duration(static_cast<Duration::rep>(kIntervals * static_cast<double>(interval_.count()))));
  const bool silent = images_.silent_for(patience, now, begun_);
  const bool no_images = driver_speaks_ ? !driver_words_.empty() : silent;
  set(no_images, ConditionKind::camera_silent, since(images_), why_no_images());
  set(wrong_size_ && !silent && !no_images, ConditionKind::image_size, wrong_since_,
      fmt::format("camera: images have {} x {} pixels, the rig is calibrated for {} x {}; set the camera to "
                  "that size, or calibrate it again: palpate calibrate camera",
                  wrong_width_, wrong_height_, width_, height_));
  const auto clock_set = [&](const std::optional<Instant<GraphicsClock>>& at, ConditionKind kind,
                             const char* device) {
    set(at && now - *at < kJumpTold, kind, at.value_or(now),
        fmt::format("{}: its clock was set or stood still; it is being learned anew, for a second pictures "
                    "may not fit",
                    device));
  };
  clock_set(camera_clock_set_, ConditionKind::camera_clock, "camera");
  clock_set(tracker_clock_set_, ConditionKind::tracker_clock, "tracker");
  const bool no_samples = !on_board_ && samples_.silent_for(allowed(samples_), now, begun_);
  const bool blind = !no_samples && !on_board_ && head_.silent_for(allowed(head_), now, begun_);
  const std::string why = (no_samples || blind) && tracker_why_ ? tracker_why_() : "";
  set(no_samples, ConditionKind::tracker_silent, since(samples_),
      !why.empty() ? why
                   : "tracker: no samples; look at its cable and server, poses go on when samples come");
  set(blind, ConditionKind::tracker_blind, since(head_),
      !why.empty() ? why
                   : "tracker: does not see the head's marker; turn it towards the tracker, or take away "
                     "what stands between");
  set(images_.heard && !silent && !no_images && !wrong_size_ && predicted_ > 0 && missed_ >= kMissed &&
          carried_.silent_for(patience, now, begun_),
      ConditionKind::landmarks_lost, since(carried_),
      fmt::format("landmarks: {} of {} expected ones agree, at least 3 are needed; the picture rests on the "
                  "tracker alone, uncover them or calibrate them again: palpate calibrate landmarks",
                  used_, predicted_));
  // A left camera that is silent, too, is news enough.
  const bool told = std::any_of(conditions_.begin(), conditions_.end(),
                                [](const auto& c) { return c.kind == ConditionKind::right_eye_lost; });
  set(two_eyes_ && !right_there_ && images_.heard && (told || (!silent && !no_images)),
      ConditionKind::right_eye_lost, since(right_),
      right_wrong_width_ > 0
          ? fmt::format("right camera: images have {} x {} pixels, the rig is calibrated for {} x {}; both "
                        "eyes see the left camera's picture, set the right one to that size",
                        right_wrong_width_, right_wrong_height_, width_, height_)
          : "right camera: no image that was taken together with the left one's; both eyes see the left "
            "camera's picture, look at its cable, power and trigger");
  set(on_board_ && !board_why_.empty() && images_.heard && !silent && !no_images && !wrong_size_ &&
          board_.silent_for(patience, now, begun_),
      ConditionKind::board_lost, since(board_), "board: " + board_why_);
}

std::string ConditionWatch::why_no_images() const {
  if (driver_speaks_) return driver_words_;
  if (interval_ == Duration(0)) return "camera: no image yet; look at its cable and power";
  return fmt::format(
      "camera: no image any more, one every {:.0f} ms is expected; look at its cable and power, pictures go "
      "on when images come",
      to_seconds(interval_) * 1e3);
}

void ConditionWatch::set(bool holds, ConditionKind kind, Instant<GraphicsClock> since,
                         const std::string& text) {
  const auto at =
      std::find_if(conditions_.begin(), conditions_.end(), [kind](const auto& c) { return c.kind == kind; });
  if (!holds) {
    if (at != conditions_.end()) conditions_.erase(at);
    return;
  }
  if (at == conditions_.end()) {
    conditions_.push_back({kind, since, text});
  } else if ((kind == ConditionKind::camera_silent && driver_speaks_) ||
             ((kind == ConditionKind::tracker_silent || kind == ConditionKind::tracker_blind) &&
              tracker_why_)) {
    at->text = text;  // another trouble meanwhile, of which a driver speaks once
  }
  // Else the words stay those of its beginning: a line that changes every frame cannot be read.
}

}  // namespace palpate::server::graphics
