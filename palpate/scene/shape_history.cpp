#include "palpate/scene/shape_history.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace palpate {
namespace {

// out = a + share * (b - a), block by block: atomic words can only be loaded one by one, what lies in the
// cache is then mixed many numbers at a time.
void mix(const AtomicWord* a, const AtomicWord* b, float share, std::span<float> out) noexcept {
  constexpr std::size_t kBlock = 256;
  std::array<float, kBlock> ahead;
  for (std::size_t done = 0; done < out.size(); done += kBlock) {
    const std::size_t count = std::min(kBlock, out.size() - done), bytes = count * sizeof(float);
    float* const to = out.data() + done;
    load_words(to, a + done / 2, bytes);
    load_words(ahead.data(), b + done / 2, bytes);
    for (std::size_t i = 0; i < count; ++i) to[i] += share * (ahead[i] - to[i]);
  }
}

}  // namespace

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
    // What is not there any more the writer has overwritten meanwhile, gone right round: once more.
    if (!there(k)) continue;
    if (before >= when.ns() || k + 1 == n) {
      load_words(out.data(), words(k), out.size_bytes());
      if (still_there(k)) return Instant<PhysicsClock>{Duration(before)};
      continue;
    }
    const std::int64_t after = time(k + 1);
    if (!there(k + 1) || after <= when.ns()) continue;
    const double share = static_cast<double>(when.ns() - before) / static_cast<double>(after - before);
    mix(words(k), words(k + 1), static_cast<float>(share), out);
    if (still_there(k) && still_there(k + 1)) return when;
  }
}

}  // namespace palpate
