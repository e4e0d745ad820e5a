#include "palpate/scene/shape_history.h"

#include <stdexcept>

namespace palpate {

ShapeHistory::ShapeHistory(std::size_t vertices)
    : vertices_(vertices), words_each_(words_for(floats() * sizeof(float))) {
  if (vertices > Shape::kMaxVertices) throw std::invalid_argument("shape history: too many vertices");
  if (vertices == 0) return;
  slots_ = std::make_unique<Slot[]>(kKept);
  words_ = std::make_unique<AtomicWord[]>(kKept * words_each_);
}

bool ShapeHistory::push(Instant<PhysicsClock> time, std::span<const float> values) noexcept {
  if (vertices_ == 0 || values.size() != floats()) return false;
  const std::uint64_t k = count_.load(std::memory_order_relaxed);
  if (k > 0 && time.ns() <= slot(k - 1).time.load(std::memory_order_relaxed)) return false;
  Slot& target = slots_[k % kKept];
  target.state.store(2 * k + 1, std::memory_order_relaxed);
  target.time.store(time.ns(), std::memory_order_release);
  store_words(words(k), values.data(), values.size_bytes());
  target.state.store(2 * k + 2, std::memory_order_release);
  count_.store(k + 1, std::memory_order_release);
  return true;
}

std::optional<Instant<PhysicsClock>> ShapeHistory::at(Instant<PhysicsClock> when,
                                                      std::span<float> out) const noexcept {
  if (vertices_ == 0 || out.size() != floats()) return std::nullopt;
  const auto time = [this](std::uint64_t k) { return slot(k).time.load(std::memory_order_acquire); };
  while (true) {
    const std::uint64_t n = count_.load(std::memory_order_acquire);
    if (n == 0) return std::nullopt;
    // The slot after the newest is being written.
    const std::uint64_t oldest = n < kKept ? 0 : n - (kKept - 1);
    std::uint64_t k = n - 1;
    while (k > oldest && time(k) > when.ns()) --k;
    const std::int64_t before = time(k);
    if (!there(k) || !copy(k, out)) continue;
    if (before >= when.ns() || k + 1 == n) return Instant<PhysicsClock>{Duration(before)};
    const std::int64_t after = time(k + 1);
    if (!there(k + 1) || after <= when.ns()) continue;  // the writer has gone right round meanwhile
    const double share = static_cast<double>(when.ns() - before) / static_cast<double>(after - before);
    if (mix_in(k + 1, static_cast<float>(share), out)) return when;
  }
}

bool ShapeHistory::copy(std::uint64_t k, std::span<float> out) const noexcept {
  load_words(out.data(), words(k), out.size_bytes());
  return still_there(k);
}

// out += share * (entry k - out); a word holds two numbers, and there is an even number of them.
bool ShapeHistory::mix_in(std::uint64_t k, float share, std::span<float> out) const noexcept {
  const AtomicWord* from = words(k);
  for (std::size_t i = 0; i + 1 < out.size(); i += 2) {
    const std::uint64_t word = from[i / 2].load(std::memory_order_acquire);
    std::array<float, 2> there_values;
    std::memcpy(there_values.data(), &word, sizeof word);
    out[i] += share * (there_values[0] - out[i]);
    out[i + 1] += share * (there_values[1] - out[i + 1]);
  }
  return still_there(k);
}

}  // namespace palpate
