// The arm as one mesh in World, moved to new joint angles every frame. Thread: the context's.
#pragma once

#include <vector>

#include "palpate/render/arm_shape.h"
#include "palpate/render/mesh_buffer.h"

namespace palpate::render {

class ArmBody {
 public:
  ArmBody(const device::PhantomLengths& lengths, const ArmShapeSettings& settings);
  void move(const ArmConfiguration& configuration);
  // World frame; the vertices' look is an ArmLook.
  const MeshBuffer& mesh() const { return buffer_; }
  const std::vector<ShadedVertex>& vertices() const { return moved_; }

 private:
  struct Range {
    std::size_t begin, end;
    ArmFrame frame;
  };
  std::vector<Range> ranges_;
  std::vector<ShadedVertex> still_, moved_;
  MeshBuffer buffer_;
};

}  // namespace palpate::render
