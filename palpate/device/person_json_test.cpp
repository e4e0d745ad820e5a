#include "palpate/device/person_json.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

TEST(PersonJson, EveryRequestComesBack) {
  for (const auto gesture :
       {Gesture::rest, Gesture::next_pose, Gesture::swing_stylus, Gesture::wander, Gesture::swing_pointer,
        Gesture::touch, Gesture::look_around_board, Gesture::look, Gesture::hold}) {
    Request request{gesture, "", 0};
    if (gesture == Gesture::touch) request = {gesture, "wall", 3};
    if (gesture == Gesture::hold) request.index = 4;
    if (gesture == Gesture::next_pose)
      request.target = PoseTarget{{Vector3(0.1, -0.2, 0.3)}, so3_exp(Vector3(0.1, 0.2, 0.3)), {}};
    const auto back = request_of(Json::parse(json_of(request).dump()));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->gesture, gesture);
    EXPECT_EQ(back->what, request.what);
    EXPECT_EQ(back->index, request.index);
    ASSERT_EQ(back->target.has_value(), request.target.has_value());
    if (!request.target) continue;
    EXPECT_EQ(back->target->tip.m, request.target->tip.m);
    EXPECT_LT(back->target->R_world_marker.angularDistance(request.target->R_world_marker), 1e-12);
  }
}

TEST(PersonJson, WhatIsNoRequestIsRefusedInWords) {
  for (const char* text :
       {"3", "[]", "{}", R"({"gesture": 1})", R"({"gesture": "dance"})", R"({"gesture": "touch"})",
        R"({"gesture": "touch", "what": "table", "index": -1})",
        R"({"gesture": "touch", "what": "table", "index": 1e9})", R"({"gesture": "hold", "index": -1})",
        R"({"gesture": "hold", "index": "left"})", R"({"gesture": "swing_stylus", "what": "table"})",
        R"({"gesture": "next_pose", "tip_m": [1, 2]})", R"({"gesture": "next_pose", "tip_m": [1, 2, 3]})",
        R"({"gesture": "next_pose", "tip_m": [1, 2, 3], "marker_rotation_qwxyz": [0, 0, 0, 0]})"}) {
    const auto read = request_of(Json::parse(text));
    ASSERT_FALSE(read) << text;
    EXPECT_FALSE(read.error().message.empty());
  }
}

}  // namespace
}  // namespace palpate::device
