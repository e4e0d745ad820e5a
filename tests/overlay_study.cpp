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

#include "palpate/applications/applications.h"
#include "palpate/applications/scene_settings.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/system/overlay_of_play.h"
#include "palpate/system/picture_parts.h"
#include "palpate/system/truth_rig_for_tests.h"
#include "palpate/system/world_sample.h"

namespace palpate {
namespace {

struct Line {
  double world = 0, expected = 0, tracker = 0, expected_tracker = 0, picture = 0, registration = 0,
         surfaces = 0;
  double misfit = 0, lens = 0;
};

Rig rig_with_arm(const sim::SimWorld& world) {
  const Rig truth = truth_rig(world);
  Rig rig;
  rig.nominal_lengths = {world.file().arm.lengths[0], world.file().arm.lengths[1]};
  rig.tip_marker_leds = world.file().tip_marker.leds;
  rig.arm = truth.arm;
  rig.tip_pivot = PivotCalibration{world.truth().tip_in_marker};
  rig.delays.emplace();
  rig.delays->tracker_after_arm_s = world.file().tracker.latency_s;
  rig.delays->tracker_std_s = 1e-5;
  return rig;
}

// Squared deviations of the lens from the truth, as its covariance has them, per parameter: 1 where it is
// honest.
double lens_honesty(const CameraCalibration& camera, const CameraModel& truth) {
  LensParameters e;
  const CameraModel& m = camera.model;
  e.head<4>() << m.fx - truth.fx, m.fy - truth.fy, m.cx - truth.cx, m.cy - truth.cy;
  for (Eigen::Index i = 0; i < 5; ++i)
    e[4 + i] = m.distortion[static_cast<std::size_t>(i)] - truth.distortion[static_cast<std::size_t>(i)];
  const LensParameters sd = camera.covariance.diagonal().cwiseSqrt();
  const LensParameters z = e.cwiseQuotient(sd);
  const Eigen::MatrixXd C =
      sd.cwiseInverse().asDiagonal() * camera.covariance * sd.cwiseInverse().asDiagonal();
  return z.dot(Eigen::MatrixXd(C).ldlt().solve(z)) / 9.0;
}

Expected<Line> study(const sim::WorldFile& file, std::uint64_t seed, double seconds) {
  sim::CameraRenderer renderer;
  const sim::RenderView render = [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
    renderer.render(view, rgb);
  };
  sim::SimWorld world(file, seed);
  world.set_renderer(render);
  Rig rig = rig_with_arm(world);
  CalibrationPlan plan;
  plan.reach = reach_of(file);
  SessionHooks hooks;
  hooks.find_landmarks = landmark_finder();
  if (auto done = calibrate_rig(laboratory_of(world), rig, plan, hooks); !done)
    return tl::unexpected(done.error());

  const auto scene = scene_from_rig(rig, scene_settings(file, "pingpong"), file.ball.restitution_table);
  auto artist = make_artist(scene);
  if (!artist) return tl::unexpected(artist.error());
  PictureParts pictures(rig, scene, std::move(*artist));
  const OverlayKnowledge known = overlay_knowledge(rig);
  Line line;
  struct Seen {
    std::optional<OverlayParts> alone, refined;
    double misfit = 0.0;
  };
  std::map<std::uint64_t, Seen> of_frame;
  LockstepPictures parts;
  parts.camera = render;
  parts.refiner = [&, refiner = pictures.refiner()](EyeSide side, const CameraImage& image,
                                                    const Matrix6& covariance, EyePose& pose) {
    RefinedPose alone;
    alone.X_world_camera = pose.X_world_camera;
    Seen& seen = of_frame[image.frame];
    seen.alone = expected_overlay(known, {{}, covariance, alone});
    // The same again as in PictureParts, for the parts.
    const CameraModel& lens = rig.camera->model;
    OverlayPicture again{camera_from_marker(pose.X_world_camera * rig.hand_eye->X_marker_camera.inverse(),
                                            Matrix6::Zero(), *rig.hand_eye),
                         covariance,
                         {},
                         kUnstatedSightingSd};
    again.prior.covariance += covariance;
    again.pose =
        refine_camera_pose(lens, again.prior, known.landmarks,
                           landmark_finder()(image, *rig.camera, again.prior.X_world_camera, rig.landmarks),
                           {.pixel_sd = again.pixel_sd});
    seen.refined = expected_overlay(known, again);
    refiner(side, image, covariance, pose);
    seen.misfit = again.pose.misfit;
  };
  LockstepOptions lockstep;
  lockstep.seconds = seconds;
  lockstep.seed = seed;
  lockstep.graphics = graphics_settings(file);
  auto play = play_in_lockstep(world, rig, scene, lockstep, parts, {});
  if (!play) return tl::unexpected(play.error());
  const auto overlay = overlay_of_play(*play, rig.camera->model, scene, check_points(world.truth(), rig));
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
  sim::WorldFile file = sim::reference_world();
  if (std::string_view(argv[1]) != "-") {
    auto read = sim::read_world(argv[1]);
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
