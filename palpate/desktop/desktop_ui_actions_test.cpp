// What keys and mouse do, on a screen that is handed its input and keeps what it was given to show.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "applications/pingpong/specification.h"
#include "palpate/desktop/desktop_ui.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/truth_rig.h"
#include "palpate/transport/exchange_rig_test.h"
#include "palpate/transport/local_endpoint.h"
#include "tests/own_run_directory.h"

namespace palpate::desktop {
namespace {

struct Shown {
  Size size;
  int eyes = 0;
  std::uint8_t level = 0;  // of its first byte
};

// What passes between a test and the screen that the user interface owns.
struct Handed {
  Input input;  // for the next poll
  std::vector<Shown> pictures;
  int draws = 0, full_screens = 0;
};

class HandedScreen : public Screen {
 public:
  explicit HandedScreen(Handed& handed) : handed_(handed) {}
  Input poll() override {
    const auto pointer = handed_.input.pointer;
    Input now = std::exchange(handed_.input, {});
    handed_.input.pointer = pointer;
    return now;
  }
  void take_picture(std::span<const std::uint8_t> rgb, Size picture, int eyes) override {
    handed_.pictures.push_back({picture, eyes, rgb.empty() ? std::uint8_t{0} : rgb.front()});
  }
  void draw(const HudContent&, std::optional<Duration>) override { ++handed_.draws; }
  void toggle_full_screen() override { ++handed_.full_screens; }
  Size framebuffer() const override { return {640, 480}; }

 private:
  Handed& handed_;
};

class Actions : public ::testing::Test {
 protected:
  void open(DesktopUiOptions options) {
    auto ui =
        DesktopUi::open_on(std::make_unique<HandedScreen>(handed_), nullptr, applications_, scene_, rig_,
                           world_.file(), {*transport::default_endpoint(), std::nullopt}, options);
    ASSERT_TRUE(ui) << ui.error().message;
    ui_ = std::move(*ui);
  }
  // A millisecond each.
  bool act(int milliseconds = 1) {
    bool goes_on = true;
    for (int i = 0; i < milliseconds && goes_on; ++i) {
      exchange_.wait_a_little();
      link_->poll();
      goes_on = ui_->act(now(), *link_, conditions_, sync_);
    }
    return goes_on;
  }
  bool press(Key key) {
    handed_.input.keys = {key};
    return act();
  }
  // What has come of it at the physics server.
  std::vector<scene::Control> wishes() {
    act(50);
    std::vector<scene::Control> all;
    while (const auto wish = service_->take_control()) all.push_back(*wish);
    return all;
  }
  server::graphics::FrameRecord frame(std::uint8_t level = 100) const {
    server::graphics::FrameRecord frame;
    frame.have_state = true;
    frame.answer = AnswerKind::interpolated;
    frame.pose_source = server::graphics::PoseSource::tracker;
    frame.width = rig_.camera->model.width, frame.height = rig_.camera->model.height;
    frame.rgb.assign(3 * static_cast<std::size_t>(frame.width * frame.height), level);
    return frame;
  }
  Instant<GraphicsClock> now() const { return {exchange_.network.now().since_epoch + seconds(7.0)}; }

  OwnRunDirectory run_directory_;
  sim::Simulator world_{sim::config::reference_world(), 3};
  const rig::Rig rig_ = sim::truth_rig(world_);
  const scene::ApplicationRegistry applications_{applications::pingpong::specification()};
  const scene::SceneDescription scene_ =
      server::physics::scene_from_rig(rig_, *sim::config::scene_of(world_.file(), applications_, "pingpong"));
  transport::testing::InProcessRig exchange_;
  std::unique_ptr<transport::StateService> service_ = std::move(*exchange_.serve());
  std::unique_ptr<transport::StateLink> link_ = exchange_.connect();
  ClockSync<GraphicsClock, PhysicsClock> sync_;
  std::vector<server::graphics::Condition> conditions_;
  Handed handed_;
  std::unique_ptr<DesktopUi> ui_;
};

using scene::Control;

TEST_F(Actions, KeysAreWishesToThePhysicsServer) {
  open({});
  EXPECT_FALSE(ui_->attended());
  EXPECT_TRUE(press(Key::serve));
  EXPECT_TRUE(ui_->attended());
  EXPECT_EQ(wishes(), (std::vector{Control::begin}));
  press(Key::reset);
  EXPECT_EQ(wishes(), (std::vector{Control::reset}));
  press(Key::pause);
  EXPECT_EQ(wishes(), (std::vector{Control::pause}));
  EXPECT_TRUE(ui_->content().paused);
  press(Key::pause);
  EXPECT_EQ(wishes(), (std::vector{Control::resume}));
  EXPECT_FALSE(ui_->content().paused);
  for (const Key key :
       {Key::help, Key::full_screen, Key::view, Key::strokes, Key::program_plays, Key::farther})
    EXPECT_TRUE(press(key));
  EXPECT_TRUE(wishes().empty()) << "those are the window's own";
  EXPECT_EQ(handed_.full_screens, 1);
}

TEST_F(Actions, SeveralKeysAreObeyedInTheirOrderAndNoneAfterQuit) {
  open({});
  handed_.input.keys = {Key::serve, Key::pause, Key::quit, Key::reset};
  EXPECT_FALSE(act());
  link_->poll();
  exchange_.network.advance_to(exchange_.network.now() + std::chrono::milliseconds(20));
  std::vector<Control> all;
  for (int i = 0; i < 50; ++i) {
    exchange_.wait_a_little();
    link_->poll();
    while (const auto wish = service_->take_control()) all.push_back(*wish);
  }
  EXPECT_EQ(all, (std::vector{Control::begin, Control::pause}));
}

TEST_F(Actions, EscapeClosesTheListOfKeysBeforeItQuits) {
  open({.mouse = true});
  press(Key::help);
  ASSERT_TRUE(ui_->content().help);
  EXPECT_TRUE(press(Key::escape));
  EXPECT_FALSE(ui_->content().help);
  EXPECT_FALSE(press(Key::escape));
}

TEST_F(Actions, HelpListsTheKeysThatDoSomethingHere) {
  open({.mouse = true});
  EXPECT_FALSE(ui_->content().help);
  press(Key::help);
  ASSERT_TRUE(ui_->content().help);
  EXPECT_TRUE(ui_->content().help->mouse && ui_->content().help->strokes);
  EXPECT_FALSE(ui_->content().help->program || ui_->content().help->view);
  press(Key::help);
  EXPECT_FALSE(ui_->content().help);
}

TEST_F(Actions, TheMouseTakesTheHandFromTheProgramOnceItHasMovedFarAndAKeyGivesItBack) {
  open({.mouse = true, .scripted_player = true});
  ui_->show(frame(), {}, now());
  EXPECT_FALSE(ui_->person_plays());
  handed_.input.moved = 8.0;  // somebody has touched the table
  act();
  EXPECT_FALSE(ui_->person_plays() || ui_->attended());
  handed_.input.moved = 8.0;
  act();
  EXPECT_TRUE(ui_->person_plays() && ui_->attended());
  EXPECT_FALSE(ui_->take_left());
  press(Key::program_plays);
  EXPECT_FALSE(ui_->person_plays());
  EXPECT_TRUE(ui_->take_left());
  EXPECT_FALSE(ui_->take_left()) << "once";
  handed_.input.moved = 8.0;
  act();
  EXPECT_FALSE(ui_->person_plays()) << "counted anew";
  handed_.input.left = true;
  act();
  EXPECT_TRUE(ui_->person_plays()) << "a button is meant";
}

// What the program has scored is not the person's.
TEST_F(Actions, TheGameBeginsAtZeroWhenAPersonTakesItFromTheProgramForTheFirstTime) {
  open({.mouse = true, .scripted_player = true});
  EXPECT_TRUE(wishes().empty());
  EXPECT_FALSE(ui_->take_own_game());
  handed_.input.moved = 20.0;
  EXPECT_EQ(wishes(), (std::vector{Control::reset}));
  EXPECT_TRUE(ui_->take_own_game());
  EXPECT_FALSE(ui_->take_own_game()) << "once";
  press(Key::program_plays);
  press(Key::program_plays);
  EXPECT_TRUE(ui_->person_plays());
  EXPECT_FALSE(ui_->take_own_game()) << "it is theirs already";
  EXPECT_TRUE(wishes().empty());
  open({.mouse = true});
  handed_.input.moved = 20.0;
  EXPECT_TRUE(wishes().empty()) << "nobody has played before";
  EXPECT_FALSE(ui_->take_own_game());
}

TEST_F(Actions, WhoDoesNotPlayYetReadsHowLongTheProgramGoesOn) {
  open({.mouse = true, .scripted_player = true});
  act();
  ui_->set_end(now() + seconds(10.0));
  act(100);
  EXPECT_EQ(ui_->content().hint, "Waiting for the first picture");
  ui_->show(frame(), {}, now());
  EXPECT_EQ(ui_->content().hint, "The program plays, 10 s more. Move the mouse to take the bat");
  act(4000);
  EXPECT_EQ(ui_->content().hint, "The program plays, 6 s more. Move the mouse to take the bat");
  ui_->set_end(std::nullopt);
  act(100);
  EXPECT_EQ(ui_->content().hint, "The program plays. Move the mouse to take the bat");
  handed_.input.moved = 20.0;
  act(100);
  EXPECT_EQ(ui_->content().hint.find("The program"), std::string::npos) << ui_->content().hint;
}

// On a busy machine the first answer takes a while; a server that is not there is told of all the same.
TEST_F(Actions, ThePhysicsServerIsMissedOnlyOnceItHasHadTimeToAnswer) {
  service_.reset();
  open({});
  act(2900);
  EXPECT_TRUE(ui_->content().warnings.empty());
  act(400);
  EXPECT_EQ(ui_->content().warnings.size(), 1u);
  service_ = std::move(*exchange_.serve());
  act(3000);
  EXPECT_TRUE(ui_->content().warnings.empty());
  service_.reset();
  act(600);
  EXPECT_EQ(ui_->content().warnings.size(), 1u) << "from its first word on it is missed at once";
}

// Whose hand is on a mouse has felt nothing go.
TEST_F(Actions, ThatForcesRestIsToldInOtherWordsToWhoHasNoneInTheHand) {
  transport::LoopStatus loop;
  loop.forces = device::ForceCondition{device::ForceState::safe, device::ForceFault::overspeed};
  exchange_.status.loops = {loop};
  for (const auto& [mouse, words] :
       {std::pair{true, "the force rests"}, std::pair{false, "forces are off"}}) {
    open({.mouse = mouse});
    act(1500);
    ASSERT_EQ(ui_->content().warnings.size(), 1u) << words;
    EXPECT_NE(ui_->content().warnings.front().find(words), std::string::npos)
        << ui_->content().warnings.front();
  }
}

TEST_F(Actions, TheKeyTakesTheHandAsWellAndAWheelToo) {
  open({.mouse = true, .scripted_player = true});
  press(Key::program_plays);
  EXPECT_TRUE(ui_->person_plays());
  press(Key::program_plays);
  handed_.input.wheel = -1.0;
  act();
  EXPECT_TRUE(ui_->person_plays());
}

TEST_F(Actions, WithoutAMouseNobodyTakesTheHandAndWithoutAProgramNobodyGivesIt) {
  open({.scripted_player = true});
  handed_.input.moved = 100.0, handed_.input.left = true;
  act();
  press(Key::program_plays);
  EXPECT_FALSE(ui_->person_plays());
  open({.mouse = true});
  EXPECT_TRUE(ui_->person_plays());
  press(Key::program_plays);
  EXPECT_TRUE(ui_->person_plays());
  EXPECT_FALSE(ui_->take_left());
}

TEST_F(Actions, TheViewTurnsToTheSideAndBackWhereThereIsOne) {
  open({});
  press(Key::view);
  EXPECT_FALSE(ui_->from_outside());
  render::OutsidePicture outside;
  outside.width = 320, outside.height = 200;
  outside.rgb.assign(3 * 320 * 200, 7);
  int asked = 0;
  DesktopUiOptions options;
  options.outside = [&](const server::graphics::FrameRecord&) -> const render::OutsidePicture& {
    ++asked;
    return outside;
  };
  const render::Onlooker onlooker(scene_.surfaces, rig_.camera->model.width, rig_.camera->model.height);
  options.onlooker = &onlooker;
  open(options);
  ui_->show(frame(100), {}, now());
  press(Key::view);
  EXPECT_TRUE(ui_->from_outside());
  ui_->show(frame(101), {}, now());
  press(Key::view);
  EXPECT_FALSE(ui_->from_outside());
  ui_->show(frame(102), {}, now());
  ASSERT_EQ(handed_.pictures.size(), 3u);
  EXPECT_EQ(asked, 1) << "drawn for those who look";
  EXPECT_EQ(handed_.pictures[0].level, 100);
  EXPECT_EQ(handed_.pictures[1].level, 7);
  EXPECT_EQ(handed_.pictures[1].size.width, 320);
  EXPECT_EQ(handed_.pictures[2].level, 102);
}

TEST_F(Actions, OnePictureStandsBeforeBothEyes) {
  open({.biocular = true});
  ui_->show(frame(), {}, now());
  ASSERT_EQ(handed_.pictures.size(), 1u);
  EXPECT_EQ(handed_.pictures[0].size.width, 2 * rig_.camera->model.width);
  EXPECT_EQ(handed_.pictures[0].eyes, 2);
}

TEST_F(Actions, AFrameWithoutPixelsLeavesThePictureAndIsDrawnOver) {
  open({});
  auto empty = frame();
  empty.rgb.clear();
  ui_->show(empty, {"3 : 2"}, now());
  EXPECT_TRUE(handed_.pictures.empty());
  EXPECT_EQ(handed_.draws, 1);
  EXPECT_EQ(ui_->content().score, (std::vector<std::string>{"3 : 2"}));
}

// The window lives on where no images come: twenty times a second.
TEST_F(Actions, WithoutFramesTheWindowIsDrawnAllTheSame) {
  open({});
  act(1000);
  EXPECT_NEAR(handed_.draws, 20, 2);
}

TEST_F(Actions, WhatIsWrongWithADeviceStandsInTheWindowWhileItIs) {
  open({});
  act(1000);
  EXPECT_TRUE(ui_->content().warnings.empty());
  conditions_.emplace_back().words = "camera: nothing to see";
  act(1000);
  EXPECT_EQ(ui_->content().warnings, (std::vector<std::string>{"camera: nothing to see"}));
  conditions_.clear();
  act(2000);
  EXPECT_TRUE(ui_->content().warnings.empty());
  service_.reset();
  act(2000);
  EXPECT_EQ(ui_->content().warnings.size(), 1u) << "the physics server is missed";
  service_ = std::move(*exchange_.serve());
  act(3000);
  EXPECT_TRUE(ui_->content().warnings.empty());
}

TEST_F(Actions, FramesThatAreDrawnLateAreSaid) {
  open({});
  for (const bool late : {false, true}) {
    for (int i = 0; i < 50; ++i) {
      auto one = frame();
      one.late = late;
      one.image_time = now();
      act(30);
      one.drawn = now();
      ui_->show(one, {}, now());
    }
    EXPECT_EQ(ui_->content().warnings.size(), late ? 1u : 0u);
    EXPECT_NEAR(ui_->content().pictures_per_s.value_or(0.0), 1000.0 / 30.0, 1.0);
    EXPECT_NEAR(ui_->content().delay_s.value_or(0.0), 0.030, 1e-6);
  }
}

}  // namespace
}  // namespace palpate::desktop
