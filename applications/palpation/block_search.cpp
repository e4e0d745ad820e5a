#include "applications/palpation/block_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "applications/palpation/press_map.h"
#include "palpate/core/random.h"
#include "palpate/experiment/observer.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kGrid_m = 0.010, kAreaX_m = 0.100, kAreaZ_m = 0.070, kInnerShare = 0.8,
                 kFoundWithin_m = 0.010;
constexpr std::size_t kPressedAgain = 5, kTimesAgain = 4;
constexpr double kMarksApart_m = 0.018, kFreelyApart_m = 0.012;

std::vector<PlanPlace> searching_grid() {
  std::vector<PlanPlace> places;
  for (double x = 0.5 * (kGrid_m - kAreaX_m); x < 0.5 * kAreaX_m; x += kGrid_m)
    for (double z = 0.5 * (kGrid_m - kAreaZ_m); z < 0.5 * kAreaZ_m; z += kGrid_m) places.emplace_back(x, z);
  return places;
}

// One search going on: places, where the nodule is, and what has been felt.
class BlockSearch {
 public:
  BlockSearch(const ContrastProfile& profile, const SearchTask& task, Random& random)
      : profile_(profile),
        senses_(task.senses),
        noise_(experiment::noise_of_weber_fraction(task.weber_fraction)),
        random_(random),
        map_(searching_grid(), kGrid_m, noise_, PressMap::Trend::level) {
    nodule_.x() = 0.5 * kInnerShare * kAreaX_m * random.uniform(-1.0, 1.0);
    nodule_.y() = 0.5 * kInnerShare * kAreaZ_m * random.uniform(-1.0, 1.0);
    for (std::size_t i = 0; i < map_.places().size(); ++i) press(i);
  }

  bool ends_by_grid() {
    const auto again = map_.best(kPressedAgain);
    for (std::size_t k = 0; k < kTimesAgain; ++k)
      for (const std::size_t i : again) press(i);
    const auto hard = map_.hardness();
    const auto answer =
        *std::max_element(again.begin(), again.end(), [&](auto a, auto b) { return hard[a] < hard[b]; });
    return is_near(map_.places()[answer]);
  }

  bool ends_freely() {
    for (std::size_t k = 0; k < kTimesAgain; ++k)
      for (const PlanPlace& place : map_.likeliest(kPressedAgain, kFreelyApart_m))
        press(map_.add_place(place));
    const auto answers = map_.believed(1, 1, kMarksApart_m);
    return !answers.empty() && is_near(answers.front());
  }

 private:
  void press(std::size_t i) {
    const double contrast = senses_ ? profile_.at((map_.places()[i] - nodule_).norm()) : 0.0;
    map_.felt(i, contrast + random_.normal(noise_));
  }
  bool is_near(const PlanPlace& answer) const { return (answer - nodule_).norm() <= kFoundWithin_m; }

  const ContrastProfile& profile_;
  bool senses_;
  double noise_;
  Random& random_;
  PressMap map_;
  PlanPlace nodule_ = PlanPlace::Zero();
};

template <typename Ends>
double share_of(const ContrastProfile& profile, const SearchTask& task, const char* purpose, Ends ends) {
  Random random(task.seed, purpose);
  int found = 0;
  for (int i = 0; i < task.searches; ++i) {
    BlockSearch search(profile, task, random);
    found += ends(search);
  }
  return static_cast<double>(found) / task.searches;
}

}  // namespace

double grid_share(const ContrastProfile& profile, const SearchTask& task) {
  return share_of(profile, task, "palpation/grid", [](BlockSearch& s) { return s.ends_by_grid(); });
}

double freer_share(const ContrastProfile& profile, const SearchTask& task) {
  return share_of(profile, task, "palpation/freer", [](BlockSearch& s) { return s.ends_freely(); });
}

}  // namespace palpate::applications::palpation
