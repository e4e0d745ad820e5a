// The shapes of the last half second of a surface that deforms: too large to be kept a thousand times a
// second like the world's state (10,000 vertices are 240 kB), smooth enough that 120 a second do.
//
// One thread pushes, any number ask; nobody locks or waits for another, and only the constructor allocates.
// Memory model: palpate/core/broadcast_ring.h. Between two shapes each number goes straight from one to the
// other: a vertex at 1 m/s that turns about within one interval is then wrong by 2 mm at most, and normals
// are a little short of unit length.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "palpate/core/broadcast_ring.h"
#include "palpate/scene/shape.h"

namespace palpate {

class ShapeHistory {
 public:
  static constexpr double kRateHz = 120.0;  // as often as a writer should push
  static constexpr std::size_t kKept = 64;

  // 0 vertices: no surface, and no memory. Throws std::invalid_argument above Shape::kMaxVertices.
  explicit ShapeHistory(std::size_t vertices);

  std::size_t vertices() const { return vertices_; }

  // The one writer. False, and nothing stored, for another size or a time that does not increase.
  bool push(Instant<PhysicsClock> time, std::span<const float> values) noexcept;

  // Fills `out` (of vertices() * Shape::kFloatsPerVertex) with the shape at `when`, or with the nearest
  // known; the time of what was given, nothing while there is none.
  std::optional<Instant<PhysicsClock>> at(Instant<PhysicsClock> when, std::span<float> out) const noexcept;

 private:
  struct Slot {
    AtomicWord state{0};  // entry k is there where this is 2k + 2
    std::atomic<std::int64_t> time{0};
  };

  std::size_t floats() const { return vertices_ * Shape::kFloatsPerVertex; }
  AtomicWord* words(std::uint64_t k) const noexcept { return &words_[(k % kKept) * words_each_]; }
  const Slot& slot(std::uint64_t k) const noexcept { return slots_[k % kKept]; }
  bool there(std::uint64_t k) const noexcept {
    return slot(k).state.load(std::memory_order_acquire) == 2 * k + 2;
  }
  bool still_there(std::uint64_t k) const noexcept {
    return slot(k).state.load(std::memory_order_relaxed) == 2 * k + 2;
  }

  std::size_t vertices_, words_each_;
  std::unique_ptr<Slot[]> slots_;
  std::unique_ptr<AtomicWord[]> words_;
  AtomicWord count_{0};
};

}  // namespace palpate
