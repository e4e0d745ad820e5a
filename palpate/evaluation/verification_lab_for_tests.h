// Rigs of the simulated laboratory, calibrated once, and verified on another day after something was knocked.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/calibration/session/verification_session.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/math/random_vector.h"
#include "palpate/sim/camera_renderer.h"

namespace palpate::evaluation {

inline sim::RenderView drawn_by(sim::CameraRenderer& renderer) {
  return
      [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) { renderer.render(view, rgb); };
}

// As `palpate calibrate all` does it; `plan` says how much.
inline rig::Rig calibrated_rig(std::uint64_t seed, calibration::session::CalibrationPlan plan) {
  const sim::config::WorldFile file = sim::config::reference_world();
  sim::CameraRenderer renderer;
  sim::Simulator world(file, seed);
  world.set_renderer(drawn_by(renderer));
  rig::Rig rig = blank_rig(file);
  plan.reach = reach_of(file);
  plan.guidance_seed = seed;
  calibration::session::SessionHooks hooks;
  hooks.find_landmarks = calibration::session::landmark_finder();
  const auto done = calibration::session::calibrate_rig(laboratory_of(world), rig, plan, hooks);
  EXPECT_TRUE(done) << done.error().message;
  return rig;
}

// Errors to truth of what a verification states figures of, in the same poses and pictures: m, m, px, px.
struct TrueErrors {
  double arm = 0.0, places = 0.0, picture = 0.0, tip = 0.0;
  double camera_delay = 0.0, tracker_delay = 0.0;  // s, the rig's less the true one
};

struct Verified {
  calibration::Verification found;
  TrueErrors truth;
  double seconds = 0.0;
};

class RmsOfErrors {
 public:
  template <typename V>
  void add(const V& error) {
    sum_ += error.squaredNorm();
    ++count_;
  }
  double value() const { return count_ > 0 ? std::sqrt(sum_ / count_) : 0.0; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

inline TrueErrors errors_to_truth(const sim::Simulator& world, const rig::Rig& rig,
                                  const calibration::RigObservations& seen) {
  const auto& truth = world.truth();
  RmsOfErrors arm, places, picture, tip;
  std::vector<std::pair<Vector3, Vector3>> tips;  // the rig's and the true one
  for (const auto& held : seen.held) {
    tips.emplace_back(
        (rig.arm->X_world_base *
         device::phantom_tip(rig.arm->correction.apply(held.joints), rig.arm->model.lengths))
            .m,
        (truth.X_world_base * device::phantom_tip(truth.joints.apply(held.joints), truth.lengths)).m);
    arm.add(tips.back().first - tips.back().second);
  }
  for (const auto& touched : seen.touched) {
    const auto i = static_cast<std::size_t>(touched.index);
    if (touched.what == "landmark")
      places.add(rig.landmarks[i].place.m - truth.landmarks[i].centre);
    else
      places.add(rig.surface(touched.what)->corner(touched.index).m -
                 (touched.what == "table" ? truth.table : truth.wall)[i]);
  }
  for (const auto& frame : seen.frames) {
    // What a camera's clock leaves in its stamps is the camera's latency.
    const auto moment = Instant<TrueTime>::from_seconds(frame.time_s - world.file().camera.latency_s);
    const auto true_eye = world.true_camera_at(moment).inverse();
    const auto eye = (frame.X_world_marker * rig.hand_eye->X_marker_camera).inverse();
    const auto drawn = [&](const Vector3& p) { return rig.camera->model.project((eye * Point<World>{p}).m); };
    const auto real = [&](const Vector3& p) { return truth.lens.project((true_eye * Point<World>{p}).m); };
    for (const auto& dot : frame.dots)
      picture.add(drawn(rig.landmarks[dot.landmark].place.m) - real(truth.landmarks[dot.landmark].centre));
    for (const auto& [mine, true_one] : tips) {
      const device::Pixel p = drawn(mine);
      if (p.x() >= 0.0 && p.y() >= 0.0 && p.x() < rig.camera->model.width && p.y() < rig.camera->model.height)
        tip.add(p - real(true_one));
    }
  }
  const double late = world.file().tracker.latency_s;
  return {arm.value(),
          places.value(),
          picture.value(),
          tip.value(),
          rig.delays->camera_after_tracker_s - (world.file().camera.latency_s - late),
          rig.delays->tracker_after_arm_s - late};
}

// In the laboratory of `file`, which may have a knock.
inline Verified verified_rig(const sim::config::WorldFile& file, std::uint64_t seed, std::uint64_t visit,
                             const rig::Rig& rig, const calibration::session::VerificationPlan& plan) {
  sim::CameraRenderer renderer;
  sim::Simulator world(file, seed, visit);
  world.set_renderer(drawn_by(renderer));
  calibration::session::VerificationHooks hooks;
  hooks.find_landmarks = calibration::session::landmark_finder();
  Verified result;
  const auto seen = calibration::session::observe_rig(laboratory_of(world), rig, plan, hooks);
  EXPECT_TRUE(seen) << seen.error().message;
  if (!seen) return result;
  const auto found = calibration::verify_rig(rig, seen->observed);
  EXPECT_TRUE(found) << found.error().message;
  if (!found) return result;
  result.found = *found;
  result.truth = errors_to_truth(world, rig, seen->observed);
  result.seconds = seen->seconds;
  return result;
}

// What may happen overnight, each of the size that has to be told.
enum class Knock { none, camera_shift, camera_turn, base_shift, base_turn, stylus, pointer, lens };
inline constexpr int kKnocks = 8;

inline const char* name_told_of(Knock knock) {
  constexpr const char* kTold[] = {"",         "camera",        "camera",  "arm base",
                                   "arm base", "stylus marker", "pointer", "lens"};
  return kTold[static_cast<int>(knock)];
}

inline sim::config::WorldFile knocked_world(Knock knock, std::uint64_t seed) {
  sim::config::WorldFile file = sim::config::reference_world();
  Random random(seed, "knock");
  const Vector3 way = normal3(random).normalized();
  const Vector3 shift = 1e-3 * way, turn = radians_from_degrees(0.5) * way;
  switch (knock) {
    case Knock::none:
      break;
    case Knock::camera_shift:
      file.knock.camera = shift;
      break;
    case Knock::camera_turn:
      file.knock.camera_turn = turn;
      break;
    case Knock::base_shift:
      file.knock.base = shift;
      break;
    case Knock::base_turn:
      file.knock.base_turn = turn;
      break;
    case Knock::stylus:
      file.knock.tip = shift;
      break;
    case Knock::pointer:
      file.knock.pointer_tip = shift;
      break;
    case Knock::lens:
      file.knock.focus = way.x() > 0.0 ? 0.01 : -0.01;
      file.knock.principal_point = {2.0 * way.y(), 2.0 * way.z()};
      break;
  }
  return file;
}

inline std::string names_of(const calibration::Verification& found) {
  std::string names;
  for (const auto& change : found.changes)
    names += (names.empty() ? "" : ", ") + std::string(calibration::name_of(change.change));
  if (!found.explained) names += names.empty() ? "unexplained" : ", unexplained";
  return names;
}

}  // namespace palpate::evaluation
