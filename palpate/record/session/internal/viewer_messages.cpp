#include "palpate/record/session/internal/viewer_messages.h"

namespace palpate::record::session {
namespace {

struct Tint {
  double r, g, b;
};

void set_color(foxglove::Color& color, const Tint& tint) {
  color.set_r(tint.r);
  color.set_g(tint.g);
  color.set_b(tint.b);
  color.set_a(1.0);
}

foxglove::SceneEntity& add_entity(foxglove::SceneUpdate& update, std::uint64_t time, const std::string& frame,
                                  const std::string& id) {
  auto& entity = *update.add_entities();
  set_time(*entity.mutable_timestamp(), time);
  entity.set_frame_id(frame);
  entity.set_id(id);
  entity.set_frame_locked(true);
  return entity;
}

void add_sphere(foxglove::SceneUpdate& update, std::uint64_t time, const std::string& frame, double diameter,
                const Tint& tint) {
  auto& sphere = *add_entity(update, time, frame, "body " + frame).add_spheres();
  sphere.mutable_pose()->mutable_orientation()->set_w(1.0);
  sphere.mutable_size()->set_x(diameter);
  sphere.mutable_size()->set_y(diameter);
  sphere.mutable_size()->set_z(diameter);
  set_color(*sphere.mutable_color(), tint);
}

}  // namespace

void set_time(google::protobuf::Timestamp& to, std::uint64_t time) {
  to.set_seconds(static_cast<std::int64_t>(time / 1'000'000'000));
  to.set_nanos(static_cast<std::int32_t>(time % 1'000'000'000));
}

void add_frame(foxglove::FrameTransforms& frames, std::uint64_t time, const std::string& parent,
               const std::string& child, const Vector3& translation, const Quaternion& rotation) {
  auto& frame = *frames.add_transforms();
  set_time(*frame.mutable_timestamp(), time);
  frame.set_parent_frame_id(parent);
  frame.set_child_frame_id(child);
  frame.mutable_translation()->set_x(translation.x());
  frame.mutable_translation()->set_y(translation.y());
  frame.mutable_translation()->set_z(translation.z());
  frame.mutable_rotation()->set_x(rotation.x());
  frame.mutable_rotation()->set_y(rotation.y());
  frame.mutable_rotation()->set_z(rotation.z());
  frame.mutable_rotation()->set_w(rotation.w());
}

void add_surface(foxglove::SceneUpdate& update, std::uint64_t time, const scene::SceneSurface& surface) {
  auto& line = *add_entity(update, time, "World", "surface " + surface.name).add_lines();
  line.set_type(foxglove::LinePrimitive::LINE_LOOP);
  line.mutable_pose()->mutable_orientation()->set_w(1.0);
  line.set_thickness(2.0);
  line.set_scale_invariant(true);
  for (const Vector3& corner : surface.corners) {
    auto& point = *line.add_points();
    point.set_x(corner.x());
    point.set_y(corner.y());
    point.set_z(corner.z());
  }
  set_color(*line.mutable_color(), {0.2, 0.6, 0.9});
}

void add_tip(foxglove::SceneUpdate& update, std::uint64_t time, const std::string& frame) {
  add_sphere(update, time, frame, 0.006, {0.95, 0.3, 0.2});
}

void add_body(foxglove::SceneUpdate& update, std::uint64_t time, const std::string& frame) {
  add_sphere(update, time, frame, 0.040, {0.95, 0.75, 0.2});
}

}  // namespace palpate::record::session
