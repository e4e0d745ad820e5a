// What wild marker poses do to the calibration: the same recordings with and without 5 % of the poses thrown
// 10 mm to one side, as reflections and hidden LEDs do it.
#include <array>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/points_study.h"
#include "palpate/math/random_vector.h"

namespace palpate::evaluation::studies {
namespace {

constexpr std::array kOutlierCounts{30, kHalf};
constexpr int kOneIn = 20;
constexpr double kThrow = 0.010;  // m
// The ratio needs fewer laboratories than a bound: both sides of it are of the same ones.
constexpr std::size_t kRunsPerOutlierLaboratory = 5;

struct OutlierOutcome {
  double clean_mm = kNoValue, wild_mm = kNoValue;  // rms error to truth
};
using OutlierRun = std::array<OutlierOutcome, kOutlierCounts.size()>;

Expected<OutlierRun> try_outliers(const StudyOptions& options, const sim::config::WorldFile& world,
                                  std::size_t number) {
  const std::uint64_t seed = repeat_seed(options.seed, "study/outliers", number);
  const auto laboratory =
      record_laboratory(world, seed, {.samples = kHalf, .unused = 0, .judged = 100, .swing = 0});
  if (!laboratory) return tl::unexpected(laboratory.error());
  const auto model = nominal_model(world);
  Random random(seed, "wild poses");
  OutlierRun run;
  for (std::size_t c = 0; c < kOutlierCounts.size(); ++c) {
    std::vector<device::ArmObservation> samples(laboratory->samples.begin(),
                                                laboratory->samples.begin() + kOutlierCounts[c]);
    const auto error_mm = [&] {
      const auto solved = solve_as(kJoint, samples, model, laboratory->pivot_tip);
      return solved ? mm_from_metres(summary_of(errors_to_truth(solved->value, *laboratory)).rms) : kNoValue;
    };
    run[c].clean_mm = error_mm();
    for (std::size_t i = random.below(kOneIn); i < samples.size(); i += kOneIn)
      samples[i].marker->translation += kThrow * normal3(random).normalized();
    run[c].wild_mm = error_mm();
  }
  return run;
}

}  // namespace

Expected<void> add_outliers(StudyResult& study, const StudyOptions& options) {
  const std::size_t laboratories =
      (static_cast<std::size_t>(options.runs) + kRunsPerOutlierLaboratory - 1) / kRunsPerOutlierLaboratory;
  const std::array worlds{white_world(options.world), options.world};
  constexpr std::array<std::string_view, 2> kWorldNames{"white", "reference"};
  std::vector<Expected<OutlierRun>> slots(2 * laboratories);
  repeat(slots.size(), options.repeats, [&](std::size_t i) {
    slots[i] = try_outliers(options, worlds[i / laboratories], i % laboratories);
  });
  Json rows = Json::array();
  for (std::size_t w = 0; w < worlds.size(); ++w)
    for (std::size_t c = 0; c < kOutlierCounts.size(); ++c) {
      std::vector<double> clean, wild;
      for (std::size_t i = 0; i < laboratories; ++i) {
        const auto& run = slots[w * laboratories + i];
        if (!run) return tl::unexpected(run.error());
        clean.push_back((*run)[c].clean_mm);
        wild.push_back((*run)[c].wild_mm);
      }
      const auto without = summary_of(clean), with = summary_of(wild);
      const double rise = with.rms / without.rms - 1.0;
      rows.push_back({{"world", kWorldNames[w]},
                      {"points", kOutlierCounts[c]},
                      {"clean_rms_mm", number_or_null(without.rms)},
                      {"outliers_rms_mm", number_or_null(with.rms)},
                      {"rise", number_or_null(rise)},
                      {"refused", with.refused},
                      {"laboratories", laboratories}});
      study.lines.push_back(fmt::format(
          "{} world, {} points: 5 % outliers of 10 mm change the error by {:+.1f} %, {:.4f} to {:.4f} mm rms "
          "({} laboratories)",
          kWorldNames[w], kOutlierCounts[c], 100.0 * rise, without.rms, with.rms, laboratories));
    }
  study.values["outliers"] = rows;
  return {};
}

}  // namespace palpate::evaluation::studies
