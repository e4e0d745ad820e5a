#include <gtest/gtest.h>

#include <limits>

#include "drivers/laboratory/channel.h"
#include "drivers/laboratory/memory.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::laboratory {
namespace {

device::CameraImage blank_image(std::uint64_t frame, int width, int height) {
  device::CameraImage i{{}, frame, width, height, {}};
  i.rgb.resize(static_cast<std::size_t>(width * height * 3));
  return i;
}

// Whoever of this user maps the memory can write anything into it, and a process that runs wild does.
TEST(WreckedMemory, NumbersThatCannotBeEndNobody) {
  const ScratchFolder folder;
  const auto opened = LabServer::open("bench", {1, 64, 48, folder.path()});
  ASSERT_TRUE(opened.has_value()) << opened.error().message;
  const auto& server = *opened;
  server->heartbeat();
  const auto client = *LabClient::open("bench", folder.path());
  LabMemory& memory = *client->memory();
  server->publish_arm({{Duration(1)}, Vector3::Zero(), Vector3::Zero()});
  memory.arm_holder.store(1'000'000);  // a holder that no place belongs to
  const auto arm = LabArm::open(client);
  ASSERT_TRUE(arm.has_value()) << arm.error().message;

  const auto camera = LabCamera::open(client);
  ASSERT_TRUE(camera.has_value());
  memory.width = memory.height = 1'000'000;
  memory.cameras = 200;
  EXPECT_EQ(client->cameras(), 1);
  EXPECT_FALSE(server->publish_image(blank_image(2, 64, 48), 100));
  EXPECT_FALSE(server->publish_image(blank_image(2, 640, 480)));
  const std::vector<std::uint8_t> pixels(64 * 48 * 3);
  for (const auto& [width, height] : {std::pair{-64, 48}, std::pair{64, -48}, std::pair{0, 0},
                                      std::pair{1 << 30, 1 << 30}, std::pair{65, 1}}) {
    client->mapping().image_slots(0).push({0, 3, width, height, 0}, pixels.data());
    EXPECT_FALSE((*camera)->poll().has_value()) << width << " x " << height;
  }
  EXPECT_TRUE(server->publish_image(blank_image(4, 64, 48)));
  EXPECT_EQ((*camera)->poll()->frame, 4u);

  LabTracker tracker(client);
  TrackerWire wire = pack(device::TrackerSample{.seen = true});
  wire.marker = 77;
  memory.tracker.push(wire);
  wire.marker = 0;
  wire.translation[1] = std::numeric_limits<double>::quiet_NaN();
  memory.tracker.push(wire);
  server->publish_tracker({.marker = device::MarkerId::pointer});
  ASSERT_EQ(tracker.poll().size(), 1u);
  EXPECT_EQ(tracker.lost(), 2u);
  HandWire hand = pack(device::HandTarget{});
  hand.velocity[0] = std::numeric_limits<double>::infinity();
  memory.hand.write(hand);
  EXPECT_FALSE(server->take_hand_target().has_value());

  // The counts of all rings, which a reader goes by.
  for (auto* ring :
       {reinterpret_cast<AtomicWord*>(&memory.tracker), reinterpret_cast<AtomicWord*>(&memory.arm),
        reinterpret_cast<AtomicWord*>(&memory.display), reinterpret_cast<AtomicWord*>(&memory.force)})
    ring->store(std::uint64_t{1} << 62);
  EXPECT_TRUE(tracker.poll().empty());
  EXPECT_FALSE((*arm)->read().connected);
  EXPECT_TRUE(server->take_timecodes().empty());
  EXPECT_FALSE(server->take_force().has_value());
}

}  // namespace
}  // namespace palpate::drivers::laboratory
