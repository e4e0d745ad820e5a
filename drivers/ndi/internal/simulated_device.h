// A tracker as the combined API shows it, whose tools are where they were last said to be. Commands in, replies out; no
// sockets, no clock of its own. One thread.
//
// Poses in metres, from the tool to the frame that they were published in. Times: this machine's monotonic clock, ns.
#pragma once

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/ndi/codec.h"
#include "drivers/network/pose_server.h"

namespace palpate::drivers::ndi {

class SimulatedDevice {
 public:
  explicit SimulatedDevice(bool timestamps) : timestamps_(timestamps) {}

  // A wired tool: it has a handle from the next INIT on.
  void plug_in(const std::string& tool);
  void pose(const network::PublishedPose& pose);
  // The whole reply, with checksums.
  std::string answer(const Command& command, std::int64_t now_ns);
  // Poses wait for who asks by BX2.
  bool has_more() const { return !sights_.empty(); }

 private:
  struct Port {
    std::string tool;        // whose pose it shows; empty: none that is there
    std::string definition;  // of a wireless one, as far as it is written
    bool wireless = false, initialized = false, enabled = false;
    bool told_missing = false;  // to who asks by BX2
  };
  struct Newest {
    network::RigidPose pose;
    std::int64_t at_ns = 0;
    std::uint32_t frame = 0;
  };
  // What was seen at one time.
  struct Sight {
    std::uint32_t frame = 0;
    std::int64_t stamp_ns = 0, at_ns = 0;
    std::vector<std::pair<std::string, network::RigidPose>> tools;
  };

  std::string initialize();
  std::string while_set_up(const Command& command);
  std::string list(const std::string& parameters) const;
  std::string request_handle(const std::string& parameters);
  std::string write_definition(const std::string& parameters);
  std::string of_handle(const Command& command);
  std::string tool_info(std::uint8_t handle, const Port& port, std::string_view options) const;
  std::string newest(const Command& command, std::int64_t now_ns) const;
  std::string since_last_asked(std::int64_t now_ns);
  bool is_missing(const Port& port, std::int64_t now_ns) const;
  Frame frame_of(const Sight& sight) const;
  Frame missing_ones(std::int64_t now_ns);

  const bool timestamps_;
  std::vector<std::string> tools_;
  std::map<std::uint8_t, Port> ports_;  // by handle
  bool initialized_ = false, tracking_ = false;
  bool asked_ = false;                    // by BX2, since it tracks
  std::map<std::string, Newest> newest_;  // by tool
  std::deque<Sight> sights_;              // that BX2 has not told
  Sight last_;                            // without its tools
};

}  // namespace palpate::drivers::ndi
