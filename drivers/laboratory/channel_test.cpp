#include "drivers/laboratory/channel.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <stdexcept>
#include <thread>

#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::laboratory {
namespace {

class LabChannel : public testing::Test {
 protected:
  LabSettings settings(int width = 64, int height = 48, int cameras = 1) const {
    return {cameras, width, height, folder_};
  }
  std::unique_ptr<LabServer> serve(int cameras = 1) {
    auto server = LabServer::open("bench", settings(64, 48, cameras));
    if (!server) throw std::runtime_error(server.error().message);
    return std::move(*server);
  }
  // The sign of life comes first: a busy machine may have left more than a second between two lines of a
  // test.
  std::shared_ptr<LabClient> connect(LabServer& server) {
    server.heartbeat();
    return connect();
  }
  std::shared_ptr<LabClient> connect() {
    auto client = LabClient::open("bench", folder_);
    if (!client) throw std::runtime_error(client.error().message);
    return *client;
  }
  // A refusal in one line that contains this.
  template <typename T>
  static void expect_refused(const Expected<T>& result, const std::string& text) {
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().kind, Error::Kind::refused);
    EXPECT_NE(result.error().message.find(text), std::string::npos) << result.error().message;
    EXPECT_EQ(result.error().message.find('\n'), std::string::npos);
  }

  ScratchFolder scratch_;
  const std::filesystem::path folder_ = scratch_.path();
};

device::CameraImage image(std::uint64_t frame, int width = 64, int height = 48) {
  device::CameraImage i{{seconds(static_cast<double>(frame) / 30.0)}, frame, width, height, {}};
  i.rgb.resize(static_cast<std::size_t>(width * height * 3));
  for (std::size_t k = 0; k < i.rgb.size(); ++k)
    i.rgb[k] = static_cast<std::uint8_t>(frame * 37 + k * (frame + 1));
  return i;
}

TEST_F(LabChannel, CarriesEverySampleUnchanged) {
  const auto server = serve(2);
  const auto client = connect(*server);
  Random random(1, "samples");
  const auto v3 = [&] { return Vector3(random.normal(), random.normal(), random.normal()); };
  const auto q = [&] {
    return Quaternion(random.normal(), random.normal(), random.normal(), random.normal());
  };

  device::ArmSample arm_sample{{Duration(123'456'789'012'345)}, v3(), v3()};
  arm_sample.waited = std::chrono::microseconds(300);
  server->publish_arm(arm_sample);
  const auto arm = LabArm::open(client);
  ASSERT_TRUE(arm.has_value());
  EXPECT_EQ((*arm)->read().stamp, arm_sample.stamp);
  EXPECT_EQ((*arm)->read().joints, arm_sample.joints);
  EXPECT_EQ((*arm)->read().gimbal, arm_sample.gimbal);
  EXPECT_GE((*arm)->read().waited, arm_sample.waited);
  EXPECT_LT((*arm)->read().waited, std::chrono::seconds(20));

  const Vector3 force = v3();
  (*arm)->command(force);
  EXPECT_EQ(server->take_force()->force, force);
  EXPECT_GE(server->take_force()->age, Duration(0));
  EXPECT_FALSE(server->take_force()->let_go);
  std::thread([&] { (*arm)->let_go(); }).join();
  EXPECT_EQ(server->take_force()->force, Vector3::Zero());
  EXPECT_TRUE(server->take_force()->let_go);
  (*arm)->command(force);
  EXPECT_EQ(server->take_force()->force, force) << "until the next command";

  LabTracker tracker(client);
  device::TrackerSample sent{{Duration(-5)}, device::MarkerId::pointer, true, q(), v3(), {}, {}, 5};
  for (int i = 0; i < 36; ++i) sent.covariance(i / 6, i % 6) = random.normal();
  for (int i = 0; i < 9; ++i) sent.systematic(i / 3, i % 3) = random.normal();
  server->publish_tracker(sent);
  const auto samples = tracker.poll();
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].stamp, sent.stamp);
  EXPECT_EQ(samples[0].marker, sent.marker);
  EXPECT_EQ(samples[0].seen, sent.seen);
  EXPECT_EQ(samples[0].rotation.coeffs(), sent.rotation.coeffs());
  EXPECT_EQ(samples[0].translation, sent.translation);
  EXPECT_EQ(samples[0].covariance, sent.covariance);
  EXPECT_EQ(samples[0].systematic, sent.systematic);
  EXPECT_EQ(samples[0].leds, sent.leds);
  EXPECT_TRUE(tracker.poll().empty());

  const auto left = LabCamera::open(client, 0), right = LabCamera::open(client, 1);
  ASSERT_TRUE(left && right);
  EXPECT_TRUE(server->publish_image(image(7), 1));
  EXPECT_FALSE((*left)->poll().has_value());
  const auto picture = (*right)->poll();
  ASSERT_TRUE(picture.has_value());
  EXPECT_EQ(picture->frame, 7u);
  EXPECT_EQ(picture->mid_exposure, image(7).mid_exposure);
  EXPECT_EQ(picture->rgb, image(7).rgb);

  const auto hand = LabHand::open(client);
  ASSERT_TRUE(hand.has_value());
  EXPECT_FALSE(server->take_hand_target().has_value());
  device::HandTarget target{Point<World>{v3()}, v3(), q(), true};
  (*hand)->move_to(target);
  const auto taken = server->take_hand_target();
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(taken->tip.m, target.tip.m);
  EXPECT_EQ(taken->velocity, target.velocity);
  EXPECT_EQ(taken->R_world_tip.coeffs(), target.R_world_tip.coeffs());
  EXPECT_TRUE(taken->head_still);
  EXPECT_FALSE(server->take_hand_target().has_value());  // taken is taken
  target.head_still = false;
  (*hand)->move_to(target);
  EXPECT_FALSE(server->take_hand_target()->head_still);
}

TEST_F(LabChannel, ACameraGivesTheNewestImageOnceAndNoneThatIsTooLarge) {
  const auto server = serve();
  EXPECT_TRUE(server->publish_image(image(1)));
  const auto camera = LabCamera::open(connect(*server));
  EXPECT_FALSE((*camera)->poll().has_value());  // taken before we came
  for (std::uint64_t frame = 2; frame < 12; ++frame) EXPECT_TRUE(server->publish_image(image(frame)));
  EXPECT_EQ((*camera)->poll()->frame, 11u);
  EXPECT_FALSE((*camera)->poll().has_value());
  EXPECT_FALSE(server->publish_image(image(12, 128, 48)));
  EXPECT_TRUE(server->publish_image(image(13, 8, 6)));
  const auto smaller = (*camera)->poll();
  ASSERT_TRUE(smaller);
  EXPECT_EQ(smaller->width, 8);
  EXPECT_EQ(smaller->height, 6);
  EXPECT_EQ(smaller->rgb, image(13, 8, 6).rgb);
  // How long an image has waited already is carried on, and what it waits here comes on top.
  device::CameraImage late = image(14);
  late.waited = std::chrono::milliseconds(50);
  EXPECT_TRUE(server->publish_image(late));
  const auto taken = (*camera)->poll();
  ASSERT_TRUE(taken);
  EXPECT_GE(taken->waited, late.waited);
  EXPECT_LT(taken->waited, std::chrono::seconds(20));
  EXPECT_FALSE(server->publish_image(image(12), 1));
  EXPECT_FALSE(LabCamera::open(connect(*server), 1).has_value());
}

TEST_F(LabChannel, AnImageTakenBackLendsItsMemoryToTheNext) {
  const auto server = serve();
  const auto camera = LabCamera::open(connect(*server));
  EXPECT_TRUE(server->publish_image(image(1)));
  auto first = (*camera)->poll();
  ASSERT_TRUE(first);
  const std::uint8_t* memory = first->rgb.data();
  (*camera)->take_back(std::move(*first));
  const auto elsewhere = image(1);  // would lie there if it had been freed
  EXPECT_FALSE((*camera)->poll());
  for (const std::uint64_t frame : {2, 3}) {
    EXPECT_TRUE(server->publish_image(image(frame, frame == 2 ? 8 : 64, frame == 2 ? 6 : 48)));
    auto next = (*camera)->poll();
    ASSERT_TRUE(next);
    EXPECT_EQ(next->rgb.data(), memory) << frame;
    EXPECT_EQ(next->rgb, image(frame, frame == 2 ? 8 : 64, frame == 2 ? 6 : 48).rgb);
    (*camera)->take_back(std::move(*next));
  }
}

TEST_F(LabChannel, ATrackersSamplesSayHowLongEachHasWaited) {
  const auto server = serve();
  LabTracker tracker(connect(*server));
  device::TrackerSample sample;
  sample.waited = std::chrono::milliseconds(50);  // before it was handed over
  server->publish_tracker(sample);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  sample.waited = Duration(0);
  server->publish_tracker(sample);
  const auto samples = tracker.poll();
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_GE(samples[0].waited, std::chrono::milliseconds(70));
  EXPECT_GE(samples[0].waited - samples[1].waited, std::chrono::milliseconds(70));
  EXPECT_LT(samples[0].waited, std::chrono::seconds(20));
}

TEST_F(LabChannel, ATrackerThatIsPolledTooLateCountsWhatItLost) {
  const auto server = serve();
  LabTracker tracker(connect(*server));
  for (int i = 0; i < 2000; ++i) server->publish_tracker({.stamp = {Duration(i)}});
  const auto samples = tracker.poll();
  ASSERT_EQ(samples.size(), 1024u);
  EXPECT_EQ(tracker.lost(), 2000u - 1024u);
  EXPECT_EQ(samples.front().stamp.ns(), 976);
  EXPECT_EQ(samples.back().stamp.ns(), 1999);
}

TEST_F(LabChannel, ALaboratoryThatIsNotThereIsRefused) {
  expect_refused(LabClient::open("nowhere", folder_), "is not there");
  EXPECT_EQ(LabClient::open("../etc", folder_).error().kind, Error::Kind::wrong_use);
  EXPECT_EQ(LabServer::open("", settings()).error().kind, Error::Kind::wrong_use);
  EXPECT_EQ(LabServer::open("x", settings(0, 48)).error().kind, Error::Kind::wrong_use);
}

TEST_F(LabChannel, ANameIsServedOnceAndFreeAgainAfterwards) {
  auto server = serve();
  expect_refused(LabServer::open("bench", settings()), "address in use");
  EXPECT_TRUE(LabServer::open("other", settings()).has_value());
  EXPECT_TRUE(connect(*server)->alive());  // the refused one has done no harm
  server.reset();
  EXPECT_NE(serve(), nullptr);
  EXPECT_TRUE(std::filesystem::is_empty(folder_)) << "neither memory nor lock is left";
}

TEST_F(LabChannel, ClientsNoticeThatItWasClosed) {
  auto server = serve();
  const auto client = connect(*server);
  EXPECT_TRUE(client->check().has_value());
  server.reset();
  EXPECT_FALSE(client->alive());
  expect_refused(client->check(), "has been closed");
  expect_refused(LabClient::open("bench", folder_), "is not there");
}

TEST_F(LabChannel, ArmAndHandHaveOneHolderEach) {
  const auto server = serve();
  server->publish_arm({});
  const auto first = connect(*server), second = connect(*server);
  server->heartbeat();
  EXPECT_EQ(server->peers().clients, 2);
  EXPECT_FALSE(server->peers().arm);
  {
    const auto arm = LabArm::open(first);
    const auto hand = LabHand::open(second);
    ASSERT_TRUE(arm && hand);
    EXPECT_TRUE(server->peers().arm && server->peers().hand);
    expect_refused(LabArm::open(second), "is held by process");
    expect_refused(LabHand::open(first), "is held by process");
    (*arm)->command({1, 2, 3});
  }
  EXPECT_FALSE(server->peers().arm || server->peers().arm_lost);
  EXPECT_EQ(server->take_force()->force, Vector3::Zero());  // let go, so no force is left behind
  EXPECT_TRUE(LabArm::open(second).has_value());
  EXPECT_TRUE(LabHand::open(first).has_value());
}

TEST_F(LabChannel, TheDisplaysTimecodesArriveInOrderWithTheirTimes) {
  const auto server = serve();
  const auto first = connect(*server), second = connect(*server);
  EXPECT_TRUE(server->take_timecodes().empty());
  {
    const auto display = LabDisplay::open(first);
    ASSERT_TRUE(display);
    expect_refused(LabDisplay::open(second), "is held by process");
    for (int i = 0; i < 5; ++i) (*display)->show_timecode(std::chrono::milliseconds(i));
    const auto timecodes = server->take_timecodes();
    ASSERT_EQ(timecodes.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(timecodes[i].code, std::chrono::milliseconds(i));
      EXPECT_GE(timecodes[i].sent_ns, timecodes[i > 0 ? i - 1 : 0].sent_ns);
    }
    EXPECT_TRUE(server->take_timecodes().empty());
    // Nobody has looked for long: the newest are kept.
    for (int i = 0; i < 5000; ++i) (*display)->show_timecode(std::chrono::milliseconds(i));
    const auto late = server->take_timecodes();
    ASSERT_EQ(late.size(), 4095u);
    EXPECT_EQ(late.back().code, std::chrono::milliseconds(4999));
  }
  EXPECT_TRUE(LabDisplay::open(second).has_value()) << "let go";
}

TEST_F(LabChannel, AnArmWithoutASampleIsRefused) {
  const auto server = serve();
  expect_refused(LabArm::open(connect(*server)), "gave no sample");
  server->publish_arm({});
  EXPECT_TRUE(LabArm::open(connect(*server)).has_value());  // the refused one does not hold it
}

TEST_F(LabChannel, MemoryThatIsNotALaboratoryOfThisBuildIsRefused) {
  const std::filesystem::path file = folder_ / "bench.lab";
  ASSERT_TRUE(write_file(file, std::string(100, 'x')).has_value());
  expect_refused(LabClient::open("bench", folder_), "not a laboratory of this build");
  ASSERT_TRUE(write_file(file, std::string(4'000'000, 'x')).has_value());
  expect_refused(LabClient::open("bench", folder_), "does not hold a laboratory");
  const auto server = serve();  // replaces what lies there
  const std::string whole = *read_file(file);
  std::string altered = whole;
  altered[8] ^= 1;  // the version
  ASSERT_TRUE(write_file(file, altered).has_value());
  expect_refused(LabClient::open("bench", folder_), "another build");
  ASSERT_TRUE(write_file(file, whole + "more").has_value());
  expect_refused(LabClient::open("bench", folder_), "bytes, expected");
}

TEST_F(LabChannel, AFolderOpenToOthersIsRefused) {
  ASSERT_EQ(chmod(folder_.c_str(), 0755), 0);
  expect_refused(LabServer::open("bench", settings()), "open to other users");
  ASSERT_EQ(chmod(folder_.c_str(), 0700), 0);
}

// A laboratory in a process of its own that ends as processes do at their worst.
TEST_F(LabChannel, AKilledLaboratoryIsNoticedAndReplaced) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto server = LabServer::open("bench", settings());
    if (!server) _exit(1);
    for (std::int64_t tick = 1;; ++tick) {
      (*server)->publish_arm(
          {{Duration(tick)}, Vector3::Constant(static_cast<double>(tick)), Vector3::Zero()});
      (*server)->heartbeat();
      if (tick == 1 && write(ready[1], "x", 1) != 1) _exit(1);
      usleep(1000);
    }
  }
  char byte;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  close(ready[0]);
  close(ready[1]);
  const auto client = connect();
  const auto arm = LabArm::open(client);
  ASSERT_TRUE(arm.has_value());
  const std::int64_t first = (*arm)->read().stamp.ns();
  std::int64_t last = first;
  while (last < first + 20 && client->alive()) {
    const device::ArmSample sample = (*arm)->read();
    EXPECT_GE(sample.stamp.ns(), last);
    EXPECT_EQ(sample.joints.x(), static_cast<double>(sample.stamp.ns()));
    last = sample.stamp.ns();
  }
  EXPECT_TRUE(client->alive());
  expect_refused(LabServer::open("bench", settings()), "address in use");
  ASSERT_EQ(kill(child, SIGKILL), 0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  for (int i = 0; i < 500 && client->alive(); ++i) usleep(10'000);
  expect_refused(client->check(), "has been silent");
  expect_refused(LabClient::open("bench", folder_), "has been silent");
  const auto server = serve();
  EXPECT_TRUE(connect(*server)->alive());
  EXPECT_FALSE(client->alive());  // the old memory stays dead
}

TEST_F(LabChannel, WhatADeadClientHeldIsFreeAgain) {
  const auto server = serve();
  server->publish_arm({});
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto client = LabClient::open("bench", folder_);
    if (!client) _exit(1);
    auto arm = LabArm::open(*client);
    if (!arm) _exit(2);
    (*arm)->command({0, 0, 5});
    _exit(0);  // without letting go
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(server->take_force()->force.z(), 5.0);  // it says how old it is; the laboratory stops obeying
  for (int i = 0; i < 500 && !server->peers().arm_lost; ++i) usleep(10'000);
  EXPECT_TRUE(server->peers().arm_lost);
  const auto client = connect(*server);
  EXPECT_TRUE(LabArm::open(client).has_value());
  EXPECT_FALSE(server->peers().arm_lost);
}

// All channels at once, a thread each, as in a running system; for the thread sanitizer above all.
TEST_F(LabChannel, AllChannelsRunBesideEachOther) {
  const auto server = serve();
  server->publish_arm({});
  const auto client = connect(*server);
  std::atomic<bool> done{false};
  std::atomic<int> images{0}, torn{0}, forces_torn{0}, samples{0}, backwards{0};
  std::thread arm_side([&] {
    const auto arm = LabArm::open(client);
    for (double last = 0; !done;) {
      const device::ArmSample sample = (*arm)->read();
      torn += sample.joints.x() != sample.gimbal.z();
      backwards += sample.joints.x() < last;
      last = sample.joints.x();
      (*arm)->command(Vector3::Constant(last));
    }
  });
  std::thread camera_side([&] {
    const auto camera = LabCamera::open(client);
    while (!done)
      if (const auto picture = (*camera)->poll()) {
        ++images;
        torn += picture->rgb != image(picture->frame).rgb;
      } else {
        std::this_thread::yield();
      }
  });
  std::thread tracker_side([&] {
    LabTracker tracker(client);
    while (!done) {
      samples += static_cast<int>(tracker.poll().size());
      std::this_thread::yield();
    }
  });
  std::thread picture_maker([&] {
    for (std::uint64_t frame = 0; frame < 200 || images < 3 || samples < 3; ++frame) {
      server->publish_image(image(frame));
      std::this_thread::yield();
    }
    done = true;
  });
  for (std::int64_t tick = 1; !done; ++tick) {
    const double x = static_cast<double>(tick);
    server->publish_arm({{Duration(tick)}, Vector3::Constant(x), Vector3::Constant(x)});
    if (tick % 10 == 0) server->publish_tracker({.stamp = {Duration(tick)}});
    if (const auto command = server->take_force()) forces_torn += command->force.x() != command->force.z();
    server->heartbeat();
    std::this_thread::yield();
  }
  for (std::thread* t : {&arm_side, &camera_side, &tracker_side, &picture_maker}) t->join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(forces_torn, 0);
  EXPECT_EQ(backwards, 0);
  EXPECT_GE(images, 3);
  EXPECT_GE(samples, 3);
}

}  // namespace
}  // namespace palpate::drivers::laboratory
