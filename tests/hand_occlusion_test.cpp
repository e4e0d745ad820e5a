// The person's hand at the stylus: what stands behind it is not drawn over it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/sim/camera_renderer.h"
#include "tests/picture_scene_for_tests.h"

namespace palpate {
namespace {

using device::HoldingHand;

// A stylus that leans towards the person, its tip at `tip`, and a hand that holds it, as the camera sees them.
sim::TrueView view_of_hand(const sim::TrueHand& hand, const Vector3& tip, double lean, double turn) {
  const render::RealScene real = real_scene(true);
  sim::TrueView view;
  view.lens = kTestCamera;
  view.X_world_camera = kTestEye;
  view.table = real.surfaces[0].corners;
  view.wall = real.surfaces[1].corners;
  view.X_world_base = real.arm->X_world_base;
  view.lengths = real.arm->lengths;
  const auto X_base_world = view.X_world_base.inverse();
  EXPECT_TRUE(device::phantom_inverse(X_base_world * Point<World>{tip}, view.lengths, view.theta));
  const Quaternion R_world_tip = Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitY())) *
                                 Quaternion(Eigen::AngleAxisd(-lean, Vector3::UnitX()));
  view.gimbal = device::phantom_gimbal(view.theta, X_base_world.rotation * R_world_tip);
  view.hand = hand;
  return view;
}

render::RealScene known_of(const sim::TrueView& view, HoldingHand hand) {
  render::RealScene real = real_scene(true);
  real.arm->theta = view.theta;
  real.arm->gimbal = view.gimbal;
  real.hand = hand;
  return real;
}

// Nothing else in the room is of its colour.
bool is_skin(const std::uint8_t* p) { return p[0] > p[2] + 25 && p[0] > p[1] + 10; }

struct HandCount {
  int hand = 0;        // pixels
  int drawn_over = 0;  // of them
  int cut_out = 0;     // others at which the virtual thing is missing
};

// A block on whose top the tip rests: it stands behind the hand, and below it.
HandCount hand_before_block(const sim::TrueView& view, HoldingHand known) {
  const scene::TriangleMesh block = scene::box_mesh({-0.15, -0.10, -0.15}, {0.15, 0.0, 0.15});
  const scene::DrawItem item = item_at(block, sim::true_tip(view), kGreen);
  device::CameraImage image{};
  image.width = view.lens.width, image.height = view.lens.height;
  sim::CameraRenderer().render(view, image.rgb);
  render::Compositor compositor(render::CompositorSettings{.samples = 1, .shadows = false});
  std::vector<std::uint8_t> with_hand, without;
  compositor.draw(image, view.lens, view.X_world_camera, {&item, 1}, known_of(view, known), with_hand);
  compositor.draw(image, view.lens, view.X_world_camera, {&item, 1}, known_of(view, HoldingHand::none),
                  without);
  HandCount count;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const auto drawn = [&](const std::vector<std::uint8_t>& rgb) {
      return !std::equal(&rgb[i], &rgb[i] + 3, &image.rgb[i]);
    };
    if (is_skin(&image.rgb[i])) {
      ++count.hand;
      count.drawn_over += drawn(with_hand);
    } else if (drawn(without) && !drawn(with_hand)) {
      ++count.cut_out;
    }
  }
  return count;
}

const Vector3 kTouched{0.08, -1.42, 1.62};

TEST(Hand, IsDrawnOverInATenthOfItsPixelsAtMost) {
  double worst = 0.0, most_cut_out = 0.0;
  int hands = 0;
  for (const HoldingHand side : {HoldingHand::right, HoldingHand::left})
    for (const double size : {0.93, 1.0, 1.07})
      for (const double along : {-0.006, 0.0, 0.006})
        for (const double roll : {-0.2, 0.0, 0.2}) {
          const sim::TrueHand hand{side, size, along, roll};
          const HandCount count = hand_before_block(view_of_hand(hand, kTouched, 0.9, 0.0), side);
          ASSERT_GT(count.hand, 1500);
          worst = std::max(worst, static_cast<double>(count.drawn_over) / count.hand);
          most_cut_out = std::max(most_cut_out, static_cast<double>(count.cut_out) / count.hand);
          ++hands;
        }
  RecordProperty("drawn_over_per_mille", static_cast<int>(1000.0 * worst));
  RecordProperty("cut_out_per_mille", static_cast<int>(1000.0 * most_cut_out));
  EXPECT_EQ(hands, 54);
  EXPECT_LE(worst, 0.10);
  EXPECT_LE(most_cut_out, 0.45) << "a halo round the hand";
}

TEST(Hand, IsFollowedWhereverTheStylusIsTurned) {
  for (const double lean : {0.6, 0.9, 1.2})
    for (const double turn : {-0.5, 0.0, 0.5})
      for (const Vector3& aside : {Vector3(0.0, 0.0, 0.0), Vector3(-0.06, 0.03, -0.05)}) {
        const HandCount count = hand_before_block(
            view_of_hand({HoldingHand::right}, kTouched + aside, lean, turn), HoldingHand::right);
        ASSERT_GT(count.hand, 1000) << lean << ' ' << turn;
        EXPECT_LE(count.drawn_over, 0.10 * count.hand) << lean << ' ' << turn << ' ' << aside.transpose();
      }
}

TEST(Hand, IsDrawnOverWhereItIsNotKnown) {
  const HandCount count =
      hand_before_block(view_of_hand({HoldingHand::right}, kTouched, 0.9, 0.0), HoldingHand::none);
  EXPECT_GT(count.drawn_over, 0.4 * count.hand);
  EXPECT_EQ(count.cut_out, 0);
}

TEST(Hand, IsNotThereWhereNobodyHoldsTheStylus) {
  const sim::TrueView view = view_of_hand({}, kTouched, 0.9, 0.0);
  EXPECT_EQ(hand_before_block(view, HoldingHand::none).hand, 0);
}

}  // namespace
}  // namespace palpate
