#include "palpate/system/overlay_of_play.h"

#include <array>

namespace palpate {

std::vector<CheckPoint> check_points(const sim::Truth& truth, const Rig& rig) {
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

OverlayOfPlay overlay_of_play(const LockstepResult& play, const CameraModel& lens,
                              const SceneDescription& scene, const std::vector<CheckPoint>& points) {
  OverlayOfPlay all;
  // Errors of the points as a camera at `estimated` would show them; their rms.
  const auto judge = [&points](const CameraView& estimated, const PlayedFrame& frame, ErrorSummary& total) {
    ErrorSummary here;
    for (const auto& point : points)
      if (const auto e = overlay_error(estimated, point.estimate, frame.truth, point.truth)) {
        here.add(*e);
        total.add(*e);
      }
    return here.empty() ? std::nullopt : std::optional(here.rms());
  };
  for (const auto& frame : play.frames) {
    const auto& record = frame.record;
    const CameraView drawn{lens, record.X_world_camera};
    FrameErrors errors;
    errors.world_px = judge(drawn, frame, all.world);
    if (record.have_tracker)
      errors.world_px_tracker = judge({lens, record.X_world_camera_tracker}, frame, all.world_tracker);
    errors.expected_world_px = record.expected_world_px;
    if (errors.world_px && errors.expected_world_px) {
      all.frame_world.add(*errors.world_px);
      all.expected_world.add(*errors.expected_world_px);
    }
    errors.tip_px = overlay_error(drawn, shown_tip(record.state, scene), frame.truth, frame.true_tip);
    if (errors.tip_px) all.tip.add(*errors.tip_px);
    all.frames.push_back(errors);
  }
  return all;
}

}  // namespace palpate
