// How the graphics server's own estimate of its overlay error agrees with the truth, over many calibrations.
//
//   palpate_overlay_study WORLD FIRST COUNT [SECONDS]     WORLD: a world file, or - for the reference
//
// Each seed draws a laboratory, calibrates surfaces, landmarks, lens and hand-eye through its devices (the
// arm is given: no overlay error of table and wall knows of it), plays, and prints a line: true and estimated
// error, px rms over the frames, refined and by the tracker alone, and the estimate's parts. Last their rms
// over the seeds.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>

#include "applications/pingpong/specification.h"
#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/core/statistics.h"
#include "palpate/evaluation/overlay_of_play.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate {
namespace {

// Refines as it is told, and draws nothing.
class RefiningPipeline : public server::graphics::NullFramePipeline {
 public:
  using Refine = std::function<void(server::graphics::EyeSide, const device::CameraImage&, const Matrix6&,
                                    server::graphics::EyePose&)>;
  explicit RefiningPipeline(Refine refine) : refine_(std::move(refine)) {}
  bool sees() const override { return true; }
  void refine(server::graphics::EyeSide side, const device::CameraImage& image, const Matrix6& covariance,
              server::graphics::EyePose& pose) override {
    refine_(side, image, covariance, pose);
  }

 private:
  Refine refine_;
};

struct Line {
  double world = 0, expected = 0, tracker = 0, expected_tracker = 0, picture = 0, registration = 0,
         surfaces = 0;
  double misfit = 0, lens = 0;
};

rig::Rig rig_with_arm(const sim::Simulator& world) {
  const rig::Rig truth = sim::truth_rig(world);
  rig::Rig rig;
  rig.nominal_arm.lengths = {world.file().arm.lengths[0], world.file().arm.lengths[1]};
  rig.tip_marker_leds = world.file().tip_marker.leds;
  rig.arm = truth.arm;
  rig.tip_pivot = rig::PivotCalibration{world.truth().tip_in_marker};
  rig.delays.emplace();
  rig.delays->tracker_after_arm_s = world.file().tracker.latency_s;
  rig.delays->tracker_std_s = 1e-5;
  return rig;
}

// Squared deviations of the lens from the truth, as its covariance has them, per parameter: 1 where it is
// honest.
double lens_honesty(const rig::CameraCalibration& camera, const device::CameraModel& truth) {
  Eigen::Matrix<double, 9, 1> e;  // Brown's
  const device::CameraModel& m = camera.model;
  e.head<4>() << m.fx - truth.fx, m.fy - truth.fy, m.cx - truth.cx, m.cy - truth.cy;
  for (Eigen::Index i = 0; i < 5; ++i)
    e[4 + i] = m.distortion[static_cast<std::size_t>(i)] - truth.distortion[static_cast<std::size_t>(i)];
  const Eigen::MatrixXd covariance = camera.covariance.topLeftCorner<9, 9>();
  const Eigen::VectorXd sd = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd z = e.cwiseQuotient(sd);
  const Eigen::MatrixXd C = sd.cwiseInverse().asDiagonal() * covariance * sd.cwiseInverse().asDiagonal();
  return z.dot(Eigen::MatrixXd(C).ldlt().solve(z)) / 9.0;
}

Expected<Line> study(const sim::config::WorldFile& file, std::uint64_t seed, double seconds) {
  sim::CameraRenderer renderer;
  const sim::RenderView render = [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
    renderer.render(view, rgb);
  };
  sim::Simulator world(file, seed);
  world.set_renderer(render);
  rig::Rig rig = rig_with_arm(world);
  calibration::session::CalibrationPlan plan;
  plan.reach = evaluation::reach_of(file);
  calibration::session::SessionHooks hooks;
  hooks.find_landmarks = calibration::session::landmark_finder();
  if (auto done = calibration::session::calibrate_rig(evaluation::laboratory_of(world), rig, plan, hooks);
      !done)
    return tl::unexpected(done.error());

  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(file, {applications::pingpong::specification()}, "pingpong"));
  const scene::ApplicationRegistry applications{applications::pingpong::specification()};
  auto scene_view = applications.make_view(scene);
  if (!scene_view) return tl::unexpected(scene_view.error());
  server::graphics::FrameRenderer pictures(rig, scene, std::move(*scene_view));
  const vision::OverlayKnowledge known = vision::overlay_knowledge(rig);
  Line line;
  struct Seen {
    std::optional<vision::OverlayParts> alone, refined;
    double misfit = 0.0;
  };
  std::map<std::uint64_t, Seen> of_frame;
  sim::lockstep::LockstepPictures parts;
  parts.camera = render;
  RefiningPipeline pipeline([&](server::graphics::EyeSide side, const device::CameraImage& image,
                                const Matrix6& covariance, server::graphics::EyePose& pose) {
    vision::RefinedPose alone;
    alone.X_world_camera = pose.X_world_camera;
    Seen& seen = of_frame[image.frame];
    seen.alone = vision::expected_overlay(known, {{}, covariance, alone});
    // The same again as in FrameRenderer, for the parts.
    const device::CameraModel& lens = rig.camera->model;
    vision::OverlayPicture again{
        vision::camera_from_marker(pose.X_world_camera * rig.hand_eye->X_marker_camera.inverse(),
                                   Matrix6::Zero(), *rig.hand_eye),
        covariance,
        {},
        vision::kUnstatedSightingSd};
    again.prior.covariance += covariance;
    again.pose =
        vision::refine_camera_pose(lens, again.prior, known.landmarks,
                                   calibration::session::landmark_finder()(
                                       image, *rig.camera, again.prior.X_world_camera, rig.landmarks),
                                   {.pixel_sd = again.pixel_sd});
    seen.refined = vision::expected_overlay(known, again);
    pictures.refine(side, image, covariance, pose);
    seen.misfit = again.pose.misfit;
  });
  parts.pipeline = &pipeline;
  sim::lockstep::LockstepOptions lockstep;
  lockstep.applications = applications;
  lockstep.seconds = seconds;
  lockstep.seed = seed;
  lockstep.graphics = sim::lockstep::graphics_settings(file);
  auto play = sim::lockstep::play_in_lockstep(world, rig, scene, lockstep, parts, {});
  if (!play) return tl::unexpected(play.error());
  const auto overlay = evaluation::overlay_of_play(play->frames, rig.camera->model,
                                                   evaluation::check_points(world.truth(), rig));
  ErrorSummary expected_tracker, misfit, picture, registration, surfaces;
  for (const auto& frame : play->frames) {
    const Seen& seen = of_frame[frame.record.camera_frame];
    if (seen.alone) expected_tracker.add(seen.alone->total());
    misfit.add(seen.misfit);
    if (const auto& e = seen.refined)
      picture.add(e->picture), registration.add(e->registration), surfaces.add(e->surfaces);
  }
  line.world = overlay.frame_world.rms(), line.expected = overlay.expected_world.rms();
  line.tracker = overlay.world_tracker.rms(), line.expected_tracker = expected_tracker.rms();
  line.misfit = misfit.rms();
  line.picture = picture.rms(), line.registration = registration.rms(), line.surfaces = surfaces.rms();
  line.lens = lens_honesty(*rig.camera, world.truth().lens);
  return line;
}

int run(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: palpate_overlay_study WORLD|- FIRST COUNT [SECONDS]\n");
    return 2;
  }
  sim::config::WorldFile file = sim::config::reference_world();
  if (std::string_view(argv[1]) != "-") {
    auto read = sim::config::read_world(argv[1], {applications::pingpong::specification()});
    if (!read) {
      fmt::print(stderr, "{}\n", read.error().message);
      return read.error().exit_code();
    }
    file = *read;
  }
  const auto first = static_cast<std::uint64_t>(std::atoll(argv[2]));
  const auto count = static_cast<std::uint64_t>(std::atoll(argv[3]));
  const double seconds = argc > 4 ? std::atof(argv[4]) : 4.0;
  fmt::print(
      "seed  true  own  own/true   tracker: true  own  own/true   picture registration surfaces  misfit "
      "lens\n");
  Line sum;
  std::uint64_t done = 0;
  const auto show = [](const std::string& name, const Line& l) {
    fmt::print("{:>4} {:.3f} {:.3f} {:.2f}   {:.3f} {:.3f} {:.2f}   {:.3f} {:.3f} {:.3f}   {:.2f} {:.2f}\n",
               name, l.world, l.expected, l.expected / l.world, l.tracker, l.expected_tracker,
               l.expected_tracker / l.tracker, l.picture, l.registration, l.surfaces, l.misfit, l.lens);
    std::fflush(stdout);
  };
  const std::array<double Line::*, 8> figures{
      &Line::world,   &Line::expected,     &Line::tracker,  &Line::expected_tracker,
      &Line::picture, &Line::registration, &Line::surfaces, &Line::misfit};
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const auto line = study(file, seed, seconds);
    if (!line) {
      fmt::print("{:>4} {}\n", seed, line.error().message);
      continue;
    }
    show(std::to_string(seed), *line);
    for (const auto figure : figures) sum.*figure += (*line).*figure * (*line).*figure;
    sum.lens += line->lens;
    ++done;
  }
  if (done == 0) return 1;
  for (const auto figure : figures) sum.*figure = std::sqrt(sum.*figure / static_cast<double>(done));
  sum.lens /= static_cast<double>(done);
  show("rms", sum);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) { return palpate::run(argc, argv); }
