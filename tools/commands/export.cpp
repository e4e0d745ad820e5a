// palpate export: a rig, or a part of it, as other programs read it.
#include <fmt/format.h>

#include <memory>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/toml.h"
#include "palpate/device/arm_model_file.h"
#include "palpate/formats/write.h"
#include "palpate/rig/rig.h"
#include "palpate/rig/urdf.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {
namespace {

struct ExportArguments {
  std::string rig, form, part, out;
};

struct Part {
  std::string name, what;  // "hand-eye", "the camera in its marker"
  formats::Content content;
};

formats::Content lens_of(const device::CameraModel& model) {
  return {"", "",
          formats::Lens{model.fx, model.fy, model.cx, model.cy, model.distortion, model.kind,
                        std::array<int, 2>{model.width, model.height}}};
}

template <typename A, typename B>
formats::Content transform_of(const Pose<A, B>& pose) {
  formats::Transform transform;
  transform.matrix.topLeftCorner<3, 3>() = pose.matrix();
  transform.matrix.topRightCorner<3, 1>() = pose.translation;
  return {"", "", transform};
}

// Corners of the surfaces and middles of the dots, in World.
formats::Content points_of(const rig::Rig& rig) {
  formats::Points points;
  for (const auto& surface : rig.surfaces)
    for (int i = 0; i < 4; ++i) {
      points.places.push_back(surface.corner(i).m);
      points.labels.push_back(fmt::format("{}_{}", surface.name, i + 1));
    }
  for (std::size_t i = 0; i < rig.landmarks.size(); ++i) {
    points.places.push_back(rig.landmarks[i].place.m);
    points.labels.push_back(fmt::format("dot_{}", i + 1));
  }
  return {"", "", points};
}

// Everything of the rig that other programs have a form for, the likeliest first.
std::vector<Part> parts_of(const rig::Rig& rig) {
  std::vector<Part> parts;
  if (rig.camera) parts.push_back({"camera", "the camera's lens", lens_of(rig.camera->model)});
  if (rig.right_camera)
    parts.push_back({"right-camera", "the right camera's lens", lens_of(rig.right_camera->model)});
  if (rig.hand_eye)
    parts.push_back({"hand-eye", "the camera in its marker", transform_of(rig.hand_eye->X_marker_camera)});
  if (rig.right_hand_eye)
    parts.push_back({"right-hand-eye", "the right camera in its marker",
                     transform_of(rig.right_hand_eye->X_marker_camera)});
  if (rig.arm)
    parts.push_back(
        {"arm-base", "the arm's base in the tracker's frame", transform_of(rig.arm->X_world_base)});
  if (rig.tip_pivot)
    parts.push_back(
        {"tip", "the tip in its marker",
         transform_of(Pose<TipMarker, Tip>{Quaternion::Identity(), rig.tip_pivot->tip_in_marker})});
  for (const auto& surface : rig.surfaces)
    parts.push_back({surface.name, "a surface's corner frame in the tracker's frame",
                     transform_of(surface.X_world_rectangle)});
  if (!rig.surfaces.empty() || !rig.landmarks.empty())
    parts.push_back({"points", "corners of surfaces and middles of dots", points_of(rig)});
  return parts;
}

// The arm alone, as --arm of `calibrate arm` reads it; the calibrated one where there is one.
std::string arm_toml(const rig::Rig& rig) {
  const device::ArmModel& model = rig.arm ? rig.arm->model : rig.nominal_arm;
  if (model.kind == device::ArmModel::Kind::phantom)
    return fmt::format("type = \"phantom\"\nlengths_mm = [{}, {}]\n", kMm * model.lengths.l1,
                       kMm * model.lengths.l2);
  if (model.kind == device::ArmModel::Kind::cartesian) return device::cartesian_text(model);
  return "type = \"dh\"\n" + device::tool_text(model) + device::dh_joints_text(model, "joint");
}

Expected<std::string> part_as(const ExportArguments& options, const rig::Rig& rig) {
  const auto form = formats::written_form("", options.form);
  if (!form) return tl::unexpected(form.error());
  std::string fitting, known;
  std::optional<std::string> text;
  for (const auto& part : parts_of(rig)) {
    known += (known.empty() ? "" : ", ") + part.name;
    if (!options.part.empty() && options.part != part.name) continue;
    auto written = formats::text_of(part.content, *form);
    if (!written) {
      if (options.part.empty()) continue;
      return wrong_use("--part {}: {}", excerpt(options.part), written.error().message);
    }
    if (!text) text = std::move(*written);
    fitting += (fitting.empty() ? "" : ", ") + part.name;
  }
  if (!options.part.empty() && !text)
    return wrong_use("{}: has no part '{}'; it has {}", options.rig, excerpt(options.part),
                     known.empty() ? "none yet: calibrate first" : known);
  if (!text)
    return refused("{}: holds nothing that is written as {}; it has {}", options.rig, options.form,
                   known.empty() ? "nothing yet: calibrate first" : known);
  // Which of several lenses is meant is plain, which of several transforms is not.
  const bool lens = fitting.starts_with("camera");
  if (!lens && fitting.find(',') != std::string::npos)
    return wrong_use("--as {}: {} has several: {}; name one with --part", options.form, options.rig, fitting);
  return *text;
}

Expected<void> run_export(const ExportArguments& options) {
  if (options.out != "-" && same_file(options.rig, options.out))
    return wrong_use("--out {}: is the rig itself; another name is expected for the new file", options.out);
  const auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  Expected<std::string> text;
  if (options.form == "urdf" || options.form == "arm") {
    if (!options.part.empty())
      return wrong_use("--part {}: goes with forms of one part, not with {}", excerpt(options.part),
                       options.form);
    if (options.form == "urdf" && !rig->arm)
      return refused("{}: its arm is not calibrated; palpate calibrate arm --rig {} comes first", options.rig,
                     options.rig);
    text = options.form == "urdf" ? rig::urdf_of(*rig) : arm_toml(*rig);
  } else {
    text = part_as(options, *rig);
  }
  if (!text) return tl::unexpected(text.error());
  if (options.out == "-") {
    fmt::print("{}", *text);
    return {};
  }
  if (auto done = write_file(options.out, *text); !done) return done;
  print_line(fmt::format("written to {}", options.out), stdout);
  return {};
}

}  // namespace

void add_export(CLI::App& program) {
  auto options = std::make_shared<ExportArguments>();
  auto* command = program.add_subcommand(
      "export", "A rig as other programs read it: its arm as URDF, a lens, a transform, its points");
  command->add_option("rig", options->rig, "The rig file")->required()->type_name("RIG");
  std::vector<std::string> names{"urdf", "arm"};
  for (const auto& form : formats::written_forms())
    if (form.name != "tum" && form.name != "kitti" && form.name != "euroc")
      names.push_back(form.name);  // of poses, which a rig has none of
  command->add_option("--as", options->form, "Form to write (docs/files-of-others.md)")
      ->required()
      ->check(one_of(names));
  command
      ->add_option("--part", options->part,
                   "Which part: camera, right-camera, hand-eye, right-hand-eye, arm-base, tip, points, or a "
                   "surface's name")
      ->type_name("PART");
  command->add_option("--out", options->out, "Its file; one that is there is replaced (- = standard output)")
      ->default_val("-")
      ->type_name("FILE");
  on(command, [options] { return run_export(*options); });
}

}  // namespace palpate::tools::commands
