#include "palpate/calibration/verification.h"

#include <fmt/format.h>

#include <array>

#include "palpate/calibration/internal/change_search.h"
#include "palpate/calibration/internal/rig_figures.h"
#include "palpate/core/units.h"
#include "palpate/math/chi_square.h"

namespace palpate::calibration {
namespace {

constexpr std::array<const char*, kChanges> kNames{
    "camera",  "lens",  "arm base", "encoder zero", "stylus marker",
    "pointer", "table", "tracker",  "camera delay", "tracker delay"};

// Noise alone leaves more than this once in ten thousand verifications.
constexpr double kUnexplained = 1e-4;

bool finite(const RigObservations& observed) {
  bool fine = !observed.rest || observed.rest->allFinite();
  const auto pose = [&fine](const auto& X) {
    fine = fine && X.rotation.coeffs().allFinite() && X.translation.allFinite();
  };
  for (const auto& held : observed.held) {
    pose(held.X_world_marker);
    fine = fine && held.joints.allFinite() && held.covariance.allFinite() && held.systematic.allFinite();
  }
  for (const auto& touched : observed.touched) {
    pose(touched.X_world_pointer);
    fine = fine && touched.covariance.allFinite();
  }
  for (const auto& frame : observed.frames) {
    pose(frame.X_world_marker);
    fine = fine && frame.covariance.allFinite() && frame.rate.allFinite();
    for (const auto& dot : frame.dots) fine = fine && dot.centre.allFinite() && dot.covariance.allFinite();
  }
  return fine && std::isfinite(observed.tracker_delay_s.value_or(0.0)) &&
         std::isfinite(observed.tracker_delay_std_s);
}

bool nothing(const RigObservations& observed) {
  for (const auto& frame : observed.frames)
    if (!frame.dots.empty()) return false;
  return !observed.rest && observed.held.empty() && observed.touched.empty() && !observed.tracker_delay_s;
}

// Wrong use, which no observation excuses.
Expected<void> known(const rig::Rig& rig, const RigObservations& observed) {
  const auto joints = rig.arm->model.joint_count();
  if (observed.rest && observed.rest->size() != joints)
    return wrong_use("verification: {} readings at rest, the rig's arm has {} joints", observed.rest->size(),
                     joints);
  for (const auto& held : observed.held)
    if (held.joints.size() != joints)
      return wrong_use("verification: a pose of {} readings, the rig's arm has {} joints", held.joints.size(),
                       joints);
  const auto landmarks = static_cast<int>(rig.landmarks.size());
  for (const auto& touched : observed.touched) {
    const bool dot = touched.what == "landmark";
    if (!dot && rig.surface(touched.what) == nullptr)
      return wrong_use("verification: '{}' was touched, the rig has no such surface", touched.what);
    if (touched.index < 0 || touched.index >= (dot ? landmarks : 4))
      return wrong_use("verification: {} {} was touched, the rig has {} of them", touched.what,
                       touched.index + 1, dot ? landmarks : 4);
  }
  for (const auto& frame : observed.frames)
    for (const auto& dot : frame.dots)
      if (dot.landmark >= rig.landmarks.size())
        return wrong_use("verification: landmark {} was seen, the rig has {}", dot.landmark + 1, landmarks);
  return {};
}

// What of the differences the changes leave, whitened.
Eigen::VectorXd left_by(const RigMisfit& misfit, const ChangeFit& found) {
  return misfit.remaining(found.jacobian,
                          misfit.differences(changed(misfit.rig_state(), found.changes, found.amounts)));
}

// What one kind of observation leaves must not hide behind another that fits better than stated.
bool each_kind_fits(const RigMisfit& misfit, const Eigen::VectorXd& left) {
  const std::array kinds{misfit.rest(), misfit.held(), misfit.touched(), misfit.seen(), misfit.delay()};
  for (const auto& kind : kinds)
    if (kind.count > 0 && left.segment(kind.first, kind.count).squaredNorm() >
                              chi_square_quantile(kUnexplained / static_cast<double>(kinds.size()),
                                                  static_cast<double>(kind.count), true))
      return false;
  return true;
}

// Whose difference stands in this row of the misfit.
std::string observation_words(const RigMisfit& misfit, const RigObservations& observed, Eigen::Index row) {
  const auto within = [row](RigMisfit::Rows rows) {
    return row >= rows.first && row < rows.first + rows.count;
  };
  if (within(misfit.rest())) return fmt::format("joint {} at rest", row - misfit.rest().first + 1);
  if (within(misfit.held()))
    return fmt::format("the stylus held still, pose {} of {}", (row - misfit.held().first) / 3 + 1,
                       observed.held.size());
  if (within(misfit.touched())) {
    const auto& touched = observed.touched[static_cast<std::size_t>((row - misfit.touched().first) / 3)];
    return fmt::format("the touch of {} {}",
                       touched.what == "landmark" ? "landmark" : touched.what + ", corner",
                       touched.index + 1);
  }
  // The dots of a picture share its pose's error and are whitened together: no row belongs to one of them.
  Eigen::Index from = misfit.seen().first;
  for (std::size_t i = 0; i < observed.frames.size(); ++i) {
    from += 2 * static_cast<Eigen::Index>(observed.frames[i].dots.size());
    if (row < from) return fmt::format("the landmarks in picture {} of {}", i + 1, observed.frames.size());
  }
  return "the tracker's delay";
}

std::string amount_words(const FoundChange& found) {
  const auto turn_and_shift = [&] {
    return fmt::format("turned by {:.2f} deg and shifted by {:.2f} mm",
                       degrees_from_radians(found.amount.head<3>().norm()),
                       mm_from_metres(found.amount.tail<3>().norm()));
  };
  switch (found.change) {
    case Change::camera:
    case Change::base:
    case Change::table:
    case Change::tracker:
      return turn_and_shift();
    case Change::lens:
      return fmt::format("focal length by {:+.2f} %, principal point by ({:+.1f}, {:+.1f}) px",
                         100.0 * found.amount[0], found.amount[1], found.amount[2]);
    case Change::encoder_zero:
      return fmt::format("by {:.2f} deg", degrees_from_radians(found.amount.norm()));
    case Change::stylus_marker:
    case Change::pointer:
      return fmt::format("its tip is {:.2f} mm elsewhere", mm_from_metres(found.amount.norm()));
    case Change::camera_delay:
    case Change::tracker_delay:
      return fmt::format("by {:+.1f} ms", 1e3 * found.amount[0]);
  }
  return "";
}

const char* remedy(Change change) {
  switch (change) {
    case Change::camera:
      return "the camera has moved on its marker; palpate calibrate hand-eye";
    case Change::lens:
      return "the lens was refocused; palpate calibrate camera, then hand-eye";
    case Change::base:
      return "the arm's base has moved; palpate calibrate arm";
    case Change::encoder_zero:
      return "the encoders' zero was lost; set it in the reset position (--arm-at-reset)";
    case Change::stylus_marker:
      return "the marker on the stylus was bent or has slipped; palpate calibrate pivot, then arm";
    case Change::pointer:
      return "the pointer was bent; palpate calibrate pivot --marker pointer";
    case Change::table:
      return "table, wall and landmarks have moved; palpate calibrate surface, then landmarks";
    case Change::tracker:
      return "the tracker has moved; palpate calibrate arm, surface and landmarks";
    case Change::camera_delay:
      return "the camera's delay has changed; palpate calibrate hand-eye --estimate-delay";
    case Change::tracker_delay:
      return "the tracker's delay has changed; palpate calibrate delay";
  }
  return "";
}

}  // namespace

std::string_view name_of(Change change) { return kNames[static_cast<std::size_t>(change)]; }

std::optional<Change> change_of(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames[i]) return static_cast<Change>(i);
  return std::nullopt;
}

std::string change_words(const FoundChange& change) {
  return fmt::format("{}: {} ({})", name_of(change.change), amount_words(change), remedy(change.change));
}

Expected<Verification> verify_rig(const rig::Rig& rig, const RigObservations& observed,
                                  const VerificationOptions& options) {
  if (!rig.arm || !rig.camera || !rig.hand_eye)
    return refused("verification: the rig lacks its {}; palpate calibrate all finds it", !rig.arm ? "arm"
                                                                                         : !rig.camera
                                                                                             ? "camera"
                                                                                             : "hand-eye");
  if (observed.rest && !rig.arm->rest_known) {  // nothing to compare it with
    RigObservations others = observed;
    others.rest.reset();
    return verify_rig(rig, others, options);
  }
  if (auto fine = known(rig, observed); !fine) return tl::unexpected(fine.error());
  if (!finite(observed)) return refused("verification: an observation is not a number");
  if (nothing(observed)) return refused("verification: nothing was observed");
  const RigMisfit misfit(rig, observed, options);
  const ChangeSearch search = search_changes(misfit, options);
  Verification result;
  result.changes = search.told;
  result.tried = search.tried;
  result.freedoms = static_cast<double>(misfit.rows() - search.found.amounts.size());
  const Eigen::VectorXd left = left_by(misfit, search.found);
  Eigen::Index farthest = 0;
  result.farthest_sds = left.cwiseAbs().maxCoeff(&farthest);
  result.farthest = observation_words(misfit, observed, farthest);
  if (result.freedoms > 0.0) {
    result.misfit = search.found.cost / result.freedoms;
    result.explained = search.found.cost <= chi_square_quantile(kUnexplained, result.freedoms, true) &&
                       each_kind_fits(misfit, left);
  }
  result.figures = rig_figures(misfit, observed, search.found, options);
  return result;
}

}  // namespace palpate::calibration
