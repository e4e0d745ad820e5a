#include "palpate/render/shadow_gather.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace palpate::render {
namespace {

constexpr std::size_t kTilesAcross = 4, kChannels = 2;

// One row of a tile, softened over 2 x 2 texels, added to the sums: of a texel whichever channel is darker, and the second.
class RowSum {
 public:
  explicit RowSum(std::size_t size) : size_(size), pairs_(kChannels * (size + 2)), sums_(kChannels * size) {}
  void begin() { std::fill(sums_.begin(), sums_.end(), std::uint16_t{0}); }
  // `a`, `b`: two rows of the tile; `right`: with the neighbour on the right, else on the left.
  void add(const std::uint8_t* a, const std::uint8_t* b, bool right) {
    // The outermost texels once more at both ends.
    std::uint16_t* inner = pairs_.data() + kChannels;
    for (std::size_t k = 0; k < kChannels * size_; ++k) inner[k] = static_cast<std::uint16_t>(a[k] + b[k]);
    for (std::size_t c = 0; c < kChannels; ++c) {
      pairs_[c] = inner[c];
      inner[kChannels * size_ + c] = inner[kChannels * (size_ - 1) + c];
    }
    const std::uint16_t* from = pairs_.data() + (right ? kChannels : 0);
    for (std::size_t x = 0; x < size_; ++x) {
      const auto any = static_cast<std::uint16_t>(from[2 * x] + from[2 * x + 2]);
      const auto real = static_cast<std::uint16_t>(from[2 * x + 1] + from[2 * x + 3]);
      sums_[2 * x] = static_cast<std::uint16_t>(sums_[2 * x] + std::max(any, real));
      sums_[2 * x + 1] = static_cast<std::uint16_t>(sums_[2 * x + 1] + real);
    }
  }
  // Sixteen tiles of four texels each.
  void write(std::uint8_t* row) const {
    for (std::size_t k = 0; k < sums_.size(); ++k) row[k] = static_cast<std::uint8_t>((sums_[k] + 32u) / 64u);
  }

 private:
  std::size_t size_;
  std::vector<std::uint16_t> pairs_, sums_;
};

}  // namespace

void gather_tiles(std::span<const std::uint8_t> tiles, int size, std::vector<std::uint8_t>& result) {
  const auto side = static_cast<std::size_t>(std::max(size, 0));
  const std::size_t stride = kChannels * kTilesAcross * side;
  if (size <= 0 || tiles.size() != stride * kTilesAcross * side)
    throw std::invalid_argument("shadow tiles: " + std::to_string(tiles.size()) + " bytes for tiles of " +
                                std::to_string(size) + " texels");
  result.resize(kChannels * side * side);
  RowSum row(side);
  for (std::size_t y = 0; y < side; ++y) {
    row.begin();
    for (std::size_t tile = 0; tile < kTilesAcross * kTilesAcross; ++tile) {
      const std::size_t beside = (tile & 2) == 0 ? std::min(y + 1, side - 1) : (y > 0 ? y - 1 : 0);
      const std::uint8_t* corner =
          tiles.data() + (tile / kTilesAcross) * side * stride + (tile % kTilesAcross) * kChannels * side;
      row.add(corner + y * stride, corner + beside * stride, (tile & 1) == 0);
    }
    row.write(result.data() + kChannels * side * y);
  }
}

}  // namespace palpate::render
