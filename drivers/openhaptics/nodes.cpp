#include "drivers/openhaptics/nodes.h"

#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "palpate/core/text.h"

namespace palpate::drivers::openhaptics {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUsbVendor = "2988";           // 3D Systems (Geomagic)
constexpr const char* kFireWireVendor = "0x000b99";  // SensAble
constexpr int kDeepest = 4;                          // interface / driver's device / class / node

std::string line_of(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

ArmNode node_at(std::string device, const fs::path& path) {
  ArmNode node;
  node.device = excerpt(device);
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return node;
  node.path = path;
  node.usable = access(path.c_str(), R_OK | W_OK) == 0;
  if ((info.st_mode & 0060u) != 0060u) return node;
  std::array<char, 1024> room{};
  group entry{}, *found = nullptr;
  if (getgrgid_r(info.st_gid, &entry, room.data(), room.size(), &found) == 0 && found != nullptr)
    node.group = found->gr_name;
  return node;
}

// A serial line or a HID device below one of the USB device's interfaces.
fs::path usb_node(const fs::path& devices, const std::string& name, const fs::path& dev) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const auto& interface : fs::directory_iterator(devices, ignored)) {
    if (!interface.path().filename().string().starts_with(name + ":")) continue;
    for (fs::recursive_directory_iterator at(interface.path(), ignored), end; at != end;
         at.increment(ignored)) {
      if (at.depth() >= kDeepest) at.disable_recursion_pending();
      const std::string below = at->path().filename();
      const bool number = below.find_first_of("0123456789") != std::string::npos;
      if (number && (below.starts_with("ttyACM") || below.starts_with("hidraw")))
        found.push_back(dev / below);
    }
  }
  return found.empty() ? fs::path() : *std::min_element(found.begin(), found.end());
}

// /dev/bus/usb/001/004
fs::path raw_usb_node(const fs::path& device, const fs::path& dev) {
  const auto three = [](const std::string& digits) {
    return std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
  };
  return dev / "bus" / "usb" / three(line_of(device / "busnum")) / three(line_of(device / "devnum"));
}

}  // namespace

std::vector<ArmNode> find_arm_nodes(const fs::path& sys, const fs::path& dev) {
  std::vector<ArmNode> nodes;
  std::error_code ignored;
  const fs::path usb = sys / "bus" / "usb" / "devices";
  for (const auto& entry : fs::directory_iterator(usb, ignored)) {
    if (line_of(entry.path() / "idVendor") != kUsbVendor) continue;
    const std::string product = line_of(entry.path() / "product");
    const fs::path node = usb_node(usb, entry.path().filename(), dev);
    nodes.push_back(node_at(fmt::format("USB {}:{}{}{}", kUsbVendor, line_of(entry.path() / "idProduct"),
                                        product.empty() ? "" : " ", product),
                            node.empty() ? raw_usb_node(entry.path(), dev) : node));
  }
  for (const auto& entry : fs::directory_iterator(sys / "bus" / "firewire" / "devices", ignored))
    if (line_of(entry.path() / "vendor") == kFireWireVendor)
      nodes.push_back(node_at("FireWire", dev / entry.path().filename()));
  std::sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return nodes;
}

}  // namespace palpate::drivers::openhaptics
