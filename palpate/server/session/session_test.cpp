// A session of one's own, in threads and on the machine's clock, with devices that stand still.
#include "palpate/server/session/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/specification.h"
#include "palpate/core/log.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/server/session/devices_for_tests.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/transport/zmq_engine.h"
#include "tests/own_run_directory.h"

namespace palpate::server::session {
namespace {

class RunningSession : public testing::Test {
 protected:
  RunningSession() {
    setup_.physics.rig = StillLaboratory::rig();
    setup_.physics.applications = {applications::pingpong::specification()};
    setup_.physics.scene =
        *sim::config::scene_of(sim::config::reference_world(), setup_.physics.applications, "pingpong");
    setup_.physics.drivers = laboratory_.drivers();
    setup_.physics.arm.uri = "still";
    setup_.graphics.stand_in = "still";
    setup_.graphics.pixels = Pixels::unseen;
    how_.real_time = false;  // a test does not take the machine's cores away
    how_.shown = [this](const graphics::FrameRecord& frame) {
      const std::lock_guard lock(mutex_);
      frame_ = frame;
    };
  }

  // Until it is so, or the patience is over.
  template <typename Condition>
  static bool wait_for(Session& session, Condition condition) {
    const MonotonicClock<GraphicsClock> clock;
    const auto begun = clock.now();
    while (!condition() && clock.now() - begun < std::chrono::seconds(60)) {
      const auto fine = session.look();
      EXPECT_TRUE(fine) << fine.error().message;
      if (!fine) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return condition();
  }
  graphics::FrameRecord frame() {
    const std::lock_guard lock(mutex_);
    return frame_;
  }

  OwnRunDirectory run_directory_;
  StillLaboratory laboratory_;
  SessionSetup setup_;
  RealTime how_;

 private:
  std::mutex mutex_;
  graphics::FrameRecord frame_;
};

TEST_F(RunningSession, ShowsTheStateOfItsPhysicsSideAtTheMomentOfEachImage) {
  auto session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  ASSERT_TRUE(wait_for(**session,
                       [&] {
                         const auto f = frame();
                         return f.have_state && f.answer == AnswerKind::interpolated && f.have_tracker;
                       }))
      << frame().number << " frames";
  const auto shown = frame();
  EXPECT_GE((*session)->frames(), shown.number);
  // The tip that the picture has is that of the arm, which stands still.
  const auto now = (*session)->physics().server().state_at(shown.asked);
  ASSERT_TRUE(now.usable());
  const auto& scene = (*session)->physics().scene();
  EXPECT_LT((scene::shown_tip(now.state, scene) - scene::shown_tip(shown.state, scene)).norm(), 1e-9);
  EXPECT_LT((shown.X_world_camera.translation - StillTracker::kCamera).norm(), 1e-9);
  EXPECT_TRUE(shown.rgb.empty()) << "nobody draws";
}

TEST_F(RunningSession, OthersMayLookOnAndAWishReachesTheApplication) {
  auto session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  const MonotonicClock<GraphicsClock> clock;
  auto link = transport::connect_states(
      *transport::parse_endpoint((*session)->endpoint(), transport::EndpointUse::connect), clock, "onlooker");
  ASSERT_TRUE(link) << link.error().message;
  EXPECT_TRUE(wait_for(**session, [&] {
    (*link)->poll();
    (*link)->ask_status();
    return (*link)->description() && (*link)->status() && (*link)->status()->loops.size() == 2 &&
           (*link)->status()->loops[0].ticks > 0;
  }));
  EXPECT_EQ((*link)->description()->application, "pingpong");
  const auto serves = [&] {
    const auto f = frame();
    return f.have_state ? f.state.counters[applications::pingpong::kServes] : 0;
  };
  ASSERT_TRUE(wait_for(**session, [&] { return serves() > 0; }));
  EXPECT_EQ((*session)->physics().service().counters().controls, 0u);
  (*session)->control(scene::Control::pause);
  EXPECT_TRUE(wait_for(**session, [&] { return (*session)->physics().service().counters().controls > 0; }));
  (*session)->stop();
  const auto frames = (*session)->frames();
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_EQ((*session)->frames(), frames) << "stopped is stopped";
  (*session)->stop();
}

TEST_F(RunningSession, WhatCannotBeHadIsRefusedBeforeAnythingRuns) {
  const auto refusal = [&](auto spoil) {
    SessionSetup setup = setup_;
    RealTime how = how_;
    spoil(setup, how);
    const auto session = Session::start(setup, how);
    return session ? std::string("started") : session.error().message;
  };
  EXPECT_EQ(refusal([](auto& s, auto&) { s.physics.arm.uri = "elsewhere"; }),
            "arm: is 'elsewhere'; still is expected");
  EXPECT_EQ(refusal([](auto& s, auto&) { s.physics.rig.arm.reset(); }),
            "physics: the rig has no arm calibration; run `palpate calibrate arm` on it");
  EXPECT_EQ(refusal([](auto& s, auto&) { s.physics.applications = {}; }),
            "application 'pingpong' is not known; there are: none");
  EXPECT_EQ(refusal([](auto& s, auto&) { s.graphics.stand_in = "elsewhere"; }),
            "is 'elsewhere'; still is expected");
  EXPECT_NE(refusal([](auto& s, auto&) { s.physics.rig.hand_eye.reset(); }).find("hand-eye"),
            std::string::npos);
  EXPECT_NE(refusal([](auto&, auto& how) { how.endpoint = "tcp://127.0.0.1:0"; }).find("ipc:// is expected"),
            std::string::npos);
}

TEST_F(RunningSession, ThatCouldNotBeginLeavesNothingBehindThatIsInTheWay) {
  SessionSetup spoilt = setup_;
  spoilt.graphics.stand_in = "elsewhere";  // found last: arm, socket and physics side are there by then
  for (int i = 0; i < 3; ++i) ASSERT_FALSE(Session::start(spoilt, how_));
  auto session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  session->reset();  // nobody has said stop
  session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  EXPECT_TRUE(wait_for(**session, [&] { return (*session)->frames() > 0; }));
}

// A device that is asked by a session that has stopped may be gone by then.
TEST_F(RunningSession, TouchesNoDeviceOnceItHasStopped) {
  std::atomic<int> touched{0};
  class WatchedArm : public StillArm {
   public:
    explicit WatchedArm(std::atomic<int>& touched) : touched_(touched) {}
    device::ArmSample read() override { return ++touched_, StillArm::read(); }
    void command(const Vector3&) override { ++touched_; }

   private:
    std::atomic<int>& touched_;
  } arm(touched);
  class WatchedCamera : public StillCamera {
   public:
    explicit WatchedCamera(std::atomic<int>& touched) : touched_(touched) {}
    std::optional<device::CameraImage> poll() override { return ++touched_, StillCamera::poll(); }

   private:
    std::atomic<int>& touched_;
  } camera(touched);
  setup_.physics.drivers.add(device::borrowed_devices(
      "watched", {.arm = &arm,
                  .arm_facts = {.simulated = true, .identity = "watched", .peak_n = {}, .continuous_n = {}},
                  .tracker = &laboratory_.tracker,
                  .camera = &camera,
                  .simulated = true}));
  setup_.physics.arm.uri = "watched";
  setup_.graphics.stand_in = "watched";
  auto session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  ASSERT_TRUE(wait_for(**session, [&] { return (*session)->frames() > 2; }));
  (*session)->stop();
  const int before = touched;
  EXPECT_GT(before, 0);
  (*session)->control(scene::Control::pause);
  EXPECT_TRUE((*session)->look());
  std::this_thread::sleep_for(std::chrono::milliseconds(60));  // of loops that ran a thousand times a second
  EXPECT_EQ(touched, before);
}

TEST_F(RunningSession, ACameraThatGoesDarkIsSaidAndItsFramesComeBackWithIt) {
  class Dark : public StillCamera {
   public:
    std::atomic<bool> dark{false};
    std::optional<device::CameraImage> poll() override { return dark ? std::nullopt : StillCamera::poll(); }
  } camera;
  const LogCapture told;
  setup_.physics.drivers.add(device::borrowed_devices(
      "dark", {.arm = &laboratory_.arm,
               .arm_facts = {.simulated = true, .identity = "dark", .peak_n = {}, .continuous_n = {}},
               .tracker = &laboratory_.tracker,
               .camera = &camera,
               .simulated = true}));
  setup_.physics.arm.uri = "dark";
  setup_.graphics.stand_in = "dark";
  auto session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  ASSERT_TRUE(wait_for(**session, [&] { return frame().answer == AnswerKind::interpolated; }));
  const auto says_of_camera = [&] {
    const auto lines = told.lines();
    return std::count_if(lines.begin(), lines.end(),
                         [](const auto& line) { return line.text.find("camera") != std::string::npos; });
  };
  const auto before = says_of_camera();
  camera.dark = true;
  ASSERT_TRUE(wait_for(**session, [&] { return says_of_camera() > before; })) << told.text();
  const auto last = frame().number;
  const auto requests = (*session)->physics().service().counters().syncs;
  EXPECT_TRUE(wait_for(**session, [&] {
    return (*session)->physics().service().counters().syncs > requests;
  })) << "the clocks are kept meanwhile";
  EXPECT_LE(frame().number, last + 1);
  camera.dark = false;
  EXPECT_TRUE(wait_for(**session, [&] {
    const auto f = frame();
    return f.number > last + 1 && f.conditions.empty() && f.answer == AnswerKind::interpolated && !f.late;
  })) << frame().number;
}

// A camera that is pulled out.
TEST_F(RunningSession, LookRefusesWhereADeviceHasGone) {
  class Gone : public device::OpenedCamera {
   public:
    explicit Gone(device::CameraDevice& camera) : camera_(camera) {}
    device::CameraDevice& device() override { return camera_; }
    std::string name() const override { return "film"; }
    std::string description() const override { return "a film of ten looks"; }
    Expected<void> look() override {
      if (++looks_ > 10) return refused("camera film: has been pulled out");
      return {};
    }

   private:
    device::CameraDevice& camera_;
    int looks_ = 0;
  };
  device::Driver film;
  film.scheme = "film";
  film.summary = "a camera that goes";
  film.camera.emplace();
  film.camera->form = "film";
  film.camera->open =
      [this](const device::CameraRequest&) -> Expected<std::unique_ptr<device::OpenedCamera>> {
    return std::make_unique<Gone>(laboratory_.camera);
  };
  setup_.physics.drivers.add(film);
  setup_.graphics.camera = device::CameraRequest{"film", {}};
  auto session = Session::start(setup_, how_);
  ASSERT_TRUE(session) << session.error().message;
  Expected<void> fine;
  for (int i = 0; i < 3000 && fine; ++i) {
    fine = (*session)->look();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_FALSE(fine);
  EXPECT_EQ(fine.error().message, "session: camera film: has been pulled out");
}

}  // namespace
}  // namespace palpate::server::session
