#include "tools/doctor/doctor_facts.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include "drivers/cameras/camera_choice.h"
#include "drivers/forcedimension/arm.h"
#include "drivers/forcedimension/library.h"
#include "drivers/openhaptics/arm.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/text.h"
#include "palpate/desktop/sound_out.h"
#include "palpate/desktop/window.h"
#include "palpate/headset/headset.h"
#include "palpate/render/context.h"
#include "palpate/render/picture_file.h"
#include "tools/doctor/doctor_network.h"

namespace palpate::tools::doctor {
namespace {

namespace fs = std::filesystem;

// First line of a file of the kernel's; empty where it cannot be read.
std::string first_line(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

std::optional<long> whole_number(const fs::path& path) {
  std::istringstream text(first_line(path));
  long number = 0;
  if (!(text >> number)) return std::nullopt;
  return number;
}

bool all_digits(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

// Soft limit; nothing where there is none.
std::optional<std::uint64_t> limit_of(__rlimit_resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

std::vector<std::string> governors() {
  std::vector<std::string> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/sys/devices/system/cpu", ignored)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with("cpu") || !all_digits(name.substr(3))) continue;
    const std::string governor = first_line(entry.path() / "cpufreq" / "scaling_governor");
    if (!governor.empty()) found.push_back(governor);
  }
  return found;
}

RealTimeFacts real_time_facts() {
  RealTimeFacts facts;
  // In a thread that ends, because the priority would stay; the pages are let go again.
  std::thread([&facts] { facts.grant = enter_real_time(80); }).join();
  munlockall();
  facts.rtprio_limit = limit_of(RLIMIT_RTPRIO);
  facts.memlock_limit = limit_of(RLIMIT_MEMLOCK);
  utsname system{};
  if (uname(&system) == 0) facts.kernel = system.version;
  facts.kernel_real_time = first_line("/sys/kernel/realtime") == "1";
  facts.preempt_argument = preempt_argument_of(first_line("/proc/cmdline"));
  facts.rt_runtime_us = whole_number("/proc/sys/kernel/sched_rt_runtime_us");
  facts.rt_period_us = whole_number("/proc/sys/kernel/sched_rt_period_us");
  facts.governors = governors();
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (sched_getaffinity(0, sizeof cores, &cores) == 0)
    facts.cores = static_cast<unsigned>(std::max(1, CPU_COUNT(&cores)));
  timespec resolution{};
  if (clock_getres(CLOCK_MONOTONIC, &resolution) == 0)
    facts.timer_resolution_ns = static_cast<std::uint64_t>(resolution.tv_sec) * 1'000'000'000u +
                                static_cast<std::uint64_t>(resolution.tv_nsec);
  return facts;
}

// Programs that keep clocks, as far as this user sees processes of others. The kernel cuts names at 15
// characters.
std::vector<std::string> clock_keepers() {
  std::vector<std::string> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    if (!all_digits(entry.path().filename())) continue;
    std::string name = first_line(entry.path() / "comm");
    if (name == "systemd-timesyn") name = "systemd-timesyncd";
    for (const char* keeper : {"chronyd", "ntpd", "ntp-daemon", "systemd-timesyncd", "phc2sys"})
      if (name == keeper && std::find(found.begin(), found.end(), name) == found.end()) found.push_back(name);
  }
  return found;
}

ClockFacts clock_facts() {
  ClockFacts facts;
  timex state{};  // no modes: only asks
  const int answer = adjtimex(&state);
  facts.known = answer >= 0;
  if (!facts.known) facts.why_unknown = std::strerror(errno);
  facts.synchronised = facts.known && answer != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
  facts.estimated_error_us = state.esterror;
  facts.maximum_error_us = state.maxerror;
  facts.keepers = clock_keepers();
  facts.source = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  return facts;
}

GraphicsFacts graphics_facts() {
  GraphicsFacts facts;
  if (const auto context = render::Context::of_this_thread()) {
    facts.renderer = (*context)->renderer();
    facts.platform = (*context)->platform();
  } else {
    facts.problem = context.error().message;
  }
  return facts;
}

DesktopFacts desktop_facts() {
  DesktopFacts facts;
  if (const char* display = std::getenv("DISPLAY")) facts.display = display;
  if (const auto possible = desktop::Window::possible(); !possible)
    facts.window_problem = possible.error().message;
  // PulseAudio's library makes itself a folder even where no sound server runs.
  const char* run = std::getenv("XDG_RUNTIME_DIR");
  const fs::path pulse = run == nullptr ? fs::path() : fs::path(run) / "pulse";
  std::error_code ignored;
  const bool was_there = pulse.empty() || fs::exists(pulse, ignored);
  if (const auto sound = desktop::SoundOut::open())
    facts.sound = (*sound)->device();
  else
    facts.sound_problem = sound.error().message;
  if (!was_there) fs::remove(pulse, ignored);  // only if it is empty
  if (const auto found = headset::Headset::look_for(std::chrono::seconds(3)))
    facts.headset = fmt::format("{} ({})", found->device, found->runtime);
  else
    facts.headset_problem = found.error().message;
  return facts;
}

void look_at_force_dimension(const std::optional<drivers::forcedimension::ArmSettings>& asked,
                             DeviceFacts& facts) {
  namespace driver = drivers::forcedimension;
  facts.force_dimension = driver::inspect_library();
  facts.force_dimension_asked = asked.has_value();
  if (!asked || facts.force_dimension.problem != drivers::arms::LibraryProblem::none) return;
  if (const auto who = driver::probe_arm(*asked)) {
    facts.force_dimension_answer =
        fmt::format("{}, serial {}, {:.1f} N", who->model, who->serial, who->peak_n);
  } else {
    facts.force_dimension_problem = who.error().message;
  }
}

void look_at_arms(const std::optional<std::string>& asked, DeviceFacts& facts) {
  facts.arm_nodes = drivers::openhaptics::find_arm_nodes();
  if (const char* settings = std::getenv("GTDD_HOME"); settings != nullptr) {
    facts.arm_settings = settings;
    std::error_code ignored;
    facts.arm_settings_there = fs::is_directory(settings, ignored) && access(settings, R_OK | X_OK) == 0;
  }
  facts.arm_library = drivers::openhaptics::inspect_library();
  facts.arm_asked = asked.has_value();
  if (!asked || facts.arm_library.problem != drivers::openhaptics::LibraryProblem::none) return;
  drivers::openhaptics::ArmSettings settings;
  settings.name = facts.arm_name = *asked;
  if (const auto who = drivers::openhaptics::probe_arm(settings)) {
    facts.arm_answer = fmt::format("{}, serial {}, {:.1f} N", who->model, who->serial, who->peak_n);
  } else {
    facts.arm_problem = who.error().message;
  }
}

// How long a camera that was opened may take for its first picture.
constexpr Duration kFirstPicture = std::chrono::seconds(3);

void look_at_cameras(const std::optional<drivers::cameras::Choice>& asked, DeviceFacts& facts) {
  facts.cameras = drivers::cameras::list_v4l2();
  facts.aravis = drivers::cameras::aravis_version();
  facts.camera_asked = asked.has_value();
  if (!asked) return;
  const auto camera = drivers::cameras::open_camera({*asked, {}});
  if (!camera) {
    facts.camera_problem = camera.error().message;
  } else {
    facts.camera_name = (*camera)->name();
    const auto begun = std::chrono::steady_clock::now();
    std::optional<device::CameraImage> picture;
    while (!(picture = (*camera)->poll()) && std::chrono::steady_clock::now() - begun < kFirstPicture)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (picture)
      facts.camera_answer = drivers::cameras::description((*camera)->facts());
    else if (const auto status = (*camera)->status(); status.health)
      facts.camera_problem = status.health->words;
    else
      facts.camera_problem =
          facts.camera_name + ": it opens and sends no picture; see to its trigger and cable";
  }
  if (asked->kind == drivers::cameras::Kind::aravis && !camera)
    facts.genicam_cameras = drivers::cameras::list_aravis();
}

DeviceFacts device_facts(const std::optional<std::string>& arm,
                         const std::optional<drivers::forcedimension::ArmSettings>& place_arm,
                         const std::optional<drivers::cameras::Choice>& camera) {
  DeviceFacts facts;
  look_at_arms(arm, facts);
  look_at_force_dimension(place_arm, facts);
  look_at_cameras(camera, facts);
  return facts;
}

SpaceFacts space_facts() {
  SpaceFacts facts;
  facts.folder = run_directory_place();
  std::error_code ignored;
  while (facts.folder.has_relative_path() && !fs::exists(facts.folder, ignored))
    facts.folder = facts.folder.parent_path();
  struct statvfs space {};
  if (statvfs(facts.folder.c_str(), &space) == 0)
    facts.free_bytes = static_cast<std::uint64_t>(space.f_bavail) * space.f_frsize;
  facts.open_files = limit_of(RLIMIT_NOFILE);
  return facts;
}

}  // namespace

std::string preempt_argument_of(std::string_view command_line) {
  std::istringstream words{std::string(command_line)};
  std::string word, value;
  while (words >> word)
    if (word.starts_with("preempt=")) value = word.substr(8);  // the last one counts
  return value;
}

Expected<Facts> gather_facts(const Options& options) {
  Facts facts;
  const auto arm = drivers::openhaptics::device_asked_for(options.arm);
  const auto place_arm = drivers::forcedimension::settings_of(options.arm);
  if (!arm && !place_arm && !options.arm.empty())
    return wrong_use(
        "--arm: is '{}'; openhaptics, openhaptics:NAME, forcedimension or forcedimension:SERIAL is expected",
        excerpt(options.arm));
  std::optional<drivers::cameras::Choice> camera;
  if (!options.camera.empty()) {
    auto choice = drivers::cameras::parse_choice(options.camera);
    if (!choice)
      return wrong_use("--camera: is '{}'; {} is expected", excerpt(options.camera, 100),
                       drivers::cameras::kChoices);
    camera = *choice;
  }
  // First, while nothing else runs: drawing starts threads, and locked memory is the whole process's.
  facts.real_time = real_time_facts();
  auto keys = key_facts(options.keys);
  auto listen = listen_facts(options.listen, keys);
  if (!listen) return tl::unexpected(listen.error());
  facts.keys = std::move(keys);
  facts.listen = std::move(*listen);
  facts.clock = clock_facts();
  facts.sockets = socket_facts();
  facts.devices = device_facts(arm, place_arm, camera);
  facts.space = space_facts();
  facts.plugins = options.plugins;
  facts.libraries = {
      options.version, fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION),
      render::picture_library(), transport::network_libraries(), physics::deformable::dense_library()};
  facts.graphics = graphics_facts();
  facts.desktop = desktop_facts();
  return facts;
}

}  // namespace palpate::tools::doctor
