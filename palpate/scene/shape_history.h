// The shapes of the last half second of a surface that deforms: too large to be kept a thousand times a
// second like the world's state (10,000 vertices are 240 kB), smooth enough that 120 a second do.
//
// One thread pushes, any number ask; nobody locks or waits for another, and only the constructor allocates.
// Too large as well to be copied by atomic words: a reader says which two shapes it reads, and the writer
// leaves these alone. Between two shapes each number goes straight from one to the other: a vertex at 1 m/s
// that turns about within one interval is then wrong by 2 mm at most, and normals are a little short of unit
// length.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>

#include "palpate/scene/shape.h"
#include "palpate/time/instant.h"

namespace palpate::scene {

class ShapeHistory {
 public:
  static constexpr double kRateHz = 120.0;  // as often as a writer should push
  static constexpr std::size_t kKept = 64;

  // 0 vertices: no surface, and no memory. Throws std::invalid_argument above Shape::kMaxVertices.
  explicit ShapeHistory(std::size_t vertices);

  std::size_t vertices() const { return vertices_; }

  // The one writer. False, and nothing stored, for another size, a time that does not increase, or where
  // somebody still reads the shape of half a second ago that would have to go.
  bool push(Instant<PhysicsClock> time, std::span<const float> values) noexcept;

  // Fills `out` (of vertices() * Shape::kFloatsPerVertex) with the shape at `when`, or with the nearest
  // known; the time of what was given, nothing while there is none.
  std::optional<Instant<PhysicsClock>> at(Instant<PhysicsClock> when, std::span<float> out) const noexcept;

 private:
  struct Slot {
    std::atomic<std::uint64_t> entry{0};  // counted from 1; kBeingWritten
    std::atomic<std::int64_t> time{0};
    mutable std::atomic<int> readers{0};
  };
  static constexpr std::uint64_t kBeingWritten = ~std::uint64_t{0};

  // One entry, kept from the writer while this lives. empty() where it has gone already.
  class Held;

  std::size_t floats() const { return vertices_ * Shape::kFloatsPerVertex; }
  Slot& slot(std::uint64_t entry) const noexcept { return slots_[entry % kKept]; }
  float* values(std::uint64_t entry) const noexcept { return &values_[(entry % kKept) * floats()]; }

  std::size_t vertices_;
  std::unique_ptr<Slot[]> slots_;
  std::unique_ptr<float[]> values_;
  std::atomic<std::uint64_t> newest_{0};  // entry; 0: none
};

}  // namespace palpate::scene
