// A match: so many serves, points, and a level that rises with every match that is won.
//
// Each return to the wall counts as many points as the level's number, so that a long rally is worth more than a
// serve brought back once. Levels change the serves alone (serves_of_level). Values; physics thread, no allocation.
#pragma once

#include <array>
#include <cstdint>

#include "applications/pingpong/settings.h"

namespace palpate::applications::pingpong {

inline constexpr int kLevels = 5;
inline constexpr double kWonShare = 0.7;  // of a match's serves returned: the next one is a level higher

// Speeds and spread of that level's serves, 1 to kLevels.
struct LevelServes {
  std::array<double, 2> speed;  // slowest and fastest, m/s
  double aim_sd;                // m, sideways (ServeSettings)
};
LevelServes serves_of_level(int level);

class Match {
 public:
  Match() = default;  // without an end
  explicit Match(const MatchSettings& settings) : length_(settings.serves), level_(settings.level) {}

  bool has_end() const { return length_ > 0; }
  bool over() const { return has_end() && ended_; }
  int level() const { return level_; }
  std::int32_t serves() const { return serves_; }
  std::int32_t returned() const { return returned_; }
  std::int32_t points() const { return points_; }
  std::int32_t best() const { return best_; }  // points of a match since the start
  bool won() const { return returned_ >= kWonShare * length_; }

  void serve() { ++serves_; }
  // The ball has reached the wall; `first`: since its serve.
  void bring_back(bool first) {
    returned_ += first ? 1 : 0;
    points_ += level_;
  }
  // The ball is out of play: after the last serve so is the match.
  void end_serve();
  // The next match, a level higher where the last one was won.
  void begin_next();

 private:
  int length_ = 0, level_ = 1;
  bool ended_ = false;
  std::int32_t serves_ = 0, returned_ = 0, points_ = 0, best_ = 0;
};

}  // namespace palpate::applications::pingpong
