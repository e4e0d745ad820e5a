#include "palpate/rig/rig.h"

#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "palpate/core/file.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/rig/doubtful_values.h"
#include "palpate/scene/mesh_file.h"
#include "tools/commands/arm_result.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {
namespace {

struct RigArguments {
  std::string file;
  std::vector<double> rest_readings;     // deg, or mm of a Cartesian arm
  std::optional<double> rest_tolerance;  // the same; none: a hand's
  bool force = false;
  std::string arm;  // of a new one: a model's name or file; empty: a PHANToM
};

// A rig before any calibration: makers' link lengths, and markers of the sizes the simulated laboratory uses,
// which a user replaces.
rig::Rig nominal_rig() {
  rig::Rig rig;
  const auto leds = [](std::initializer_list<Vector3> mm) {
    std::vector<Vector3> result;
    for (const auto& led : mm) result.push_back(led / kMm);
    return result;
  };
  rig.tip_marker_leds =
      leds({{60, 0, 0}, {30, 52, 8}, {-30, 52, 0}, {-60, 0, 8}, {-30, -52, 0}, {30, -52, 8}});
  rig.camera_marker_leds =
      leds({{70, 0, 0}, {35, 61, 10}, {-35, 61, 0}, {-70, 0, 10}, {-35, -61, 0}, {35, -61, 10}});
  rig.pointer_leds = leds({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {50, 60, 10}});
  for (double* length : {&rig.nominal_arm.lengths.l1, &rig.nominal_arm.lengths.l2})
    *length = rig::as_filed(*length);
  return rig;
}

// What is known to a tenth.
std::string hundredths(const Eigen::VectorXd& values) {
  return fmt::format("{:.2f}", fmt::join(values, " "));
}

void line(const char* name, const std::string& text) { print_line(fmt::format("{:<22} {}", name, text)); }

Expected<void> make_new(const RigArguments& options) {
  rig::Rig rig = nominal_rig();
  if (!options.arm.empty()) {
    auto model = device::read_arm_model(options.arm);
    if (!model) return tl::unexpected(model.error());
    if (auto fine = device::check_runnable(*model); !fine) return fine;
    rig.nominal_arm = std::move(*model);
  }
  if (!options.force && options.file != "-" && is_there(options.file))
    return wrong_use("{}: exists already; choose another name, or --force to replace it", options.file);
  const std::string head =
      "# A new rig: link lengths and LEDs below are nominal, replace them by those of your devices (arm "
      "frame and marker\n"
      "# frames, mm). Everything else is added by the calibrations, each with date, data and uncertainty:\n"
      "#   palpate calibrate pivot | arm | camera | hand-eye | surface | landmarks ... --rig FILE,   or   "
      "palpate "
      "calibrate all --rig FILE\n"
      "# `palpate rig check FILE` says what is still missing.\n";
  if (const auto written = write_file(options.file, head + rig::rig_text(rig)); !written) return written;
  if (options.file == "-") return {};
  line("new", options.file);
  line("next", rig.nominal_arm.kind != device::ArmModel::Kind::dh
                   ? "palpate calibrate all --arm URI --tracker URI --camera URI --rig " + options.file
                   : "palpate calibrate arm --samples FILE --rig " + options.file +
                         ", and the other calibrations from files: `calibrate all` knows no chains");
  return {};
}

std::string origin(const rig::Provenance& from, const char* unit = "mm") {
  if (from.date.empty() && from.method.empty()) return "no provenance";
  // One touch of each dot leaves no residual.
  const std::string date = from.date.empty()                  ? "no date"
                           : from.date == rig::kSimulatedDate ? "simulated"
                                                              : from.date;
  const std::string residual =
      from.rms_mm > 0.0 ? fmt::format("residual {:.4f} {} rms", from.rms_mm, unit) : "no residual";
  return fmt::format("{}, {}, {}, data {}", date, from.method.empty() ? "?" : from.method, residual,
                     from.data_hash.empty() ? "?" : from.data_hash);
}

// "x y z +- sx sy sz": variances at `at` of the covariance, nothing where there is none.
std::string with_sd(const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance, Eigen::Index at,
                    double unit) {
  std::string text = shown(value, unit);
  if (covariance.rows() >= at + value.size())
    text += "  +- " + shown(standard_deviations(covariance).segment(at, value.size()), unit);
  return text;
}

std::string delay_text(double delay_s, double std_s, bool known) {
  return known ? fmt::format("{:.3f} +- {:.3f}", 1e3 * delay_s, 1e3 * std_s) : "not measured";
}

std::string lengths_text(const device::ArmModel& model) {
  return fmt::format("{:.3f} {:.3f}", kMm * model.lengths.l1, kMm * model.lengths.l2);
}

void show_chain(const rig::ArmCalibration& arm) {
  line("  joints", fmt::format("{}, a chain; a mm, alpha deg, d mm, theta offset deg, range deg:",
                               arm.model.joint_count()));
  for (std::size_t j = 0; j < arm.model.joints.size(); ++j) {
    const auto& row = arm.model.joints[j];
    const auto& [low, high] = row.range;
    line(fmt::format("    {}", j + 1).c_str(),
         fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}, {}", kMm * row.a, degrees_from_radians(row.alpha),
                     kMm * row.d, degrees_from_radians(row.theta_offset),
                     row.range.known() ? fmt::format("{:.1f} to {:.1f}", degrees_from_radians(low),
                                                     degrees_from_radians(high))
                                       : "not told"));
  }
  line("  tool, mm", with_sd(arm.model.tool, arm.covariance, 2 * arm.model.joint_count() + 9, kMm));
  line("  stylus on it, deg", shown(so3_log(arm.model.tool_turn), kDegreesPerRadian));
}

void show_cartesian(const rig::ArmCalibration& arm) {
  std::string ranges;
  for (const auto& [low, high] : arm.model.places)
    ranges += fmt::format("{}{:.1f} to {:.1f}", ranges.empty() ? "" : ", ", kMm * low, kMm * high);
  line("  range x, y, z, mm", ranges);
  const auto& terms = arm.model.correction.terms;
  line("  correction, mm", fmt::format("strains {}; bends up to {:.3f}", shown(terms.head<6>(), kMm),
                                       kMm * terms.tail<18>().cwiseAbs().maxCoeff()));
}

void show_arm(const rig::ArmCalibration& arm) {
  const auto& C = arm.covariance;
  const Eigen::Index n = arm.model.joint_count();
  line("arm", fmt::format("{}  ({})", arm.model.name, origin(arm.from)));
  if (arm.model.kind == device::ArmModel::Kind::cartesian) {
    show_cartesian(arm);
  } else {
    line("  gains", with_sd(arm.correction.gain, C, 0, 1.0));
    line("  offsets, deg", with_sd(arm.correction.offset, C, n, kDegreesPerRadian));
    if (arm.model.kind == device::ArmModel::Kind::phantom)
      line("  lengths, mm", lengths_text(arm.model));
    else
      show_chain(arm);
  }
  line("  base in world, mm", with_sd(arm.X_world_base.translation, C, 2 * n + 3, kMm));
  line("  base turn, deg", with_sd(so3_log(arm.X_world_base.rotation), C, 2 * n, kDegreesPerRadian));
  line("  tip in marker, mm", with_sd(arm.tip_in_marker, C, 2 * n + 6, kMm));
  const auto unit = device::reading_unit(arm.model);
  line(fmt::format("  rest readings, {}", unit.name).c_str(),
       arm.rest_known ? shown(arm.rest_readings, unit.per_si) : "not known");
  line("  held-out error, mm", fmt::format("{:.4f}", kMm * arm.held_out_mean));
}

// Which arm may be given forces by this rig, as far as the rig alone can tell.
void show_forces(const rig::Rig& rig) {
  if (!rig.forces) {
    line("forces", "not checked: a real arm is given none; palpate calibrate forces --arm URI --rig FILE");
    return;
  }
  const rig::ForceCalibration& forces = *rig.forces;
  const std::string change = rig::void_reason(rig, "");
  line("forces",
       change.empty()
           ? fmt::format("checked on {}  ({}, {})", forces.identity, forces.date, forces.method)
           : fmt::format("void: since they were checked {}; palpate calibrate forces again", change));
  line("  joint gains",
       hundredths(forces.joint_gains) +
           (forces.joint_gains_std.size() > 0 ? "  +- " + hundredths(forces.joint_gains_std) : ""));
  line("  size",
       forces.gain ? fmt::format("{:.3f} +- {:.3f}, peak {:g} N", *forces.gain, forces.gain_std, forces.peak)
                   : fmt::format("not told by a weight, peak {:g} N", forces.peak));
  if (forces.dead_man_button > 0)
    line("  dead-man switch", fmt::format("button {} of the stylus", forces.dead_man_button));
}

void show_camera(const char* name, const rig::CameraCalibration& camera) {
  const auto& m = camera.model;
  line(name, fmt::format("{} x {} px  ({})", m.width, m.height, origin(camera.from, "px")));
  const Eigen::Vector4d lens(m.fx, m.fy, m.cx, m.cy);
  line("  fx fy cx cy, px",
       shown(lens) + (camera.covariance.rows() == device::kLensParameters
                          ? "  +- " + shown(standard_deviations(camera.covariance).head<4>())
                          : ""));
  const auto terms = m.coefficients();
  line((std::string("  ") + device::coefficient_names(m.kind)).c_str(),
       shown(Eigen::Map<const Eigen::VectorXd>(terms.data(), static_cast<Eigen::Index>(terms.size()))));
}

void show_hand_eye(const char* name, const rig::HandEyeCalibration& h) {
  line(name, "(" + origin(h.from) + ")");
  line("  camera in marker, mm", with_sd(h.X_marker_camera.translation, h.covariance, 3, kMm));
  line("  turn, deg", with_sd(so3_log(h.X_marker_camera.rotation), h.covariance, 0, kDegreesPerRadian));
}

// How good the rig was when it was last verified.
void show_verification(const rig::VerificationRecord& last) {
  std::string found = last.holds ? "holds" : "does not hold";
  for (std::size_t i = 0; i < last.changed.size(); ++i) found += (i == 0 ? ": " : ", ") + last.changed[i];
  line("verified", fmt::format("{}, {}: {}", last.date, last.form, found));
  for (const auto& f : last.figures)
    line(("  " + f.name).c_str(),
         fmt::format("{:.3f} ({:.3f} to {:.3f}), promised below {:.3f}", f.error, f.low, f.high, f.promised));
}

// Values that cannot be right, and bodies whose shape cannot be read: graphics would refuse those.
std::vector<rig::DoubtfulValue> doubts_of(const rig::Rig& rig) {
  auto doubts = rig::doubtful_values(rig);
  for (const auto& object : rig.objects)
    if (const auto mesh = scene::read_mesh(rig.folder / object.mesh, object.metres_per_unit); !mesh)
      doubts.push_back({fmt::format("object '{}'", object.name), mesh.error().message});
  return doubts;
}

std::string parts_of(const std::vector<rig::DoubtfulValue>& doubts) {
  std::vector<std::string> names;
  for (const auto& doubt : doubts)
    if (names.empty() || names.back() != doubt.part) names.push_back(doubt.part);
  return fmt::format("{}", fmt::join(names, ", "));
}

Expected<void> show(const RigArguments& options) {
  const auto rig = rig::read_rig(options.file);
  if (!rig) return tl::unexpected(rig.error());
  line("rig", rig->name);
  if (rig->nominal_arm.kind == device::ArmModel::Kind::phantom)
    line("nominal lengths, mm", lengths_text(rig->nominal_arm));
  else if (rig->nominal_arm.kind == device::ArmModel::Kind::cartesian)
    line("nominal arm", fmt::format("{}, which states its place", rig->nominal_arm.name));
  else
    line("nominal arm",
         fmt::format("{}, a chain of {} joints", rig->nominal_arm.name, rig->nominal_arm.joint_count()));
  line("LEDs", fmt::format("tip marker {}, camera marker {}, pointer {}", rig->tip_marker_leds.size(),
                           rig->camera_marker_leds.size(), rig->pointer_leds.size()));
  if (rig->tip_pivot)
    line("tip pivot, mm", with_sd(rig->tip_pivot->tip_in_marker, rig->tip_pivot->covariance, 0, kMm) + "  (" +
                              origin(rig->tip_pivot->from) + ")");
  if (rig->pointer_pivot)
    line("pointer pivot, mm",
         with_sd(rig->pointer_pivot->tip_in_marker, rig->pointer_pivot->covariance, 0, kMm) + "  (" +
             origin(rig->pointer_pivot->from) + ")");
  if (rig->arm) show_arm(*rig->arm);
  if (rig->arm && rig->arm->model.name != rig::kMouseArm) show_forces(*rig);
  if (rig->camera) show_camera("camera", *rig->camera);
  if (rig->hand_eye) show_hand_eye("hand-eye", *rig->hand_eye);
  if (rig->right_camera) show_camera("right camera", *rig->right_camera);
  if (rig->right_hand_eye) show_hand_eye("right hand-eye", *rig->right_hand_eye);
  if (const auto& h = rig->headset) {
    line("headset", "(" + origin(h->from) + ")");
    line("  camera before the eyes, mm", with_sd(h->X_eyes_camera.translation, h->covariance, 3, kMm));
    line("  turn, deg", with_sd(so3_log(h->X_eyes_camera.rotation), h->covariance, 0, kDegreesPerRadian));
    line("  delay, ms", delay_text(h->delay_s, h->delay_std_s, true));
  }
  if (const auto& d = rig->delays)
    line("delays, ms",
         fmt::format("tracker after arm {}, camera after tracker {}",
                     delay_text(d->tracker_after_arm_s, d->tracker_std_s, d->tracker_known()),
                     delay_text(d->camera_after_tracker_s, d->camera_std_s, d->camera_known())));
  for (const auto& s : rig->surfaces)
    line(("surface " + s.name).c_str(),
         fmt::format("{:.1f} x {:.1f} mm, corner at {}  ({})", kMm * s.width, kMm * s.height,
                     shown(s.corner(0).m, kMm), origin(s.from)));
  if (!rig->landmarks.empty()) {
    double sum = 0.0;
    for (const auto& l : rig->landmarks)
      sum += l.covariance.trace() / (3.0 * static_cast<double>(rig->landmarks.size()));
    line("landmarks", fmt::format("{}, known to {:.3f} mm rms per axis  ({})", rig->landmarks.size(),
                                  kMm * std::sqrt(sum), origin(rig->landmarks_from)));
  }
  if (const auto& placed = rig->board)
    line("board", fmt::format("{}x{} squares of {:.3f} mm, dictionary {}, first corner at {} mm",
                              placed->board.columns, placed->board.rows, kMm * placed->board.square,
                              placed->board.dictionary, shown(placed->X_world_board.translation, kMm)));
  if (const auto& light = rig->light)
    line("light", fmt::format("lamp at {} mm, radius {:.0f} mm, key {:.2f}, ambient {:.2f}",
                              shown(light->lamp, kMm), kMm * light->lamp_radius, light->key, light->ambient));
  for (const auto& object : rig->objects)
    line(("object " + object.name).c_str(),
         fmt::format("{} at {} mm", object.mesh, shown(object.position, kMm)));
  if (!rig->verifications.empty()) show_verification(rig->verifications.back());
  for (const auto& missing : rig::missing_parts(*rig))
    line("missing", fmt::format("{}: {}", missing.part, missing.remedy));
  for (const auto& doubt : doubts_of(*rig)) line("doubtful", fmt::format("{}: {}", doubt.part, doubt.what));
  return {};
}

Expected<void> check_rest(const RigArguments& options, const rig::Rig& rig) {
  if (!rig.arm)
    return refused(
        "{}: holds no arm calibration whose rest readings could be compared; palpate calibrate arm",
        options.file);
  const auto& given = options.rest_readings;
  const auto unit = device::reading_unit(rig.arm->model);
  const double tolerance = options.rest_tolerance.value_or(unit.per_si * rig::rest_tolerance(rig.arm->model));
  const auto now = rest_readings_of(given, rig.arm->model);
  if (!now) return tl::unexpected(now.error());
  if (!rig.arm->rest_known)
    return refused(
        "{}: does not tell what the arm read at rest when it was calibrated (from a table, which has no such "
        "row); read with the arm at rest, they go to palpate calibrate arm --rest-readings, or as "
        "rest_readings_{} into its [arm]",
        options.file, unit.name);
  const device::JointVector change = rig::rest_change(*rig.arm, *now);
  Eigen::Index joint = 0;
  if (unit.per_si * change.cwiseAbs().maxCoeff(&joint) <= tolerance) {
    line("encoder reset",
         fmt::format("unchanged since {} (within {:.3f} {})",
                     rig.arm->from.date.empty() ? "calibration" : rig.arm->from.date, tolerance, unit.name));
    return {};
  }
  return refused(
      "{}: the encoder reset has changed since calibration: at rest joint {} reads {:.3f} {}, {:.3f} then, "
      "{:.3f} allowed; put the arm into "
      "its rest position and reset it again, or calibrate anew",
      options.file, joint + 1, unit.per_si * (*now)[joint], unit.name,
      unit.per_si * rig.arm->rest_readings[joint], tolerance);
}

Expected<void> check(const RigArguments& options) {
  const auto rig = rig::read_rig(options.file);
  if (!rig) return tl::unexpected(rig.error());
  if (!options.rest_readings.empty())
    if (const auto rest = check_rest(options, *rig); !rest) return rest;
  if (rig->arm && rig->arm->model.name != rig::kMouseArm) {
    show_forces(*rig);
    if (!rig->delays || !rig->delays->tracker_known())
      line("tracker's delay",
           "not measured: while it moves the stylus is drawn where it was some milliseconds before or after; "
           "palpate "
           "calibrate arm --free ...,delay on samples in motion, or palpate calibrate all");
  }
  const auto missing = rig::missing_parts(*rig);
  const auto doubts = doubts_of(*rig);
  std::string names;
  for (const auto& part : missing) {
    line("missing", fmt::format("{}: {}", part.part, part.remedy));
    names += (names.empty() ? "" : ", ") + part.part;
  }
  for (const auto& doubt : doubts) line("doubtful", fmt::format("{}: {}", doubt.part, doubt.what));
  if (!missing.empty())
    return refused(
        "{}: is valid but not complete, it lacks {}{}; calibrate these with --rig {}{}", options.file, names,
        doubts.empty() ? "" : ", and cannot be right in " + parts_of(doubts), options.file,
        rig->nominal_arm.kind == device::ArmModel::Kind::phantom &&
                !(rig->arm && rig->arm->model.name == rig::kMouseArm)
            ? ", or all in one session: palpate calibrate all --arm URI --tracker URI --camera URI --rig " +
                  options.file
            : "");
  if (!doubts.empty())
    return refused("{}: is complete, but cannot be right in {}; repair what is called doubtful above",
                   options.file, parts_of(doubts));
  line("complete", options.file);
  return {};
}

}  // namespace

void add_rig(CLI::App& program) {
  auto options = std::make_shared<RigArguments>();
  auto* rig = program.add_subcommand("rig", "The rig file: devices, calibrations, uncertainty, provenance");
  rig->require_subcommand(1);
  const auto with_file = [&](const char* name, const char* help) {
    auto* command = rig->add_subcommand(name, help);
    command->add_option("FILE", options->file, "The rig file")->required();
    return command;
  };
  auto* create = with_file("new", "Write a commented template with nominal values");
  create->add_flag("--force", options->force, "Replace an existing file");
  create
      ->add_option("--arm", options->arm,
                   "The maker's arm, as `calibrate arm` knows it: phantom-premium-1.5, laboratory-delta, or "
                   "a TOML file")
      ->type_name("MODEL");
  add_rig_webcam(*rig);
  on(create, [options] { return make_new(*options); });
  on(with_file("show", "Print a rig for a person"), [options] { return show(*options); });
  auto* checked = with_file("check", "Validate a rig and say what is missing or cannot be right");
  checked
      ->add_option("--rest-readings", options->rest_readings,
                   "Encoder readings at rest, deg (of a Cartesian arm mm): has the encoder reset changed?")
      ->delimiter(',')
      ->expected(3, device::kMostJoints)
      ->type_name("PSI1,PSI2,PSI3[,...]");
  checked
      ->add_option(
          "--rest-tolerance-deg", options->rest_tolerance,
          "How well the arm is put to rest, half a degree where it is not told; of a Cartesian arm mm")
      ->check(at_least_zero());
  on(checked, [options] { return check(*options); });
}

}  // namespace palpate::tools::commands
