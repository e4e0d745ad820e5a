// Pictures for the report: moments of a game that a person wants to see, chosen while it is played.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/camera_model.h"
#include "palpate/render/outside_view.h"
#include "palpate/scene/play_record.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::tools::demo {

// Moments evenly over the play, and one after each of the first events (hits, touches): each the next frame in
// which what the play is about is in sight. What that is, and what it is called, says the application's record.
// One thread.
class SnapshotSelector {
 public:
  // `record` outlives this.
  SnapshotSelector(std::filesystem::path folder, double seconds, const device::CameraModel& lens,
                   const scene::PlayRecord& record);

  // Besides, one picture from the side (outside.png): of the first event, or else of the first moment.
  void look_from_outside(
      std::function<const render::OutsidePicture&(const server::graphics::FrameRecord&)> outside) {
    outside_ = std::move(outside);
  }
  // Frames in order; writes the picture when this is a moment. Refuses when it cannot be written.
  Expected<void> look(const server::graphics::FrameRecord& frame);
  const Json& captions() const { return captions_; }  // by file name

 private:
  std::string moment(const server::graphics::FrameRecord& frame) const;
  Expected<void> write_outside(const server::graphics::FrameRecord& frame, const std::string& what);

  std::filesystem::path folder_;
  device::CameraModel lens_;
  const scene::PlayRecord& record_;
  double every_, begun_ = 0.0, next_ = 0.0, event_until_ = 0.0;
  bool started_ = false;
  std::function<const render::OutsidePicture&(const server::graphics::FrameRecord&)> outside_;
  int count_ = 0, event_pictures_ = 0;
  std::int32_t events_ = 0;
  Json captions_ = Json::object();
};

}  // namespace palpate::tools::demo
