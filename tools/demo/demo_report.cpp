#include "tools/demo/demo_report.h"

#include <algorithm>

#include "palpate/figures/force_figures.h"
#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace fs = std::filesystem;
namespace {

// Frame pictures shown in the page; more would make it heavy, not clearer.
constexpr std::size_t kMostPictures = 4;

void add_figure(std::vector<figures::Figure>& figures, const figures::PlayFolder& data, std::string_view path,
                std::string label, std::string_view unit, std::optional<double> at_most_this,
                std::string bar) {
  const auto value = data.number(path);
  if (!value) return;
  const figures::Verdict verdict =
      at_most_this ? figures::at_most(*value, *at_most_this) : figures::Verdict::none;
  figures.push_back({std::move(label), figures::shown(value, unit), std::move(bar), verdict});
}

// The picture a film shows before it plays: an event (a hit, a touch), where there is one.
std::string poster_of(const figures::PlayFolder& data) {
  if (data.has("poster.png")) return "poster.png";
  const auto pictures = data.pictures("pictures");
  for (const auto& name : pictures)
    if (name.find('-') != std::string::npos && name.find("-play") == std::string::npos) return name;
  return pictures.empty() ? "poster.png" : pictures.front();
}

// Of an application that has none of its own.
scene::PlayReport plain_report(const figures::PlayFolder& data) {
  const std::string name = data.text("application").value_or("an application");
  scene::PlayReport report{
      .title = "Palpate: " + name,
      .task = "play " + name,
      .scene =
          "What is drawn into the picture exists only in the computer; the hand feels it through the stylus.",
      .drawn = "virtual objects",
      .figures = {},
      .sections = {}};
  std::vector<figures::Figure> forces;
  if (auto peak = figures::peak_force(data, "Peak force")) forces.push_back(std::move(*peak));
  if (auto shaped = figures::shaped_force(data, false)) forces.push_back(std::move(*shaped));
  if (!forces.empty()) report.sections.push_back({"What the hand feels", "forces", {std::move(forces)}});
  return report;
}

}  // namespace

void add_what_you_see_section(evaluation::report::Report& page, const figures::PlayFolder& data,
                              const scene::PlayReport& play) {
  page.section("What you see", "see");
  const bool two_eyes = data.find("registration/right_eye") != nullptr;
  const std::string view =
      std::string("The player's view") +
      (two_eyes ? ", left eye and right eye side by side: each camera's picture" : ": the camera's picture") +
      ", undistorted, with " + play.drawn + " drawn into it.";
  page.paragraph(
      std::string("A person holds the stylus of a haptic arm and looks at the scene through ") +
      (two_eyes ? "two cameras worn on the head, one for each eye. " : "a camera worn on the head. ") +
      play.scene +
      " In this run every device is simulated: arm, optical tracker, camera, clocks, hand and player. That "
      "is what lets every error below be measured against the truth, which the program itself never gets to "
      "see.");
  if (data.has("video.mp4")) {
    page.video(data.bytes("video.mp4"), data.bytes(poster_of(data)), view);
  } else if (data.has("poster.png")) {
    page.picture(data.bytes("poster.png"), view);
  }
  std::vector<std::pair<std::string, std::string>> pictures;
  std::vector<std::string> names = data.pictures("pictures");
  // The one from the side is always among them, the last.
  const auto outside = std::stable_partition(names.begin(), names.end(),
                                             [](const auto& name) { return name != "pictures/outside.png"; });
  const auto seen = static_cast<std::size_t>(outside - names.begin());
  if (seen < names.size() && seen >= kMostPictures) names.erase(names.begin() + kMostPictures - 1, outside);
  for (const auto& name : names) {
    if (pictures.size() == kMostPictures) break;
    const std::string file = fs::path(name).filename().string();
    pictures.emplace_back(data.bytes(name), data.text("pictures/" + file).value_or(file));
  }
  if (!pictures.empty()) page.pictures(pictures);
  std::vector<figures::Figure> figures;
  const auto bar = arm_bar_mm(data);
  add_figure(figures, data, "arm/error_to_truth_mean_mm", "Arm: the tip's error against the truth", "mm", bar,
             fmt::format("at most {}, half of the best of the paper's methods or 0.3 mm",
                         figures::shown(bar, "mm")));
  add_figure(figures, data, "registration/world_px_rms", "Overlay on the real scene, rms", "px", 0.3,
             "at most 0.3 px");
  add_figure(figures, data, "registration/tip_px_rms", "Overlay on the stylus tip, rms", "px", 0.6,
             "at most 0.6 px");
  figures.insert(figures.end(), play.figures.begin(), play.figures.end());
  if (auto peak = figures::peak_force(data, play.force_label)) figures.push_back(std::move(*peak));
  add_figure(figures, data, "realtime/exchange/round_trip_us/median",
             "Asking for the state, round trip, median", "\u00b5s", std::nullopt,
             "real time, between two processes");
  page.figures(figures);
}

Expected<evaluation::report::Report> demo_report(const fs::path& folder,
                                                 const scene::ApplicationRegistry& applications) {
  const auto data = figures::PlayFolder::read(folder);
  if (!data) return tl::unexpected(data.error());
  const auto* application = applications.find(data->text("application").value_or(""));
  const scene::PlayReport play =
      application != nullptr && application->report ? application->report(*data) : plain_report(*data);
  std::string subtitle = fmt::format(
      "A report of one demonstration of Palpate on the simulated rig: calibrate everything, {}, and hold "
      "each figure against the truth.",
      play.task);
  if (const auto seed = data->number("seed")) subtitle += fmt::format(" Seed {:.0f}.", *seed);
  evaluation::report::Report page(play.title, subtitle);
  add_what_you_see_section(page, *data, play);
  add_arm_section(page, *data);
  add_tip_and_camera_section(page, *data);
  add_overlay_section(page, *data);
  add_exchange_section(page, *data);
  for (const auto& section : play.sections) page.section(section);
  add_real_time_section(page, *data);
  add_network_section(page, *data);
  add_how_section(page, *data,
                  application != nullptr ? application->tables : std::vector<scene::PlayTable>{});
  return page;
}

Expected<void> write_demo_report(const fs::path& folder, const scene::ApplicationRegistry& applications) {
  const auto page = demo_report(folder, applications);
  if (!page) return tl::unexpected(page.error());
  return page->write(folder / "report.html");
}

}  // namespace palpate::tools::demo
