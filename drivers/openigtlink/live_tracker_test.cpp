#include "drivers/network/live_tracker.h"

#include <gtest/gtest.h>

#include "drivers/openigtlink/codec.h"
#include "drivers/openigtlink/loopback_for_tests.h"
#include "palpate/device/live_name.h"

namespace palpate::drivers::openigtlink {
namespace {

// Sends a marker's pose under our own name for it.
void send(network::PoseServer& feed, device::MarkerId marker, Instant<TrackerClock> stamp,
          const RigidPose& pose) {
  EXPECT_TRUE(feed.publish(device::live_name(marker), stamp, pose));
}

Expected<network::LiveTracker> parse(std::string_view uri, const std::vector<std::string>& tools) {
  return network::parse_live_tracker(uri, tools, kProtocol, kNameBytes);
}

network::MarkerTracker tracker_of(const network::LiveTracker& named) {
  return {client_of(named.server), {.markers = named.tools}};
}

TEST(LiveTracker, ToolsAreNamedAfterTheirMarkersUnlessSaidOtherwise) {
  const auto plain = parse("igtl://localhost", {});
  ASSERT_TRUE(plain.has_value());
  EXPECT_EQ(plain->server.port, kProtocol.default_port);
  EXPECT_EQ(plain->tools.at("CameraMarkerToWorld"), device::MarkerId::camera_marker);
  for (const char* word : {"camera_marker", "CameraMarker"})
    EXPECT_EQ(parse("igtl://h:7", {std::string(word) + "=Head"})->tools.at("Head"),
              device::MarkerId::camera_marker);
  const auto named = parse("igtl://[::1]:7", {"CameraMarker=HeadToTracker"});
  ASSERT_TRUE(named.has_value());
  EXPECT_EQ(named->server.text(), "[::1]:7");
  EXPECT_EQ(named->tools.at("HeadToTracker"), device::MarkerId::camera_marker);
  EXPECT_FALSE(named->tools.contains("CameraMarkerToWorld"));
  EXPECT_EQ(named->tools.at("TipMarkerToWorld"), device::MarkerId::tip_marker);
}

TEST(LiveTracker, WhatIsNoneIsWrongUse) {
  for (const char* address : {"localhost:1", "tcp://localhost:1", "igtl://", "igtl://host:port"})
    EXPECT_EQ(parse(address, {}).error().exit_code(), 2) << address;
  for (const char* tool : {"Head", "Head=x", "CameraMarker=", "=x", "CameraMarker=TipMarkerToWorld"})
    EXPECT_EQ(parse("igtl://localhost", {tool}).error().exit_code(), 2) << tool;
}

TEST(LiveTracker, WhatIsNotHeardOfHasItsReasonAndPosesThatComeAreThoseThatWereSent) {
  auto feed = server_at();
  const auto named = parse("igtl://" + feed->address().text(), {});
  ASSERT_TRUE(named.has_value());
  auto device = tracker_of(*named);
  ASSERT_TRUE(comes_true([&] { return device.state().connected; }));
  EXPECT_NE(why_unheard(device, *named, kProtocol).find("does not see 'CameraMarkerToWorld'"),
            std::string::npos);

  // The poses that come are those that were sent, as samples of their markers.
  const auto stamp = Instant<TrackerClock>::from_seconds(5.0);
  const RigidPose pose{so3_exp(Vector3(0.1, -0.4, 0.2)), Vector3(0.1, -0.2, -1.1)};
  std::vector<device::TrackerSample> samples;
  ASSERT_TRUE(comes_true([&] {
    send(*feed, device::MarkerId::camera_marker, stamp,
         pose);  // again and again: whoever is connected is served from now on
    samples = device.poll();
    return !samples.empty();
  }));
  EXPECT_EQ(samples[0].marker, device::MarkerId::camera_marker);
  EXPECT_EQ(samples[0].stamp.ns(), stamp.ns());
  EXPECT_LT((samples[0].translation - pose.translation).norm(), 1e-6);  // float32
  EXPECT_LT(samples[0].rotation.angularDistance(pose.rotation), 1e-6);

  feed.reset();
  ASSERT_TRUE(comes_true([&] { return !device.state().connected; }));
  EXPECT_NE(why_unheard(device, *named, kProtocol).find("no OpenIGTLink server answers"), std::string::npos);
}

TEST(LiveTracker, AToolUnderAnotherNameIsAskedFor) {
  auto feed = server_at();
  const auto named = parse("igtl://" + feed->address().text(), {"CameraMarker=Head"});
  auto device = tracker_of(*named);
  const auto stamp = Instant<TrackerClock>::from_seconds(5.0);
  const RigidPose pose{Quaternion::Identity(), Vector3::Zero()};
  ASSERT_TRUE(comes_true([&] {
    send(*feed, device::MarkerId::camera_marker, stamp, pose);
    static_cast<void>(device.poll());
    return !device.others().empty();
  }));
  const auto said = why_unheard(device, *named, kProtocol);
  EXPECT_NE(said.find("there are CameraMarkerToWorld"), std::string::npos) << said;
  EXPECT_NE(said.find("--tracker-tool camera_marker=NAME"), std::string::npos) << said;
}

}  // namespace
}  // namespace palpate::drivers::openigtlink
