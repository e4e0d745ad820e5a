#include "palpate/evaluation/overlay_of_play.h"

#include <array>
#include <utility>

namespace palpate::evaluation {

std::vector<CheckPoint> check_points(const sim::Truth& truth, const rig::Rig& rig) {
  std::vector<CheckPoint> points;
  for (const auto& [name, corners] : {std::pair{"table", &truth.table}, std::pair{"wall", &truth.wall}}) {
    const auto* surface = rig.surface(name);
    if (surface == nullptr) continue;
    const Vector3 x = (*corners)[1] - (*corners)[0], y = (*corners)[3] - (*corners)[0];
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 4; ++j) {
        const double u = 0.1 + 0.2 * i, v = 0.125 + 0.25 * j;
        points.push_back(
            {(*corners)[0] + u * x + v * y,
             (surface->X_world_rectangle * Point<Rectangle>{{u * surface->width, v * surface->height, 0.0}})
                 .m});
      }
  }
  return points;
}

namespace {

// Of one eye's pictures.
class OverlayJudge {
 public:
  OverlayJudge(const device::CameraModel& lens, const std::vector<CheckPoint>& points)
      : lens_(lens), points_(points) {}

  void frame(const server::graphics::EyePose& pose, const CameraView& truth, const Vector3& tip,
             const Vector3& true_tip) {
    const CameraView drawn{lens_, pose.X_world_camera};
    FrameErrors errors;
    errors.world_px = judge(drawn, truth, all_.world);
    if (pose.have_tracker)
      errors.world_px_tracker = judge({lens_, pose.X_world_camera_tracker}, truth, all_.world_tracker);
    errors.expected_world_px = pose.expected_world_px;
    if (errors.world_px && errors.expected_world_px) {
      all_.frame_world.add(*errors.world_px);
      all_.expected_world.add(*errors.expected_world_px);
    }
    errors.tip_px = overlay_error(drawn, tip, truth, true_tip);
    if (errors.tip_px) all_.tip.add(*errors.tip_px);
    all_.frames.push_back(errors);
  }
  OverlayOfPlay take() { return std::move(all_); }

 private:
  // Errors of the points as a camera at `estimated` would show them; their rms.
  std::optional<double> judge(const CameraView& estimated, const CameraView& truth,
                              ErrorSummary& total) const {
    ErrorSummary here;
    for (const auto& point : points_)
      if (const auto e = overlay_error(estimated, point.estimate, truth, point.truth)) {
        here.add(*e);
        total.add(*e);
      }
    return here.empty() ? std::nullopt : std::optional(here.rms());
  }

  const device::CameraModel& lens_;
  const std::vector<CheckPoint>& points_;
  OverlayOfPlay all_;
};

}  // namespace

OverlayOfPlay overlay_of_play(const std::vector<PlayedFrame>& frames, const device::CameraModel& lens,
                              const std::vector<CheckPoint>& points) {
  OverlayJudge judge(lens, points);
  for (const auto& frame : frames) judge.frame(frame.record, frame.truth, frame.shown_tip, frame.true_tip);
  return judge.take();
}

OverlayOfPlay overlay_of_right_eye(const std::vector<PlayedFrame>& frames, const device::CameraModel& lens,
                                   const std::vector<CheckPoint>& points) {
  OverlayJudge judge(lens, points);
  for (const auto& frame : frames)
    if (frame.right_truth)
      judge.frame(*frame.record.right, *frame.right_truth, frame.shown_tip, frame.true_tip);
  return judge.take();
}

Json overlay_figures(const OverlayOfPlay& overlay) {
  Json figures = Json::object();
  if (!overlay.world.empty()) {
    figures["world_px_rms"] = overlay.world.rms();
    figures["world_px_p95"] = overlay.world.quantile(0.95);
  }
  if (!overlay.world_tracker.empty()) figures["world_px_rms_tracker_only"] = overlay.world_tracker.rms();
  if (!overlay.tip.empty()) {
    figures["tip_px_rms"] = overlay.tip.rms();
    figures["tip_px_p95"] = overlay.tip.quantile(0.95);
  }
  if (!overlay.expected_world.empty() && overlay.frame_world.rms() > 0.0) {
    figures["own_estimate_px_rms"] = overlay.expected_world.rms();
    figures["own_estimate_over_true"] = overlay.expected_world.rms() / overlay.frame_world.rms();
  }
  return figures;
}

DisparityErrors disparity_of_play(const std::vector<PlayedFrame>& frames, const rig::Rig& rig,
                                  const std::vector<CheckPoint>& points) {
  DisparityErrors errors;
  const auto& left_lens = rig.camera->model;
  const auto& right_lens = rig.right_camera->model;
  for (const auto& frame : frames) {
    if (!frame.right_truth) continue;
    const CameraView left{left_lens, frame.record.X_world_camera},
        right{right_lens, frame.record.right->X_world_camera};
    const auto judge = [&](const Vector3& drawn, const Vector3& real, ErrorSummary& summary) {
      const auto drawn_left = drawn_pixel(left, drawn), drawn_right = drawn_pixel(right, drawn);
      const auto real_left = real_pixel(frame.truth, left_lens, real),
                 real_right = real_pixel(*frame.right_truth, right_lens, real);
      if (drawn_left && drawn_right && real_left && real_right)
        summary.add(((*drawn_left - *drawn_right) - (*real_left - *real_right)).norm());
    };
    for (const auto& point : points) judge(point.estimate, point.truth, errors.world);
    const auto& body = frame.record.state.bodies[0];
    if (body.visible != 0) judge(body.p(), body.p(), errors.body);
  }
  return errors;
}

}  // namespace palpate::evaluation
