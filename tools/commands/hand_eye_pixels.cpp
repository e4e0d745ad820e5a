#include <algorithm>
#include <filesystem>
#include <map>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/pose_file.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/pixel_hand_eye.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/hand_eye_arguments.h"
#include "tools/commands/hand_eye_output.h"
#include "tools/commands/lens_file.h"

namespace palpate::tools::commands {
namespace {

const std::vector<std::string> kLensParameterNames = {"fx_px", "fy_px", "cx_px", "cy_px", "k1",
                                                      "k2",    "p1",    "p2",    "k3"};

// Views and hand poses that belong together; times where stamps tell them.
struct Joined {
  std::vector<device::StampedPose> hand;
  std::vector<vision::BoardView> views;
  std::vector<double> time_s;
  std::string by;
};

// Tables name images without the folder that a pattern finds them in.
std::string image_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

void note_left_out(std::size_t count, const char* why, std::vector<std::string>& warnings) {
  if (count > 0) warnings.push_back(fmt::format("{} {} left out", counted(count, "view"), why));
}

Expected<Joined> join_by_stamps(const HandEyeArguments& options, const device::PoseFile& hand,
                                const vision::BoardViews& views, std::vector<std::string>& warnings) {
  if (!hand.has_time) return wrong_use("{}: has no times; --stamps needs them", options.hand);
  const auto table = read_csv(options.stamps);
  if (!table) return tl::unexpected(table.error());
  const auto image = table->require("image"), time = table->require("time_s");
  if (!image) return tl::unexpected(image.error());
  if (!time) return tl::unexpected(time.error());
  if (const auto fine = table->require_within({*time}, kLatestTime); !fine)
    return tl::unexpected(fine.error());
  std::map<std::string, double> stamps;
  for (std::size_t i = 0; i < table->rows.size(); ++i)
    stamps[image_name(table->text[i][*image])] = table->rows[i][*time];
  Joined joined{hand.poses, {}, {}, "stamps"};
  for (const auto& view : views.views)
    if (const auto at = stamps.find(image_name(view.name)); at != stamps.end()) {
      joined.views.push_back(view);
      joined.time_s.push_back(at->second);
    }
  if (joined.views.empty())
    return refused("{}: names none of the {}; the names of the images are expected, such as '{}'",
                   options.stamps, counted(views.views.size(), "view"),
                   excerpt(image_name(views.views.front().name)));
  note_left_out(views.views.size() - joined.views.size(), "without a stamp", warnings);
  return joined;
}

Expected<Joined> join_by_name(const device::PoseFile& hand, std::size_t column,
                              const vision::BoardViews& views, std::vector<std::string>& warnings) {
  std::map<std::string, std::size_t> rows;
  for (std::size_t i = 0; i < hand.poses.size(); ++i) rows[image_name(hand.table.text[i][column])] = i;
  Joined joined{{}, {}, {}, "name"};
  for (const auto& view : views.views)
    if (const auto at = rows.find(image_name(view.name)); at != rows.end()) {
      joined.views.push_back(view);
      joined.hand.push_back(hand.poses[at->second]);
    }
  if (joined.views.empty())
    return refused("{}: its column image names none of the {}; names such as '{}' are expected", hand.source,
                   counted(views.views.size(), "view"), excerpt(image_name(views.views.front().name)));
  note_left_out(views.views.size() - joined.views.size(), "without a hand pose", warnings);
  return joined;
}

// The n-th image belongs to the n-th pose, whether the board was found in it or not.
Expected<Joined> join_by_order(const HandEyeArguments& options, const device::PoseFile& hand,
                               const vision::BoardViews& views) {
  std::vector<std::string> images = views.not_found;
  for (const auto& view : views.views) images.push_back(view.name);
  if (!views.not_found.empty()) std::sort(images.begin(), images.end());
  if (images.size() != hand.poses.size())
    return wrong_use(
        "{} has {}, {} has {}; they belong together one by one, unless --stamps or a column image in {} "
        "says how",
        options.hand, counted(hand.poses.size(), "pose"), source_of(options.board),
        counted(images.size(), "image"), options.hand);
  Joined joined{{}, views.views, {}, "order"};
  for (std::size_t i = 0; i < images.size(); ++i)
    if (std::find(views.not_found.begin(), views.not_found.end(), images[i]) == views.not_found.end())
      joined.hand.push_back(hand.poses[i]);
  return joined;
}

Expected<Joined> join(const HandEyeArguments& options, const device::PoseFile& hand,
                      const vision::BoardViews& views, std::vector<std::string>& warnings) {
  if (!options.stamps.empty()) return join_by_stamps(options, hand, views, warnings);
  if (options.estimate_delay || options.delay_s != 0.0)
    return wrong_use(
        "calibrate hand-eye: the delay needs the views' times; give --stamps FILE (image,time_s)");
  const auto column = hand.table.find("image");
  if (column && hand.table.text.size() == hand.poses.size())
    return join_by_name(hand, *column, views, warnings);
  return join_by_order(options, hand, views);
}

Json to_json(const HandEyeArguments& options, const Estimate<vision::PixelHandEye>& fit, const Joined& joined,
             const std::vector<std::string>& warnings, const std::string& hash) {
  const auto& s = fit.value;
  const auto sd = standard_deviations(fit.covariance);
  Json json;
  json["translation_mm"] = json_list(s.X_marker_camera.translation, kMm);
  json["rotation_qwxyz"] = json_quaternion(s.X_marker_camera.rotation);
  json["delay_s"] = s.delay_s;
  json["delay_std_s"] = sd[12];
  json["rotation_residual_median_deg"] = degrees_from_radians(s.rotation_residual_median);
  json["translation_residual_median_mm"] = kMm * s.translation_residual_median;
  json["warnings"] = warnings;
  json["rms_px"] = s.rms_px;
  json["views"] = s.views.size();
  json["joined_by"] = joined.by;
  json["board_in_world"] = {{"translation_mm", json_list(s.X_world_board.translation, kMm)},
                            {"rotation_qwxyz", json_quaternion(s.X_world_board.rotation)}};
  const auto terms = s.lens.coefficients();
  json["lens"] = {{"estimated", sd[13] > 0.0},
                  {"fx", s.lens.fx},
                  {"fy", s.lens.fy},
                  {"cx", s.lens.cx},
                  {"cy", s.lens.cy},
                  {"lens", device::lens_word(s.lens.kind)},
                  {"distortion", std::vector<double>(terms.begin(), terms.end())},
                  {"width_px", s.lens.width},
                  {"height_px", s.lens.height}};
  json["corner_noise_px"] = s.noise_px;
  json["tracker_noise_mm"] = kMm * s.place_sd;
  json["tracker_noise_deg"] = degrees_from_radians(s.turn_sd);
  json["tracker_noise_stated"] = options.tracker_sd_mm > 0.0 && options.tracker_sd_deg > 0.0;
  json["board_scale"] = s.board_scale;
  json["rotation_range_deg"] = degrees_from_radians(s.rotation_range);
  json["condition"] = fit.condition;
  json["std"] = {{"rotation_deg", json_list(sd.segment<3>(0), kDegreesPerRadian)},
                 {"translation_mm", json_list(sd.segment<3>(3), kMm)},
                 {"board_rotation_deg", json_list(sd.segment<3>(6), kDegreesPerRadian)},
                 {"board_translation_mm", json_list(sd.segment<3>(9), kMm)},
                 {"delay_s", sd[12]},
                 {"lens", json_list(sd.tail<9>())},
                 {"board_scale", s.board_scale_sd}};
  std::vector<std::string> names;
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(22);
  for (const char* part : {"camera", "board"})
    for (const char* kind : {"turn_{}_deg", "{}_mm"})
      for (const char* axis : {"x", "y", "z"}) {
        scales[static_cast<Eigen::Index>(names.size())] = kind[0] == 't' ? kDegreesPerRadian : kMm;
        names.push_back(fmt::format("{}_{}", part, fmt::format(fmt::runtime(kind), axis)));
      }
  names.emplace_back("delay_s");
  names.insert(names.end(), kLensParameterNames.begin(), kLensParameterNames.end());
  json["covariance"] = json_covariance(names, fit.covariance, scales);
  json["data"] = {{"hand", options.hand},
                  {"board", source_of(options.board)},
                  {"stamps", options.stamps},
                  {"lens", options.lens},
                  {"hash", hash}};
  return json;
}

std::vector<std::string> summary_of(const Estimate<vision::PixelHandEye>& fit, bool delay,
                                    const std::vector<std::string>& warnings) {
  const auto& s = fit.value;
  const auto sd = standard_deviations(fit.covariance);
  std::vector<std::string> lines = {
      fmt::format("camera in marker  {} mm  +- {}", shown(s.X_marker_camera.translation, kMm),
                  shown(sd.segment<3>(3), kMm)),
      fmt::format("turned by         {} deg about x, y, z  +- {}",
                  shown(so3_log(s.X_marker_camera.rotation), kDegreesPerRadian),
                  shown(sd.segment<3>(0), kDegreesPerRadian))};
  if (delay)
    lines.push_back(fmt::format("delay             {:.5f} +- {:.5f} s (hand time = view time + delay)",
                                s.delay_s, sd[12]));
  if (sd[13] > 0.0)
    lines.push_back(
        fmt::format("focal length      {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px, found with the rest", s.lens.fx,
                    sd[13], s.lens.fy, sd[14]));
  lines.push_back(fmt::format(
      "residual          {:.3f} px rms over {}; corners {:.3f} px, tracker {:.3f} mm, {:.4f} deg", s.rms_px,
      counted(s.views.size(), "view"), s.noise_px, kMm * s.place_sd, degrees_from_radians(s.turn_sd)));
  for (const auto& warning : warnings) lines.push_back("warning: " + warning);
  return lines;
}

// What a rig keeps of it.
void store(rig::Rig& rig, const HandEyeArguments& options, const Estimate<vision::PixelHandEye>& fit,
           const std::string& hash) {
  const auto& s = fit.value;
  const bool right = options.camera == "right";
  const rig::Provenance from{rig::utc_now(), hash, "pixels", kMm * s.place_sd};
  (right ? rig.right_hand_eye : rig.hand_eye) =
      rig::HandEyeCalibration{s.X_marker_camera, fit.covariance.topLeftCorner<6, 6>(), from};
  if (fit.covariance(13, 13) > 0.0) {
    auto& camera = right ? rig.right_camera : rig.camera;
    const auto encoding = camera                         ? camera->encoding
                          : options.board.images.empty() ? device::Encoding::root
                                                         : device::Encoding::srgb;
    camera = rig::CameraCalibration{
        s.lens,
        fit.covariance.bottomRightCorner<device::kLensParameters, device::kLensParameters>(),
        {rig::utc_now(), hash, "hand-eye", s.rms_px},
        encoding};
  }
  if (!options.estimate_delay || right) return;  // both take their images together
  set_camera_delay(rig, s.delay_s, fit.standard_deviation(12), from);
}

}  // namespace

Expected<void> run_hand_eye_pixels(const HandEyeArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  const auto hand = read_poses(options.hand);
  if (!hand) return tl::unexpected(hand.error());
  std::vector<std::string> warnings;
  auto views = read_board_views(options.board, "calibrate hand-eye", warnings);
  if (!views) return tl::unexpected(views.error());
  const auto joined = join(options, *hand, *views, warnings);
  if (!joined) return tl::unexpected(joined.error());
  auto lens = given_lens(options.lens, *rig, options.camera);
  if (!lens) return tl::unexpected(lens.error());
  const std::string source = fmt::format("{}, {}", options.hand, source_of(options.board));
  vision::PixelHandEyeOptions how{.free_lens = !lens->has_value(),
                                  .free_delay = options.estimate_delay,
                                  .delay_s = options.delay_s,
                                  .turn_sd = radians_from_degrees(options.tracker_sd_deg),
                                  .place_sd = metres_from_mm(options.tracker_sd_mm)};
  if (how.free_lens) {
    if (const auto done = set_size(options.board, *views, warnings); !done) return done;
    const auto start =
        vision::calibrate_camera(views->views, views->width, views->height,
                                 {.lens = lens_model(options.lens_model, *rig, options.camera)});
    if (!start)
      return refused("{}: the lens is to be found too, and cannot: {}; give --lens", source,
                     start.error().message);
    *lens = start->value.model;
  }
  const auto fit =
      vision::calibrate_hand_eye_pixels(joined->hand, joined->views, joined->time_s, **lens, how);
  if (!fit)
    return tl::unexpected(Error{fit.error().kind, fmt::format("{}: {}", source, fit.error().message)});
  warnings.insert(warnings.end(), fit->value.warnings.begin(), fit->value.warnings.end());
  if (auto apart = warning_of_clocks(options.estimate_delay ? fit->value.delay_s : 0.0); !apart.empty())
    warnings.push_back(std::move(apart));
  const std::string hash = content_hash(hand->hash + views->data_hash);
  Result result{to_json(options, *fit, *joined, warnings, hash),
                summary_of(*fit, options.estimate_delay, warnings),
                {}};
  result.store = [&](rig::Rig& to) { store(to, options, *fit, hash); };
  return write_result(options.result, result);
}

}  // namespace palpate::tools::commands
