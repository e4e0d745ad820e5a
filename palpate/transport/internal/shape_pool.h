// Buffers for shapes on their way out, so that what waits for slow readers is bounded and nothing of that
// size is allocated per answer.
//
// take() on one thread; a buffer comes back when its last owner lets go of it, on any thread, also after the
// pool has gone.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/scene/shape.h"

namespace palpate::transport {

class ShapePool {
 public:
  static constexpr std::size_t kInAll = 64;
  static constexpr std::size_t kPerPeer = 4;  // who does not take four shapes gets no fifth

  explicit ShapePool(std::size_t vertices) : vertices_(vertices) {}

  // Room for one shape; nothing where this peer, or all together, have not taken enough of theirs yet.
  std::shared_ptr<scene::Shape> take(std::string_view peer) {
    std::shared_ptr<Buffer> free;
    std::size_t of_peer = 0;
    for (const auto& buffer : buffers_) {
      if (!buffer->busy.load(std::memory_order_acquire))
        free = buffer;
      else if (buffer->peer == peer)
        ++of_peer;
    }
    if (of_peer >= kPerPeer) return nullptr;
    if (!free) {
      if (buffers_.size() >= kInAll) return nullptr;
      free = std::make_shared<Buffer>();
      free->shape.values.resize(vertices_ * scene::Shape::kFloatsPerVertex);
      buffers_.push_back(free);
    }
    free->peer = peer;
    free->busy.store(true, std::memory_order_relaxed);
    return {&free->shape, [free](scene::Shape*) { free->busy.store(false, std::memory_order_release); }};
  }

 private:
  struct Buffer {
    scene::Shape shape;
    std::string peer;
    std::atomic<bool> busy{false};
  };
  std::size_t vertices_;
  std::vector<std::shared_ptr<Buffer>> buffers_;
};

}  // namespace palpate::transport
