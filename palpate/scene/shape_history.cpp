#include "palpate/scene/shape_history.h"

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>

namespace palpate::scene {

// Reader and writer each first say what they are about to do and then look at the other (sequentially
// consistent, so at least one of them sees the other and steps back).
class ShapeHistory::Held {
 public:
  Held(const ShapeHistory& history, std::uint64_t entry) : slot_(history.slot(entry)) {
    slot_.readers.fetch_add(1, std::memory_order_seq_cst);
    empty_ = slot_.entry.load(std::memory_order_seq_cst) != entry;
  }
  ~Held() { slot_.readers.fetch_sub(1, std::memory_order_release); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  bool empty() const { return empty_; }
  std::int64_t time() const { return slot_.time.load(std::memory_order_relaxed); }

 private:
  const Slot& slot_;
  bool empty_;
};

ShapeHistory::ShapeHistory(std::size_t vertices) : vertices_(vertices) {
  if (vertices > Shape::kMaxVertices) throw std::invalid_argument("shape history: too many vertices");
  if (vertices == 0) return;
  slots_ = std::make_unique<Slot[]>(kKept);
  values_ = std::make_unique<float[]>(kKept * floats());
}

bool ShapeHistory::push(Instant<PhysicsClock> time, std::span<const float> values) noexcept {
  if (vertices_ == 0 || values.size() != floats()) return false;
  const std::uint64_t before = newest_.load(std::memory_order_relaxed), entry = before + 1;
  if (before > 0 && time.ns() <= slot(before).time.load(std::memory_order_relaxed)) return false;
  Slot& target = slot(entry);
  const std::uint64_t there = target.entry.load(std::memory_order_relaxed);
  target.entry.store(kBeingWritten, std::memory_order_seq_cst);
  if (target.readers.load(std::memory_order_seq_cst) != 0) {
    target.entry.store(there, std::memory_order_seq_cst);
    return false;
  }
  target.time.store(time.ns(), std::memory_order_relaxed);
  std::copy(values.begin(), values.end(), this->values(entry));
  target.entry.store(entry, std::memory_order_seq_cst);
  newest_.store(entry, std::memory_order_release);
  return true;
}

std::optional<Instant<PhysicsClock>> ShapeHistory::at(Instant<PhysicsClock> when,
                                                      std::span<float> out) const noexcept {
  if (vertices_ == 0 || out.size() != floats()) return std::nullopt;
  using Numbers = Eigen::Map<Eigen::ArrayXf>;
  const auto numbers = [this](std::uint64_t entry) {
    return Eigen::Map<const Eigen::ArrayXf>(values(entry), static_cast<Eigen::Index>(floats()));
  };
  Numbers given(out.data(), static_cast<Eigen::Index>(out.size()));
  while (true) {
    const std::uint64_t newest = newest_.load(std::memory_order_acquire);
    if (newest == 0) return std::nullopt;
    // The slot after the newest is being written.
    const std::uint64_t oldest = newest < kKept ? 1 : newest - kKept + 2;
    std::uint64_t entry = newest;
    while (entry > oldest && slot(entry).time.load(std::memory_order_relaxed) > when.ns()) --entry;
    // What is not there any more the writer has overwritten meanwhile, gone right round: once more.
    const Held first(*this, entry);
    if (first.empty()) continue;
    if (first.time() >= when.ns() || entry == newest) {
      given = numbers(entry);
      return Instant<PhysicsClock>{Duration(first.time())};
    }
    const Held second(*this, entry + 1);
    if (second.empty() || second.time() <= when.ns()) continue;
    const double share =
        static_cast<double>(when.ns() - first.time()) / static_cast<double>(second.time() - first.time());
    given = numbers(entry) + static_cast<float>(share) * (numbers(entry + 1) - numbers(entry));
    return when;
  }
}

}  // namespace palpate::scene
