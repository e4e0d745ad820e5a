#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>

#include "palpate/calibration/session/sample_csv.h"
#include "palpate/calibration/session/stream_tables.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/marker_names.h"
#include "tools/commands/command.h"
#include "tools/commands/sample_kinds.h"
#include "tools/commands/sample_source.h"

namespace palpate::tools::commands {
namespace {

namespace session = calibration::session;

struct SampledKind {
  SampleArguments source;
  session::HoldSettings holds;
  std::string marker, reference, label;
  std::vector<std::string> markers;
  std::vector<double> tip_mm;
  bool continuous = false, by_themselves = false;
};

// The tip in a marker: as it is said, else as the rig has it.
std::optional<Vector3> given_tip(const SampledKind& options, const rig::Rig& rig, device::MarkerId marker) {
  if (!options.tip_mm.empty())
    return Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMillimetresPerMetre;
  const auto& pivot = marker == device::MarkerId::pointer ? rig.pointer_pivot : rig.tip_pivot;
  if (marker == device::MarkerId::camera_marker || !pivot) return std::nullopt;
  return pivot->tip_in_marker;
}

Json marker_counts(const TakenSamples& taken, device::MarkerId marker) {
  return {{"seen", session::seen_poses(taken.streams.marker_poses(marker)).size()},
          {"hidden", taken.streams.missed(marker)}};
}

SampleNeeds arm_and_tracker() { return {.arm = true, .tracker = true}; }

Expected<void> sample_arm_table(const SampledKind& options) {
  const auto rig = rig_of_samples(options.source);
  if (!rig) return tl::unexpected(rig.error());
  auto taken = take_samples(options.source, arm_and_tracker());
  if (!taken) return tl::unexpected(taken.error());
  const auto marker = device::MarkerId::tip_marker;
  if (const auto seen = sampled_poses(*taken, marker, ""); !seen) return tl::unexpected(seen.error());
  const auto poses = options.continuous ? taken->streams.poses(marker)
                                        : session::still_arm_poses(taken->streams, options.holds);
  if (poses.empty() && options.continuous)
    return refused("{}: arm and tracker were never heard at one time", taken->source);
  if (poses.empty())
    return refused(
        "{}: the stylus was never held still within {:g} mm for {:g} s; hold it in each pose, or take all "
        "that was "
        "seen with --continuous",
        taken->source, mm_from_metres(options.holds.still.place), options.holds.still.window_s);
  const auto tip = given_tip(options, *rig, marker);
  Json counts{{"rows", poses.size()},
              {"continuous", options.continuous},
              {"arm_readings", taken->streams.arm().size()},
              {"tip_marker", marker_counts(*taken, marker)}};
  return write_samples(
      options.source, "arm", *taken,
      {{"arm.csv", session::arm_csv(poses, tip.value_or(Vector3::Zero()), rig->nominal_arm), poses.size()}},
      counts,
      fmt::format("palpate calibrate arm --samples {}/arm.csv --arm MODEL --rig FILE",
                  one_line(options.source.out)));
}

// A label for each, NAME_1, NAME_2 ...
std::vector<std::string> touch_labels(const std::string& name, std::size_t count) {
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < count; ++i) labels.push_back(fmt::format("{}_{}", name, i + 1));
  return labels;
}

Expected<void> sample_touch_table(const SampledKind& options) {
  const auto rig = rig_of_samples(options.source);
  if (!rig) return tl::unexpected(rig.error());
  const auto marker = sampled_marker(options.marker);
  if (!marker) return tl::unexpected(marker.error());
  const auto tip = given_tip(options, *rig, *marker);
  if (!tip)
    return wrong_use(
        "the tip in {} is not known; --tip-mm X,Y,Z, or --rig FILE after calibrate pivot, is expected",
        options.marker);
  const bool keys = options.source.recording.empty() && !options.by_themselves;
  auto taken = take_samples(options.source, {.tracker = true, .keys = keys});
  if (!taken) return tl::unexpected(taken.error());
  const auto poses = sampled_poses(*taken, *marker, options.reference);
  if (!poses) return tl::unexpected(poses.error());
  auto holds = session::find_holds(*poses, options.holds);
  const std::size_t found = holds.size();
  if (keys) {
    std::size_t missed = 0;
    holds = session::holds_at(holds, taken->keys_s, missed);
    if (missed > 0)
      taken->warnings.push_back(fmt::format(
          "{} without a hold: the pointer was not still within 5 s of the key", counted(missed, "touch")));
  } else {
    taken->warnings.emplace_back(
        "touches are found by the pointer's being held still: one in the air, or put down, counts as well; "
        "look at "
        "the rows and take those out");
  }
  if (holds.empty() && keys && taken->keys_s.empty())
    return refused(
        "{}: Enter was never pressed; press it when the tip is there, or let holds be found with --found",
        taken->source);
  if (holds.empty())
    return refused("{}: {} was never held still within {:g} mm for {:g} s", taken->source, options.marker,
                   mm_from_metres(options.holds.still.place), options.holds.still.window_s);
  std::vector<session::HeldTouch> touches;
  for (const auto& hold : holds) touches.push_back(session::touch_of(hold, *tip));
  Json counts{{"touches", touches.size()},
              {"holds", found},
              {"keys", taken->keys_s.size()},
              {options.marker, marker_counts(*taken, *marker)}};
  return write_samples(
      options.source, "touches", *taken,
      {{"points.csv", session::touches_csv(touches, touch_labels(options.label, touches.size())),
        touches.size()}},
      counts,
      fmt::format(
          "palpate calibrate surface --points {}/points.csv --name NAME --rig FILE, or calibrate landmarks",
          one_line(options.source.out)));
}

Expected<void> sample_pivot_table(const SampledKind& options) {
  const auto marker = sampled_marker(options.marker);
  if (!marker) return tl::unexpected(marker.error());
  const auto rig = rig_of_samples(options.source);
  if (!rig) return tl::unexpected(rig.error());
  SampleNeeds needs{.arm = false, .tracker = true};
  auto taken = take_samples(options.source, needs);
  if (!taken) return tl::unexpected(taken.error());
  auto all = sampled_poses(*taken, *marker, options.reference);
  if (!all) return tl::unexpected(all.error());
  auto poses = session::seen_poses(*all);
  // A stylus in an arm is dragged by it; readings beside the poses show that.
  const bool with_arm = *marker == device::MarkerId::tip_marker && options.reference.empty() &&
                        !taken->streams.arm_readings().empty();
  if (with_arm) poses = taken->streams.poses(*marker);
  if (poses.empty()) return refused("{}: arm and tracker were never heard at one time", taken->source);
  auto segments = session::pivot_segments(poses);
  if (!segments) taken->warnings.push_back(segments.error().message);
  const std::vector<int> numbers = segments ? *segments : std::vector<int>{};
  const int rests = numbers.empty() ? 0 : *std::max_element(numbers.begin(), numbers.end());
  Json counts{
      {"rows", poses.size()}, {"segments", Json::array()}, {options.marker, marker_counts(*taken, *marker)}};
  for (int rest = 1; rest <= rests; ++rest) {
    const auto first = std::find(numbers.begin(), numbers.end(), rest);
    const auto last = std::find(numbers.rbegin(), numbers.rend(), rest);
    counts["segments"].push_back(
        {{"label", std::to_string(rest)},
         {"poses", std::count(numbers.begin(), numbers.end(), rest)},
         {"from_s", poses[static_cast<std::size_t>(first - numbers.begin())].time_s},
         {"to_s", poses[static_cast<std::size_t>(numbers.rend() - last) - 1].time_s}});
  }
  // No next command where the tip was found not to rest: it would refuse the table.
  const auto next = !segments
                        ? std::string()
                        : fmt::format("palpate calibrate pivot --poses {}/pivot.csv{}{} --rig FILE",
                                      one_line(options.source.out), rests > 0 ? " --segments segment" : "",
                                      *marker == device::MarkerId::pointer ? " --marker pointer" : "");
  return write_samples(
      options.source, "pivot", *taken,
      {{"pivot.csv", session::pivot_csv(poses, with_arm, numbers, rig->nominal_arm), poses.size()}}, counts,
      next);
}

// "pointer=a.csv": a marker and its file in the folder; "pointer" alone: pointer.csv.
Expected<std::pair<device::MarkerId, std::string>> marker_and_file(const std::string& text) {
  const auto equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const std::string file = equals == std::string::npos ? name + ".csv" : text.substr(equals + 1);
  const auto marker = sampled_marker(name);
  if (!marker) return tl::unexpected(marker.error());
  if (file.empty() || file.find('/') != std::string::npos || file == "." || file == "..")
    return wrong_use("--marker {}: the name of a file in the folder of --out is expected after '='",
                     excerpt(text));
  return std::pair(*marker, file);
}

Expected<void> sample_tool_tables(const SampledKind& options) {
  std::vector<std::pair<device::MarkerId, std::string>> wanted;
  std::set<std::string> files;
  for (const auto& text : options.markers) {
    const auto one = marker_and_file(text);
    if (!one) return tl::unexpected(one.error());
    if (!files.insert(one->second).second)
      return wrong_use("--marker {}: two markers in one file", excerpt(text));
    wanted.push_back(*one);
  }
  auto taken = take_samples(options.source, {.tracker = true});
  if (!taken) return tl::unexpected(taken.error());
  if (wanted.empty())
    for (const auto marker :
         {device::MarkerId::tip_marker, device::MarkerId::camera_marker, device::MarkerId::pointer})
      if (const std::string name = device::name_of_marker(marker);
          name != options.reference && !session::seen_poses(taken->streams.marker_poses(marker)).empty())
        wanted.emplace_back(marker, name + ".csv");
  if (wanted.empty()) return refused("{}: no marker was seen", taken->source);
  std::vector<SampleTable> tables;
  Json counts;
  for (const auto& [marker, file] : wanted) {
    const auto poses = sampled_poses(*taken, marker, options.reference);
    if (!poses) return tl::unexpected(poses.error());
    const auto seen = session::seen_poses(*poses);
    tables.push_back({file, session::marker_csv(seen), seen.size()});
    counts[device::name_of_marker(marker)] = marker_counts(*taken, marker);
  }
  if (!options.reference.empty()) counts["reference"] = options.reference;
  return write_samples(options.source, "tools", *taken, tables, counts, "");
}

void add_tip_option(CLI::App& command, SampledKind& options, const char* help) {
  command.add_option("--tip-mm", options.tip_mm, help)->delimiter(',')->expected(3)->type_name("X,Y,Z");
}

void add_reference_option(CLI::App& command, SampledKind& options) {
  command
      .add_option(
          "--reference", options.reference,
          "A marker on what is measured: all poses are seen from it, so that the tracker may be moved")
      ->type_name("MARKER");
}

}  // namespace

void add_sample_arm(CLI::App& sample) {
  auto options = std::make_shared<SampledKind>();
  auto* command = sample.add_subcommand(
      "arm", "Joint readings beside poses of the stylus' marker, a row for each pose held still: arm.csv");
  add_sample_options(*command, options->source, arm_and_tracker());
  add_still_options(*command, options->holds);
  command->add_flag("--continuous", options->continuous,
                    "Every frame of the tracker, the stylus moving freely");
  add_tip_option(*command, *options, "The tip in its marker, for its covariance; default: the rig's");
  on(command, [options] { return sample_arm_table(*options); });
}

void add_sample_touches(CLI::App& sample) {
  auto options = std::make_shared<SampledKind>();
  auto* command =
      sample.add_subcommand("touches", "Places that the pointer's tip was held on, averaged: points.csv");
  add_sample_options(*command, options->source, {.tracker = true});
  add_still_options(*command, options->holds);
  add_tip_option(*command, *options, "The pointer's tip in its marker; default: the rig's");
  add_reference_option(*command, *options);
  command->add_option("--marker", options->marker, "Whose tip it is")
      ->type_name("MARKER")
      ->default_val("pointer");
  command
      ->add_option("--label", options->label,
                   "The touches are called NAME_1, NAME_2 ...: table for a surface")
      ->type_name("NAME")
      ->default_val("touch");
  command->add_flag("--found", options->by_themselves,
                    "Devices: no key; every hold counts, as in a recording, also one in the air");
  on(command, [options] { return sample_touch_table(*options); });
}

void add_sample_pivot(CLI::App& sample) {
  auto options = std::make_shared<SampledKind>();
  auto* command = sample.add_subcommand(
      "pivot",
      "Poses of a marker that was swung about a resting tip, the rests found and numbered: pivot.csv");
  add_sample_options(*command, options->source, arm_and_tracker());
  add_reference_option(*command, *options);
  command->add_option("--marker", options->marker, "Which marker was swung")
      ->type_name("MARKER")
      ->default_val("tip_marker");
  on(command, [options] { return sample_pivot_table(*options); });
}

void add_sample_tools(CLI::App& sample) {
  auto options = std::make_shared<SampledKind>();
  auto* command = sample.add_subcommand(
      "tools", "Poses of several markers with their covariance, on one time base: a table each");
  add_sample_options(*command, options->source, {.tracker = true});
  add_reference_option(*command, *options);
  command
      ->add_option(
          "--marker", options->markers,
          "A marker and its file in the folder, as often as there are some; default: all that are seen")
      ->type_name("MARKER[=FILE]")
      ->allow_extra_args(false);
  on(command, [options] { return sample_tool_tables(*options); });
}

}  // namespace palpate::tools::commands
