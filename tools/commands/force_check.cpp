#include "tools/commands/force_check.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <thread>

#include "palpate/calibration/forces/force_session.h"
#include "palpate/core/crash_words.h"
#include "palpate/core/file.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/units.h"
#include "palpate/device/force_strength.h"
#include "palpate/device/health_monitor.h"
#include "palpate/device/held_places.h"
#include "palpate/haptics/arm_check.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"
#include "palpate/time/standstill.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/result_output.h"
#include "tools/commands/terminal_key.h"

namespace palpate::tools::commands {
namespace {

using calibration::ForceVerdict;
namespace forces = calibration::forces;

constexpr double kGravity = 9.81;  // m/s^2

// Who holds the stylus and the key: the simulated laboratory's hand, or a person.
class Holder : public forces::ForcePerson {
 public:
  Holder(const ForceArguments& options, std::unique_ptr<TerminalKey> key,
         std::unique_ptr<device::OpenedHand> hand, const Pose<World, ArmBase>& X_world_base)
      : options_(options), key_(std::move(key)), hand_(std::move(hand)), X_world_base_(X_world_base) {}

  bool key_held(std::uint32_t buttons) override {
    if (hand_) hand_->device().move_to(target_);
    if (options_.key_button > 0) return (buttons >> static_cast<unsigned>(options_.key_button - 1) & 1u) != 0;
    return key_ ? key_->held() : true;
  }
  bool is_computed() const { return hand_ != nullptr; }
  bool quit() const { return key_ != nullptr && key_->quit(); }
  void say(const std::string& line) override {
    notice("forces: " + line);
    last_said_ = line;
  }
  void pose_wanted(int pose, const Vector3& tip) override {
    if (options_.instructions) options_.instructions->write({device::Gesture::hold, "", pose}, last_said_);
    if (!hand_) return;
    const Vector3 here = (X_world_base_ * Point<ArmBase>{tip}).m;
    if (pose == 0) middle_ = here + Vector3(0.0, 0.03, 0.0);
    if (pose < static_cast<int>(device::kHeldPlaces.size()))
      target_.tip.m = middle_ + device::kHeldPlaces[static_cast<std::size_t>(pose)];
  }

 private:
  const ForceArguments& options_;
  std::unique_ptr<TerminalKey> key_;
  std::unique_ptr<device::OpenedHand> hand_;
  Pose<World, ArmBase> X_world_base_;
  std::string last_said_;
  Vector3 middle_ = Vector3::Zero();
  device::HandTarget target_;
};

bool names_a_fault(ForceVerdict verdict) {
  switch (verdict) {
    case ForceVerdict::axis_mirrored:
    case ForceVerdict::axes_exchanged:
    case ForceVerdict::joint_mirrored:
    case ForceVerdict::joints_exchanged:
    case ForceVerdict::joint_without_power:
    case ForceVerdict::ratio_off:
      return true;
    case ForceVerdict::agreed:
    case ForceVerdict::too_little_motion:
    case ForceVerdict::restless_hand:
    case ForceVerdict::undetermined:
    case ForceVerdict::unexplained:
      break;
  }
  return false;
}

Json forces_json(const calibration::ForceCheck& check, const forces::ForceObservations& seen,
                 const device::ArmFacts& facts) {
  Json json;
  json["arm"] = facts.identity;
  json["verdict"] = std::string(calibration::name_of(check.verdict));
  json["words"] = check.words;
  json["poses"] = seen.poses.size();
  json["ratios_told"] = check.ratios_told;
  json["joint_gains"] = json_list(check.joint_gains);
  json["joint_gains_std"] = json_list(standard_deviations(check.covariance));
  json["map"] = json_rows(check.map);
  json["map_covariance"] = json_rows(check.map_covariance);
  json["hand_compliance_mm_n"] = kMm * check.compliance;
  json["hand_anisotropy"] = check.anisotropy;
  json["scatter_mm_n"] = kMm * check.scatter;
  json["misfit"] = check.cost;
  json["freedoms"] = check.freedoms;
  json["next_misfit"] = check.next_cost;
  for (int i = 1; i < forces::kBreakOffs; ++i)
    json["break_offs"][std::string(forces::name_of(static_cast<forces::BreakOff>(i)))] =
        seen.break_offs[static_cast<std::size_t>(i)];
  json["data_hash"] = content_hash(seen.ramps_csv);
  return json;
}

rig::ForceCalibration part_of(const rig::Rig& rig, const ForceArguments& options,
                              const device::ArmFacts& facts, const calibration::ForceCheck& check,
                              const std::optional<calibration::WeightGain>& weight, const std::string& hash) {
  rig::ForceCalibration part = rig::force_calibration_of(rig, facts.identity);
  part.map = check.map;
  part.covariance = check.map_covariance;
  part.joint_gains = check.joint_gains;
  part.joint_gains_std = standard_deviations(check.covariance);
  if (weight) {
    part.gain = weight->gain;
    part.gain_std = weight->deviation;
    if (check.ratios_told)  // else an axis may be stronger than the one that has lifted the weight
      part.peak = haptics::lowered_to(haptics::force_limits_of(rig.arm->model), facts).peak_n;
  }
  part.dead_man_button = options.dead_man;
  part.date = rig::utc_now();
  part.method = weight ? "ramps and weight" : "ramps";
  part.data_hash = hash;
  return part;
}

// The rig file as it is now, with another part: the check may have taken minutes.
Expected<void> put_into_rig(const std::string& file, std::optional<rig::ForceCalibration> part) {
  auto rig = rig::read_rig(file);
  if (!rig) return tl::unexpected(rig.error());
  rig->forces = std::move(part);
  return rig::write_rig(file, *rig);
}

// The stylus of a computed arm is held by its hand, of any other by a person.
Expected<std::unique_ptr<Holder>> holder(const ForceArguments& options, const rig::Rig& rig,
                                         const device::ArmFacts& facts) {
  const auto* driver = drivers().find_for(options.arm);
  std::unique_ptr<device::OpenedHand> hand;
  if (facts.simulated && driver != nullptr && driver->hand) {
    auto opened = drivers().open(device::HandRequest{options.arm});
    if (!opened) return tl::unexpected(opened.error());
    hand = std::move(*opened);
  }
  std::unique_ptr<TerminalKey> key;
  if (!hand && options.key_button == 0 && !options.yes_held) {
    auto opened = TerminalKey::open();
    if (!opened) return tl::unexpected(opened.error());
    key = std::move(*opened);
  }
  return std::make_unique<Holder>(options, std::move(key), std::move(hand), rig.arm->X_world_base);
}

Expected<void> tell(const ForceArguments& options, const rig::Rig& rig, const device::ArmFacts& facts,
                    const forces::ForceObservations& seen) {
  calibration::ForceCheckSettings settings;
  settings.states_place = facts.states_place;
  const auto check = calibration::check_forces(seen.poses, settings);
  if (!check) return tl::unexpected(check.error());
  Json json = forces_json(*check, seen, facts);
  std::optional<calibration::WeightGain> weight;
  std::string trouble = check->verdict == ForceVerdict::agreed ? "" : check->words;
  if (trouble.empty() && options.weight_g > 0.0) {
    const auto found =
        calibration::gain_of_weight(1e-3 * options.weight_g * kGravity, seen.rising, seen.sinking);
    if (found) {
      weight = *found;
      json["gain"] = weight->gain;
      json["gain_std"] = weight->deviation;
      json["friction_n"] = weight->friction;
    } else {
      trouble = found.error().message;
      json["words"] = trouble;
    }
  }
  const auto part = part_of(rig, options, facts, *check, weight, json["data_hash"].get<std::string>());
  if (trouble.empty()) json["peak_n"] = part.peak;
  if (!options.json.empty())
    if (auto done = write_json(options.json, json); !done) return done;
  const bool void_now =
      names_a_fault(check->verdict) || (check->verdict == ForceVerdict::agreed && !trouble.empty());
  if (trouble.empty() || void_now)
    if (auto done = put_into_rig(options.rig, trouble.empty() ? std::optional(part) : std::nullopt); !done)
      return done;
  if (!trouble.empty())
    return refused("{}: forces stay off: {}{}", options.arm,
                   check->verdict == ForceVerdict::agreed
                       ? ""
                       : fmt::format("{}: ", calibration::name_of(check->verdict)),
                   trouble);
  std::FILE* const stream = lines_beside(options.json);
  fmt::print(stream, "{}: {}; gains of the {} {} (+- {})\n", one_line(facts.identity), check->words,
             check->ratios_told ? "joints" : "axes, the hand's unevenness in them,",
             shown(check->joint_gains), shown(standard_deviations(check->covariance)));
  fmt::print(stream, "{}\n",
             weight
                 ? fmt::format("size {:.3f} +- {:.3f} of what is commanded; peak {:g} N", weight->gain,
                               weight->deviation, part.peak)
                 : fmt::format("no known weight has told their size: the peak stays at {:g} N", part.peak));
  return {};
}

// The clock of the check's loop, which reads it in every tick: whether the loop goes on shows in how often.
class CountedClock : public Clock<PhysicsClock> {
 public:
  Instant<PhysicsClock> now() const override {
    asked_.fetch_add(1, std::memory_order_relaxed);
    return clock_.now();
  }
  void sleep_until(Instant<PhysicsClock> t) override { clock_.sleep_until(t); }
  std::uint64_t asked() const { return asked_.load(std::memory_order_relaxed); }

 private:
  mutable std::atomic<std::uint64_t> asked_{0};
  MonotonicClock<PhysicsClock> clock_;
};

// The check in a thread of its own, and this one beside it: where the driver does not come back the arm lets go within
// some 25 ms, and after two seconds the process ends in words; a driver that throws ends the check in words.
class WatchedCheck {
 public:
  WatchedCheck(device::OpenedArm& arm, const std::string& uri) : arm_(arm), uri_(uri) {}

  Expected<forces::ForceObservations> run(const rig::Rig& rig, std::unique_ptr<Holder>& person,
                                          forces::ForceSessionSettings settings) {
    settings.stop = &stop_;
    Expected<forces::ForceObservations> seen = refused("force check: not begun");
    device::ArmDevice& device = arm_.device();
    say_crashes([](void* of) noexcept { static_cast<device::ArmDevice*>(of)->let_go(); }, &device);
    std::thread thread([&] {
      give_crash_stack();
      enter_real_time(80);
      try {
        seen = forces::observe_forces(device, rig, clock_, *person, settings);
      } catch (const std::exception& error) {
        seen = refused("force check: arm {} threw: {}", uri_, error.what());
      }
      done_.store(true);
    });
    enter_real_time(90);
    watch(person);
    thread.join();
    say_crashes(nullptr, nullptr);
    if (!gone_.empty()) return refused("force check: {}", gone_);
    return seen;
  }

 private:
  void watch(std::unique_ptr<Holder>& person) {
    // Looks and no time: a process that was stopped as a whole gives nobody up.
    constexpr int kGivenUp = 500;
    constexpr Duration kLook = std::chrono::milliseconds(4);
    MonotonicClock<PhysicsClock> clock;
    Standstill<PhysicsClock> hangs(device::kLongestHold);
    std::uint64_t before = 0;
    int standing = 0;
    if (const auto who = arm_.description(); !who.empty() && !arm_.health()) notice(who);
    for (int look = 0; !done_.load(); ++look) {
      clock.sleep_until(clock.now() + kLook);
      if (stop_requested().load() || person->quit()) stop_.store(true);
      const std::uint64_t asked = clock_.asked();
      if (hangs.look(asked, clock.now())) arm_.device().let_go();
      standing = asked == before ? standing + 1 : 0;
      before = asked;
      if (standing >= kGivenUp) give_up(person);
      if (look % 25 == 0) look_at_the_arm();
    }
  }

  void look_at_the_arm() {
    const auto there = arm_.look();
    arm_health_.follow(arm_.health(), MonotonicClock<PhysicsClock>().now());
    if (there) return;
    gone_ = there.error().message;
    stop_.store(true);
  }

  [[noreturn]] void give_up(std::unique_ptr<Holder>& person) {
    person.reset();  // the terminal is a person's again
    notice(fmt::format("error: force check: the driver of arm {} does not come back; nothing was changed",
                       uri_));
    std::fflush(nullptr);
    std::_Exit(1);
  }

  device::OpenedArm& arm_;
  device::HealthMonitor<PhysicsClock> arm_health_{Log()};
  const std::string& uri_;
  CountedClock clock_;
  std::atomic<bool> stop_{false}, done_{false};
  std::string gone_;
};

}  // namespace

void add_force_options(CLI::App& command, ForceArguments& options) {
  command
      .add_option(
          "--weight-g", options.weight_g,
          "A known weight that the arm lifts at the end, g: tells the size; without it the peak stays at 1 N")
      ->check(between(5.0, 90.0));
  command
      .add_option("--dead-man", options.dead_man,
                  "From then on forces only while this button of the stylus is held, counted from 1")
      ->check(between(1, 32));
  command
      .add_option(
          "--key-button", options.key_button,
          "The key to be held during the check is this button of the stylus, not the terminal's space bar")
      ->check(between(1, 32));
  command.add_flag("--yes-held", options.yes_held,
                   "Count the key as held throughout: for scripts, not for people");
}

bool forces_due(const rig::Rig& rig, const device::ArmFacts& facts) {
  return !facts.simulated && !facts.identity.empty() &&
         (!rig.forces || !rig::void_reason(rig, facts.identity).empty());
}

bool key_can_be_held(const ForceArguments& options) {
  return options.key_button > 0 || options.yes_held || isatty(STDIN_FILENO) != 0;
}

Expected<void> check_forces_of(const ForceArguments& options) {
  const auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  if (!rig->arm)
    return refused("{}: has no arm calibration; run `palpate calibrate arm ... --rig {}`", options.rig,
                   options.rig);
  if (!drivers().names_arm(options.arm))
    return wrong_use("--arm: {}",
                     drivers().check(device::ArmRequest{.uri = options.arm, .nominal = {}}).error().message);
  auto arm = drivers().open(device::ArmRequest{
      .uri = options.arm, .nominal = rig->nominal_arm, .at_reset_position = options.at_reset});
  if (!arm) return tl::unexpected(arm.error());
  if (auto fine = haptics::check_arm(*rig, **arm, options.arm); !fine) return fine;
  if ((*arm)->facts().identity.empty())
    return refused(
        "arm {}: its driver does not say which arm it is (ArmFacts::identity), so that no check could be "
        "kept",
        options.arm);
  auto person = holder(options, *rig, (*arm)->facts());
  if (!person) return tl::unexpected(person.error());
  forces::ForceSessionSettings settings;
  settings.poses = options.poses;
  if ((*person)->is_computed()) settings.key = "no key (the laboratory's hand needs none)";
  if (options.key_button > 0) settings.key = fmt::format("button {} of the stylus", options.key_button);
  settings.weight_kg = 1e-3 * options.weight_g;
  settings.patience_s = options.patience_s;
  auto seen = WatchedCheck(**arm, options.arm).run(*rig, *person, settings);
  if (!seen) return tl::unexpected(seen.error());
  return tell(options, *rig, (*arm)->facts(), *seen);
}

}  // namespace palpate::tools::commands
