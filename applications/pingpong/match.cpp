#include "applications/pingpong/match.h"

#include <algorithm>

namespace palpate::applications::pingpong {

LevelServes serves_of_level(int level) {
  constexpr std::array<LevelServes, kLevels> kServesOfLevels{
      {{{2.0, 2.3}, 0.02}, {{2.0, 2.7}, 0.04}, {{2.2, 3.1}, 0.05}, {{2.4, 3.5}, 0.06}, {{2.7, 3.8}, 0.08}}};
  return kServesOfLevels.at(static_cast<std::size_t>(std::clamp(level, 1, kLevels) - 1));
}

void Match::end_serve() {
  if (!has_end() || ended_ || serves_ < length_) return;
  ended_ = true;
  best_ = std::max(best_, points_);
}

void Match::begin_next() {
  if (won()) level_ = std::min(level_ + 1, kLevels);
  ended_ = false;
  serves_ = returned_ = points_ = 0;
}

}  // namespace palpate::applications::pingpong
