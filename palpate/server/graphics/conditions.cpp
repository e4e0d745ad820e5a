#include "palpate/server/graphics/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace palpate::server::graphics {
namespace {

using device::HealthCode;
using enum device::HealthCode;

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
// So long a description has stood before another one's words, or their end, are told.
constexpr Duration kDescribed = std::chrono::seconds(1);
constexpr Duration kLongestInterval = std::chrono::seconds(5);

}  // namespace

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

void ConditionWatch::scene_described(Instant<GraphicsClock> now, std::optional<std::string> scene_words,
                                     std::optional<std::string> rig_words) {
  scene_words_ = std::move(scene_words), rig_words_ = std::move(rig_words);
  described_ = now;
}

void ConditionWatch::look_at_scene(Instant<GraphicsClock> now) {
  if (!described_) return;
  const bool settled = now - *described_ >= kDescribed;
  const auto tell = [&](const std::optional<std::string>& words, HealthCode code) {
    if (settled || (words && !health_.holds(code)))
      health_.set(words.has_value(), {code, words.value_or("")}, *described_);
  };
  tell(scene_words_, other_scene);
  tell(rig_words_, other_rig);
  if (settled) described_.reset();
}

void ConditionWatch::look(Instant<GraphicsClock> now) {
  if (!begun_known_) begun_ = now, begun_known_ = true;
  const auto allowed = [](const Source& source) { return source.heard ? kAllowed : kAllowedAtFirst; };
  const auto since = [this](const Source& source) { return source.heard ? source.last : begun_; };

  const Duration patience =
      std::max(allowed(images_),
               Duration(static_cast<Duration::rep>(kIntervals * static_cast<double>(interval_.count()))));
  const bool silent = images_.silent_for(patience, now, begun_);
  const bool no_images = driver_speaks_ ? driver_says_.has_value() : silent;
  health_.set(no_images, why_no_images(), since(images_));
  const auto set = [this](bool holds, HealthCode code, Instant<GraphicsClock> begun, std::string words) {
    health_.set(holds, {code, std::move(words)}, begun);
  };
  set(wrong_size_ && !silent && !no_images, image_size, wrong_since_,
      fmt::format("camera: images have {} x {} pixels, the rig is calibrated for {} x {}; set the camera to "
                  "that size, or calibrate it again: palpate calibrate camera",
                  wrong_width_, wrong_height_, width_, height_));
  const auto clock_set = [&](const std::optional<Instant<GraphicsClock>>& at, HealthCode code,
                             const char* device) {
    set(at && now - *at < kJumpTold, code, at.value_or(now),
        fmt::format("{}: its clock was set or stood still; it is being learned anew, for a second pictures "
                    "may not fit",
                    device));
  };
  clock_set(camera_clock_set_, camera_clock, "camera");
  clock_set(tracker_clock_set_, tracker_clock, "tracker");
  const bool no_samples = !on_board_ && samples_.silent_for(allowed(samples_), now, begun_);
  const bool blind = !no_samples && !on_board_ && head_.silent_for(allowed(head_), now, begun_);
  const std::string why = (no_samples || blind) && tracker_why_ ? tracker_why_() : "";
  set(no_samples, tracker_silent, since(samples_),
      !why.empty() ? why
                   : "tracker: no samples; look at its cable and server, poses go on when samples come");
  set(blind, tracker_blind, since(head_),
      !why.empty() ? why
                   : "tracker: does not see the head's marker; turn it towards the tracker, or take away "
                     "what stands between");
  set(images_.heard && !silent && !no_images && !wrong_size_ && predicted_ > 0 && missed_ >= kMissed &&
          carried_.silent_for(patience, now, begun_),
      landmarks_lost, since(carried_),
      fmt::format("landmarks: {} of {} expected ones agree, at least 3 are needed; the picture rests on the "
                  "tracker alone, uncover them or calibrate them again: palpate calibrate landmarks; or the "
                  "rig is of "
                  "another place (a simulated laboratory has the --seed it was calibrated with)",
                  used_, predicted_));
  // A left camera that is silent, too, is news enough.
  set(two_eyes_ && !right_there_ && images_.heard &&
          (health_.holds(right_eye_lost) || (!silent && !no_images)),
      right_eye_lost, since(right_),
      right_wrong_width_ > 0
          ? fmt::format("right camera: images have {} x {} pixels, the rig is calibrated for {} x {}; both "
                        "eyes see the left camera's picture, set the right one to that size",
                        right_wrong_width_, right_wrong_height_, width_, height_)
          : "right camera: no image that was taken together with the left one's; both eyes see the left "
            "camera's picture, look at its cable, power and trigger");
  set(on_board_ && !board_why_.empty() && images_.heard && !silent && !no_images && !wrong_size_ &&
          board_.silent_for(patience, now, begun_),
      board_lost, since(board_), "board: " + board_why_);
  look_at_scene(now);
}

device::HealthReport ConditionWatch::why_no_images() const {
  // In the driver's words; that images come again is said in those of all cameras.
  if (driver_speaks_ && driver_says_) return {driver_says_->code, driver_says_->words};
  if (interval_ == Duration(0)) return {camera_silent, "camera: no image yet; look at its cable and power"};
  return {camera_silent,
          fmt::format("camera: no image any more, one every {:.0f} ms is expected; look at its cable and "
                      "power, pictures go on when images come",
                      to_seconds(interval_) * 1e3)};
}

}  // namespace palpate::server::graphics
