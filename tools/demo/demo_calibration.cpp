// The demo report's calibration part: arm, stylus tip, camera and surfaces.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace {

struct Method {
  const char* name;  // in raw/arm_errors.csv
  const char* key;   // in summary.json
  const char* true_tip_key;
  const char* label;
  figures::Tone tone;
};
constexpr std::array<Method, 5> kMethods{{
    {"uncorrected", "arm/uncorrected_error_to_truth_mm", "", "uncorrected", figures::Tone::muted},
    {"one-pass", "arm/one_pass_error_to_truth_mm", "arm/true_tip_one_pass_error_to_truth_mm",
     "paper: one pass", figures::Tone::fourth},
    {"alternating", "arm/alternating_error_to_truth_mm", "arm/true_tip_alternating_error_to_truth_mm",
     "paper: alternating", figures::Tone::third},
    {"eq7", "arm/eq7_error_to_truth_mm", "arm/true_tip_eq7_error_to_truth_mm", "paper: equations 7, 8",
     figures::Tone::rival},
    {"joint", "arm/error_to_truth_mean_mm", "arm/true_tip_joint_error_to_truth_mm", "ours: joint with tip",
     figures::Tone::ours},
}};

// Rows of `table` whose text in `key` is `value`, one column of them.
std::vector<double> where(const CsvTable& table, std::string_view key, std::string_view value,
                          std::string_view wanted) {
  std::vector<double> found;
  const auto at = table.find(key), column_at = table.find(wanted);
  if (!at || !column_at) return found;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.text[i][*at] == value) found.push_back(table.rows[i][*column_at]);
  }
  return found;
}

void draw_errors_by_method(evaluation::report::Report& page, const figures::PlayFolder& data) {
  figures::Plot bars{.title = "Mean error of the tip against the truth",
                     .x_label = "mm",
                     .sideways = true,
                     .height_px = 330};
  figures::Series measured{.name = "tip offset from the pivot calibration",
                           .mark = figures::Mark::bars,
                           .tone = figures::Tone::ours};
  figures::Series given{
      .name = "true tip offset given", .mark = figures::Mark::bars, .tone = figures::Tone::muted};
  for (const auto& method : kMethods) {
    const auto value = data.number(method.key);
    if (!value) continue;
    measured.labels.push_back(method.label);
    measured.y.push_back(*value);
    measured.written.push_back(figures::shown(value, ""));
    if (const auto perfect = data.number(method.true_tip_key)) {
      given.labels.push_back(method.label);
      given.y.push_back(*perfect);
      given.written.push_back(figures::shown(perfect, ""));
    }
  }
  bars.series.push_back(measured);
  if (!given.y.empty()) bars.series.push_back(given);
  if (const auto bar = arm_bar_mm(data)) {
    bars.levels.push_back({.at = *bar,
                           .label = "bar " + figures::shown(bar, "mm"),
                           .tone = figures::Tone::good,
                           .upright = true});
  }
  std::vector<figures::Plot> plots{bars};
  if (const CsvTable* errors = data.raw("arm_errors.csv")) {
    figures::Plot shares{.title = "Share of poses below an error",
                         .x_label = "error, mm",
                         .y_label = "share",
                         .log_x = true,
                         .height_px = 330};
    for (const auto& method : kMethods) {
      auto values = where(*errors, "method", method.name, "error_mm");
      if (!values.empty())
        shares.series.push_back(figures::cumulative(method.label, std::move(values), method.tone));
    }
    if (!shares.series.empty()) plots.push_back(shares);
  }
  page.plots(plots);
}

// How the predicted error falls with the poses, shown where they help most and chosen by the person.
void draw_guidance(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const CsvTable* table = data.raw("arm_guidance.csv");
  if (table == nullptr || !figures::has_columns(*table, {"poses", "guided_mm", "chosen_mm"})) return;
  const auto poses = figures::column(*table, "poses"), guided = figures::column(*table, "guided_mm"),
             chosen = figures::column(*table, "chosen_mm");
  figures::Plot plot{.title = "Predicted error of the tip against the number of poses",
                     .x_label = "poses",
                     .y_label = "mm rms over the workspace",
                     .log_y = true,
                     .height_px = 300};
  figures::Series ours{.name = "shown where the next pose helps most",
                       .mark = figures::Mark::line,
                       .tone = figures::Tone::ours},
      theirs{.name = "chosen by the person (the samples held out)",
             .mark = figures::Mark::line,
             .tone = figures::Tone::muted};
  ours.x = theirs.x = poses;
  ours.y = guided;
  theirs.y = chosen;
  plot.series = {ours, theirs};
  plot.caption =
      "While the poses are collected, the arm is solved again and again, and the person is shown where to "
      "hold the stylus next.";
  // As many poses of the person's own choice as are as good as thirty shown ones.
  const auto thirty = std::find(poses.begin(), poses.end(), 30.0);
  if (thirty != poses.end()) {
    const double there = guided[static_cast<std::size_t>(thirty - poses.begin())];
    const auto as_good =
        std::find_if(chosen.begin(), chosen.end(), [&](double error) { return error <= there; });
    plot.caption +=
        as_good == chosen.end()
            ? fmt::format(" Thirty of them are worth more than {:.0f} of the person's own choice.",
                          poses.back())
            : fmt::format(" Thirty of them are worth {:.0f} of the person's own choice.",
                          poses[static_cast<std::size_t>(as_good - chosen.begin())]);
  }
  page.plots({plot});
}

// The errors as strokes in space, before and after.
void draw_error_cloud(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const CsvTable* errors = data.raw("arm_errors.csv");
  if (errors == nullptr ||
      !figures::has_columns(*errors, {"x_mm", "y_mm", "z_mm", "dx_mm", "dy_mm", "dz_mm"}))
    return;
  constexpr double magnified = 10.0;
  constexpr std::size_t most = 250;
  const auto strokes = [&](const char* method, std::string name, figures::Tone tone) {
    std::array<std::vector<double>, 6> c;
    const std::array<const char*, 6> names{"x_mm", "y_mm", "z_mm", "dx_mm", "dy_mm", "dz_mm"};
    for (std::size_t k = 0; k < 6; ++k) c[k] = where(*errors, "method", method, names[k]);
    figures::CloudGroup group{
        .name = std::move(name), .tone = tone, .points = {}, .joined = true, .size_px = 1.6};
    for (std::size_t i = 0; i < std::min(c[0].size(), most); ++i) {
      group.points.push_back({c[0][i], c[1][i], c[2][i]});
      group.points.push_back(
          {c[0][i] + magnified * c[3][i], c[1][i] + magnified * c[4][i], c[2][i] + magnified * c[5][i]});
      group.points.push_back({NAN, NAN, NAN});
    }
    return group;
  };
  page.cloud(
      {.title = "Errors across the workspace, drawn ten times as long as they are (turn it)",
       .unit = "mm",
       .groups = {strokes("uncorrected", "before", figures::Tone::muted),
                  strokes("eq7", "paper: equations 7, 8", figures::Tone::rival),
                  strokes("joint", "ours", figures::Tone::ours)},
       .caption =
           "Each stroke begins at a true place of the tip and points to where the calibrated arm believes "
           "it is. Before the calibration the strokes follow the joints; with a slightly wrong tip they "
           "follow the marker; with the tip solved for, little is left."});
}

}  // namespace

std::optional<double> arm_bar_mm(const figures::PlayFolder& data) {
  std::optional<double> best;
  for (const char* key :
       {"arm/one_pass_error_to_truth_mm", "arm/alternating_error_to_truth_mm", "arm/eq7_error_to_truth_mm"}) {
    const auto value = data.number(key);
    if (value && (!best || *value < *best)) best = value;
  }
  if (!best) return std::nullopt;
  return std::min(0.3, *best / 2);
}

void add_arm_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto ours = data.number("arm/error_to_truth_mean_mm");
  if (!ours) return;
  page.section("The arm learns where it is", "arm");
  page.paragraph(
      "The arm reports joint angles with unknown gains and offsets, and does not know where it stands. The "
      "optical tracker sees a marker on the stylus, but not the tip. From measured poses one solve finds "
      "gains, offsets, the arm's place in the world and the tip's offset in the marker. The last one "
      "matters: a tip offset that is a little wrong turns with the marker, and no correction of joints can "
      "absorb that. The methods of the 2006 paper take the tip offset from the pivot calibration as it is, "
      "and stay where it leaves them.");
  std::vector<figures::Figure> figures;
  const auto bar = arm_bar_mm(data);
  figures.push_back({"Error to truth, 1000 poses never used", figures::shown(ours, "mm"),
                     bar ? "at most " + figures::shown(bar, "mm") : "",
                     bar ? figures::at_most(*ours, *bar) : figures::Verdict::none});
  if (const auto before = data.number("arm/uncorrected_error_to_truth_mm"))
    figures.push_back({"... before the calibration", figures::shown(before, "mm"), "same poses, same measure",
                       figures::Verdict::none});
  if (const auto held = data.number("arm/heldout_mean_mm"), before = data.number("arm/uncorrected_mean_mm");
      held && before) {
    figures.push_back({"Distance to what the tracker saw, samples held out",
                       figures::shown(before, "mm") + " \u2192 " + figures::shown(held, "mm"),
                       "before \u2192 after; another measure, as one has it without the truth: the tracker's "
                       "own noise is in it",
                       figures::Verdict::none});
  }
  if (const auto turned = data.number("arm/stylus_error_to_truth_deg")) {
    figures.push_back({"Stylus turned away from the truth", figures::shown(turned, "\u00b0"),
                       "gimbal corrected from the same poses; samples held out", figures::Verdict::none});
  }
  if (const auto samples = data.number("arm/samples")) {
    figures.push_back({"Poses used", fmt::format("{:.0f}", *samples), "", figures::Verdict::none});
  }
  page.figures(figures);
  draw_errors_by_method(page, data);
  if (data.number("arm/true_tip_eq7_error_to_truth_mm")) {
    page.aside(
        "Grey: the same methods with the true tip offset handed to them, which nobody has in practice. The "
        "gap between each pair is what a wrong tip offset costs.");
  }
  draw_guidance(page, data);
  draw_error_cloud(page, data);
}

void add_tip_and_camera_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  std::vector<figures::Figure> figures;
  const auto add = [&](std::string_view path, std::string label, std::string_view unit, std::string note) {
    if (const auto value = data.number(path))
      figures.push_back(
          {std::move(label), figures::shown(value, unit), std::move(note), figures::Verdict::none});
  };
  add("pivot/error_to_truth_mm", "Stylus tip in its marker, error", "mm",
      "the arm holds the tip, a hand swings the stylus");
  add("hand_eye/error_to_truth_mm", "Camera in its marker, error", "mm",
      "from head motion in front of a board");
  add("hand_eye/rotation_error_deg", "Camera in its marker, turned by", "\u00b0", "");
  add("camera/rms_px", "Lens, residual at the board's corners", "px", "");
  if (figures.empty()) return;
  page.section("Tip, lens and camera", "camera");
  page.paragraph(
      "Three smaller calibrations stand between the arm and the picture: where the tip sits in the marker on "
      "the stylus, how the lens bends the picture, and where the camera sits in the marker on the head.");
  page.figures(figures);
  const CsvTable* pivot = data.raw("pivot.csv");
  if (pivot != nullptr && figures::has_columns(*pivot, {"x_mm", "y_mm", "z_mm"})) {
    figures::CloudGroup markers{.name = "marker while the tip is held",
                                .tone = figures::Tone::ours,
                                .points = {},
                                .joined = false,
                                .size_px = 2.2};
    const auto x = figures::column(*pivot, "x_mm"), y = figures::column(*pivot, "y_mm"),
               z = figures::column(*pivot, "z_mm");
    const std::size_t step = std::max<std::size_t>(1, x.size() / 800);
    for (std::size_t i = 0; i < x.size(); i += step) markers.points.push_back({x[i], y[i], z[i]});
    page.cloud(
        {.title = "Pivot calibration: the marker's path (turn it)",
         .unit = "mm",
         .groups = {markers},
         .height_px = 340,
         .caption =
             "The marker swings on a sphere around the held tip. The hand also pulls, so the tip gives way "
             "by a millimetre or two; this is why a pivot calibration alone is not enough."});
  }
  const CsvTable* lens = data.raw("lens.csv");
  if (lens != nullptr && lens->has("which")) {
    std::vector<std::vector<std::string>> rows;
    const auto which = *lens->find("which");
    for (std::size_t c = 0; c < lens->header.size(); ++c) {
      if (c == which) continue;
      std::string estimated, truth;
      for (std::size_t i = 0; i < lens->rows.size(); ++i) {
        (lens->text[i][which] == "true" ? truth : estimated) = figures::shown(
            lens->rows[i][c], "",
            lens->header[c].size() == 2 && lens->header[c][0] != 'f' && lens->header[c][0] != 'c' ? 5 : 6);
      }
      rows.push_back({lens->header[c], estimated, truth});
    }
    page.table({"Lens", "estimated", "true"}, rows);
  }
}

}  // namespace palpate::tools::demo
