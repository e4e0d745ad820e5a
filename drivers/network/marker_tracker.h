// A server of poses as the laboratory's optical tracker: names of tools become markers, what has no name
// here is passed over. Use by one thread.
//
// Frames: the server says where a tool is in its own frame S; World is our tracker frame with its axes
// (docs/conventions.md), and X_world_server leads from one to the other. Stamps are the server's, or times of
// arrival where it has none. Such protocols carry no accuracy: it is stated here.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "drivers/network/pose_client.h"
#include "palpate/device/devices.h"

namespace palpate::drivers::network {

struct ServerFrame;  // what the server measures in

struct TrackerMapping {
  std::map<std::string, device::MarkerId> markers;  // by the tool's name as the server sends it
  Pose<World, ServerFrame> X_world_server;
  // Of one pose, per component; makers of optical trackers state 0.1 to 0.3 mm rms over the volume.
  double translation_sd = 0.00025;  // m, sane: 1e-5 to 1e-2
  double rotation_sd = 0.002;       // rad, 0.25 mm over a marker of 12 cm; sane: 1e-4 to 1e-1
  double systematic_sd = 0.0;       // m, the part that does not average out
};

class MarkerTracker : public device::TrackerDevice {
 public:
  MarkerTracker(std::unique_ptr<PoseClient> client, TrackerMapping mapping)
      : client_(std::move(client)), mapping_(std::move(mapping)) {}
  std::vector<device::TrackerSample> poll() override;
  PoseClientState state() const { return client_->state(); }
  // Poses of this marker so far, those in which it was seen.
  std::uint64_t seen(device::MarkerId marker) const { return seen_[static_cast<std::size_t>(marker)]; }
  // The server's tools that are no markers here, by name.
  const std::set<std::string>& others() const { return others_; }

 private:
  std::unique_ptr<PoseClient> client_;
  TrackerMapping mapping_;
  std::array<std::uint64_t, 3> seen_{};
  std::set<std::string> others_;  // at most PoseClient::kMostTools
};

}  // namespace palpate::drivers::network
