// Figures 8 and 9 with the paper's axes: the offsets and gains found on one arm, one recording, over random
// halves of its 140 poses.
#include <algorithm>
#include <numeric>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/points_study.h"

namespace palpate::evaluation::studies {
namespace {

constexpr std::size_t kMostSplits = 100;
constexpr std::array kOneArmMethods{kEq7, kJoint};

struct Found {
  Vector3 gain = Vector3::Constant(kNoValue), offset_deg = Vector3::Constant(kNoValue);
};
using Split = std::array<std::array<Found, kPointCounts.size()>, kOneArmMethods.size()>;

}  // namespace

Expected<void> add_one_arm(StudyResult& study, const StudyOptions& options) {
  const std::uint64_t seed = repeat_seed(options.seed, "study/points-one-arm", 0);
  const auto laboratory = record_laboratory(options.world, seed);
  if (!laboratory) return tl::unexpected(laboratory.error());
  const auto model = nominal_model(options.world);
  std::vector<Split> splits(std::min(kMostSplits, static_cast<std::size_t>(options.runs)));
  repeat(splits.size(), options.repeats, [&](std::size_t i) {
    Random random(repeat_seed(seed, "study/splits", i));
    auto samples = laboratory->samples;
    for (std::size_t k = samples.size(); k > 1; --k) std::swap(samples[k - 1], samples[random.below(k)]);
    for (std::size_t c = 0; c < kPointCounts.size(); ++c) {
      if (kPointCounts[c] > kHalf) continue;
      const std::vector<device::ArmObservation> train(samples.begin(), samples.begin() + kPointCounts[c]);
      for (std::size_t m = 0; m < kOneArmMethods.size(); ++m)
        if (const auto solved = solve_as(kOneArmMethods[m], train, model, laboratory->pivot_tip))
          splits[i][m][c] = {solved->value.gain, kDegreesPerRadian * solved->value.offset};
    }
  });
  const auto& truth = laboratory->truth.joints;
  Json arm;
  for (std::size_t m = 0; m < kOneArmMethods.size(); ++m) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      Curve gain{"gains of one arm", fmt::format("k{}, {}", j + 1, kOneArmMethods[m]), "points", "gain", {}};
      Curve offset{"offsets of one arm",
                   fmt::format("gamma{}, {}", j + 1, kOneArmMethods[m]),
                   "points",
                   "offset_deg",
                   {}};
      for (std::size_t c = 0; c < kPointCounts.size(); ++c) {
        if (kPointCounts[c] > kHalf) continue;
        std::vector<double> gains, offsets;
        for (const auto& split : splits) {
          gains.push_back(split[m][c].gain[j]);
          offsets.push_back(split[m][c].offset_deg[j]);
        }
        gain.points.push_back({static_cast<double>(kPointCounts[c]), summary_of(gains)});
        offset.points.push_back({static_cast<double>(kPointCounts[c]), summary_of(offsets)});
      }
      study.curves.push_back(std::move(gain));
      study.curves.push_back(std::move(offset));
    }
  }
  for (Eigen::Index j = 0; j < 3; ++j) {
    arm["true_gains"].push_back(truth.gain[j]);
    arm["true_offsets_deg"].push_back(kDegreesPerRadian * truth.offset[j]);
  }
  arm["splits"] = splits.size();
  study.values["one_arm"] = arm;
  return {};
}

}  // namespace palpate::evaluation::studies
