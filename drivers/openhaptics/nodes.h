// Arms of the maker that the kernel sees at USB and FireWire, and whether this user may talk to them.
//
// Ethernet arms do not show there. Nothing is opened. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::drivers::openhaptics {

struct ArmNode {
  std::string device;   // "USB 2988:0302 Touch" or "FireWire"
  std::string path;     // of its node in /dev; empty: the kernel has made none
  bool usable = false;  // this user may read and write it
  std::string group;    // that may, where there is one; empty otherwise
};

// The folders are parameters for tests.
std::vector<ArmNode> find_arm_nodes(const std::filesystem::path& sys = "/sys",
                                    const std::filesystem::path& dev = "/dev");

}  // namespace palpate::drivers::openhaptics
