#include "palpate/evaluation/world_sample.h"

#include "palpate/calibration/session/guided_poses.h"
#include "palpate/calibration/session/sample_csv.h"
#include "palpate/core/csv.h"
#include "palpate/core/json.h"
#include "palpate/sim/board_view.h"
#include "palpate/sim/truth_json.h"
#include "palpate/vision/camera.h"

namespace palpate::evaluation {
namespace {

using sim::Simulator;

struct Files {
  std::vector<std::pair<std::string, std::string>> csv;  // name, content
  Json truth;
};

vision::BoardView view_of(std::string name, const std::vector<device::Pixel>& corners) {
  vision::BoardView view{std::move(name), {}, corners};
  const vision::BoardShape shape{sim::kBoardColumns, sim::kBoardRows, sim::kBoardSquare};
  for (int i = 0; i < shape.corners(); ++i) view.board.push_back(shape.corner(i));
  return view;
}

Expected<Files> sample_pivot(Simulator& world, const SampleRequest& request) {
  calibration::session::PivotRecordingOptions options;
  if (request.points > 0) options.poses = request.points;
  options.fixation.nominal = sim::makers_arm(world.file());
  options.fixation.stiffness = world.file().hand.fixation_stiffness;
  Vector3 held = Vector3::Zero();
  options.holding = [&] { held = world.true_state().X_world_tip.translation; };
  const auto poses = calibration::session::record_pivot(laboratory_of(world), options);
  if (!poses) return tl::unexpected(poses.error());
  return Files{
      {{"pivot.csv", calibration::session::pivot_csv(*poses, true, {}, sim::makers_arm(world.file()))}},
      sim::pivot_truth_json(world.truth(), held)};
}

Expected<Files> sample_arm(Simulator& world, const SampleRequest& request) {
  const double delay = world.file().tracker.latency_s;
  const device::ArmModel maker = sim::makers_arm(world.file());
  // The covariance is that of the tip as the maker of the stylus states it; this world's own tip is not known
  // yet.
  const Vector3 stated_tip = world.file().tip_marker.tip;
  if (!request.continuous) {
    calibration::session::ArmRecordingOptions recording;
    if (request.points > 0) recording.points = request.points;
    calibration::session::GuidanceOptions guidance;
    guidance.model.lengths = {world.file().arm.lengths[0], world.file().arm.lengths[1]};
    guidance.tip = stated_tip;
    guidance.reach = reach_of(world.file());
    guidance.seed = request.seed;
    calibration::session::GuidedPoses guide(guidance);
    if (request.guided) recording = guide.recording(recording.points);
    const auto poses = calibration::session::record_arm(laboratory_of(world), recording);
    if (!poses) return tl::unexpected(poses.error());
    return Files{{{"arm.csv", calibration::session::arm_csv(*poses, stated_tip, maker)}},
                 sim::arm_truth_json(world.truth(), delay)};
  }
  const int points = request.points > 0 ? request.points : 2000;
  const auto moving = calibration::session::record_moving(laboratory_of(world),
                                                          points / world.file().tracker.rate_hz * 1.02 + 0.5);
  if (!moving) return tl::unexpected(moving.error());
  auto poses = moving->marker;
  if (static_cast<int>(poses.size()) > points) poses.resize(static_cast<std::size_t>(points));
  return Files{{{"arm.csv", calibration::session::arm_csv(poses, stated_tip, maker)}},
               sim::arm_truth_json(world.truth(), delay)};
}

Expected<Files> sample_hand_eye(Simulator& world, const SampleRequest& request) {
  const int images = request.points > 0 ? request.points : 600;
  const auto record = calibration::session::record_hand_eye(
      laboratory_of(world), images / world.file().camera.rate_hz, see_board_in(world));
  if (!record) return tl::unexpected(record.error());
  const double delay = world.file().tracker.latency_s - world.file().camera.latency_s;
  return Files{{{"hand.csv", calibration::session::poses_csv(record->hand)},
                {"eye.csv", calibration::session::poses_csv(record->eye)}},
               sim::hand_eye_truth_json(world.truth(), delay)};
}

Expected<Files> sample_camera(Simulator& world, const SampleRequest& request) {
  const int views = request.points > 0 ? request.points : 15;
  Random random(world.seed(), "sample/camera");
  const auto& lens = world.truth().lens;
  const auto poses = sim::board_poses(lens, views, random);
  if (static_cast<int>(poses.size()) < views)
    return refused(
        "camera: the whole board fits {} times into this camera's picture where {} views are wanted; a wider "
        "lens shows it",
        poses.size(), views);
  CsvWriter csv(
      {"image", "corner", "board_x_squares", "board_y_squares", "u_px", "v_px", "width_px", "height_px"});
  int number = 0;
  for (const auto& pose : poses) {
    const auto corners = sim::board_corners(lens, pose, sim::kCornerNoise, random);
    if (!corners) continue;
    const std::string name = fmt::format("view{:02d}", ++number);
    for (std::size_t i = 0; i < corners->size(); ++i)
      csv.row(std::vector<std::string>{name, std::to_string(i), std::to_string(i % sim::kBoardColumns),
                                       std::to_string(i / sim::kBoardColumns), number_text((*corners)[i].x()),
                                       number_text((*corners)[i].y()), std::to_string(lens.width),
                                       std::to_string(lens.height)});
  }
  auto truth = sim::camera_truth_json(world.truth());
  truth["width_px"] = lens.width;
  truth["height_px"] = lens.height;
  return Files{{{"corners.csv", csv.content()}}, truth};
}

Expected<Files> sample_surface(Simulator& world, const SampleRequest& request) {
  // --points counts touches: the corners in turn, as often as it takes.
  const int touches = request.points > 0 ? request.points : 4;
  const auto touch = [&](const std::string& surface) -> Expected<std::string> {
    std::vector<device::Request> places;
    const auto corners = calibration::session::corner_requests(surface);
    for (int i = 0; i < touches; ++i) places.push_back(corners[static_cast<std::size_t>(i % 4)]);
    const auto touched =
        calibration::session::record_touches(laboratory_of(world), places, world.file().pointer.tip);
    if (!touched) return tl::unexpected(touched.error());
    return calibration::session::points_csv(*touched);
  };
  const auto table = touch("table");
  if (!table) return tl::unexpected(table.error());
  const auto wall = touch("wall");
  if (!wall) return tl::unexpected(wall.error());
  auto truth = sim::surface_truth_json(world.truth().table);
  truth["wall"] = sim::surface_truth_json(world.truth().wall);
  return Files{{{"surface.csv", *table}, {"wall.csv", *wall}}, truth};
}

Expected<Files> sample_pointer(Simulator& world, const SampleRequest& request) {
  const int poses = request.points > 0 ? request.points : 400;
  const auto recorded = calibration::session::record_pointer_pivot(laboratory_of(world), poses, 20.0);
  if (!recorded) return tl::unexpected(recorded.error());
  Json truth;
  truth["tip_mm"] = sim::mm_json(world.truth().pointer_tip);
  return Files{{{"pointer.csv", calibration::session::pivot_csv(*recorded, false)}}, truth};
}

Expected<Files> sample_landmarks(Simulator& world, const SampleRequest& request) {
  const auto& dots = world.truth().landmarks;
  // --points counts touches: the dots in turn, as often as it takes.
  const std::size_t touches = request.points > 0 ? static_cast<std::size_t>(request.points) : dots.size();
  std::vector<device::Request> places;
  for (std::size_t i = 0; i < touches && !dots.empty(); ++i)
    places.push_back({device::Gesture::touch, "landmark", static_cast<int>(i % dots.size())});
  if (places.empty()) return refused("landmarks: this world has none");
  const auto touched =
      calibration::session::record_touches(laboratory_of(world), places, world.file().pointer.tip);
  if (!touched) return tl::unexpected(touched.error());
  Json truth;
  truth["landmarks"] = Json::array();
  for (const auto& dot : dots) truth["landmarks"].push_back({{"place_mm", sim::mm_json(dot.centre)}});
  return Files{{{"landmarks.csv", calibration::session::points_csv(*touched)}}, truth};
}

Expected<Files> sample(Simulator& world, const SampleRequest& request) {
  switch (request.kind) {
    case SampleKind::pivot:
      return sample_pivot(world, request);
    case SampleKind::arm:
      return sample_arm(world, request);
    case SampleKind::hand_eye:
      return sample_hand_eye(world, request);
    case SampleKind::camera:
      return sample_camera(world, request);
    case SampleKind::pointer:
      return sample_pointer(world, request);
    case SampleKind::surface:
      return sample_surface(world, request);
    case SampleKind::landmarks:
      return sample_landmarks(world, request);
  }
  return wrong_use("sample: unknown kind");
}

}  // namespace

calibration::session::AcquisitionContext laboratory_of(Simulator& world) {
  return {.clock = world.physics_clock(),
          .arm = world.arm(),
          .tracker = world.tracker(),
          .camera = &world.camera(),
          .person = world.person(),
          .right_camera = world.right_camera(),
          .computed_arm = true};
}

calibration::ReachablePoses reach_of(const sim::config::WorldFile& file) {
  calibration::ReachablePoses reach;
  reach.joint_range = file.arm.joint_range;
  reach.tracker = (file.tracker.cameras[0] + file.tracker.cameras[1] + file.tracker.cameras[2]) / 3.0;
  return reach;
}

rig::Rig blank_rig(const sim::config::WorldFile& file) {
  rig::Rig rig;
  rig.name = "simulated rig";
  rig.nominal_arm.lengths = {file.arm.lengths[0], file.arm.lengths[1]};
  rig.tip_marker_leds = file.tip_marker.leds;
  rig.camera_marker_leds = file.camera_marker.leds;
  rig.pointer_leds = file.pointer.leds;
  return rig;
}

calibration::session::SeeBoard see_board_in(Simulator& world) {
  auto random = std::make_shared<Random>(world.seed(), "sample/corners");
  return [&world, random](const device::CameraImage& image) -> std::optional<Pose<Board, CameraOptical>> {
    const auto t = world.camera_clock().true_time(image.mid_exposure);
    const auto X_camera_board = world.true_camera_at(t).inverse() * world.truth().X_world_board;
    const auto corners = sim::board_corners(world.truth().lens, X_camera_board, sim::kCornerNoise, *random);
    if (!corners) return std::nullopt;
    const auto pose = vision::board_pose(world.truth().lens, view_of("", *corners));
    if (!pose || pose->value.ambiguous) return std::nullopt;
    return pose->value.X_camera_board.inverse();
  };
}

Expected<std::vector<std::filesystem::path>> sample_world(const sim::config::WorldFile& file,
                                                          const SampleRequest& request,
                                                          const std::filesystem::path& folder) {
  Simulator world(file, request.seed);
  const auto files = sample(world, request);
  if (!files) return tl::unexpected(files.error());
  if (const auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  if (!is_there(folder / "truth.json"))
    for (const auto& [name, content] : files->csv)
      if (is_there(folder / name))
        return wrong_use(
            "{}: exists already and is of no earlier sample, for there is no truth.json beside it; name "
            "another folder",
            (folder / name).string());
  std::vector<std::filesystem::path> written;
  for (const auto& [name, content] : files->csv) {
    written.push_back(folder / name);
    if (const auto done = write_file(written.back(), content); !done) return tl::unexpected(done.error());
  }
  written.push_back(folder / "truth.json");
  if (const auto done = write_json(written.back(), files->truth); !done) return tl::unexpected(done.error());
  return written;
}

}  // namespace palpate::evaluation
