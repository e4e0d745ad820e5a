#include "palpate/calibration/forces/force_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/csv.h"
#include "palpate/core/units.h"

namespace palpate::calibration::forces {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
// Longer than drivers take to let forces in again after they had let go.
constexpr double kSettle = 1.3;                         // s
constexpr double kStill = 0.003;                        // m
constexpr int kMostExcursions = 6, kMostTroubles = 20;  // troubles: in a row
constexpr double kLiftRate = 0.25;                      // N/s
constexpr double kLiftPeak = 1.0;                       // N
constexpr double kRisen = 0.001, kSunk = 0.0005;        // m

constexpr const char* kWhere[] = {"in the middle of its reach", "a hand's breadth to the left, and up",
                                  "to the right, and up", "to the left, and down", "to the right, and down"};

class ForceSession {
 public:
  ForceSession(device::ArmDevice& arm, const rig::Rig& rig, Clock<PhysicsClock>& clock, ForcePerson& person,
               const ForceSessionSettings& settings)
      : arm_(arm), rig_(rig), clock_(clock), person_(person), settings_(settings), next_(clock.now()) {
    pusher_.emplace(arm, rig, settings.limits);
  }

  Expected<ForceObservations> run() {
    for (int pose = 0; pose < settings_.poses; ++pose)
      if (auto done = push_in_pose(pose); !done) return tl::unexpected(done.error());
    if (settings_.weight_kg > 0.0)
      if (auto done = lift(); !done) return tl::unexpected(done.error());
    seen_.ramps_csv = csv_.content();
    return seen_;
  }

 private:
  BreakOff tick(const Vector3& force) {
    next_ += kTick;
    clock_.sleep_until(next_);
    const Instant<PhysicsClock> now = clock_.now();
    if (now > next_ + 20 * kTick) next_ = now;
    return pusher_->tick(now, force, person_.key_held(pusher_->buttons()));
  }
  bool stopped() const {
    return settings_.stop != nullptr && settings_.stop->load(std::memory_order_relaxed);
  }

  bool far_from_the_others() const {
    return std::all_of(places_.begin(), places_.end(),
                       [&](const Vector3& p) { return (p - pusher_->tip()).norm() >= settings_.apart_m; });
  }

  // Without a force, until the key has been held and the stylus still for a while.
  Expected<void> wait_until_held(bool new_pose) {
    const Instant<PhysicsClock> begun = clock_.now();
    double calm_s = 0.0, silent_s = 0.0;
    Vector3 place = Vector3::Constant(1e9);
    bool told = false;
    while (calm_s < kSettle) {
      const BreakOff reason = tick(Vector3::Zero());
      if (stopped()) return refused("force check: stopped; nothing was changed");
      if (reason == BreakOff::arm_lost) return lost();
      silent_s = reason == BreakOff::arm_silent || reason == BreakOff::bad_reading ? silent_s + 1e-3 : 0.0;
      if (silent_s > 5.0)
        return refused("force check: the arm has been silent for 5 s; see to its driver and cable");
      const bool here = !new_pose || far_from_the_others();
      const bool calm = reason == BreakOff::none && person_.key_held(pusher_->buttons()) && here &&
                        (pusher_->tip() - place).norm() < kStill;
      if (!calm) place = pusher_->tip();
      calm_s = calm ? calm_s + 1e-3 : 0.0;
      const double waited = to_seconds(clock_.now() - begun);
      if (!told && waited > 10.0 && !here) {
        person_.say(
            fmt::format("the stylus is within {:.0f} mm of where it has been tried: take it further away",
                        kMillimetresPerMetre * settings_.apart_m));
        told = true;
      }
      if (waited > settings_.patience_s) {
        const std::string last = reason != BreakOff::none ? fmt::format(" (at last: {})", name_of(reason))
                                 : !here                  ? " (at last: where it has been tried)"
                                                          : "";
        return refused(
            "force check: the key was not held with the stylus still within {:.0f} s{}; hold both and start "
            "again",
            settings_.patience_s, last);
      }
    }
    return {};
  }

  Expected<void> lost() const {
    return refused("force check: the arm is gone; see to its power and cable, and start again");
  }

  // What follows a push that was broken off: refused where it makes no sense to go on.
  Expected<void> after(BreakOff reason) {
    ++seen_.break_offs[static_cast<std::size_t>(reason)];
    if (stopped()) return refused("force check: stopped; nothing was changed");
    if (reason == BreakOff::arm_lost) return lost();
    if (reason == BreakOff::too_far || reason == BreakOff::too_fast) {
      share_ = std::max(0.25, 0.5 * share_);
      if (++excursions_ >= kMostExcursions)
        return refused(
            "force check: the tip went {} {} times, though the force was small; hold the stylus a little "
            "more firmly, and keep the other arm still",
            name_of(reason), excursions_);
    } else if (reason != BreakOff::key_released && ++troubles_ >= kMostTroubles) {
      return refused(
          "force check: broken off {} times in a row ({} the last time); see to the driver, and to what else "
          "runs on this machine",
          troubles_, name_of(reason));
    }
    person_.say(fmt::format("broken off ({}): no force; hold {} and keep still to go on", name_of(reason),
                            settings_.key));
    return wait_until_held(false);
  }

  Expected<void> push_in_pose(int pose) {
    person_.say(fmt::format("pose {} of {}: hold the stylus lightly {}, keep still, and hold {}", pose + 1,
                            settings_.poses, kWhere[pose], settings_.key));
    person_.pose_wanted(pose, pusher_->tip());
    if (auto held = wait_until_held(true); !held) return held;
    places_.push_back(pusher_->tip());
    ForcePose found{pusher_->jacobian(), {}};
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) {
        auto ramp = ramp_until_whole(sign * Vector3::Unit(axis));
        if (!ramp) return tl::unexpected(ramp.error());
        keep(pose, *ramp);
        found.ramps.push_back(*ramp);
      }
    seen_.poses.push_back(std::move(found));
    return {};
  }

  Expected<RampResponse> ramp_until_whole(const Vector3& direction) {
    while (true) {
      const BreakOff reason = ramp(direction);
      if (reason == BreakOff::none) {
        troubles_ = 0;
        if (const auto response = ramp_response(direction, samples_)) return *response;
        return refused("force check: a ramp left too few readings");
      }
      if (auto fine = after(reason); !fine) return tl::unexpected(fine.error());
    }
  }

  // One rise and fall of the force, as a raised cosine.
  BreakOff ramp(const Vector3& direction) {
    samples_.clear();
    pusher_->begin();
    const double peak = share_ * settings_.limits.peak_n / std::max(1.0, pusher_->gain());
    const Instant<PhysicsClock> begun = next_;
    for (double t = 0.0; t <= settings_.ramp_s; t = to_seconds(next_ + kTick - begun)) {
      const double force = 0.5 * peak * (1.0 - std::cos(2.0 * std::numbers::pi * t / settings_.ramp_s));
      const BreakOff reason = tick(force * direction);
      if (reason != BreakOff::none || stopped())
        return reason == BreakOff::none ? BreakOff::key_released : reason;
      samples_.push_back({t, force, pusher_->way()});
    }
    return tick(Vector3::Zero());
  }

  void keep(int pose, const RampResponse& ramp) {
    std::vector<std::string> row{std::to_string(pose + 1)};
    for (const Vector3& v : {ramp.direction, Vector3(kMillimetresPerMetre * ramp.compliance)})
      for (const double x : v) row.push_back(number_text(x));
    csv_.row(row);
  }

  // --- the weight

  Expected<void> lift() {
    PushLimits limits = settings_.limits;
    limits.peak_n = kLiftPeak;
    pusher_.emplace(arm_, rig_, limits);
    person_.say(
        fmt::format("now the weight: hang {:.0f} g at the tip, let it lie or hang without your hand, hold {}",
                    1e3 * settings_.weight_kg, settings_.key));
    person_.pose_wanted(settings_.poses, pusher_->tip());
    if (auto held = wait_until_held(false); !held) return held;
    const Vector3 up = rig_.arm->X_world_base.rotation.conjugate() * Vector3::UnitY();
    while (static_cast<int>(seen_.sinking.size()) < settings_.lifts) {
      auto whole = lift_once(up);
      if (!whole) return tl::unexpected(whole.error());
      if (*whole == BreakOff::none) {
        if (auto held = wait_until_held(false); !held) return held;
      } else if (auto fine = after(*whole); !fine) {
        return fine;
      }
    }
    return {};
  }

  Expected<BreakOff> lift_once(const Vector3& up) {
    pusher_->begin();
    const double most = kLiftPeak / std::max(1.0, pusher_->gain());
    double force = 0.0, rising = 0.0, top = 0.0;
    while (true) {
      force += (rising > 0.0 ? -1e-3 : 1e-3) * kLiftRate;
      if (force > most)
        return refused(
            "force check: {:.2f} N upwards do not lift {:.0f} g; a weight below {:.0f} g is expected, and "
            "one that nothing else holds",
            most, 1e3 * settings_.weight_kg, 1e3 * most / 9.81);
      if (force <= 0.0) return BreakOff::too_far;  // it never sank: something else holds it
      const BreakOff reason = tick(force * up);
      if (reason != BreakOff::none || stopped())
        return reason == BreakOff::none ? BreakOff::key_released : reason;
      const double height = pusher_->way().dot(up);
      top = std::max(top, height);
      if (rising == 0.0 && height > kRisen) rising = force;
      if (rising > 0.0 && height < top - kSunk) break;
    }
    seen_.rising.push_back(rising);
    seen_.sinking.push_back(force);
    for (; force > 0.0; force -= 1e-3 * kLiftRate)
      if (tick(force * up) != BreakOff::none) break;  // it may come down quickly: then it has no force
    return BreakOff::none;
  }

  device::ArmDevice& arm_;
  const rig::Rig& rig_;
  Clock<PhysicsClock>& clock_;
  ForcePerson& person_;
  ForceSessionSettings settings_;
  std::optional<ForcePusher> pusher_;
  Instant<PhysicsClock> next_;
  std::vector<Vector3> places_;
  std::vector<RampSample> samples_;
  ForceObservations seen_;
  CsvWriter csv_{{"pose", "x", "y", "z", "response_x_mm_n", "response_y_mm_n", "response_z_mm_n"}};
  double share_ = 1.0;  // of the peak, after excursions
  int excursions_ = 0, troubles_ = 0;
};

}  // namespace

Expected<ForceObservations> observe_forces(device::ArmDevice& arm, const rig::Rig& rig,
                                           Clock<PhysicsClock>& clock, ForcePerson& person,
                                           const ForceSessionSettings& settings) {
  if (settings.poses < 1 || settings.poses > static_cast<int>(std::size(kWhere)) || settings.lifts < 3)
    return wrong_use("force check: {} poses and {} lifts; 1 to {} and 3 or more are expected", settings.poses,
                     settings.lifts, std::size(kWhere));
  return ForceSession(arm, rig, clock, person, settings).run();
}

}  // namespace palpate::calibration::forces
