// The live system's poses for others, 3D Slicer say, over OpenIGTLink: what the picture shows and where the
// tracker sees its markers.
//
// Names are AToWorld: a pose maps coordinates of A to World, the tracker's frame (docs/conventions.md).
// Bodies and stylus as they were drawn, at the time of the state; the camera as it was drawn, at the time of
// the image; markers each time the tracker sees them. Stamps are the graphics host's clock on the arm's time
// line: the rig's delay of tracker after arm is taken off, so that equal stamps are equal moments. What is
// not known or not seen is not sent. From the frame loop's thread, which never waits here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/openigtlink/pose_publisher.h"
#include "palpate/core/json.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/graphics_server.h"

namespace palpate::server::graphics {

struct LivePose {
  std::string name;
  Instant<GraphicsClock> time;
  drivers::openigtlink::RigidPose pose;
};

// Of a frame that was drawn.
std::vector<LivePose> live_poses(const FrameRecord& frame, const scene::SceneDescription& scene,
                                 const ClockModel<GraphicsClock, PhysicsClock>& sync,
                                 Duration tracker_after_arm);

class PoseFeed {
 public:
  // Refused where somebody listens there already.
  static Expected<PoseFeed> open(const drivers::openigtlink::Address& address,
                                 Duration tracker_after_arm = Duration(0));
  void marker(device::MarkerId marker, const device::MarkerPose& pose);
  void frame(const FrameRecord& frame, const scene::SceneDescription& scene,
             const ClockModel<GraphicsClock, PhysicsClock>& sync);
  const drivers::openigtlink::Address& address() const { return publisher_->address(); }
  Json figures() const;

 private:
  PoseFeed(std::unique_ptr<drivers::openigtlink::PosePublisher> publisher, Duration tracker_after_arm)
      : publisher_(std::move(publisher)), tracker_after_arm_(tracker_after_arm) {}
  void send(const LivePose& pose);
  std::unique_ptr<drivers::openigtlink::PosePublisher> publisher_;
  Duration tracker_after_arm_;
};

}  // namespace palpate::server::graphics
