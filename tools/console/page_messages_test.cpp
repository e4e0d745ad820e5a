#include "tools/console/page_messages.h"

#include <gtest/gtest.h>

#include "palpate/core/json.h"

namespace palpate::tools::console {
namespace {

scene::SceneState state_at(std::int64_t ns, const Vector3& force) {
  scene::SceneState state;
  state.time = Instant<PhysicsClock>{Duration(ns)};
  state.tick = 1;
  state.continuous.force = {force.x(), force.y(), force.z()};
  return state;
}

TEST(PageMessages, StatesHoldEveryForceAndTheNewestBodies) {
  auto older = state_at(9'007'199'254'000'001, {1, 2, 2}),
       newest = state_at(9'007'199'258'000'001, {0, 0, 0.5});
  newest.body_count = 1;
  newest.bodies[0].set_p({0.1, 0.2, 0.3});
  newest.continuous.touching = 1;
  newest.continuous.point = {0.4, 0.5, 0.6};
  newest.impact.force = {0, 0, 0.25};
  const Json json = Json::parse(states_message({older, newest}));
  EXPECT_EQ(json["op"], "states");
  EXPECT_EQ(json["t_ns"], "9007199258000001");  // beyond a browser's whole numbers
  EXPECT_EQ(json["dt_ms"], Json::array({-4.0, 0.0}));
  EXPECT_EQ(json["force"], Json::parse("[[1.0,2.0,2.0],[0.0,0.0,0.75]]"));
  EXPECT_EQ(json["bodies"], Json::parse("[[0.1,0.2,0.3,1.0,0.0,0.0,0.0,true]]"));
  EXPECT_EQ(json["touch"], Json::parse("[0.4,0.5,0.6]"));
  EXPECT_TRUE(Json::parse(states_message({older}))["touch"].is_null());
}

TEST(PageMessages, SceneAndStatusCarryNamesOfOthersAsData) {
  scene::SceneDescription scene;
  scene.application = "<script>alert(1)</script>";
  scene.surfaces.push_back(
      {"table", {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)}});
  scene.bodies.push_back({"ball", 0.0027});
  const Json shown = Json::parse(scene_message(scene));
  EXPECT_EQ(shown["application"], scene.application);
  EXPECT_EQ(shown["surfaces"][0]["corners"][2], Json::parse("[1.0,1.0,0.0]"));
  EXPECT_EQ(shown["bodies"], Json::array({"ball"}));

  SystemView view{true, {}, transport::ServerStatus{}};
  view.status->clients.resize(1);
  view.status->clients[0].name = "\"><img src=x onerror=alert(1)>\xff";
  const std::vector<Event> news{{3, 12.5, Level::warning, "forces off"}};
  const Json status = Json::parse(status_message(view, news, {.viewers = 2, .controls = true}));
  EXPECT_EQ(status["lights"].size(), 7u);
  EXPECT_EQ(status["events"][0]["level"], "warning");
  EXPECT_EQ(status["console"]["viewers"], 2);
  EXPECT_EQ(status["console"]["controls"], true);
  EXPECT_EQ(status["status"]["clients"].size(), 1u);
  EXPECT_TRUE(Json::parse(status_message({}, {}, {}))["status"].is_null());
}

TEST(PageMessages, ReadsWhatAPageSaysAndNothingElse) {
  using Kind = PageSaying::Kind;
  const auto seen = read_page_message(R"({"op":"seen","t_ns":"9007199258000001"})");
  EXPECT_EQ(seen.kind, Kind::seen);
  EXPECT_EQ(seen.seen_ns, 9'007'199'258'000'001);
  const auto control = read_page_message(R"({"op":"control","control":"reset","token":"abc","more":[1]})");
  EXPECT_EQ(control.kind, Kind::control);
  EXPECT_EQ(control.control, "reset");
  EXPECT_EQ(control.token, "abc");
  EXPECT_EQ(read_page_message(R"({"op":"control","control":7,"token":null})").control, "");
  for (const std::string& none :
       {std::string(), std::string("7"), std::string("[\"op\"]"), std::string("{"),
        std::string(R"({"op":"seen"})"), std::string(R"({"op":"seen","t_ns":12})"),
        std::string(R"({"op":"seen","t_ns":"12x"})"), std::string(R"({"op":"seen","t_ns":"-1"})"),
        std::string(R"({"op":"seen","t_ns":"99999999999999999999"})"),
        std::string(30'000, '[') + std::string(30'000, ']')})
    EXPECT_EQ(read_page_message(none).kind, Kind::other) << none.substr(0, 50);
}

TEST(PageMessages, APictureHasItsHeadBeforeIt) {
  transport::ShownPicture picture;
  picture.number = 12;
  picture.expected_overlay_px = 0.25;
  picture.landmarks = {{10.04, 20.0, true}};
  const std::string bytes = picture_message(picture, "jpeg");
  const auto size = static_cast<std::size_t>(static_cast<unsigned char>(bytes[0])) +
                    256 * static_cast<unsigned char>(bytes[1]);
  const Json head = Json::parse(bytes.substr(4, size));
  EXPECT_EQ(head["number"], 12);
  EXPECT_EQ(head["expected_overlay_px"], 0.25);
  EXPECT_EQ(head["landmarks"].dump(), "[[10.0,20.0,true]]");
  EXPECT_EQ(bytes.substr(4 + size), "jpeg");
}

}  // namespace
}  // namespace palpate::tools::console
