#include "palpate/server/graphics/prediction_check.h"

#include <algorithm>
#include <utility>

#include "palpate/scene/shown_tip.h"

namespace palpate::server::graphics {
namespace {

// Numbers of questions: the picture's, and which of its moments.
constexpr std::uint64_t kQuestions = 2;
std::uint64_t of_light(std::uint64_t frame) { return kQuestions * frame; }
std::uint64_t of_image(std::uint64_t frame) { return kQuestions * frame + 1; }

double apart(const Vector3& a, const Vector3& b) { return (a - b).norm(); }

std::optional<double> worst_vertex(const scene::Shape& a, const scene::Shape& b) {
  if (a.values.size() != b.values.size()) return std::nullopt;
  using Vertex = Eigen::Map<const Eigen::Vector3f>;
  float worst = 0.0f;
  for (std::size_t i = 0; i < a.values.size(); i += scene::Shape::kFloatsPerVertex)
    worst = std::max(worst, (Vertex(a.values.data() + i) - Vertex(b.values.data() + i)).squaredNorm());
  return std::sqrt(static_cast<double>(worst));
}

}  // namespace

void PredictionCheck::shown(const PredictedPicture& picture) {
  const FrameRecord& frame = *picture.frame;
  Waiting next;
  next.error.frame = frame.number;
  next.error.ahead_s = to_seconds(frame.extrapolated_by);
  next.error.moment_s = to_seconds(picture.light - frame.photon);
  next.shown = frame.state;
  next.newest = *picture.newest;
  next.shape = frame.shape;
  next.marker = picture.marker;
  next.light = picture.light;
  next.marker_light = picture.marker_light;
  next.image_time = picture.image_time;
  if (waiting_.size() >= kWaiting) waiting_.pop_front();
  waiting_.push_back(std::move(next));
}

void PredictionCheck::service(Instant<GraphicsClock> now, const ClockModel<GraphicsClock, PhysicsClock>& sync,
                              Duration tracker_after_arm, const device::MarkerHistory& camera_marker,
                              const scene::SceneDescription& scene) {
  take_answers();
  for (Waiting& picture : waiting_)
    if (!picture.asked && now >= picture.light + kAskedAfter) ask(picture, sync, tracker_after_arm);
  while (!waiting_.empty() && waiting_.front().at_light && waiting_.front().at_image) {
    judge(waiting_.front(), camera_marker, scene);
    known_.push_back(std::move(waiting_.front().error));
    waiting_.pop_front();
  }
}

void PredictionCheck::ask(Waiting& picture, const ClockModel<GraphicsClock, PhysicsClock>& sync,
                          Duration tracker_after_arm) {
  const bool shape = picture.shape && picture.error.frame % kShapeEvery == 0;
  picture.asked =
      link_.look_back(of_light(picture.error.frame), sync.to(picture.light), shape) &&
      link_.look_back(of_image(picture.error.frame), sync.to(picture.image_time) - tracker_after_arm, false);
}

void PredictionCheck::take_answers() {
  for (const auto& reply : link_.looked_back()) {
    const auto picture = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) {
      return w.error.frame == reply.number / kQuestions;
    });
    if (picture == waiting_.end()) continue;
    const bool light = reply.number == of_light(picture->error.frame);
    (light ? picture->at_light : picture->at_image) = reply.answer.state;
    if (light) picture->shape_at_light = reply.shape;
  }
}

void PredictionCheck::judge(Waiting& picture, const device::MarkerHistory& camera_marker,
                            const scene::SceneDescription& scene) const {
  const scene::SceneState &there = *picture.at_light, &before = *picture.at_image;
  const auto places = [&](const auto& place) {
    const Vector3 at = place(there);
    return PlaceErrors{apart(place(picture.shown), at), apart(place(picture.newest), at),
                       apart(place(before), at)};
  };
  picture.error.tip = places([&](const scene::SceneState& s) { return scene::shown_tip(s, scene); });
  const int count = std::min(there.body_count, picture.shown.body_count);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    const auto &now = there.bodies[i], &then = picture.newest.bodies[i];
    const bool steady = now.visible != 0 && then.visible != 0 && now.jumps == then.jumps &&
                        now.jumps == before.bodies[i].jumps;
    auto& error = picture.error.bodies.emplace_back();
    if (steady) error = places([i](const scene::SceneState& s) { return s.bodies[i].p(); });
  }
  if (const auto seen = camera_marker.at(picture.marker_light); seen && picture.marker) {
    picture.error.head_m = apart(picture.marker->translation, seen->translation);
    picture.error.head_rad = angle_between(picture.marker->rotation, seen->rotation);
  }
  if (picture.shape && picture.shape_at_light)
    picture.error.shape_m = worst_vertex(*picture.shape, *picture.shape_at_light);
}

}  // namespace palpate::server::graphics
