// The paper's Figures 4 and 5 with the paper's sphere fit and ours side by side.
#include "palpate/evaluation/studies/internal/pivot_study.h"

#include <array>
#include <cmath>
#include <limits>

#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/paper_values.h"
#include "palpate/evaluation/studies/study.h"

namespace palpate::evaluation::studies {
namespace {

struct Method {
  std::string_view label;
  calibration::PivotMethod method;
  bool with_motion;
};
constexpr std::array<Method, 3> kStill{{{"paper: sphere fit", calibration::PivotMethod::sphere, false},
                                        {"ours: algebraic", calibration::PivotMethod::algebraic, false},
                                        {"ours: robust", calibration::PivotMethod::robust, false}}};
constexpr std::array<Method, 4> kMoving{
    {kStill[0],
     kStill[1],
     kStill[2],
     {"ours: with the arm's reading", calibration::PivotMethod::algebraic, true}}};

struct Setting {
  std::string_view name;  // as in curves
  Coverage coverage;
  TipMotion motion;
  bool biased = true;  // the tracker's smooth bias is on
};
constexpr std::array<Setting, 4> kMarkerSettings{
    {{"full sphere", Coverage::full_sphere, TipMotion::random},
     {"quarter sphere", Coverage::quarter_sphere, TipMotion::random},
     {"full sphere, white noise", Coverage::full_sphere, TipMotion::random, false},
     {"quarter sphere, white noise", Coverage::quarter_sphere, TipMotion::random, false}}};
constexpr std::array<Setting, 3> kTipSettings{
    {{"full sphere", Coverage::full_sphere, TipMotion::random},
     {"quarter sphere", Coverage::quarter_sphere, TipMotion::random},
     {"quarter sphere, dragged", Coverage::quarter_sphere, TipMotion::dragged}}};

struct Errors {
  double centre_mm = kNoValue, tip_mm = kNoValue;
};

using Levels = std::vector<std::pair<double, SwingErrors>>;  // what the axis shows, and what it means

// Errors of each method at each level of each setting, for one run.
template <typename Settings, typename Methods>
std::vector<Errors> try_methods(const StudyOptions& options, const Settings& settings, const Methods& methods,
                                const Levels& levels, std::string_view purpose, std::size_t run) {
  std::vector<Errors> errors;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    SwingSettings swing_settings;
    swing_settings.coverage = settings[s].coverage;
    swing_settings.motion = settings[s].motion;
    swing_settings.bias_share = settings[s].biased ? bias_share_of(options.world) : 0.0;
    // Every level sees the same poses and the same chance, larger or smaller.
    const SwingDraw draw(options.world, swing_settings,
                         repeat_seed(options.seed, purpose, run * settings.size() + s));
    for (const auto& level : levels) {
      const auto swung = draw.with(level.second);
      for (const auto& method : methods) {
        calibration::PivotCalibrationOptions pivot;
        pivot.method = method.method;
        pivot.with_motion = method.with_motion;
        const auto estimate = calibration::calibrate_pivot(swung.poses, pivot);
        Errors e;
        if (estimate) {
          // With the tip's motion subtracted the pivot is the mean place of the tip, without it the place
          // about which it moves.
          const Vector3 centre = method.with_motion ? swung.mean_place : Vector3(Vector3::Zero());
          e.centre_mm = mm_from_metres((estimate->value.segments[0].pivot - centre).norm());
          e.tip_mm = mm_from_metres((estimate->value.tip - options.world.tip_marker.tip).norm());
        }
        errors.push_back(e);
      }
    }
  }
  return errors;
}

template <typename Settings, typename Methods>
std::vector<Curve> pivot_curves(const StudyOptions& options, const Settings& settings, const Methods& methods,
                                const Levels& levels, std::string_view purpose, const std::string& x_name) {
  std::vector<std::vector<Errors>> slots(static_cast<std::size_t>(options.runs));
  repeat(slots.size(), options.repeats, [&](std::size_t run) {
    slots[run] = try_methods(options, settings, methods, levels, purpose, run);
  });
  std::vector<Curve> curves;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      Curve centre{
          figure_of("centre", settings[s].name), std::string(methods[m].label), x_name, "error_mm", {}};
      Curve tip{figure_of("tip", settings[s].name), std::string(methods[m].label), x_name, "error_mm", {}};
      for (std::size_t level = 0; level < levels.size(); ++level) {
        const std::size_t at = (s * levels.size() + level) * methods.size() + m;
        std::vector<double> c, t;
        for (const auto& slot : slots) {
          c.push_back(slot[at].centre_mm);
          t.push_back(slot[at].tip_mm);
        }
        centre.points.push_back({levels[level].first, summary_of(c)});
        tip.points.push_back({levels[level].first, summary_of(t)});
      }
      curves.push_back(std::move(centre));
      curves.push_back(std::move(tip));
    }
  }
  return curves;
}

// Mean errors at one level, for NAME.json and for a person.
template <typename Settings, typename Methods>
void add_level(StudyResult& study, const Settings& settings, const Methods& methods, double level,
               const std::string& x_name) {
  for (const auto& setting : settings) {
    std::string line = fmt::format("{} {:.1f} mm, {}:", x_name, level, setting.name);
    Json by_method;
    for (const auto& method : methods) {
      Json both;
      for (const char* what : {"centre", "tip"}) {
        for (const auto& point :
             curve_named(study.curves, figure_of(what, setting.name), method.label).points)
          if (std::abs(point.x - level) < 1e-9) both[what] = point.y.mean;
      }
      if (both.is_null()) continue;
      line += fmt::format("  {} centre {:.3f} tip {:.3f} mm", method.label,
                          both["centre"].template get<double>(), both["tip"].template get<double>());
      by_method[std::string(method.label)] = both;
    }
    study.values[fmt::format("at_{:.1f}_mm", level)][std::string(setting.name)] = by_method;
    study.lines.push_back(line);
  }
}

Levels marker_levels() {
  Levels levels;
  for (int i = 0; i <= 10; ++i) levels.push_back({0.1 * i, {metres_from_mm(0.1 * i), 0.0}});
  return levels;
}

Levels tip_levels() {
  Levels levels;
  for (int i = 0; i <= 6; ++i)
    levels.push_back({0.5 * i, {metres_from_mm(paper::kTrackerRms_mm), metres_from_mm(0.5 * i)}});
  return levels;
}

}  // namespace

Expected<StudyResult> study_marker_noise(const StudyOptions& options) {
  StudyResult study;
  study.name = "marker-noise";
  study.curves =
      pivot_curves(options, kMarkerSettings, kStill, marker_levels(), "study/marker-noise", "led_rms_mm");
  study.values["paper"] = {{"full_sphere_centre_below_mm", paper::kFullSphere_mm},
                           {"quarter_sphere_centre_up_to_mm", paper::kQuarterSphere_mm},
                           {"at_tracker_rms_mm", paper::kTrackerRms_mm},
                           {"source", "section 4.2.2, Figure 4"}};
  add_level(study, kMarkerSettings, kStill, paper::kTrackerRms_mm, "tracker");
  for (const auto& setting : kMarkerSettings)
    study.page["sphere_centre_mm"][std::string(setting.name)] = mean_at(
        curve_named(study.curves, figure_of("centre", setting.name), kStill[0].label), paper::kTrackerRms_mm);
  return study;
}

Expected<StudyResult> study_tip_noise(const StudyOptions& options) {
  StudyResult study;
  study.name = "tip-noise";
  study.curves = pivot_curves(options, kTipSettings, kMoving, tip_levels(), "study/tip-noise", "tip_rms_mm");
  study.values["paper"] = {{"tip_moves_mm", {paper::kTipMotionLow_mm, paper::kTipMotionHigh_mm}},
                           {"global_error_below_mm", paper::kPivotGlobal_mm},
                           {"source", "section 4.2.2, Figure 5"}};
  for (const double level : {paper::kTipMotionLow_mm, paper::kTipMotionHigh_mm})
    add_level(study, kTipSettings, kMoving, level, "tip motion");
  for (const auto& setting : kTipSettings) {
    const auto& curve = curve_named(study.curves, figure_of("centre", setting.name), kMoving[0].label);
    study.page["sphere_centre_mm"][std::string(setting.name)] = {
        {"still", mean_at(curve, 0.0)}, {"moving", mean_at(curve, paper::kTipMotionLow_mm)}};
  }
  return study;
}

}  // namespace palpate::evaluation::studies
