#include "palpate/server/physics/recorded_setup.h"

#include <fmt/format.h>

#include <charconv>
#include <string>

#include "palpate/core/text.h"

namespace palpate::server::physics {
namespace {

// All digits that reading it back needs.
std::string number(double value) { return fmt::format("{}", value); }

class Reader {
 public:
  explicit Reader(const record::Words& words) : words_(words) {}
  const std::string* text(const std::string& name) const {
    const auto found = words_.find(name);
    return found == words_.end() ? nullptr : &found->second;
  }
  template <typename Number>
  Number get(const std::string& name, Number otherwise) {
    const std::string* found = text(name);
    if (found == nullptr) {
      fail(name, "is missing");
      return otherwise;
    }
    return parse(name, *found, otherwise);
  }
  std::optional<double> maybe(const std::string& name) {
    return text(name) == nullptr ? std::nullopt : std::optional(get(name, 0.0));
  }
  bool flag(const std::string& name) { return get(name, 0) != 0; }
  device::JointVector numbers(const std::string& name, std::string_view list) {
    device::JointVector values;
    std::vector<double> found;
    while (!list.empty()) {
      const auto end = list.find(' ');
      found.push_back(parse(name, std::string(list.substr(0, end)), 0.0));
      list = end == std::string_view::npos ? std::string_view() : list.substr(end + 1);
    }
    if (found.empty() || found.size() > static_cast<std::size_t>(device::kMostJoints)) {
      fail(name, "has no numbers, or too many");
      return values;
    }
    values = Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(found.size()));
    return values;
  }
  const std::string& trouble() const { return trouble_; }
  void fail(const std::string& name, const char* what) {
    if (trouble_.empty()) trouble_ = fmt::format("{} {} {}", kSetupWords, excerpt(name), what);
  }

 private:
  template <typename Number>
  Number parse(const std::string& name, const std::string& from, Number otherwise) {
    Number value{};
    const auto [end, error] = std::from_chars(from.data(), from.data() + from.size(), value);
    if (error == std::errc() && end == from.data() + from.size()) return value;
    fail(name, "is no number");
    return otherwise;
  }

  const record::Words& words_;
  std::string trouble_;
};

}  // namespace

record::Words words_of(const RecordedSetup& setup) {
  record::Words words{{"seed", fmt::format("{}", setup.run.seed)},
                      {"physics_hz", number(setup.physics_hz)},
                      {"haptic_hz", number(setup.haptic_hz)},
                      {"armed", setup.armed ? "1" : "0"},
                      {"extra_force_delay_ns", fmt::format("{}", setup.extra_force_delay.count())},
                      {"arm_simulated", setup.arm.simulated ? "1" : "0"},
                      {"arm_identity", setup.arm.identity},
                      {"arm_joints", fmt::format("{}", setup.arm.joints)},
                      {"guests_timed", setup.guests_timed ? "1" : "0"}};
  if (setup.run.pause_s) words["pause_s"] = number(*setup.run.pause_s);
  if (setup.arm.peak_n) words["arm_peak_n"] = number(*setup.arm.peak_n);
  if (setup.arm.continuous_n) words["arm_continuous_n"] = number(*setup.arm.continuous_n);
  if (setup.torque_limits) {
    std::string list;
    for (const double limit : *setup.torque_limits) list += (list.empty() ? "" : " ") + number(limit);
    words["torque_limits_n_m"] = list;
  }
  return words;
}

Expected<RecordedSetup> setup_of(const record::Words& words) {
  Reader read(words);
  RecordedSetup setup;
  setup.run.seed = read.get("seed", setup.run.seed);
  setup.run.pause_s = read.maybe("pause_s");
  setup.physics_hz = read.get("physics_hz", setup.physics_hz);
  setup.haptic_hz = read.get("haptic_hz", setup.haptic_hz);
  setup.armed = read.flag("armed");
  setup.extra_force_delay = Duration(read.get("extra_force_delay_ns", std::int64_t{0}));
  setup.arm.simulated = read.flag("arm_simulated");
  if (const auto* identity = read.text("arm_identity")) setup.arm.identity = *identity;
  setup.arm.joints = read.get("arm_joints", setup.arm.joints);
  setup.arm.peak_n = read.maybe("arm_peak_n");
  setup.arm.continuous_n = read.maybe("arm_continuous_n");
  if (const auto* limits = read.text("torque_limits_n_m"))
    setup.torque_limits = read.numbers("torque_limits_n_m", *limits);
  setup.guests_timed = read.flag("guests_timed");
  constexpr double kLowest = 1.0, kHighest = 100000.0;
  for (const double hz : {setup.physics_hz, setup.haptic_hz})
    if (!(hz >= kLowest && hz <= kHighest)) read.fail("physics_hz or haptic_hz", "is no rate");
  if (!read.trouble().empty()) return refused("{}", read.trouble());
  return setup;
}

RecordedSetup recorded_setup(const PhysicsSetup& setup, device::OpenedArm& arm, bool guests_timed) {
  RecordedSetup recorded{.run = setup.run,
                         .physics_hz = setup.physics_hz,
                         .haptic_hz = setup.haptic_hz,
                         .armed = setup.armed,
                         .extra_force_delay = setup.extra_force_delay,
                         .arm = arm.facts(),
                         .torque_limits = {},
                         .guests_timed = guests_timed};
  if (const auto* motors = arm.device().motors()) recorded.torque_limits = motors->limits();
  return recorded;
}

}  // namespace palpate::server::physics
