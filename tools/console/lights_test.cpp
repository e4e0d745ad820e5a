#include "tools/console/lights.h"

#include <gtest/gtest.h>

#include <map>

namespace palpate::tools::console {
namespace {

using device::ForceCondition;
using device::ForceFault;
using device::ForceState;
using device::HealthCode;

transport::LoopStatus force_loop(ForceState state, ForceFault fault = ForceFault::none) {
  transport::LoopStatus loop;
  loop.name = "haptic";
  loop.rate_hz = 1000.0;
  loop.forces = ForceCondition{state, fault};
  return loop;
}

transport::ClientStatus graphics(double clock_us = 20.0,
                                 std::vector<transport::ClientCondition> conditions = {}) {
  transport::ClientStatus client;
  client.name = "screen";
  client.role = transport::Role::graphics;
  client.figures.frames = 100;
  client.figures.clock_uncertainty_us = clock_us;
  client.figures.conditions = std::move(conditions);
  return client;
}

SystemView running() {
  SystemView view{true, {}, transport::ServerStatus{}};
  view.status->application = "pingpong";
  view.status->loops = {force_loop(ForceState::running)};
  view.status->clients = {graphics()};
  return view;
}

std::map<std::string, Light> lights(const SystemView& view) {
  std::map<std::string, Light> by_name;
  for (const auto& light : lights_of(view)) by_name[light.name] = light;
  return by_name;
}

TEST(Lights, AreAlwaysAllInTheirOrder) {
  const std::vector<std::string> names{"servers", "arm",    "forces",   "tracker",
                                       "camera",  "clocks", "recording"};
  for (const auto& view : {SystemView{}, SystemView{true, {}, {}}, running()}) {
    std::vector<std::string> got;
    for (const auto& light : lights_of(view)) got.push_back(light.name);
    EXPECT_EQ(got, names);
  }
}

TEST(Lights, AreGoodWhereAllIsWell) {
  const auto got = lights(running());
  for (const char* name : {"servers", "arm", "forces", "tracker", "camera", "clocks"})
    EXPECT_EQ(got.at(name).level, Level::good) << name << ": " << got.at(name).words;
  EXPECT_EQ(got.at("recording").level, Level::off);
  EXPECT_EQ(got.at("clocks").words, "known to 20 us");
}

TEST(Lights, KnowNothingWithoutAServer) {
  const auto got = lights({false, "the key is not admitted", {}});
  EXPECT_EQ(got.at("servers").level, Level::fault);
  EXPECT_NE(got.at("servers").words.find("the key is not admitted"), std::string::npos);
  EXPECT_EQ(got.at("forces").level, Level::off);
}

TEST(Lights, TellTheArmFromItsForces) {
  auto view = running();
  view.status->loops = {force_loop(ForceState::safe, ForceFault::overspeed)};
  EXPECT_EQ(lights(view).at("forces").level, Level::fault);
  EXPECT_EQ(lights(view).at("arm").level, Level::good);
  view.status->loops = {force_loop(ForceState::safe, ForceFault::arm_lost)};
  EXPECT_EQ(lights(view).at("arm").level, Level::fault);
  view.status->loops = {force_loop(ForceState::ready, ForceFault::outside_workspace)};
  EXPECT_EQ(lights(view).at("arm").level, Level::notice);
}

TEST(Lights, SayThatTheApplicationHasFailed) {
  auto view = running();
  view.status->loops = {force_loop(ForceState::degraded, ForceFault::stale_input)};
  view.status->failure = "the application 'tether' threw: it broke";
  EXPECT_EQ(lights(view).at("forces").level, Level::fault);
  EXPECT_EQ(lights(view).at("forces").words, "off: the application 'tether' threw: it broke");
}

// Whatever can be wrong with a device shows in one light, as bad as it is.
TEST(Lights, EachConditionShowsInOne) {
  const std::map<HealthCode, std::string> expected{{HealthCode::camera_silent, "camera"},
                                                   {HealthCode::camera_unfit, "camera"},
                                                   {HealthCode::camera_lost, "camera"},
                                                   {HealthCode::recording_ended, "camera"},
                                                   {HealthCode::image_size, "camera"},
                                                   {HealthCode::camera_clock, "clocks"},
                                                   {HealthCode::tracker_silent, "tracker"},
                                                   {HealthCode::tracker_clock, "clocks"},
                                                   {HealthCode::tracker_blind, "tracker"},
                                                   {HealthCode::landmarks_lost, "camera"},
                                                   {HealthCode::right_eye_lost, "camera"},
                                                   {HealthCode::board_lost, "camera"},
                                                   {HealthCode::arm_lost, "arm"},
                                                   {HealthCode::arm_inconsistent, "arm"},
                                                   {HealthCode::arm_uncalibrated, "arm"},
                                                   {HealthCode::arm_forces_off, "arm"},
                                                   {HealthCode::laboratory_silent, "servers"},
                                                   {HealthCode::physics_server_gone, "servers"},
                                                   {HealthCode::other_scene, "servers"},
                                                   {HealthCode::other_rig, "servers"}};
  ASSERT_EQ(expected.size(), device::kHealthCodes);
  const auto before = lights(running());
  for (const auto& [code, name] : expected) {
    auto view = running();
    view.status->clients = {graphics(20.0, {{code, 1.0, "it says so"}})};
    for (const auto& light : lights_of(view)) {
      if (light.name != name) {
        EXPECT_EQ(light.level, before.at(light.name).level) << device::name_of(code) << ", " << light.name;
        continue;
      }
      EXPECT_EQ(light.level, level_of(device::severity_of(code))) << device::name_of(code);
      EXPECT_EQ(light.words, "it says so");
    }
  }
}

TEST(Lights, ClocksAreAsBadAsTheWorst) {
  auto view = running();
  view.status->clients = {graphics(20.0), graphics(5000.0), graphics(30.0)};
  EXPECT_EQ(lights(view).at("clocks").level, Level::warning);
  EXPECT_EQ(lights(view).at("clocks").words, "known to 5000 us");
  view.status->clients.clear();
  EXPECT_EQ(lights(view).at("clocks").level, Level::off);
}

TEST(Lights, ARecordingThatLosesIsNoGoodOne) {
  auto view = running();
  view.status->recording = {.seconds = 12.0, .dropped = 0, .ended = false};
  EXPECT_EQ(lights(view).at("recording").level, Level::good);
  view.status->recording->dropped = 3;
  EXPECT_EQ(lights(view).at("recording").level, Level::warning);
  view.status->recording->ended = true;
  EXPECT_EQ(lights(view).at("recording").level, Level::fault);
}

}  // namespace
}  // namespace palpate::tools::console
