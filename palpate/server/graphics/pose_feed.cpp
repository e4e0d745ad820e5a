#include "palpate/server/graphics/pose_feed.h"

#include <algorithm>

#include "drivers/openigtlink/protocol.h"
#include "drivers/vrpn/protocol.h"
#include "palpate/device/live_name.h"
#include "palpate/scene/shown_tip.h"

namespace palpate::server::graphics {
namespace {

// Of live poses only the newest matter: a second or so for a reader that hesitates, not ten.
constexpr std::size_t kMostWaitingPoses = 256;
constexpr int kBodies = scene::SceneState::kBodies;

}  // namespace

std::vector<LivePose> live_poses(const FrameRecord& frame, const scene::SceneDescription& scene,
                                 const ClockModel<GraphicsClock, PhysicsClock>& sync,
                                 Duration tracker_after_arm) {
  std::vector<LivePose> poses;
  if (frame.have_state) {
    const auto time = sync.back(frame.state.time);
    const auto& carried = frame.state.bodies[scene::kCarried];
    poses.push_back({"TipToWorld", time, {carried.q(), scene::shown_tip(frame.state, scene)}});
    const auto known = static_cast<std::size_t>(std::clamp(frame.state.body_count, 0, kBodies));
    for (std::size_t i = 0; i < std::min(known, scene.bodies.size()); ++i) {
      const auto& body = frame.state.bodies[i];
      if (!scene.bodies[i].name.empty() && (body.visible != 0 || i == scene::kCarried))
        poses.push_back({scene.bodies[i].name + "ToWorld", time, {body.q(), body.p()}});
    }
  }
  if (frame.pose_source != PoseSource::none)
    poses.push_back({"CameraToWorld",
                     frame.image_time - tracker_after_arm,
                     {frame.X_world_camera.rotation, frame.X_world_camera.translation}});
  return poses;
}

const char* name_of(PublishAt::By by) {
  return by == PublishAt::By::vrpn ? drivers::vrpn::kProtocol.name : drivers::openigtlink::kProtocol.name;
}

Expected<PoseFeed> PoseFeed::open(const std::vector<PublishAt>& places, Duration tracker_after_arm) {
  const drivers::network::PoseServerOptions options{.most_waiting = kMostWaitingPoses};
  std::vector<Place> opened;
  for (const auto& place : places) {
    auto server =
        place.by == PublishAt::By::vrpn
            ? drivers::vrpn::listen(place.address, options)
            : drivers::openigtlink::listen(place.address, {.of_any = options, .tracking_data = true});
    if (!server) return tl::unexpected(server.error());
    opened.push_back({place.by, std::move(*server)});
  }
  return PoseFeed(std::move(opened), tracker_after_arm);
}

std::string PoseFeed::places() const {
  std::string all;
  for (const auto& place : places_)
    all +=
        fmt::format("{}{} at {}", all.empty() ? "" : ", ", name_of(place.by), place.server->address().text());
  return all;
}

void PoseFeed::marker(device::MarkerId marker, const device::MarkerPose& pose) {
  send({device::live_name(marker), pose.time - tracker_after_arm_, {pose.rotation, pose.translation}});
}

void PoseFeed::frame(const FrameRecord& frame, const scene::SceneDescription& scene,
                     const ClockModel<GraphicsClock, PhysicsClock>& sync) {
  for (const auto& pose : live_poses(frame, scene, sync, tracker_after_arm_)) send(pose);
}

void PoseFeed::send(const LivePose& pose) {
  // Refused only where the protocol has no such number: a pose or time that means nothing is not sent.
  for (const auto& place : places_)
    static_cast<void>(
        place.server->publish(pose.name, Instant<TrackerClock>{pose.time.since_epoch}, pose.pose));
}

Json PoseFeed::figures() const {
  drivers::network::PoseServerState sum;
  for (const auto& place : places_) {
    const auto state = place.server->state();
    sum.published += state.published;
    sum.sent += state.sent;
    sum.dropped += state.dropped;
    sum.accepted += state.accepted;
    sum.stalled += state.stalled;
    sum.thrown_out += state.thrown_out;
  }
  return {{"published", sum.published}, {"sent", sum.sent},       {"dropped", sum.dropped},
          {"clients", sum.accepted},    {"stalled", sum.stalled}, {"thrown_out", sum.thrown_out}};
}

}  // namespace palpate::server::graphics
