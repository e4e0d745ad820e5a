// The person's hand at the stylus: what stands behind it is not drawn over it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
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

// Where the hand makes the picture another one, and it is of its colour: its shadow is not.
bool is_hand(const std::uint8_t* with, const std::uint8_t* without) {
  const int changed =
      std::abs(with[0] - without[0]) + std::abs(with[1] - without[1]) + std::abs(with[2] - without[2]);
  return changed > 12 && with[0] > with[2] + 25 && with[0] > with[1] + 10;
}

struct HandCount {
  int hand = 0;        // pixels
  int drawn_over = 0;  // of them
  int cut_out = 0;     // others at which the virtual thing is missing
};

// A block on whose top the tip rests: it stands behind the hand, and below it.
class BlockAndHand {
 public:
  HandCount count(const sim::TrueView& view, HoldingHand known) {
    scene::DrawItem item = item_at(block_, sim::true_tip(view), kGreen);
    const device::CameraImage image = image_of(view);
    sim::TrueView bare = view;
    bare.hand = {};
    const device::CameraImage nobody = image_of(bare);
    const auto with_hand = drawn(view, image, item, known),
               without = drawn(view, image, item, HoldingHand::none);
    HandCount count;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
      const auto differs = [&](const std::vector<std::uint8_t>& rgb) {
        return !std::equal(&rgb[i], &rgb[i] + 3, &image.rgb[i]);
      };
      if (is_hand(&image.rgb[i], &nobody.rgb[i])) {
        ++count.hand;
        count.drawn_over += differs(with_hand);
      } else if (differs(without) && !differs(with_hand)) {
        ++count.cut_out;
      }
    }
    return count;
  }

 private:
  device::CameraImage image_of(const sim::TrueView& view) {
    device::CameraImage image{};
    image.width = view.lens.width, image.height = view.lens.height;
    camera_.render(view, image.rgb);
    return image;
  }
  std::vector<std::uint8_t> drawn(const sim::TrueView& view, const device::CameraImage& image,
                                  const scene::DrawItem& item, HoldingHand known) {
    std::vector<std::uint8_t> rgb;
    compositor_.draw(image, view.lens, view.X_world_camera, {&item, 1}, known_of(view, known), rgb);
    return rgb;
  }
  scene::TriangleMesh block_ = scene::box_mesh({-0.15, -0.10, -0.15}, {0.15, 0.0, 0.15});
  sim::CameraRenderer camera_;
  render::Compositor compositor_{render::CompositorSettings{.samples = 1, .shadows = false}};
};

const Vector3 kTouched{0.08, -1.42, 1.62};

// Of hands of these turns about the handle: the largest share that is drawn over, and that is cut out beside it.
std::pair<double, double> worst_of_hands(const std::vector<double>& rolls) {
  BlockAndHand block;
  double drawn_over = 0.0, cut_out = 0.0;
  for (const HoldingHand side : {HoldingHand::right, HoldingHand::left})
    for (const double size : {0.93, 1.0, 1.07})
      for (const double along : {-0.006, 0.0, 0.006})
        for (const double roll : rolls) {
          const HandCount count =
              block.count(view_of_hand({side, size, along, roll}, kTouched, 0.9, 0.0), side);
          EXPECT_GT(count.hand, 1500);
          drawn_over = std::max(drawn_over, static_cast<double>(count.drawn_over) / count.hand);
          cut_out = std::max(cut_out, static_cast<double>(count.cut_out) / count.hand);
        }
  return {drawn_over, cut_out};
}

TEST(Hand, IsDrawnOverInATenthOfItsPixelsAtMost) {
  // Turned by so much, the elbow is 2 cm beside.
  const auto [drawn_over, cut_out] = worst_of_hands({-0.05, 0.0, 0.05});
  RecordProperty("drawn_over_per_mille", static_cast<int>(1000.0 * drawn_over));
  RecordProperty("cut_out_per_mille", static_cast<int>(1000.0 * cut_out));
  EXPECT_LE(drawn_over, 0.10);
  EXPECT_LE(cut_out, 0.60) << "a halo round the hand";
}

// Where the elbow is nobody measures: 7 cm beside, a part of the forearm is drawn over.
TEST(Hand, WhoseElbowIsElsewhereIsHiddenForTheMostPart) {
  const auto [drawn_over, cut_out] = worst_of_hands({-0.2, 0.2});
  RecordProperty("elbow_aside_per_mille", static_cast<int>(1000.0 * drawn_over));
  EXPECT_LE(drawn_over, 0.35);
  EXPECT_GT(drawn_over, 0.0);
}

TEST(Hand, IsFollowedWhereverTheStylusIsTurned) {
  BlockAndHand block;
  for (const double lean : {0.7, 0.9, 1.2})
    for (const double turn : {-0.4, 0.0, 0.4})
      for (const Vector3& aside : {Vector3(0.0, 0.0, 0.0), Vector3(-0.06, 0.03, -0.05)}) {
        const HandCount count =
            block.count(view_of_hand({HoldingHand::right}, kTouched + aside, lean, turn), HoldingHand::right);
        ASSERT_GT(count.hand, 1000) << lean << ' ' << turn;
        EXPECT_LE(count.drawn_over, 0.10 * count.hand) << lean << ' ' << turn << ' ' << aside.transpose();
      }
}

TEST(Hand, IsDrawnOverWhereItIsNotKnown) {
  BlockAndHand block;
  const HandCount count =
      block.count(view_of_hand({HoldingHand::right}, kTouched, 0.9, 0.0), HoldingHand::none);
  EXPECT_GT(count.drawn_over, 0.4 * count.hand);
  EXPECT_EQ(count.cut_out, 0);
}

TEST(Hand, IsNotThereWhereNobodyHoldsTheStylus) {
  BlockAndHand block;
  const sim::TrueView view = view_of_hand({}, kTouched, 0.9, 0.0);
  EXPECT_EQ(block.count(view, HoldingHand::none).hand, 0);
}

}  // namespace
}  // namespace palpate
