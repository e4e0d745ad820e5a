#include "palpate/render/arm_body.h"

namespace palpate::render {

ArmBody::ArmBody(const device::PhantomLengths& lengths, const ArmShapeSettings& settings) {
  ShadedMesh all;
  std::vector<ArmPart> parts = arm_parts(lengths, settings);
  parts.insert(parts.end(), settings.more.begin(), settings.more.end());
  for (const ArmPart& part : parts) {
    const ShadedMesh mesh = shaded(part.mesh);
    const std::size_t begin = all.vertices.size();
    for (ShadedVertex vertex : mesh.vertices) {
      vertex.look = static_cast<float>(part.look);
      all.vertices.push_back(vertex);
    }
    for (const std::uint32_t i : mesh.indices) all.indices.push_back(static_cast<std::uint32_t>(begin) + i);
    ranges_.push_back({begin, all.vertices.size(), part.frame});
  }
  still_ = moved_ = all.vertices;
  buffer_.upload(all);
}

void ArmBody::move(const ArmConfiguration& c) {
  const auto poses = arm_part_poses(c.lengths, c.theta, c.gimbal, c.X_tip_marker);
  for (const Range& range : ranges_) {
    const auto X = c.X_world_base * poses[static_cast<std::size_t>(range.frame)];
    const Eigen::Matrix3f R = X.matrix().cast<float>();
    const Vector3f t = X.translation.cast<float>();
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const Vector3f p = R * Vector3f(still_[i].position) + t, n = R * Vector3f(still_[i].normal);
      Vector3f::Map(moved_[i].position) = p;
      Vector3f::Map(moved_[i].normal) = n;
    }
  }
  buffer_.upload_vertices(moved_);
}

}  // namespace palpate::render
