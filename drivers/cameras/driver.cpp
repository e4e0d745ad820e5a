#include "drivers/cameras/driver.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/cameras/aravis_source.h"
#include "drivers/cameras/camera_choice.h"
#include "drivers/cameras/v4l2_source.h"

namespace palpate::drivers::cameras {
namespace {

class OpenedLiveCamera : public device::OpenedCamera {
 public:
  explicit OpenedLiveCamera(std::unique_ptr<LiveCamera> camera) : camera_(std::move(camera)) {}
  device::CameraDevice& device() override { return *camera_; }
  std::optional<device::HealthReport> health() override { return camera_->status().health; }
  std::string name() const override { return camera_->name(); }
  std::string description() const override { return cameras::description(camera_->facts()); }
  double exposure_s() const override { return camera_->facts().exposure_s; }
  bool ended() const override {
    const auto health = camera_->status().health;
    return health && health->code == device::HealthCode::recording_ended;
  }
  Json figures() const override {
    const auto status = camera_->status();
    return {{"name", camera_->name()},     {"model", camera_->facts().model},
            {"pictures", status.pictures}, {"damaged", status.damaged},
            {"dropped", status.dropped},   {"times_opened", status.times_opened}};
  }

 private:
  std::unique_ptr<LiveCamera> camera_;
};

std::vector<device::FoundCamera> found_by_aravis() {
  std::vector<device::FoundCamera> found;
  for (const auto& camera : list_aravis())
    found.push_back({{{"camera", "aravis:" + camera.name},
                      {"model", camera.model},
                      {"serial", camera.serial},
                      {"address", camera.address},
                      {"protocol", camera.protocol}},
                     fmt::format("aravis:{}  {}, serial {}, {} at {}", camera.name, camera.model,
                                 camera.serial, camera.protocol, camera.address)});
  return found;
}

std::vector<device::FoundCamera> found_by_v4l2() {
  std::vector<device::FoundCamera> found;
  for (const auto& camera : list_v4l2()) {
    if (!camera.camera && camera.problem.empty()) continue;
    found.push_back({{{"camera", "v4l2:" + camera.path},
                      {"model", camera.model},
                      {"formats", camera.formats},
                      {"problem", camera.problem}},
                     camera.problem.empty() ? fmt::format("v4l2:{}  {} ({})", camera.path, camera.model,
                                                          fmt::join(camera.formats, ", "))
                                            : "v4l2:" + camera.problem});
  }
  return found;
}

device::Driver driver(std::string scheme, std::string summary, std::string form) {
  device::Driver made;
  made.scheme = std::move(scheme);
  made.summary = std::move(summary);
  made.camera.emplace();
  made.camera->form = std::move(form);
  made.camera->names = [](std::string_view uri) { return parse_choice(uri).has_value(); };
  made.camera->check = [](const device::CameraRequest& request) {
    return check_settings(*parse_choice(request.uri), request.settings);
  };
  made.camera->open =
      [](const device::CameraRequest& request) -> Expected<std::unique_ptr<device::OpenedCamera>> {
    auto camera = open_camera({*parse_choice(request.uri), request.settings});
    if (!camera) return tl::unexpected(camera.error());
    return std::make_unique<OpenedLiveCamera>(std::move(*camera));
  };
  return made;
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  device::Driver aravis = driver("aravis", "GenICam cameras, in the network or at USB", "aravis[:NAME]");
  aravis.own_clock = true;
  aravis.find_cameras = found_by_aravis;
  registry.add(std::move(aravis));
  device::Driver v4l2 = driver("v4l2", "cameras of the kernel, such as webcams", "v4l2[:DEVICE]");
  v4l2.find_cameras = found_by_v4l2;
  registry.add(std::move(v4l2));
  device::Driver images = driver("images", "pictures in a folder, with their times", "images:FOLDER");
  device::Driver video = driver("video", "a recorded film", "video:FILE");
  images.recording = video.recording = true;
  registry.add(std::move(images));
  registry.add(std::move(video));
}

}  // namespace palpate::drivers::cameras
