// The live system's poses for others, over OpenIGTLink (3D Slicer) or VRPN: what the picture shows and where the
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

#include "drivers/network/pose_server.h"
#include "palpate/core/json.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/graphics_server.h"

namespace palpate::server::graphics {

// Where poses are served, and how.
struct PublishAt {
  enum class By { openigtlink, vrpn };
  By by = By::openigtlink;
  drivers::network::Address address;
};
const char* name_of(PublishAt::By by);  // "OpenIGTLink"

struct LivePose {
  std::string name;
  Instant<GraphicsClock> time;
  drivers::network::RigidPose pose;
};

// Of a frame that was drawn.
std::vector<LivePose> live_poses(const FrameRecord& frame, const scene::SceneDescription& scene,
                                 const ClockModel<GraphicsClock, PhysicsClock>& sync,
                                 Duration tracker_after_arm);

class PoseFeed {
 public:
  // Refused where somebody listens there already.
  static Expected<PoseFeed> open(const std::vector<PublishAt>& places,
                                 Duration tracker_after_arm = Duration(0));
  void marker(device::MarkerId marker, const device::MarkerPose& pose);
  void frame(const FrameRecord& frame, const scene::SceneDescription& scene,
             const ClockModel<GraphicsClock, PhysicsClock>& sync);
  std::string places() const;  // for a person: "OpenIGTLink at 127.0.0.1:18944"
  Json figures() const;        // counts of all places together

 private:
  struct Place {
    PublishAt::By by;
    std::unique_ptr<drivers::network::PoseServer> server;
  };
  PoseFeed(std::vector<Place> places, Duration tracker_after_arm)
      : places_(std::move(places)), tracker_after_arm_(tracker_after_arm) {}
  void send(const LivePose& pose);
  std::vector<Place> places_;
  Duration tracker_after_arm_;
};

}  // namespace palpate::server::graphics
