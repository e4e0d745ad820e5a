// The paper's Figure 10: does the calibration find its way from encoders that were zeroed in odd positions?
//
// The encoders' zeros are moved by up to 45 degrees: the paper's four combinations of right and obtuse second
// and third joints, then its extreme places of the workspace. Every solve begins at gains 1 and offsets 0.
// Each laboratory is reset in all eight ways, so that the ways are compared on the same truth, poses and
// noise.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/arm_methods.h"
#include "palpate/evaluation/studies/study.h"

namespace palpate::evaluation::studies {
namespace {

struct Reset {
  const char* name;
  Vector3 zero_deg;
};
const std::array<Reset, 8> kResets{{{"both right", {0.0, 0.0, 0.0}},
                                    {"second obtuse", {0.0, 45.0, 0.0}},
                                    {"third obtuse", {0.0, 0.0, 45.0}},
                                    {"both obtuse", {0.0, 45.0, 45.0}},
                                    {"top", {0.0, 45.0, -45.0}},
                                    {"bottom", {0.0, -45.0, -45.0}},
                                    {"left", {-45.0, 0.0, 0.0}},
                                    {"right", {45.0, 0.0, 0.0}}}};
constexpr std::array kResetCounts{15, 30, 70};
constexpr int kMostOfReset = 70;
constexpr std::size_t kRunsPerReset = kResets.size();  // a run is one reset of one laboratory
constexpr std::array kResetMethods{kAlternating, kEq7, kJoint};

struct Cell {  // of one repeat: one place of the table
  double held_out_mm = kNoValue, truth_mm = kNoValue;
};
using Table =
    std::array<std::array<std::array<Cell, kResetCounts.size()>, kResetMethods.size()>, kResets.size()>;

Expected<Table> try_resets(const StudyOptions& options, std::size_t number) {
  LaboratorySettings settings;
  settings.samples = kMostOfReset;
  settings.judged = 100;
  const auto recorded =
      record_laboratory(options.world, repeat_seed(options.seed, "study/reset", number), settings);
  if (!recorded) return tl::unexpected(recorded.error());
  const auto model = nominal_model(options.world);
  Table table;
  for (std::size_t r = 0; r < kResets.size(); ++r) {
    const auto laboratory = with_reset(*recorded, options.world, kResets[r].zero_deg / kDegreesPerRadian);
    for (std::size_t c = 0; c < kResetCounts.size(); ++c) {
      const std::vector<device::ArmObservation> train(laboratory.samples.begin(),
                                                      laboratory.samples.begin() + kResetCounts[c]);
      for (std::size_t m = 0; m < kResetMethods.size(); ++m) {
        const auto solved = solve_as(kResetMethods[m], train, model, laboratory.pivot_tip);
        if (!solved) continue;
        const auto errors = errors_to_truth(solved->value, laboratory);
        table[r][m][c] = {
            mm_from_metres(mean_norm(calibration::arm_errors(solved->value, laboratory.unused))),
            mm_from_metres(std::accumulate(errors.begin(), errors.end(), 0.0) /
                           static_cast<double>(errors.size()))};
      }
    }
  }
  return table;
}

}  // namespace

Expected<StudyResult> study_reset(const StudyOptions& options) {
  const auto runs = static_cast<std::size_t>(options.runs);
  std::vector<Expected<Table>> slots((runs + kRunsPerReset - 1) / kRunsPerReset);
  repeat(slots.size(), options.repeats, [&](std::size_t i) { slots[i] = try_resets(options, i); });
  for (const auto& slot : slots)
    if (!slot) return tl::unexpected(slot.error());
  StudyResult study;
  study.name = "reset";
  Json rows = Json::array();
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (std::size_t r = 0; r < kResets.size(); ++r) {
    Json row{{"reset", kResets[r].name},
             {"zero_deg", {kResets[r].zero_deg[0], kResets[r].zero_deg[1], kResets[r].zero_deg[2]}}};
    std::string line = fmt::format("zeroed {:14}", kResets[r].name);
    for (std::size_t m = 0; m < kResetMethods.size(); ++m) {
      Curve held_out{
          figure_of("held-out error", kResetMethods[m]), kResets[r].name, "points", "error_mm", {}};
      Curve truth{figure_of("error to truth", kResetMethods[m]), kResets[r].name, "points", "error_mm", {}};
      for (std::size_t c = 0; c < kResetCounts.size(); ++c) {
        std::vector<double> a, b;
        for (const auto& slot : slots) {
          a.push_back((*slot)[r][m][c].held_out_mm);
          b.push_back((*slot)[r][m][c].truth_mm);
        }
        held_out.points.push_back({static_cast<double>(kResetCounts[c]), summary_of(a)});
        truth.points.push_back({static_cast<double>(kResetCounts[c]), summary_of(b)});
      }
      const double mean = held_out.points.back().y.mean;
      row[std::string(kResetMethods[m])] = std::isfinite(mean) ? Json(mean) : Json(nullptr);
      line += fmt::format("  {} {:.3f} mm", kResetMethods[m], mean);
      if (kResetMethods[m] == kJoint) {
        least = std::min(least, mean);
        most = std::max(most, mean);
      }
      study.curves.push_back(std::move(held_out));
      study.curves.push_back(std::move(truth));
    }
    rows.push_back(row);
    study.lines.push_back(line);
  }
  study.values["laboratories"] = slots.size();
  study.values["at_70_points"] = rows;
  study.values["ours_spread"] = most / least - 1.0;
  study.lines.push_back(
      fmt::format("ours: largest mean {:.1f} % above the smallest", 100.0 * (most / least - 1.0)));
  return study;
}

}  // namespace palpate::evaluation::studies
