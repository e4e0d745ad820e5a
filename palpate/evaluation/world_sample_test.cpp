#include "palpate/evaluation/world_sample.h"

#include <gtest/gtest.h>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/core/units.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation {
namespace {

using sim::Simulator;
using sim::config::reference_world;

// The world's clock, looked over the shoulder at every millisecond.
class WatchedClock : public Clock<PhysicsClock> {
 public:
  WatchedClock(Simulator& world, std::function<void()> look) : world_(world), look_(std::move(look)) {}
  Instant<PhysicsClock> now() const override { return world_.physics_clock().now(); }
  void sleep_until(Instant<PhysicsClock> t) override {
    world_.physics_clock().sleep_until(t);
    look_();
  }

 private:
  Simulator& world_;
  std::function<void()> look_;
};

TEST(RecordPivot, HeldTipIsDraggedAMillimetreOrTwoInADirectionThatTurnsWithTheMarker) {
  Simulator world(reference_world(), 3);
  bool holding = false;
  double held_at = 0.0;
  Vector3 held;
  std::vector<Vector3> in_world, in_marker;
  WatchedClock clock(world, [&] {
    // From the swing's full pull until the arm lets go.
    if (!holding || world.now().seconds() < held_at + 1.5 || world.now().seconds() > held_at + 20.5) return;
    const auto state = world.true_state();
    const Vector3 drag = state.X_world_tip.translation - held;
    in_world.push_back(drag);
    in_marker.push_back(state.X_world_tip_marker.rotation.conjugate() * drag);
  });
  calibration::session::PivotRecordingOptions options;
  options.holding = [&] {
    holding = true;
    held_at = world.now().seconds();
    held = world.true_state().X_world_tip.translation;
  };
  const auto poses = calibration::session::record_pivot({.clock = clock,
                                                         .arm = world.arm(),
                                                         .tracker = world.tracker(),
                                                         .camera = nullptr,
                                                         .person = world.person(),
                                                         .computed_arm = true},
                                                        options);
  ASSERT_TRUE(poses) << poses.error().message;
  EXPECT_EQ(poses->size(), 400u);
  double size = 0.0;
  Vector3 mean_world = Vector3::Zero(), mean_marker = Vector3::Zero();
  const double n = static_cast<double>(in_world.size());
  for (std::size_t i = 0; i < in_world.size(); ++i) {
    size += in_world[i].norm() / n;
    mean_world += in_world[i] / n;
    mean_marker += in_marker[i] / n;
    EXPECT_LT(in_world[i].norm(), 3e-3);
  }
  // 0.5 to 1.5 N against 800 N/m.
  EXPECT_GT(size, 0.6e-3);
  EXPECT_LT(size, 2.0e-3);
  EXPECT_GT(mean_marker.norm(), 0.7 * size);  // so a pivot fit takes it for part of the tip offset
  EXPECT_GT(mean_marker.norm(), 1.05 * mean_world.norm());  // it turns with the marker, not with the room
  // The marker swings widely, else the tip could not be told from the pivot at all.
  double widest = 0.0;
  for (const auto& pose : *poses)
    widest = std::max(widest, angle_between(pose.marker.rotation, poses->front().marker.rotation));
  EXPECT_GT(widest, radians_from_degrees(60));
}

TEST(RecordPivot, IsRefusedWhereTheMarkerIsNeverSeen) {
  auto file = reference_world();
  file.tracker.max_led_angle = 0.0;
  Simulator world(file, 1);
  const auto poses = calibration::session::record_pivot(laboratory_of(world), {});
  ASSERT_FALSE(poses);
  EXPECT_EQ(poses.error().kind, Error::Kind::refused);
  EXPECT_NE(poses.error().message.find("turn it towards the tracker"), std::string::npos);
}

TEST(RecordPivot, IsRefusedWhereTheArmCannotHold) {
  auto file = reference_world();
  file.arm.max_force = 0.3;  // less than the hand pulls
  Simulator world(file, 1);
  const auto poses = calibration::session::record_pivot(laboratory_of(world), {});
  ASSERT_FALSE(poses);
  EXPECT_NE(poses.error().message.find("pull less"), std::string::npos) << poses.error().message;
}

TEST(RecordArm, PosesAreStillSeenAndSpreadOverTheReach) {
  Simulator world(reference_world(), 2);
  const auto poses = calibration::session::record_arm(laboratory_of(world), 60);
  ASSERT_TRUE(poses) << poses.error().message;
  ASSERT_EQ(poses->size(), 60u);
  const auto& truth = world.truth();
  Vector3 lowest = Vector3::Constant(10), highest = Vector3::Constant(-10);
  for (const auto& pose : *poses) {
    const auto tip = truth.X_world_base * device::phantom_tip(truth.joints.apply(pose.joints), truth.lengths);
    const Vector3 seen = pose.marker.rotation * truth.tip_in_marker + pose.marker.translation;
    EXPECT_LT((seen - tip.m).norm(), 1.2e-3);  // noise and bias of the marker carried to the tip, 0.2 mm rms
    lowest = lowest.cwiseMin(pose.joints);
    highest = highest.cwiseMax(pose.joints);
  }
  for (int i = 0; i < 3; ++i) {
    const auto& [low, high] = reference_world().arm.joint_range[static_cast<std::size_t>(i)];
    EXPECT_GT(highest[i] - lowest[i], 0.8 * (high - low));
  }
}

TEST(RecordArm, IsRefusedWhereAllLedsAreHidden) {
  auto file = reference_world();
  file.tracker.dropout = 1.0;
  Simulator world(file, 1);
  const auto poses = calibration::session::record_arm(laboratory_of(world), 10);
  ASSERT_FALSE(poses);
  EXPECT_EQ(poses.error().exit_code(), 1);
  EXPECT_NE(poses.error().message.find("0 times where 10"), std::string::npos) << poses.error().message;
}

TEST(RecordMoving, TrackerStampsRunBehindTheArmByTheTrackersLatency) {
  auto file = reference_world();
  file.tracker.bias_rms = 0.0;
  Simulator world(file, 2);
  const auto record = calibration::session::record_moving(laboratory_of(world), 5.0);
  ASSERT_TRUE(record) << record.error().message;
  const auto& truth = world.truth();
  const auto rms_with_delay = [&](double delay) {
    double sum = 0.0;
    int n = 0;
    std::size_t k = 0;
    for (const auto& pose : record->marker) {
      const double t = pose.time_s - delay;
      while (k + 1 < record->arm.size() && record->arm[k + 1].time_s < t) ++k;
      if (record->arm[k].time_s > t) continue;
      const auto& a = record->arm[k];
      const auto& b = record->arm[k + 1];
      const Vector3 psi = a.joints + (t - a.time_s) / (b.time_s - a.time_s) * (b.joints - a.joints);
      const auto tip = truth.X_world_base * device::phantom_tip(truth.joints.apply(psi), truth.lengths);
      sum += (pose.marker.rotation * truth.tip_in_marker + pose.marker.translation - tip.m).squaredNorm();
      ++n;
    }
    return std::sqrt(sum / n);
  };
  const double right = rms_with_delay(file.tracker.latency_s);
  EXPECT_LT(right, 0.4e-3);
  EXPECT_GT(rms_with_delay(0.0), 2.0 * right);
  EXPECT_GT(rms_with_delay(2.0 * file.tracker.latency_s), 2.0 * right);
}

TEST(RecordHandEye, CameraFromMarkerAndCameraFromBoardAgreeThroughTheTrueMounting) {
  auto file = reference_world();
  file.tracker.white_rms = file.tracker.bias_rms = file.tracker.latency_s = file.camera.latency_s = 0.0;
  Simulator world(file, 2);
  const auto record = calibration::session::record_hand_eye(laboratory_of(world), 5.0, see_board_in(world));
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_GT(record->eye.size(), 80u);
  const auto& truth = world.truth();
  std::size_t k = 0;
  double sum = 0.0, widest = 0.0;
  int n = 0;
  for (const auto& eye : record->eye) {
    while (k + 1 < record->hand.size() && record->hand[k + 1].time_s < eye.time_s) ++k;
    if (k + 1 == record->hand.size() || record->hand[k].time_s > eye.time_s) continue;
    const auto& a = record->hand[k];
    const auto& b = record->hand[k + 1];
    if (b.time_s - a.time_s > 0.0101) continue;
    const auto hand = interpolate(a.pose, b.pose, (eye.time_s - a.time_s) / (b.time_s - a.time_s));
    const auto by_hand = hand * truth.X_marker_camera, by_eye = truth.X_world_board * eye.pose;
    sum += (by_hand.translation - by_eye.translation).squaredNorm();
    ++n;
    widest = std::max(widest, angle_between(hand.rotation, record->hand.front().pose.rotation));
  }
  // 0.1 px of corner noise tilts the board by about 2 mrad, half a metre away.
  EXPECT_LT(std::sqrt(sum / n), 1.5e-3);
  EXPECT_GT(widest, radians_from_degrees(30));
}

TEST(RecordTouches, TipsLieOnTheCornersWithinTheTouchAndTheTracker) {
  Simulator world(reference_world(), 2);
  for (const std::string surface : {"table", "wall"}) {
    const auto touches = calibration::session::record_touches(
        laboratory_of(world), calibration::session::corner_requests(surface), world.truth().pointer_tip);
    ASSERT_TRUE(touches) << touches.error().message;
    const auto& corners = surface == "table" ? world.truth().table : world.truth().wall;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT(((*touches)[i].place - corners[i]).norm(), 2.5e-3);
      EXPECT_GT(((*touches)[i].place - corners[i]).norm(), 1e-6);
    }
  }
  EXPECT_FALSE(calibration::session::record_touches(laboratory_of(world),
                                                    {{device::Gesture::touch, "chair", 0}}, Vector3::Zero()));
}

TEST(RecordTouches, LandmarksAreAllWithinTheTrackersView) {
  Simulator world(reference_world(), 2);
  std::vector<device::Request> dots;
  for (int i = 0; i < 12; ++i) dots.push_back({device::Gesture::touch, "landmark", i});
  const auto touches =
      calibration::session::record_touches(laboratory_of(world), dots, world.truth().pointer_tip);
  EXPECT_TRUE(touches) << touches.error().message;
}

TEST(RecordPointerPivot, PointerSwingsAboutADivot) {
  Simulator world(reference_world(), 2);
  const auto poses = calibration::session::record_pointer_pivot(laboratory_of(world), 300, 10.0);
  ASSERT_TRUE(poses) << poses.error().message;
  Vector3 mean = Vector3::Zero();
  for (const auto& pose : *poses)
    mean += (pose.marker.rotation * world.truth().pointer_tip + pose.marker.translation) / 300.0;
  double worst = 0.0;
  for (const auto& pose : *poses)
    worst = std::max(
        worst, (pose.marker.rotation * world.truth().pointer_tip + pose.marker.translation - mean).norm());
  EXPECT_LT(worst, 3e-3);  // four LEDs, 160 mm from the tip: 0.6 mm rms
}

TEST(SampleWorld, WritesTheSameFilesForTheSameSeed) {
  const ScratchFolder folder;
  for (const auto kind : {SampleKind::arm, SampleKind::camera, SampleKind::pointer, SampleKind::surface,
                          SampleKind::landmarks}) {
    SampleRequest request;
    request.kind = kind;
    request.seed = 5;
    request.points = 8;
    const auto a = sample_world(reference_world(), request, folder / "a");
    const auto b = sample_world(reference_world(), request, folder / "b");
    request.seed = 6;
    const auto c = sample_world(reference_world(), request, folder / "c");
    ASSERT_TRUE(a && b && c) << (a ? "" : a.error().message);
    const auto table = read_csv(a->front(), {.text_columns = {"image", "label"}});
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_GE(table->rows.size(), 8u) << a->front();
    EXPECT_EQ(*read_file(a->front()), *read_file(b->front())) << a->front();
    EXPECT_NE(*read_file(a->front()), *read_file(c->front())) << a->front();
    EXPECT_EQ(a->back().filename(), "truth.json");
    EXPECT_EQ(*read_file(a->back()), *read_file(b->back())) << a->front();
  }
}

TEST(SampleWorld, ArmTruthHasTheKeysOfTheCalibration) {
  const ScratchFolder folder;
  SampleRequest request;
  request.points = 3;
  ASSERT_TRUE(sample_world(reference_world(), request, folder.path()));
  const auto truth = Json::parse(*read_file(folder / "truth.json"));
  for (const char* key : {"gains", "offsets_deg", "lengths_mm", "tip_mm"})
    EXPECT_TRUE(truth.contains(key)) << key;
  EXPECT_EQ(truth["base"]["translation_mm"].size(), 3u);
  EXPECT_EQ(truth["base"]["rotation_qwxyz"].size(), 4u);
  EXPECT_EQ(truth["offsets_deg"][0], 0.0);
}

}  // namespace
}  // namespace palpate::evaluation
