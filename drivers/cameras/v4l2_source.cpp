#include "drivers/cameras/v4l2_source.h"

#include <fmt/ranges.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "drivers/cameras/internal/frame_count.h"
#include "drivers/cameras/internal/v4l2_text.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::cameras {
namespace {

constexpr unsigned kBuffers = 4;  // one held here, one being filled, two against a busy machine
// An automatic exposure changes with the light; asking costs a transfer over USB.
constexpr std::int64_t kAskExposureNs = 500'000'000;
constexpr double kExposureUnitS = 1e-4;  // of V4L2_CID_EXPOSURE_ABSOLUTE

// Below it a picture does not follow a head; a camera that is faster in a lesser format uses that one.
constexpr double kFastEnoughHz = 24.0;

std::int64_t v4l2_now_ns() { return MonotonicClock<CameraClock>::monotonic_ns(); }

// Fastest rate at this size; 0 where it is not told.
double fastest_hz(V4l2Io& io, int fd, std::uint32_t fourcc, int width, int height) {
  double fastest = 0.0;
  for (unsigned i = 0; i < 64; ++i) {
    auto interval = zeroed<v4l2_frmivalenum>();
    interval.index = i;
    interval.pixel_format = fourcc;
    interval.width = static_cast<__u32>(width), interval.height = static_cast<__u32>(height);
    if (io.control(fd, VIDIOC_ENUM_FRAMEINTERVALS, &interval) != 0) break;
    const auto& shortest =
        interval.type == V4L2_FRMIVAL_TYPE_DISCRETE ? interval.discrete : interval.stepwise.min;
    if (shortest.numerator > 0) fastest = std::max(fastest, 1.0 * shortest.denominator / shortest.numerator);
    if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) break;
  }
  return fastest;
}

class V4l2Source : public FrameSource {
 public:
  V4l2Source(std::string device, CameraSettings settings, V4l2Io& io)
      : device_(std::move(device)),
        settings_(std::move(settings)),
        io_(io),
        name_(device_.empty() ? "v4l2" : "v4l2:" + device_) {}
  ~V4l2Source() override { V4l2Source::close(); }
  const std::string& name() const override { return name_; }

  Outcome wait(Duration longest) override {
    give_back();
    const int ms = static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(longest).count());
    const int ready = io_.wait(fd_, ms);
    if (ready < 0) return lost(errno);
    if (ready == 0) return {};
    // All that wait, since only the newest is of use.
    std::optional<v4l2_buffer> newest;
    std::string damage;
    while (true) {
      auto buffer = zeroed<v4l2_buffer>();
      buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      buffer.memory = V4L2_MEMORY_MMAP;
      if (io_.control(fd_, VIDIOC_DQBUF, &buffer) != 0) {
        if (errno == EAGAIN) break;
        if (errno != EIO) return lost(errno);
        damage = "a picture was lost on its way (EIO)";
        break;
      }
      if (buffer.index >= maps_.size()) return lost(EIO);
      if (newest) queue(newest->index);
      newest = buffer;
    }
    if (!newest) return damage.empty() ? Outcome{} : Outcome{Outcome::Kind::damaged, {}, damage};
    held_ = newest->index;
    return frame_of(*newest);
  }

  void close() override {
    if (fd_ < 0) return;
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    io_.control(fd_, VIDIOC_STREAMOFF, &type);
    for (const auto& map : maps_) io_.unmap(map.place, map.length);
    maps_.clear();
    held_.reset();
    io_.close(fd_);
    fd_ = -1;
  }

 private:
  struct Map {
    void* place = nullptr;
    std::size_t length = 0;
  };

  template <typename... Args>
  tl::unexpected<Error> no(fmt::format_string<Args...> format, Args&&... args) const {
    return refused("camera {}: {}", name_, fmt::format(format, std::forward<Args>(args)...));
  }

  Expected<CameraFacts> try_open() override {
    std::string path = device_;
    if (path.empty()) {
      for (const auto& look : list_v4l2(io_))
        if (look.camera && look.problem.empty()) {
          path = look.path;
          break;
        }
      if (path.empty())
        return no("no camera at /dev/video* can be used; see to its cable, and `palpate doctor` for rights");
      name_ = "v4l2:" + path;
    }
    fd_ = io_.open(path.c_str());
    if (fd_ < 0) return refused("camera {}", "v4l2:" + opening_problem(path, errno));
    auto about = zeroed<v4l2_capability>();
    if (io_.control(fd_, VIDIOC_QUERYCAP, &about) != 0)
      return no("this is no video device; `palpate camera list` names those there are");
    if (!can_capture(about))
      return no("'{}' does not capture pictures; a camera has several nodes, try its first",
                text_of(about.card, sizeof about.card));
    CameraFacts facts;
    facts.model = text_of(about.card, sizeof about.card);
    if (auto set = set_format(facts); !set) return tl::unexpected(set.error());
    set_rate(facts);
    if (auto set = set_exposure_and_gain(); !set) return tl::unexpected(set.error());
    ask_exposure();
    facts.exposure_s = to_seconds(exposure_);
    if (auto begun = begin(); !begun) return tl::unexpected(begun.error());
    facts.stamp = settings_.stamp_at ? "as --camera-stamp says" : "as the kernel's flags say";
    count_.restart();
    return facts;
  }

  // What we may take: what is asked for, or the first that is fast enough, or the fastest.
  Expected<std::uint32_t> choose_format() {
    const auto there = formats_of(io_, fd_);
    const bool asked = !settings_.pixel_format.empty();
    std::optional<std::uint32_t> chosen;
    double chosen_hz = -1.0;
    for (const auto& [fourcc, format] : known_fourccs()) {
      if (std::find(there.begin(), there.end(), fourcc) == there.end()) continue;
      if (asked && name_of(format) != settings_.pixel_format) continue;
      const double hz =
          settings_.width > 0 ? fastest_hz(io_, fd_, fourcc, settings_.width, settings_.height) : 0.0;
      if (!chosen || (chosen_hz < kFastEnoughHz && hz > chosen_hz)) chosen = fourcc, chosen_hz = hz;
    }
    if (chosen) return *chosen;
    return no("its pixel formats are {}, and {} is expected", fmt::join(names_of(there), ", "),
              asked ? excerpt(settings_.pixel_format)
                    : std::string("one of RGB8, BGR8, Bayer, YUYV, UYVY, MJPEG, Mono8"));
  }

  Expected<void> set_format(CameraFacts& facts) {
    const auto fourcc = choose_format();
    if (!fourcc) return tl::unexpected(fourcc.error());
    auto format = zeroed<v4l2_format>();
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (io_.control(fd_, VIDIOC_G_FMT, &format) != 0)
      return no("does not tell its format ({})", std::strerror(errno));
    auto& pixels = format.fmt.pix;
    if (settings_.width > 0) pixels.width = static_cast<__u32>(settings_.width);
    if (settings_.height > 0) pixels.height = static_cast<__u32>(settings_.height);
    pixels.pixelformat = *fourcc;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = 0;
    if (io_.control(fd_, VIDIOC_S_FMT, &format) != 0) {
      if (errno == EBUSY) return no("another program uses it; end that one");
      return no("refuses {} pictures ({})", fourcc_text(*fourcc), std::strerror(errno));
    }
    const int width = static_cast<int>(pixels.width), height = static_cast<int>(pixels.height);
    if ((settings_.width > 0 && width != settings_.width) ||
        (settings_.height > 0 && height != settings_.height))
      return no(
          "gives {}x{} px where {}x{} are asked for; calibrate the lens at a size that it has "
          "(palpate calibrate camera)",
          width, height, settings_.width, settings_.height);
    const auto got = from_fourcc(pixels.pixelformat);
    if (!got || pixels.pixelformat != *fourcc)
      return no("gives {} pictures where {} are asked for; try another --camera-format",
                fourcc_text(pixels.pixelformat), fourcc_text(*fourcc));
    format_ = *got;
    width_ = width, height_ = height;
    stride_ = pixels.bytesperline;
    facts.width = width, facts.height = height, facts.format = *got;
    return {};
  }

  void set_rate(CameraFacts& facts) {
    auto rate = zeroed<v4l2_streamparm>();
    rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (io_.control(fd_, VIDIOC_G_PARM, &rate) != 0) return;  // some drivers have one rate and no word of it
    auto& interval = rate.parm.capture.timeperframe;
    if (settings_.rate_hz > 0.0) {
      interval.numerator = 1000;
      interval.denominator = static_cast<__u32>(std::lround(settings_.rate_hz * 1000.0));
      io_.control(fd_, VIDIOC_S_PARM, &rate);  // the nearest that it has
    }
    if (interval.numerator > 0) facts.rate_hz = 1.0 * interval.denominator / interval.numerator;
  }

  // Sets a control, having looked at its range; `unit` times its value is in `what`'s words' unit.
  Expected<void> set_control(std::uint32_t id, const char* what, double wanted, double unit,
                             const char* unit_name) {
    auto range = zeroed<v4l2_queryctrl>();
    range.id = id;
    if (io_.control(fd_, VIDIOC_QUERYCTRL, &range) != 0 || (range.flags & V4L2_CTRL_FLAG_DISABLED) != 0)
      return no("its {} cannot be set; leave that option out", what);
    const double value = std::round(wanted / unit);
    if (value < range.minimum || value > range.maximum)
      return no("{} {:g}{}: {:g} to {:g}{} is expected", what, wanted, unit_name, range.minimum * unit,
                range.maximum * unit, unit_name);
    auto control = zeroed<v4l2_control>();
    control.id = id;
    control.value = static_cast<__s32>(value);
    if (io_.control(fd_, VIDIOC_S_CTRL, &control) != 0)
      return no("its {} cannot be set ({})", what, std::strerror(errno));
    return {};
  }

  void switch_to(std::uint32_t id, int value) {  // where it has such a control
    auto control = zeroed<v4l2_control>();
    control.id = id;
    control.value = value;
    io_.control(fd_, VIDIOC_S_CTRL, &control);
  }

  Expected<void> set_exposure_and_gain() {
    if (settings_.exposure_s) {
      switch_to(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
      // A longer exposure must not lower the rate, on which silence is judged.
      switch_to(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);
      auto set = set_control(V4L2_CID_EXPOSURE_ABSOLUTE, "exposure", *settings_.exposure_s * 1e3,
                             kExposureUnitS * 1e3, " ms");
      if (!set) return set;
    }
    if (settings_.gain) {
      switch_to(V4L2_CID_AUTOGAIN, 0);
      return set_control(V4L2_CID_GAIN, "gain", *settings_.gain, 1.0, "");
    }
    return {};
  }

  void ask_exposure() {
    auto control = zeroed<v4l2_control>();
    control.id = V4L2_CID_EXPOSURE_ABSOLUTE;
    exposure_ = io_.control(fd_, VIDIOC_G_CTRL, &control) == 0 && control.value > 0
                    ? seconds(control.value * kExposureUnitS)
                    : Duration(0);
    asked_ns_ = v4l2_now_ns();
  }

  Expected<void> begin() {
    auto request = zeroed<v4l2_requestbuffers>();
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (io_.control(fd_, VIDIOC_REQBUFS, &request) != 0) {
      if (errno == EBUSY) return no("another program uses it; end that one");
      return no("gives no memory for pictures ({})", std::strerror(errno));
    }
    for (unsigned i = 0; i < request.count; ++i) {
      auto buffer = zeroed<v4l2_buffer>();
      buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      buffer.memory = V4L2_MEMORY_MMAP;
      buffer.index = i;
      if (io_.control(fd_, VIDIOC_QUERYBUF, &buffer) != 0)
        return no("gives no memory for pictures ({})", std::strerror(errno));
      void* place = io_.map(fd_, buffer.length, buffer.m.offset);
      if (place == nullptr) return no("gives no memory for pictures ({})", std::strerror(errno));
      maps_.push_back({place, buffer.length});
      queue(i);
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (io_.control(fd_, VIDIOC_STREAMON, &type) != 0) {
      if (errno == EBUSY) return no("another program uses it; end that one");
      if (errno == ENOSPC)
        return no("the USB has no room for its pictures; another port, or --camera-format MJPEG");
      return no("does not begin ({}); plug it in again", std::strerror(errno));
    }
    return {};
  }

  void queue(unsigned index) {
    auto buffer = zeroed<v4l2_buffer>();
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    io_.control(fd_, VIDIOC_QBUF, &buffer);  // what fails here shows in the next wait()
  }

  void give_back() {
    if (held_) queue(*held_);
    held_.reset();
  }

  Outcome lost(int error) const {
    return {Outcome::Kind::lost,
            {},
            error == ENODEV
                ? std::string("it was unplugged; plug it in again")
                : fmt::format("the connection to it broke ({}); plug it in again", std::strerror(error))};
  }

  Outcome frame_of(const v4l2_buffer& buffer) {
    const std::int64_t taken = v4l2_now_ns();
    if (taken - asked_ns_ > kAskExposureNs && !settings_.exposure_s) ask_exposure();
    const std::uint64_t number = count_.count(buffer.sequence);
    if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0)
      return {Outcome::Kind::damaged, {}, "a picture was damaged on its way"};
    const auto stamp = v4l2_stamp(
        buffer.flags, buffer.timestamp.tv_sec * 1'000'000'000LL + buffer.timestamp.tv_usec * 1000LL, taken);
    const Shutter shutter{exposure_, seconds(settings_.readout_s), settings_.rolling};
    Outcome outcome{Outcome::Kind::frame, {}, {}};
    outcome.frame.mid_exposure_ns =
        stamp.ns + to_mid_exposure(settings_.stamp_at.value_or(stamp.at), shutter).count();
    outcome.frame.number = number;
    const Map& map = maps_[buffer.index];
    // Some drivers leave bytesused at 0 where every picture has the same size.
    const std::size_t used =
        buffer.bytesused == 0 ? map.length : std::min<std::size_t>(buffer.bytesused, map.length);
    outcome.frame.picture = {
        format_, width_, height_, stride_, {static_cast<const std::uint8_t*>(map.place), used}};
    return outcome;
  }

  const std::string device_;
  const CameraSettings settings_;
  V4l2Io& io_;
  std::string name_;
  int fd_ = -1, width_ = 0, height_ = 0;
  std::size_t stride_ = 0;
  PixelFormat format_ = PixelFormat::yuyv;
  std::vector<Map> maps_;
  std::optional<unsigned> held_;
  Duration exposure_{0};
  std::int64_t asked_ns_ = 0;
  FrameCount count_{0, 0xFFFFFFFFu};
};

}  // namespace

V4l2Stamp v4l2_stamp(std::uint32_t flags, std::int64_t stamp_ns, std::int64_t taken_ns) {
  if ((flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC || stamp_ns <= 0)
    return {taken_ns, StampAt::frame_end};
  return {stamp_ns, (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE
                        ? StampAt::exposure_start
                        : StampAt::frame_end};
}

std::unique_ptr<FrameSource> make_v4l2_source(std::string device, CameraSettings settings, V4l2Io& io) {
  return std::make_unique<V4l2Source>(std::move(device), std::move(settings), io);
}

}  // namespace palpate::drivers::cameras
