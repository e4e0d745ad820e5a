#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/calibration/session/verification_session.h"
#include "palpate/core/file.h"
#include "palpate/core/progress.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/simulator.h"
#include "tools/commands/command.h"
#include "tools/commands/device_recording.h"
#include "tools/commands/guests.h"
#include "tools/commands/live_devices.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {
namespace {

namespace session = calibration::session;

struct VerifyOptions {
  std::string rig, world, json;
  std::uint64_t seed = 1, visit = 1;
  bool quick = false;
  LiveDevices devices;
};

// With a person at the devices. `exchange`: to the window; null where there is none.
Expected<session::VerificationRecord> observe_with(const VerifyOptions& options, const rig::Rig& rig,
                                                   const session::VerificationPlan& plan,
                                                   desktop::SessionExchange* exchange) {
  auto recorded = DeviceRecording::begin(options.devices.record, "verify", rig);
  if (!recorded) return tl::unexpected(recorded.error());
  auto opened = LiveSession::open(options.devices, rig, recorded->drivers(), exchange);
  if (!opened) return tl::unexpected(opened.error());
  LiveSession& live = **opened;
  session::VerificationHooks hooks;
  hooks.progress = [&live](std::size_t step, std::size_t steps, const std::string& name) {
    live.panel().begin_step(step, steps, name);
  };
  hooks.find_landmarks = session::landmark_finder();
  auto record = session::observe_rig(live.context(), rig, plan, hooks);
  live.end();
  opened->reset();
  if (auto whole = recorded->finish(rig); !whole && record) return tl::unexpected(whole.error());
  return record;
}

Expected<session::VerificationRecord> observe_live(const VerifyOptions& options, const rig::Rig& rig,
                                                   const session::VerificationPlan& plan) {
  session::VerificationRecord record;
  const auto done = run_session(options.devices, "Palpate verification",
                                [&](desktop::SessionExchange* exchange) -> Expected<void> {
                                  auto seen = observe_with(options, rig, plan, exchange);
                                  if (!seen) return tl::unexpected(seen.error());
                                  record = std::move(*seen);
                                  return {};
                                });
  if (!done) return tl::unexpected(done.error());
  return record;
}

// By itself, in the simulated laboratory of a world file.
Expected<session::VerificationRecord> observe_simulated(const VerifyOptions& options, const rig::Rig& rig,
                                                        const session::VerificationPlan& plan) {
  sim::config::WorldFile file = sim::config::reference_world();
  if (!options.world.empty()) {
    auto read = sim::config::read_world(options.world, known_applications());
    if (!read) return tl::unexpected(read.error());
    file = *read;
  }
  sim::CameraRenderer renderer;
  sim::Simulator world(file, options.seed, options.visit);
  world.set_renderer(
      [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) { renderer.render(view, rgb); });
  Progress progress({{"verifying", 5.0}});
  session::VerificationHooks hooks;
  hooks.progress = [&progress](std::size_t step, std::size_t steps, const std::string& name) {
    progress.begin(0);
    progress.say(name);
    progress.update(static_cast<double>(step) / static_cast<double>(steps));
  };
  hooks.find_landmarks = session::landmark_finder();
  auto recorded = DeviceRecording::begin(options.devices.record, "verify", rig, true);
  if (!recorded) return tl::unexpected(recorded.error());
  auto record = session::observe_rig(recorded->recorded(evaluation::laboratory_of(world)), rig, plan, hooks);
  progress.finish();
  if (auto whole = recorded->finish(rig); !whole && record) return tl::unexpected(whole.error());
  return record;
}

std::string key_of(const calibration::RigFigure& figure) {
  std::string key = figure.name + "_" + figure.unit;
  for (char& c : key)
    if (c == ' ') c = '_';
  return key;
}

rig::VerificationRecord kept(const VerifyOptions& options, const calibration::Verification& found,
                             const std::string& date) {
  rig::VerificationRecord record;
  record.date = date;
  record.form = options.quick ? "quick" : "full";
  record.holds = found.holds();
  for (const auto& change : found.changes) record.changed.emplace_back(calibration::name_of(change.change));
  for (const auto& f : found.figures)
    record.figures.push_back({key_of(f), f.scale * f.error, f.scale * f.low, f.scale * f.high,
                              f.scale * f.promised_high, f.scale * f.seen, f.scale * f.seen_high});
  return record;
}

Json json_of(const calibration::FoundChange& change) {
  Json json;
  json["what"] = calibration::name_of(change.change);
  json["words"] = calibration::change_words(change);
  json["amount_si"] = json_list(change.amount);
  json["std_si"] = json_list(standard_deviations(change.covariance));
  json["probability_by_chance"] = change.probability;
  json["evidence"] = change.evidence;
  return json;
}

Json json_of(const rig::VerificationRecord& record, const calibration::Verification& found,
             const session::VerificationRecord& seen) {
  Json json;
  json["holds"] = record.holds;
  json["form"] = record.form;
  json["date"] = record.date;
  json["seconds"] = seen.seconds;
  json["changes"] = Json::array();
  for (const auto& change : found.changes) json["changes"].push_back(json_of(change));
  json["explained"] = found.explained;
  json["misfit"] = found.misfit;
  json["freedoms"] = found.freedoms;
  json["farthest"] = {{"observation", found.farthest}, {"standard_deviations", found.farthest_sds}};
  for (std::size_t i = 0; i < record.figures.size(); ++i) {
    const auto& f = record.figures[i];
    const auto& figure = found.figures[i];
    Json& entry = json["figures"][f.name];
    entry["error"] = f.error;
    entry["interval_95"] = {f.low, f.high};
    entry["promised"] = figure.scale * figure.promised;
    entry["promised_95"] = f.promised;
    if (figure.seen_high > 0.0) entry["seen"] = f.seen, entry["seen_95"] = f.seen_most;
  }
  if (seen.board)
    json["board"] = {{"views", seen.board->views},
                     {"rms_px", seen.board->rms_px},
                     {"promised_px", seen.board->promised_px}};
  if (!seen.no_delay.empty()) json["no_tracker_delay"] = seen.no_delay;
  if (seen.delay_correlation > 0.0) json["tracker_delay_correlation"] = seen.delay_correlation;
  json["touched"] = seen.observed.touched.size();
  json["poses"] = seen.observed.held.size();
  json["pictures"] = seen.observed.frames.size();
  json["tried"] = Json::array();
  for (const auto& change : found.tried) json["tried"].push_back(json_of(change));
  return json;
}

std::string line_of(const calibration::RigFigure& f) {
  const auto shown_in_unit = [&f](double value) { return f.scale * value; };
  std::string text = fmt::format("  {:<14} {:7.3f} {} ({:.3f} to {:.3f})", f.name, shown_in_unit(f.error),
                                 f.unit, shown_in_unit(f.low), shown_in_unit(f.high));
  // A delay that nobody has measured has a second's deviation.
  if (f.unit == "ms" && f.promised_high >= rig::kUnknownDelay) return text + ", never measured";
  text += fmt::format(", promised below {:.3f}", shown_in_unit(f.promised_high));
  if (f.seen_high > 0.0)
    text += fmt::format("; seen {:.3f}, expected below {:.3f}", shown_in_unit(f.seen),
                        shown_in_unit(f.seen_high));
  return text;
}

// Where it was verified: somebody's own rig is no matter of a simulated laboratory.
std::string place_of(const VerifyOptions& options) {
  if (options.devices.named()) return "";
  return fmt::format(" in the simulated laboratory{} (--seed {}; no --arm, --tracker and --camera)",
                     options.world.empty() ? "" : " of " + one_line(options.world), options.seed);
}

void tell(const VerifyOptions& options, const calibration::Verification& found,
          const session::VerificationRecord& seen) {
  std::FILE* stream = options.json == "-" ? stderr : stdout;
  print_line(
      fmt::format("{}: {} verification{}, {:.0f} s{}: {}", options.rig, options.quick ? "quick" : "full",
                  place_of(options), seen.seconds, options.devices.named() ? "" : " of its time",
                  found.holds() ? "the rig holds" : "the rig does not hold"),
      stream);
  for (const auto& figure : found.figures) print_line(line_of(figure), stream);
  const bool above =
      std::any_of(found.figures.begin(), found.figures.end(), [](const calibration::RigFigure& f) {
        return f.error > f.promised_high || (f.seen_high > 0.0 && f.seen > f.seen_high);
      });
  if (above && found.holds())
    print_line("  a figure above its bound is no change by itself: all observations are judged at once",
               stream);
  if (!seen.no_delay.empty()) notice("the tracker's delay was not told: " + seen.no_delay);
  if (seen.board)
    print_line(fmt::format("  {:<14} {:7.3f} px rms over {} views, the lens had {:.3f}", "board",
                           seen.board->rms_px, seen.board->views, seen.board->promised_px),
               stream);
}

// A rig that was calibrated elsewhere looks as if all of it had moved.
std::string other_laboratory(const VerifyOptions& options) {
  if (options.devices.named()) return "";
  return fmt::format("; or it was calibrated in another laboratory than the simulated one of --seed {}",
                     options.seed);
}

Expected<void> verdict(const VerifyOptions& options, const calibration::Verification& found) {
  if (found.holds()) return {};
  std::string words;
  for (const auto& change : found.changes)
    words += (words.empty() ? "" : "; ") + calibration::change_words(change);
  if (!found.explained)
    words += fmt::format(
        "{}what is observed is not explained{} (misfit {:.2f}, 1 is expected; {} is off most, by {:.0f} "
        "standard "
        "deviations); look for what is loose, verify again, then calibrate anew",
        words.empty() ? "" : "; ",
        found.changes.empty() ? " by any change that is known of" : " by this alone", found.misfit,
        found.farthest, found.farthest_sds);
  return refused("{}: has changed since it was calibrated: {}{}", options.rig, words,
                 other_laboratory(options));
}

Expected<void> verify(const VerifyOptions& options) {
  if (!is_there(options.rig))
    return wrong_use("--rig {}: no such file; palpate calibrate all makes a rig", options.rig);
  auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  if (options.devices.window && !options.devices.named()) return window_without_devices();
  const auto plan = options.quick ? session::VerificationPlan::quick() : session::VerificationPlan{};
  const auto seen =
      options.devices.named() ? observe_live(options, *rig, plan) : observe_simulated(options, *rig, plan);
  if (!seen)
    return tl::unexpected(
        Error{seen.error().kind,
              fmt::format("{}: {}{}", options.rig, seen.error().message,
                          rig::missing_parts(*rig).empty() ? other_laboratory(options) : ""),
              seen.error().code});
  calibration::VerificationOptions how;
  if (options.devices.named()) how.delay_sd = calibration::VerificationOptions::kLiveDelaySd;
  const auto found = calibration::verify_rig(*rig, seen->observed, how);
  if (!found) return tl::unexpected(found.error());
  const rig::VerificationRecord record = kept(options, *found, rig::utc_now());
  tell(options, *found, *seen);
  rig->verifications.push_back(record);
  if (auto written = rig::write_rig(options.rig, *rig); !written) return written;
  if (!options.json.empty())
    if (auto written = write_json(options.json, json_of(record, *found, *seen)); !written) return written;
  return verdict(options, *found);
}

}  // namespace

void add_verify(CLI::App& program) {
  auto* command = program.add_subcommand("verify",
                                         "How good a calibrated rig is today, by touching fresh places, and "
                                         "what has moved: with you at the devices "
                                         "that --arm, --tracker and --camera name, or by itself in a "
                                         "simulated laboratory. Exit 0: it holds, 1: not");
  auto options = std::make_shared<VerifyOptions>();
  command
      ->add_option("--rig", options->rig, "Rig file, calibrated; what is found is kept there with its date")
      ->required()
      ->type_name("FILE");
  command->add_flag("--quick", options->quick, "Half a minute, before each day's work: fewer places");
  command->add_option("--json", options->json, "Write the result as JSON to FILE (- = standard output)")
      ->type_name("FILE");
  command
      ->add_option(
          "--world", options->world,
          "World file, with what was knocked since in its [knock]; the reference laboratory where none "
          "is named")
      ->type_name("FILE");
  command->add_option("--seed", options->seed, "The simulated laboratory that the rig was calibrated in")
      ->capture_default_str();
  command
      ->add_option(
          "--visit", options->visit,
          "Which visit to it: noise, touches and poses are drawn anew for each; 0 is the calibration's")
      ->capture_default_str();
  add_device_options(*command, options->devices);
  add_record_options(*command, options->devices.record);
  on(command, [options] { return verify(*options); });
}

}  // namespace palpate::tools::commands
