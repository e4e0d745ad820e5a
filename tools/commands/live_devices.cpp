#include "tools/commands/live_devices.h"

#include "palpate/core/stop_signal.h"
#include "palpate/desktop/session_window.h"
#include "palpate/device/camera_preview.h"
#include "palpate/time/clock.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/terminal_panel.h"
#include "tools/commands/windowed_panel.h"

namespace palpate::tools::commands {

namespace session = calibration::session;

// Not in an anonymous namespace: LiveSession::Parts has them, and this file is read as a part of others.
namespace live {

struct Opened {
  std::unique_ptr<device::OpenedArm> arm;
  std::unique_ptr<device::OpenedTracker> tracker;
  std::unique_ptr<device::OpenedCamera> camera;

  // Of the first that is gone.
  Expected<void> look() {
    if (auto there = arm->look(); !there) return there;
    if (auto there = tracker->look(); !there) return there;
    return camera->look();
  }
};

Expected<Opened> open_devices(const LiveDevices& names, const rig::Rig& rig,
                              const device::DriverRegistry& known) {
  for (const auto& [option, text] :
       {std::pair("--arm", names.arm), {"--tracker", names.tracker}, {"--camera", names.camera}})
    if (text.empty())
      return wrong_use(
          "{} is missing: a session needs arm, tracker and camera (palpate doctor shows what there is)",
          option);
  Opened opened;
  auto arm = known.open(
      device::ArmRequest{.uri = names.arm, .nominal = rig.nominal_arm, .at_reset_position = names.at_reset});
  if (!arm) return tl::unexpected(arm.error());
  opened.arm = std::move(*arm);
  auto tracker = known.open(device::TrackerRequest{names.tracker, names.tools});
  if (!tracker) return tl::unexpected(tracker.error());
  opened.tracker = std::move(*tracker);
  auto camera = open_camera(drivers(), known, names.camera, names.camera_options);
  if (!camera) return tl::unexpected(camera.error());
  opened.camera = std::move(*camera);
  return opened;
}

// A person whose devices are looked at meanwhile: one that goes ends the session, in words.
class PersonAtDevices : public session::GuidedPerson {
 public:
  using Watch = std::function<void(double now_s, std::span<const device::TrackerSample> tracked)>;
  // `also`: watches as well; may be empty.
  PersonAtDevices(session::Panel& panel, Opened& devices, Watch also)
      : GuidedPerson(panel), devices_(devices), also_(std::move(also)) {}

  Expected<bool> ready() override {
    if (!there_) return tl::unexpected(there_.error());
    return GuidedPerson::ready();
  }
  void watch(double now_s, const device::ArmSample& arm,
             std::span<const device::TrackerSample> tracked) override {
    constexpr double kLook = 0.1;  // s
    if (there_ && now_s >= looked_s_ + kLook) {
      there_ = devices_.look();
      looked_s_ = now_s;
    }
    GuidedPerson::watch(now_s, arm, tracked);
    if (also_) also_(now_s, tracked);
  }

 private:
  Opened& devices_;
  Watch also_;
  Expected<void> there_{};
  double looked_s_ = 0.0;
};

}  // namespace live

void add_device_options(CLI::App& command, LiveDevices& devices) {
  command.add_option("--arm", devices.arm, "The arm: " + drivers().arm_forms())->type_name("URI");
  command.add_option("--tracker", devices.tracker, "The tracker: " + drivers().tracker_forms())
      ->type_name("URI");
  command.add_option("--tracker-tool", devices.tools,
                     "What the tracker calls a marker: tip_marker=NAME, camera_marker=NAME, pointer=NAME");
  command.add_option("--camera", devices.camera, "The camera: " + drivers().camera_forms())->type_name("URI");
  add_camera_options(command, devices.camera_options);
  command.add_flag("--arm-at-reset", devices.at_reset,
                   "The arm is in its reset position now: set its encoders' zero there if it is lost");
  command.add_flag(
      "--window", devices.window,
      "Lead you in a window, too: the camera's live picture, where to hold what, how it goes; the "
      "terminal's keys answer there as well");
  command
      .add_option("--instructions", devices.instructions,
                  "Write what the person is asked for to FILE as well, a line of JSON each")
      ->type_name("FILE");
}

tl::unexpected<Error> window_without_devices() {
  return wrong_use("--window leads a person at devices; name them with --arm, --tracker and --camera");
}

Expected<void> run_session(const LiveDevices& devices, const std::string& title,
                           const std::function<Expected<void>(desktop::SessionExchange*)>& session) {
  if (!devices.window) return session(nullptr);
  auto window = desktop::SessionWindow::open(title);
  if (!window)
    return refused(window.error().code, "{} (leave --window away to be led in this terminal alone)",
                   window.error().message);
  return (*window)->run([&session](desktop::SessionExchange& exchange) { return session(&exchange); });
}

struct LiveSession::Parts {
  Parts(live::Opened devices, std::shared_ptr<session::InstructionFile> instructions_to,
        device::CameraDevice* right_camera, desktop::SessionExchange* exchange)
      : opened(std::move(devices)),
        instructions(std::move(instructions_to)),
        terminal(std::make_unique<TerminalPanel>(instructions, stop_requested())),
        windowed(exchange != nullptr ? std::make_unique<WindowedPanel>(*terminal, *exchange) : nullptr),
        preview(exchange != nullptr ? make_preview(right_camera) : nullptr),
        person(panel(), opened, preview ? watch_for_window() : live::PersonAtDevices::Watch()),
        camera(preview ? preview->camera() : opened.camera->device()),
        right(preview ? preview->right() : right_camera) {}

  session::SessionPanel& panel() {
    if (windowed) return *windowed;
    return *terminal;
  }

  std::unique_ptr<device::CameraPreview> make_preview(device::CameraDevice* right_camera) {
    constexpr double kPictures_hz = 15.0;
    return std::make_unique<device::CameraPreview>(opened.camera->device(), right_camera, kPictures_hz,
                                                   [this](const device::CameraImage& image, bool is_right) {
                                                     windowed->show_picture(image, is_right,
                                                                            clock.now().seconds());
                                                   });
  }

  live::PersonAtDevices::Watch watch_for_window() {
    return [this](double now_s, std::span<const device::TrackerSample> tracked) {
      windowed->watch(now_s, tracked);
      preview->refresh(now_s);
    };
  }

  live::Opened opened;
  std::shared_ptr<session::InstructionFile> instructions;
  std::unique_ptr<TerminalPanel> terminal;
  std::unique_ptr<WindowedPanel> windowed;         // null: the terminal alone
  std::unique_ptr<device::CameraPreview> preview;  // for the window
  live::PersonAtDevices person;
  MonotonicClock<PhysicsClock> clock;
  device::CameraDevice& camera;
  device::CameraDevice* right;
};

Expected<std::unique_ptr<LiveSession>> LiveSession::open(const LiveDevices& devices, const rig::Rig& rig,
                                                         const device::DriverRegistry& known,
                                                         desktop::SessionExchange* exchange) {
  auto opened = live::open_devices(devices, rig, known);
  if (!opened) return tl::unexpected(opened.error());
  auto instructions = session::InstructionFile::open(devices.instructions);
  if (!instructions) return tl::unexpected(instructions.error());
  const auto right = opened->camera->right();
  if (!right) return tl::unexpected(right.error());
  std::unique_ptr<LiveSession> session(new LiveSession(
      std::make_unique<Parts>(std::move(*opened), std::move(*instructions), *right, exchange)));
  session->panel().show_rig(rig);
  return session;
}

LiveSession::LiveSession(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
LiveSession::~LiveSession() = default;

session::AcquisitionContext LiveSession::context() {
  return {parts_->clock,
          parts_->opened.arm->device(),
          parts_->opened.tracker->device(),
          &parts_->camera,
          parts_->person,
          parts_->right,
          parts_->opened.arm->facts().simulated,
          &stop_requested()};
}

session::SessionPanel& LiveSession::panel() { return parts_->panel(); }
device::ArmFacts LiveSession::arm_facts() const { return parts_->opened.arm->facts(); }
std::shared_ptr<session::InstructionFile> LiveSession::instructions() const { return parts_->instructions; }
void LiveSession::end() { parts_->terminal.reset(); }

}  // namespace palpate::tools::commands
