// What is wrong with camera, tracker and landmarks right now, in words: for the log, the window and raw data.
//
// Fed by the graphics server with what it sees; `conditions()` lists what does not hold at the moment of the
// last look(), in the order in which it began. A condition ends by itself when its cause does: nothing has to
// be started again. Each is stated within 0.5 s of its beginning, at camera and tracker rates from 10 Hz on;
// a slower camera is given three of its own intervals. A real camera's driver knows more than that images
// stay away, and is believed. Host time of the graphics server. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/time/instant.h"

namespace palpate::server::graphics {

enum class ConditionKind : std::uint8_t {
  camera_silent,   // no images
  image_size,      // images of another size than the calibrated camera's: not drawn
  camera_clock,    // its clock was set or stood still: images cannot be placed in time for a moment
  tracker_silent,  // no samples at all
  tracker_clock,   // as the camera's
  tracker_blind,   // samples, but the head's marker is not among what it sees
  landmarks_lost,  // the picture rests on the tracker alone
  right_eye_lost,  // of two cameras the right one: both eyes see the left one's picture
  board_lost,      // the board by which the camera knows its place is not found in the picture
};

struct Condition {
  ConditionKind kind = ConditionKind::camera_silent;
  Instant<GraphicsClock> since;
  std::string text;  // names the thing, the value, the expectation and the remedy; for the log and the screen
};

// As raw data and figures have it.
const char* name_of(ConditionKind kind);
// What the end of a condition is called in the log.
const char* end_of(ConditionKind kind);

class ConditionWatch {
 public:
  // Of the calibrated camera.
  ConditionWatch(int width, int height) : width_(width), height_(height) {}

  // False: the image has another size than it should and must not be drawn.
  bool image(Instant<GraphicsClock> now, int width, int height);
  // Why no image can be had, as the camera's driver has it; empty: all is well. From the first call on this
  // decides whether the camera is silent.
  void set_camera_trouble(std::string words) { driver_speaks_ = true, driver_words_ = std::move(words); }
  // The same of a second camera's image; and whether it sends any that can be used.
  bool right_image(int width, int height);
  void right_eye(Instant<GraphicsClock> now, bool there);
  // Who knows more of why a tracker is silent or blind says it in words of its own, asked while it is.
  void set_tracker_explanation(std::function<std::string()> why) { tracker_why_ = std::move(why); }
  // A device's clock was found set (watched_clock.h).
  void camera_clock_set(Instant<GraphicsClock> now) { camera_clock_set_ = now; }
  void tracker_clock_set(Instant<GraphicsClock> now) { tracker_clock_set_ = now; }
  void tracker_sample(Instant<GraphicsClock> now, bool is_head_marker, bool seen);
  // A frame's pose: how many landmarks it should have seen, and whether they carried it.
  void landmarks(Instant<GraphicsClock> now, int predicted, int used, bool refined);

  // From now on the camera's place comes from a board in the picture: nobody misses a tracker.
  void set_on_board() { on_board_ = true; }
  // A frame's pose by that board: found, or why not, in words.
  void board(Instant<GraphicsClock> now, bool found, std::string why);

  void look(Instant<GraphicsClock> now);
  const std::vector<Condition>& conditions() const { return conditions_; }

 private:
  struct Source {  // of samples that should keep coming
    bool heard = false;
    Instant<GraphicsClock> last;
    bool silent_for(Duration allowed, Instant<GraphicsClock> now, Instant<GraphicsClock> begun) const {
      return now - (heard ? last : begun) > allowed;
    }
    void hear(Instant<GraphicsClock> now) { heard = true, last = now; }
  };
  void set(bool holds, ConditionKind kind, Instant<GraphicsClock> since, const std::string& text);
  std::string why_no_images() const;

  int width_, height_, wrong_width_ = 0, wrong_height_ = 0;
  bool wrong_size_ = false, begun_known_ = false, driver_speaks_ = false;
  std::string driver_words_;
  std::function<std::string()> tracker_why_;
  Duration interval_{0};  // between images, smoothed
  Source images_, samples_, head_, carried_, board_, right_;
  bool two_eyes_ = false, right_there_ = true;
  int right_wrong_width_ = 0, right_wrong_height_ = 0;  // 0: the last image had the right size
  // Frames in a row without landmarks: on a slow machine one or two are no news, however old.
  int missed_ = 0;
  bool on_board_ = false;
  std::string board_why_;
  int predicted_ = 0, used_ = 0;
  Instant<GraphicsClock> begun_, wrong_since_;
  std::optional<Instant<GraphicsClock>> camera_clock_set_, tracker_clock_set_;
  std::vector<Condition> conditions_;
};

}  // namespace palpate::server::graphics
