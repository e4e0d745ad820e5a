#include "ppm_camera.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/time/clock.h"
#include "ppm_stream.h"

namespace ppm {
namespace {

using namespace palpate;
using namespace std::chrono_literals;

constexpr auto kPatience = 5s;    // for the first picture
constexpr auto kSilence = 2s;     // without a picture: trouble
constexpr int kLook_ms = 50;      // between two looks whether to stop
constexpr auto kNoWriter = 20ms;  // until somebody opens the pipe again
constexpr std::size_t kAtOnce = 1 << 16;

// Reads the pipe in a thread of its own and keeps the newest picture.
class PipeCamera : public device::CameraDevice {
 public:
  PipeCamera(int descriptor, bool file) : descriptor_(descriptor), file_(file), thread_([this] { read(); }) {}
  PipeCamera(const PipeCamera&) = delete;
  PipeCamera& operator=(const PipeCamera&) = delete;
  ~PipeCamera() override {
    stop_ = true;
    thread_.join();
    close(descriptor_);
  }

  std::optional<device::CameraImage> poll() override {
    const std::lock_guard lock(mutex_);
    if (newest_) newest_->waited = clock_.now() - newest_->mid_exposure;
    return std::exchange(newest_, std::nullopt);
  }
  // Waits for the first; "": none came.
  std::string size_of_first() {
    for (const auto until = std::chrono::steady_clock::now() + kPatience;
         std::chrono::steady_clock::now() < until;) {
      std::this_thread::sleep_for(5ms);
      const std::lock_guard lock(mutex_);
      if (newest_) return fmt::format("{} x {} px", newest_->width, newest_->height);
      if (ended_) break;
    }
    return "";
  }
  bool silent() const {
    const std::lock_guard lock(mutex_);
    return !ended_ && std::chrono::steady_clock::now() - heard_ > kSilence;
  }
  bool ended() const {
    const std::lock_guard lock(mutex_);
    return ended_ && !newest_;
  }
  Json figures() const {
    const std::lock_guard lock(mutex_);
    return {{"pictures", frames_}, {"dropped", 0}, {"damaged", stream_.damaged()}};
  }

 private:
  void read() {
    std::vector<char> bytes(kAtOnce);
    while (!stop_) {
      pollfd waits{descriptor_, POLLIN, 0};
      if (::poll(&waits, 1, kLook_ms) <= 0) continue;
      const ssize_t got = ::read(descriptor_, bytes.data(), bytes.size());
      if (got > 0) {
        take({bytes.data(), static_cast<std::size_t>(got)});
      } else if (got == 0 && file_) {
        const std::lock_guard lock(mutex_);
        ended_ = true;
        return;
      } else {
        std::this_thread::sleep_for(kNoWriter);  // nobody writes now; somebody may come
      }
    }
  }
  void take(std::span<const char> bytes) {
    const std::lock_guard lock(mutex_);
    stream_.add(bytes);
    while (auto picture = stream_.next()) {
      heard_ = std::chrono::steady_clock::now();
      newest_ = {.mid_exposure = clock_.now(),
                 .frame = ++frames_,
                 .width = picture->width,
                 .height = picture->height,
                 .rgb = std::move(picture->rgb)};
    }
  }

  const MonotonicClock<CameraClock> clock_;
  const int descriptor_;
  const bool file_;
  mutable std::mutex mutex_;
  Stream stream_;
  std::optional<device::CameraImage> newest_;
  std::chrono::steady_clock::time_point heard_ = std::chrono::steady_clock::now();
  std::uint64_t frames_ = 0;
  bool ended_ = false;
  std::atomic<bool> stop_ = false;
  std::thread thread_;  // last: it uses the others
};

class OpenedPipe : public device::OpenedCamera {
 public:
  OpenedPipe(std::string path, int descriptor, bool file)
      : path_(std::move(path)), camera_(descriptor, file) {}
  device::CameraDevice& device() override { return camera_; }
  std::string name() const override { return "ppm:" + path_; }
  std::string description() const override { return "pictures of " + size_ + " out of a pipe"; }
  std::optional<device::HealthReport> health() override {
    if (!camera_.silent()) return std::nullopt;
    return device::HealthReport{device::HealthCode::camera_silent,
                                "no picture comes out of " + path_ + "; see to the program that writes it"};
  }
  bool ended() const override { return camera_.ended(); }
  Json figures() const override { return camera_.figures(); }
  Expected<void> wait_for_first() {
    size_ = camera_.size_of_first();
    if (!size_.empty()) return {};
    return refused(
        "{}: no picture came in 5 s; start what writes binary PPM pictures into it, such as `ffmpeg ... -f "
        "image2pipe -c:v ppm -y {}`",
        name(), path_);
  }

 private:
  std::string path_, size_;
  PipeCamera camera_;
};

Expected<std::unique_ptr<device::OpenedCamera>> open_pipe(const device::CameraRequest& request) {
  const std::string path(device::rest_of(request.uri));
  // Without waiting for whoever writes it.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  struct stat found {};
  if (descriptor < 0 || fstat(descriptor, &found) != 0)
    return refused("ppm:{}: cannot be opened ({}); `mkfifo {}` makes a pipe", excerpt(path, 200),
                   std::strerror(errno), excerpt(path, 200));
  if (!S_ISFIFO(found.st_mode) && !S_ISREG(found.st_mode)) {
    close(descriptor);
    return refused("ppm:{}: is neither a pipe nor a file; `mkfifo` makes a pipe", excerpt(path, 200));
  }
  auto opened = std::make_unique<OpenedPipe>(path, descriptor, S_ISREG(found.st_mode));
  if (auto came = opened->wait_for_first(); !came) return tl::unexpected(came.error());
  return opened;
}

}  // namespace

device::Driver driver() {
  device::Driver driver;
  driver.scheme = "ppm";
  driver.summary = "pictures that another program writes into a pipe";
  driver.camera.emplace();
  driver.camera->form = "ppm:PATH of a pipe";
  driver.camera->names = [](std::string_view uri) { return !device::rest_of(uri).empty(); };
  driver.camera->open = open_pipe;
  return driver;
}

}  // namespace ppm
