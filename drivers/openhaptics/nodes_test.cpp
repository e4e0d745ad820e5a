#include "drivers/openhaptics/nodes.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/scratch_folder.h"

namespace palpate::drivers::openhaptics {
namespace {

// A machine's /sys and /dev, made up.
class OpenHapticsNodes : public testing::Test {
 protected:
  void file(const std::filesystem::path& name, const std::string& content = "") {
    std::filesystem::create_directories((scratch_ / name).parent_path());
    std::ofstream(scratch_ / name) << content << '\n';
  }
  void usb(const std::string& name, const std::string& vendor) {
    const auto device = std::filesystem::path("sys/bus/usb/devices") / name;
    file(device / "idVendor", vendor);
    file(device / "idProduct", "0302");
    file(device / "product", "Touch");
    file(device / "busnum", "1");
    file(device / "devnum", "14");
  }
  std::vector<ArmNode> find() { return find_arm_nodes(scratch_ / "sys", scratch_ / "dev"); }
  std::string dev(const char* name) { return scratch_ / "dev" / name; }
  ScratchFolder scratch_;
};

TEST_F(OpenHapticsNodes, NothingIsFoundWhereNothingIsOfTheMaker) {
  EXPECT_TRUE(find().empty());
  usb("1-1", "046d");
  EXPECT_TRUE(find().empty());
}

TEST_F(OpenHapticsNodes, TheSerialLineOfAUsbArmIsItsNode) {
  usb("1-2", "2988");
  usb("1-3", "046d");
  file("sys/bus/usb/devices/1-2:1.0/tty/ttyACM0/dev");
  file("sys/bus/usb/devices/1-3:1.0/tty/ttyACM1/dev");
  file("dev/ttyACM0");
  file("dev/ttyACM1");
  const auto nodes = find();
  ASSERT_EQ(nodes.size(), 1u);
  EXPECT_EQ(nodes[0].device, "USB 2988:0302 Touch");
  EXPECT_EQ(nodes[0].path, dev("ttyACM0"));
  EXPECT_TRUE(nodes[0].usable);
}

TEST_F(OpenHapticsNodes, AHidArmARawOneAndOneWithoutANodeAreTold) {
  usb("1-2", "2988");
  file("sys/bus/usb/devices/1-2:1.0/0003:2988:0302.0001/hidraw/hidraw7/dev");
  file("dev/hidraw7");
  usb("2-1", "2988");
  file("dev/bus/usb/001/014");
  auto nodes = find();
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes[0].path, dev("bus/usb/001/014"));
  EXPECT_EQ(nodes[1].path, dev("hidraw7"));
  std::filesystem::remove_all(scratch_ / "dev");
  nodes = find();
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes[0].path, "");
  EXPECT_FALSE(nodes[0].usable);
}

TEST_F(OpenHapticsNodes, FireWireArmsAreKnownByTheirMaker) {
  file("sys/bus/firewire/devices/fw0/vendor", "0x001106");
  file("sys/bus/firewire/devices/fw1/vendor", "0x000b99");
  file("dev/fw0");
  file("dev/fw1");
  std::filesystem::permissions(scratch_ / "dev/fw1", std::filesystem::perms(0660));
  const auto nodes = find();
  ASSERT_EQ(nodes.size(), 1u);
  EXPECT_EQ(nodes[0].device, "FireWire");
  EXPECT_EQ(nodes[0].path, dev("fw1"));
  EXPECT_FALSE(nodes[0].group.empty());
}

}  // namespace
}  // namespace palpate::drivers::openhaptics
