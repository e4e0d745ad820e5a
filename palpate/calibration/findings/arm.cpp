#include "palpate/calibration/findings/arm.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "palpate/calibration/arm_motion.h"
#include "palpate/calibration/findings/arm_json.h"
#include "palpate/core/text.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/device/repeats.h"
#include "palpate/math/place_text.h"

namespace palpate::calibration::findings {
namespace {

constexpr double kPoorGimbal = 1.0;  // deg
constexpr double kPoorFit = 0.03;    // misfit as a share of the motion
constexpr double kOtherTip = 0.005;  // m; no slip of the hand moves a tip in its marker so far

// What is estimated: of the arm, and whether the gimbal is beside it.
struct FreeList {
  ArmFree arm;
  bool gimbal = false;
};

Expected<FreeList> parse_free(const std::string& list) {
  FreeList all{{.gains = false, .offsets = false, .lengths = false, .tip = false, .correction = false},
               false};
  ArmFree& free = all.arm;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) {
    if (name == "gains")
      free.gains = true;
    else if (name == "offsets")
      free.offsets = true;
    else if (name == "lengths")
      free.lengths = true;
    else if (name == "tip")
      free.tip = true;
    else if (name == "dh")
      free.dh = true;
    else if (name == "correction")
      free.correction = true;
    else if (name == "gimbal")
      all.gimbal = true;
    else if (name == "quadratic")
      free.quadratic = true;
    else if (name == "hysteresis")
      free.hysteresis = true;
    else if (name == "delay")
      free.delay = true;
    else
      return wrong_use(
          "--free {}: unknown; a list of gains, offsets, lengths, tip, gimbal, quadratic, hysteresis, delay, "
          "dh, of a Cartesian arm correction, tip and delay, is expected, or auto",
          name);
  }
  return all;
}

// Refused: what an arm of this kind does not have.
Expected<void> check_terms(const std::string& asked, const ArmFree& free, const device::ArmModel& model) {
  const bool of_joints =
      free.gains || free.offsets || free.lengths || free.dh || free.quadratic || free.hysteresis;
  if (model.kind == device::ArmModel::Kind::cartesian && of_joints)
    return wrong_use("--free {}: {} states its place, not its joints; correction, tip or delay is expected",
                     asked, model.name);
  if (model.kind != device::ArmModel::Kind::cartesian && free.correction)
    return wrong_use(
        "--free {}: correction is a Cartesian arm's; {} has joints, whose gains and offsets are expected",
        asked, model.name);
  return {};
}

// A sample is the same if every device read the same; when does not matter.
device::Reading reading_of_sample(const device::ArmObservation& sample) {
  device::Reading reading;
  reading.add(sample.joints).add_if(sample.gimbal);
  if (sample.marker) reading.add(sample.marker->rotation.coeffs()).add(sample.marker->translation);
  if (sample.tip) reading.add(sample.tip->m);
  return reading;
}

// Errors on samples that the calibration has not seen.
struct Unseen {
  std::string from;
  std::vector<Vector3> errors, uncorrected;
  std::vector<Vector3>
      errors_of_fitting;  // of the samples' folds: without those that the fit of all left out
  std::size_t seen = 0;   // of the samples to test by, those that the calibration has seen after all
};

// The samples, and what is asked of them.
struct Work {
  ArmTask task;
  std::size_t repeats = 0;
  bool markers = false, has_gimbal = false, wants_gimbal = false;
  ArmOptions how;
  std::optional<ArmChoice> choice;

  const device::ArmModel& model() const { return task.nominal; }
  const std::vector<device::ArmObservation>& samples() const { return task.samples.observations; }
  const std::string& source() const { return task.samples.source; }
  bool joint() const { return how.method == ArmMethod::joint; }
  Error of_the_samples(const Error& error) const { return {error.kind, source() + ": " + error.message}; }
};

Expected<Unseen> judge_by_test(const Work& work, const ArmSolution& arm, const ArmSolution& uncorrected) {
  const device::ArmSampleFile& test = *work.task.test;
  for (const auto& sample : test.observations) {
    if (sample.joints.size() != work.model().joint_count())
      return wrong_use("{}: has {} joint columns, the arm {} has {} joints", test.source,
                       sample.joints.size(), work.model().name, work.model().joint_count());
    if (arm.tip_known && !sample.marker && !sample.tip)
      return wrong_use("{}: has no measured tips", test.source);
  }
  auto both = work.samples(), own = test.observations;
  device::drop_repeats(own, reading_of_sample);
  both.insert(both.end(), own.begin(), own.end());
  return Unseen{.from = test.source,
                .errors = arm_errors(arm, test.observations),
                .uncorrected = arm_errors(uncorrected, test.observations),
                .errors_of_fitting = {},
                .seen = device::drop_repeats(both, reading_of_sample)};
}

// What `asked` names to be estimated.
Expected<void> set_free(const std::string& asked, Work& work) {
  ArmFree& free = work.how.free;
  if (asked.empty()) {
    free.lengths = work.model().kind == device::ArmModel::Kind::phantom;
    free.tip = work.markers && work.joint();
    free.delay = work.joint() && taken_in_motion(work.samples());
    return {};
  }
  if (asked == "auto") {
    free.tip = work.markers && work.joint();
    if (!work.joint())
      return wrong_use("--free auto: chooses for the joint method, not for {}", name_of(work.how.method));
    auto chosen = choose_free(work.samples(), work.model(), work.how);
    if (!chosen) return refused("{}: {}", work.source(), chosen.error().message);
    free = chosen->free;
    work.choice = std::move(*chosen);
    return {};
  }
  const auto list = parse_free(asked);
  if (!list) return tl::unexpected(list.error());
  free = list->arm;
  if (auto fine = check_terms(asked, free, work.model()); !fine) return fine;
  work.wants_gimbal = list->gimbal;
  if (work.wants_gimbal && !work.has_gimbal)
    return wrong_use(
        "--free gimbal: needs gimbal angles (gimbal_1_deg ...) and marker poses of a PHANToM in every row "
        "of {}",
        work.source());
  if (free.tip && !work.markers)
    return wrong_use("--free tip: needs marker poses (marker_x_mm ... marker_qz), {} has none",
                     work.source());
  return {};
}

// Refused: joints where the arm states places, or the other way round.
Expected<void> check_readings(const device::ArmSampleFile& samples, const device::ArmModel& model) {
  const bool cartesian = model.kind == device::ArmModel::Kind::cartesian;
  if (samples.places == cartesian) return {};
  return wrong_use("{}: holds {}, but {} states its {}; {} is expected, or another --arm", samples.source,
                   samples.places ? "places of a Cartesian arm" : "joint readings", model.name,
                   cartesian ? "place" : "joints",
                   cartesian ? "arm_x_mm,arm_y_mm,arm_z_mm" : "joint_1_deg ...");
}

Expected<Work> work_of(ArmTask task) {
  if (auto fine = check_readings(task.samples, task.nominal); !fine) return tl::unexpected(fine.error());
  if (task.test)
    if (auto fine = check_readings(*task.test, task.nominal); !fine) return tl::unexpected(fine.error());
  Work work{.task = std::move(task), .how = {}, .choice = {}};
  work.repeats = device::drop_repeats(work.task.samples.observations, reading_of_sample);
  const auto all = [&](const auto& has) {
    return std::all_of(work.samples().begin(), work.samples().end(), has);
  };
  work.markers = all([](const auto& s) { return s.marker.has_value(); });
  work.has_gimbal = work.markers && work.model().kind == device::ArmModel::Kind::phantom &&
                    all([](const auto& s) { return s.gimbal.has_value(); });
  work.wants_gimbal = work.has_gimbal;
  work.how.method = work.task.method;
  work.how.tip = work.task.tip;
  if (auto done = set_free(work.task.free, work); !done) return tl::unexpected(done.error());
  if ((work.how.free.quadratic || work.how.free.hysteresis) && work.task.for_rig)
    return wrong_use(
        "--free {}: a rig file holds gains and offsets, no quadratic or hysteresis terms; leave them out, or "
        "use --json without --rig and --out",
        free_text(work.how.free, work.model()));
  return work;
}

// Where the samples themselves put the tip, if with that one in place of the given they fit.
std::optional<Vector3> tip_of_samples(const Work& work) {
  if (!work.how.tip || !work.markers) return std::nullopt;
  ArmOptions how = work.how;
  how.tip.reset();
  how.free.tip = true;
  const auto estimate = calibrate_arm(work.samples(), work.model(), how);
  if (!estimate || arm_misfit(estimate->value, work.samples()).share() > kPoorFit) return std::nullopt;
  return estimate->value.tip_in_marker;
}

Expected<void> refuse_given_tip(const Work& work, const Vector3& own) {
  return refused(
      "{}: arm: the given tip (--tip-mm, or tip_pivot of the rig) is at {} in its marker; these samples "
      "contradict it, and fit with one at {}; check that tip, or repeat palpate calibrate pivot",
      work.source(), place_text_mm(*work.how.tip), place_text_mm(own));
}

// How far places lie from their middle, rms, m.
double spread_of(const std::vector<Vector3>& places) {
  Vector3 middle = Vector3::Zero();
  for (const auto& place : places) middle += place / static_cast<double>(places.size());
  double sum = 0.0;
  for (const auto& place : places) sum += (place - middle).squaredNorm();
  return std::sqrt(sum / static_cast<double>(places.size()));
}

// Refused where the tracker saw another size of motion than the readings tell: a free tip or lengths can absorb that. A
// marker may move further than its tip, which may even rest, but not by so much less.
Expected<void> check_size_of_motion(const Work& work) {
  constexpr double kLeast = 0.2, kMostOfTips = 5.0;
  std::vector<Vector3> seen, told;
  bool tips = true;
  for (const auto& sample : work.samples()) {
    tips = tips && sample.tip;
    seen.push_back(sample.tip ? sample.tip->m : sample.marker->translation);
    told.push_back(device::arm_tip(work.model(), sample.joints).m);
  }
  const double by_tracker = spread_of(seen), by_readings = spread_of(told);
  if (by_tracker > kLeast * by_readings && (!tips || by_tracker < kMostOfTips * by_readings)) return {};
  return refused(
      "{}: arm: the measured places lie {:.3g} mm rms about their middle, where the readings of a {} say "
      "{:.3g} mm; check "
      "the units in the header (_mm or _m, _deg or _rad) and the arm (--arm)",
      work.source(), mm_from_metres(by_tracker), work.model().name, mm_from_metres(by_readings));
}

// Refused where half of the samples lie so far off that they are not this arm's, or the given tip is not theirs.
Expected<void> check_misfit(const Work& work, const ArmSolution& arm, const ArmMisfit& misfit) {
  constexpr double kNoArm = 0.12;
  // From so far a start the solve may also end in an arm that is turned inside out.
  constexpr double kNotTheirs = 0.05;  // m
  if (!work.joint()) return {};
  const bool astray = misfit.share() > kNoArm;
  const bool far =
      work.how.free.tip && work.how.tip && (arm.tip_in_marker - *work.how.tip).norm() > kNotTheirs;
  if (astray || far)
    if (const auto own = tip_of_samples(work)) return refuse_given_tip(work, *own);
  if (!astray) return {};
  if (auto fine = check_size_of_motion(work); !fine) return fine;
  return refused(
      "{}: arm: half of the samples lie more than {:.1f} mm off the best fit, in a motion of {:.0f} mm: this "
      "is not a {}; check the units, the order of the joints and that rows hold one moment each",
      work.source(), mm_from_metres(misfit.error), mm_from_metres(misfit.spread), work.model().name);
}

// What tells that the samples are another arm's: its own differs by millimetres and percent.
void add_doubts_of_arm(const Work& work, const Estimate<ArmSolution>& estimate,
                       std::vector<std::string>& warnings) {
  const ArmSolution& arm = estimate.value;
  constexpr double kOwn = 0.1, kOwnTurn = 0.8;  // rad: encoders are reset in the rest position, or near it
  std::string odd;
  // What the samples do not tell by three deviations says nothing of the arm. An estimate without one was given.
  constexpr double kSure = 3.0;
  const auto deviation = [&](const std::string& parameter) {
    const auto at =
        std::find(arm.parameters.begin(), arm.parameters.end(), parameter) - arm.parameters.begin();
    return at < estimate.covariance.rows() ? estimate.standard_deviation(at) : 0.0;
  };
  const auto compare = [&](const std::string& name, double found, double nominal, const char* unit,
                           const std::string& parameter = "") {
    if (std::abs(found - nominal) <= kOwn * std::abs(nominal)) return;
    if (std::abs(found - nominal) <= kSure * deviation(parameter)) return;
    odd += fmt::format("{}{} comes out at {:.4g}{} in place of {:.4g}{}", odd.empty() ? "" : ", ", name,
                       found, unit, nominal, unit);
  };
  if (arm.model.kind == device::ArmModel::Kind::phantom) {
    const device::PhantomLengths &found = arm.model.lengths, &nominal = work.model().lengths;
    compare("length 1", mm_from_metres(found.l1), mm_from_metres(nominal.l1), " mm");
    compare("length 2", mm_from_metres(found.l2), mm_from_metres(nominal.l2), " mm");
    for (Eigen::Index i = 0; i < arm.offset.size(); ++i)
      if (std::abs(arm.offset[i]) > kOwnTurn)
        odd += fmt::format("{}offset {} comes out at {:.1f} deg", odd.empty() ? "" : ", ", i + 1,
                           degrees_from_radians(arm.offset[i]));
  }
  for (Eigen::Index i = 0; i < arm.gain.size(); ++i)
    compare(fmt::format("gain {}", i + 1), arm.gain[i], 1.0, "", fmt::format("gain_{}", i + 1));
  if (odd.empty()) return;
  warnings.push_back(
      fmt::format("{}: is it a {} (--arm), and are the units and the order of the joints right?", odd,
                  work.model().name));
}

// Of a Cartesian arm: readings that it cannot have stated, if it reaches what its model says.
std::size_t beyond_reach(const Work& work) {
  constexpr double kMargin = 0.005;  // m
  if (work.model().kind != device::ArmModel::Kind::cartesian) return 0;
  const auto& places = work.model().places;
  return static_cast<std::size_t>(
      std::count_if(work.samples().begin(), work.samples().end(), [&](const device::ArmObservation& sample) {
        for (std::size_t i = 0; i < places.size(); ++i) {
          const double place = sample.joints[static_cast<Eigen::Index>(i)];
          if (place < places[i].low - kMargin || place > places[i].high + kMargin) return true;
        }
        return false;
      }));
}

Expected<std::optional<Estimate<GimbalSolution>>> fit_gimbal(const Work& work,
                                                             const Estimate<ArmSolution>& estimate) {
  if (!work.wants_gimbal) return std::nullopt;
  auto fitted = calibrate_gimbal(with_delay_removed(work.samples(), estimate.value.delay_s), estimate);
  if (!fitted) return tl::unexpected(work.of_the_samples(fitted.error()));
  return std::optional(std::move(*fitted));
}

// By the test samples, or by folds of the samples.
Expected<Unseen> judge(const Work& work, const Estimate<ArmSolution>& estimate) {
  const auto uncorrected = uncorrected_arm(work.samples(), work.model(), work.how);
  if (!uncorrected) return tl::unexpected(uncorrected.error());
  if (work.task.test) return judge_by_test(work, estimate.value, uncorrected->value);
  auto held = held_out_by_folds(work.samples(), work.model(), work.how, work.task.seed, kFolds);
  if (!held)
    return tl::unexpected(Error{
        held.error().kind,
        fmt::format("{}: {} (a fifth of the samples is held out to judge by; --test FILE judges by others)",
                    work.source(), held.error().message)});
  Unseen unseen{.from = fmt::format("{} folds of the samples", kFolds),
                .errors = std::move(held->errors),
                .uncorrected = arm_errors(uncorrected->value, work.samples()),
                .errors_of_fitting = {}};
  for (std::size_t i = 0; i < unseen.errors.size(); ++i)
    if (estimate.inlier.empty() || estimate.inlier[held->samples[i]])
      unseen.errors_of_fitting.push_back(unseen.errors[i]);
  return unseen;
}

// What a person should know of the result.
std::vector<std::string> warnings_of(const Work& work, const ArmFindings& found, const Unseen& unseen,
                                     const ArmMisfit& misfit) {
  const ArmSolution& arm = found.estimate.value;
  std::vector<std::string> warnings;
  if (work.repeats > 0) warnings.push_back(device::repeats_warning(work.repeats));
  if (unseen.seen > 0)
    warnings.push_back(
        fmt::format("{} of {} stand among the samples too, so they test nothing; record others for --test",
                    counted(unseen.seen, "row"), unseen.from));
  if (found.gimbal)
    if (const double off = gimbal_rms_deg(*found.gimbal, arm, work.samples()); off > kPoorGimbal)
      warnings.push_back(fmt::format(
          "the gimbal's angles leave the stylus {:.1f} deg rms off its marker: check their unit, their "
          "order and that of the joints",
          off));
  if (!work.joint() && work.how.free.tip)
    warnings.push_back(
        fmt::format("method {} takes the tip as given; it was not estimated", name_of(found.method)));
  if (!work.joint() && arm.tip_known && !work.how.tip)
    warnings.push_back("no tip was given (--tip-mm): it was found with the arm's nominal kinematics");
  if (work.joint() && misfit.share() > kPoorFit)
    warnings.push_back(fmt::format(
        "half of the samples lie more than {:.1f} mm off the best fit: free more, or check units, joint "
        "order and that rows hold one moment each",
        mm_from_metres(misfit.error)));
  if (work.joint() && work.how.free.tip && work.how.tip)
    if (const double off = (arm.tip_in_marker - *work.how.tip).norm(); off > kOtherTip)
      warnings.push_back(fmt::format(
          "the tip comes out {:.1f} mm from the given one, which is at {} in its marker: check that one "
          "(palpate calibrate pivot), or whether the marker was moved since",
          mm_from_metres(off), place_text_mm(*work.how.tip)));
  add_doubts_of_arm(work, found.estimate, warnings);
  if (const double with = mean_norm(unseen.errors), without = mean_norm(unseen.uncorrected); with > without)
    warnings.push_back(fmt::format(
        "{}: with the calibration these are {:.2f} mm off, without it {:.2f}: are they of this arm, "
        "and was neither arm nor tracker moved in between?",
        unseen.from, mm_from_metres(with), mm_from_metres(without)));
  if (const std::size_t beyond = beyond_reach(work); beyond > 0)
    warnings.push_back(
        fmt::format("{} outside of the reach that the arm states: check range_mm of {}, and the unit of the "
                    "readings",
                    counted(beyond, "place"), work.model().name));
  if (found.estimate.termination == Termination::iteration_limit)
    warnings.push_back("the solution had not settled at the iteration limit");
  if (work.joint() && !work.how.free.delay && taken_in_motion(work.samples()))
    warnings.push_back(
        "the samples were taken in motion: any delay between encoders and tracker went into the errors; free "
        "it (--free ...,delay)");
  return warnings;
}

}  // namespace

const char* name_of(ArmMethod method) {
  switch (method) {
    case ArmMethod::one_pass:
      return "one-pass";
    case ArmMethod::alternating:
      return "alternating";
    case ArmMethod::eq7:
      return "eq7";
    case ArmMethod::joint:
      break;
  }
  return "joint";
}

Expected<ArmFindings> find_arm(ArmTask task) {
  auto work = work_of(std::move(task));
  if (!work) return tl::unexpected(work.error());
  auto estimate = calibrate_arm(work->samples(), work->model(), work->how);
  if (!estimate) return tl::unexpected(work->of_the_samples(estimate.error()));
  const auto misfit = arm_misfit(estimate->value, work->samples());
  if (auto fine = check_misfit(*work, estimate->value, misfit); !fine) return tl::unexpected(fine.error());
  if (auto fine = check_size_of_motion(*work); !fine) return tl::unexpected(fine.error());
  auto gimbal = fit_gimbal(*work, *estimate);
  if (!gimbal) return tl::unexpected(gimbal.error());
  auto unseen = judge(*work, *estimate);
  if (!unseen) return tl::unexpected(unseen.error());
  const auto regions = held_out_by_region(work->samples(), work->model(), work->how);
  ArmFindings found{.method = work->how.method,
                    .free = free_text(work->how.free, work->model()) + (*gimbal ? ",gimbal" : ""),
                    .nominal = work->model(),
                    .samples = work->task.samples,
                    .estimate = std::move(*estimate),
                    .gimbal = std::move(*gimbal),
                    .unseen = unseen->errors,
                    .unseen_uncorrected = unseen->uncorrected,
                    .unseen_from = unseen->from,
                    .unseen_of_fitting = unseen->errors_of_fitting,
                    .regions = regions ? regions->means : std::vector<double>{},
                    .choice = work->choice,
                    .warnings = {},
                    .json = {}};
  found.warnings = warnings_of(*work, found, *unseen, misfit);
  found.json = arm_json(found);
  return found;
}

}  // namespace palpate::calibration::findings
