// What is wrong with camera, tracker and landmarks right now: for the log, the window and raw data.
//
// Fed by the graphics server with what it sees; health() has what does not hold at the moment of the last
// look(), in the order in which it began. A condition ends by itself when its cause does: nothing has to
// be started again. Each is stated within 0.5 s of its beginning, at camera and tracker rates from 10 Hz on;
// a slower camera is given three of its own intervals. A real camera's driver knows more than that images
// stay away, and is believed. Host time of the graphics server. One thread.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/device/health_monitor.h"
#include "palpate/time/instant.h"

namespace palpate::server::graphics {

using Condition = device::HealthCondition<GraphicsClock>;

class ConditionWatch {
 public:
  // Of the calibrated camera.
  ConditionWatch(int width, int height) : width_(width), height_(height) {}

  // False: the image has another size than it should and must not be drawn.
  bool image(Instant<GraphicsClock> now, int width, int height);
  // Why no image can be had, as the camera's driver has it; none: all is well. From the first call on this
  // decides whether the camera is silent.
  void set_camera_health(std::optional<device::HealthReport> health) {
    driver_speaks_ = true, driver_says_ = std::move(health);
  }
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

  // What the physics server was last described to play and where it has its surfaces, where that is not what is drawn and what our
  // rig has; none: it fits. A server that is another one each moment is told of once a second at most.
  void scene_described(Instant<GraphicsClock> now, std::optional<std::string> scene_words,
                       std::optional<std::string> rig_words);

  // From now on the camera's place comes from a board in the picture: nobody misses a tracker.
  void set_on_board() { on_board_ = true; }
  // A frame's pose by that board: found, or why not, in words.
  void board(Instant<GraphicsClock> now, bool found, std::string why);

  void look(Instant<GraphicsClock> now);
  // Beginnings and ends are told there from now on; else to nobody.
  void set_log(Log log) { health_.set_log(log); }
  const device::HealthMonitor<GraphicsClock>& health() const { return health_; }

 private:
  struct Source {  // of samples that should keep coming
    bool heard = false;
    Instant<GraphicsClock> last;
    bool silent_for(Duration allowed, Instant<GraphicsClock> now, Instant<GraphicsClock> begun) const {
      return now - (heard ? last : begun) > allowed;
    }
    void hear(Instant<GraphicsClock> now) { heard = true, last = now; }
  };
  device::HealthReport why_no_images() const;
  void look_at_scene(Instant<GraphicsClock> now);

  int width_, height_, wrong_width_ = 0, wrong_height_ = 0;
  bool wrong_size_ = false, begun_known_ = false, driver_speaks_ = false;
  std::optional<device::HealthReport> driver_says_;
  std::function<std::string()> tracker_why_;
  Duration interval_{0};  // between images, smoothed
  Source images_, samples_, head_, carried_, board_, right_;
  bool two_eyes_ = false, right_there_ = true;
  int right_wrong_width_ = 0, right_wrong_height_ = 0;  // 0: the last image had the right size
  // Frames in a row without landmarks: on a slow machine one or two are no news, however old.
  int missed_ = 0;
  bool on_board_ = false;
  std::string board_why_;
  std::optional<std::string> scene_words_, rig_words_;
  std::optional<Instant<GraphicsClock>> described_;  // none: there is nothing to tell
  int predicted_ = 0, used_ = 0;
  Instant<GraphicsClock> begun_, wrong_since_;
  std::optional<Instant<GraphicsClock>> camera_clock_set_, tracker_clock_set_;
  device::HealthMonitor<GraphicsClock> health_;
};

}  // namespace palpate::server::graphics
