#include "drivers/cameras/aravis_source.h"

#include <arv.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <mutex>

#include "drivers/cameras/internal/clock_reader.h"
#include "drivers/cameras/internal/frame_count.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"

namespace palpate::drivers::cameras {
namespace {

constexpr int kAravisBuffers = 5;  // one held here, one being filled, three against a busy machine
constexpr int kPicturesInSocket =
    4;  // come in one burst each, while the thread that takes them waits for its turn
// Of every GigE Vision camera: GevTimestampControl, whose bit for latching is the last but one, and what it has latched.
constexpr std::uint64_t kTimestampControl = 0x944, kTimestampHigh = 0x948, kTimestampLow = 0x94c;
constexpr std::uint32_t kLatch = 2;
constexpr std::int64_t kAskExposureTimeNs = 500'000'000;

std::int64_t aravis_now_ns() { return MonotonicClock<CameraClock>::monotonic_ns(); }

// A list for the whole process, and none of ours goes to the library's own pretended camera.
std::unique_lock<std::mutex> aravis_list() {
  static std::mutex mutex;
  std::unique_lock lock(mutex);
  arv_disable_interface("Fake");
  return lock;
}

// What the kernel grants a socket, bytes; 0 where it does not tell.
std::int64_t most_in_socket() {
  std::int64_t bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> bytes;
  return bytes;
}

std::string text_or_empty(const char* text) { return text == nullptr ? "" : excerpt(text, 80); }

struct Release {
  void operator()(void* object) const { g_object_unref(object); }
};
template <typename T>
using Owned = std::unique_ptr<T, Release>;

// The reason of the latest call that failed; a call that succeeded leaves it empty.
class Reason {
 public:
  ~Reason() { g_clear_error(&error_); }
  GError** operator&() {  // NOLINT(google-runtime-operator): as a C function wants it
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  std::string words() const { return error_ == nullptr ? "no reason told" : excerpt(error_->message, 160); }
  bool not_found() const {
    return error_ != nullptr && error_->domain == ARV_DEVICE_ERROR &&
           error_->code == ARV_DEVICE_ERROR_NOT_FOUND;
  }

 private:
  GError* error_ = nullptr;
};

struct GenicamFormat {
  ArvPixelFormat code;
  const char* genicam;
  PixelFormat format;
};
// The best first. Colours that are made from a Bayer picture here cost a third of the network.
constexpr GenicamFormat kGenicamFormats[] = {
    {ARV_PIXEL_FORMAT_BAYER_RG_8, "BayerRG8", PixelFormat::bayer_rg8},
    {ARV_PIXEL_FORMAT_BAYER_GR_8, "BayerGR8", PixelFormat::bayer_gr8},
    {ARV_PIXEL_FORMAT_BAYER_GB_8, "BayerGB8", PixelFormat::bayer_gb8},
    {ARV_PIXEL_FORMAT_BAYER_BG_8, "BayerBG8", PixelFormat::bayer_bg8},
    {ARV_PIXEL_FORMAT_RGB_8_PACKED, "RGB8", PixelFormat::rgb8},
    {ARV_PIXEL_FORMAT_RGB_8_PACKED, "RGB8Packed", PixelFormat::rgb8},
    {ARV_PIXEL_FORMAT_BGR_8_PACKED, "BGR8", PixelFormat::bgr8},
    {ARV_PIXEL_FORMAT_BGR_8_PACKED, "BGR8Packed", PixelFormat::bgr8},
    {ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED, "YUV422_8", PixelFormat::yuyv},
    {ARV_PIXEL_FORMAT_YUV_422_PACKED, "YUV422_8_UYVY", PixelFormat::uyvy},
    {ARV_PIXEL_FORMAT_YUV_422_PACKED, "YUV422Packed", PixelFormat::uyvy},
    {ARV_PIXEL_FORMAT_MONO_8, "Mono8", PixelFormat::mono8},
};

class AravisSource : public FrameSource {
 public:
  AravisSource(std::string camera, CameraSettings settings)
      : wanted_(std::move(camera)),
        settings_(std::move(settings)),
        name_(wanted_.empty() ? "aravis" : "aravis:" + wanted_) {}
  ~AravisSource() override { AravisSource::close(); }
  const std::string& name() const override { return name_; }

  Outcome wait(Duration longest) override {
    give_back();
    if (gone_.load())
      return {Outcome::Kind::lost, {}, "the connection to it broke; see to its cable and power"};
    const auto us = std::chrono::ceil<std::chrono::microseconds>(longest).count();
    ArvBuffer* newest = arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(us));
    if (newest == nullptr) return {};
    while (ArvBuffer* later = arv_stream_try_pop_buffer(stream_.get())) {
      arv_stream_push_buffer(stream_.get(), newest);
      newest = later;
    }
    held_ = newest;
    return frame_of(newest);
  }

  void close() override {
    give_back();
    clock_.reset();
    if (camera_ && stream_ && !gone_.load()) {
      Reason ignored;
      arv_camera_stop_acquisition(camera_.get(), &ignored);
    }
    if (camera_) g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), this);
    stream_.reset();
    camera_.reset();
    gone_ = false;
  }

 private:
  template <typename... Args>
  tl::unexpected<Error> no(fmt::format_string<Args...> format, Args&&... args) const {
    return refused("camera {}: {}", name_, fmt::format(format, std::forward<Args>(args)...));
  }

  // Of the library's thread that receives packets and notes when a picture's first one came: it is let in at once,
  // whatever draws beside it, for what it is late by looks like the camera's delay.
  static void stream_event(void*, ArvStreamCallbackType type, ArvBuffer*) {
    if (type == ARV_STREAM_CALLBACK_TYPE_INIT) ask_for_short_turns();
  }
  // Of the library's heartbeat thread.
  static void control_lost(ArvDevice*, void* self) { static_cast<AravisSource*>(self)->gone_ = true; }

  Expected<CameraFacts> try_open() override {
    Reason reason;
    CameraFacts facts;
    {
      const auto lock = aravis_list();
      camera_.reset(arv_camera_new(wanted_.empty() ? nullptr : wanted_.c_str(), &reason));
    }
    if (!camera_) {
      if (reason.not_found() || !reason)
        return no(
            "no such camera answers; see to its cable, power and address, `palpate camera list` names those "
            "there are");
      return no("cannot be opened ({}); another program may hold it, or its address is of another network",
                reason.words());
    }
    g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost", G_CALLBACK(control_lost), this);
    if (arv_camera_is_gv_device(camera_.get()) &&
        !arv_gv_device_is_controller(ARV_GV_DEVICE(arv_camera_get_device(camera_.get()))))
      return no("another program holds it; end that one");
    facts.model = text_or_empty(arv_camera_get_vendor_name(camera_.get(), &reason)) + " " +
                  text_or_empty(arv_camera_get_model_name(camera_.get(), &reason));
    facts.serial = text_or_empty(arv_camera_get_device_serial_number(camera_.get(), &reason));
    if (auto set = set_format(facts); !set) return tl::unexpected(set.error());
    if (auto set = set_size(facts); !set) return tl::unexpected(set.error());
    if (auto set = set_exposure_and_gain(); !set) return tl::unexpected(set.error());
    if (auto set = set_rate(facts); !set) return tl::unexpected(set.error());
    ask_exposure();
    facts.exposure_s = to_seconds(exposure_);
    facts.stamp = "start of exposure, by the camera's clock";
    if (settings_.stamp_at) facts.stamp = "as --camera-stamp says";
    if (arv_camera_is_gv_device(camera_.get())) {
      ticks_per_s_ = arv_gv_device_get_timestamp_tick_frequency(
          ARV_GV_DEVICE(arv_camera_get_device(camera_.get())), &reason);
      if (!reason && ticks_per_s_ > 0) clock_ = ClockReader::begin([this] { return read_clock(); });
      if (clock_) facts.stamp += ", read over the network";
    }
    if (auto begun = begin(); !begun) return tl::unexpected(begun.error());
    count_.restart();
    return facts;
  }

  // Of the thread that opens, and then of the clock's own.
  std::optional<ClockReading> read_clock() {
    if (gone_.load()) return std::nullopt;
    auto* device = arv_camera_get_device(camera_.get());
    Reason reason;
    ClockReading reading;
    reading.asked_ns = aravis_now_ns();
    arv_device_write_register(device, kTimestampControl, kLatch, &reason);
    reading.answered_ns = aravis_now_ns();
    guint32 high = 0, low = 0;
    if (!reason) arv_device_read_register(device, kTimestampHigh, &high, &reason);
    if (!reason) arv_device_read_register(device, kTimestampLow, &low, &reason);
    if (reason) return std::nullopt;
    // As the library makes ns of a picture's stamp.
    constexpr std::uint64_t kNs = 1'000'000'000;
    const std::uint64_t ticks = std::uint64_t{high} << 32 | low;
    reading.camera_ns =
        static_cast<std::int64_t>(ticks / ticks_per_s_ * kNs + ticks % ticks_per_s_ * kNs / ticks_per_s_);
    return reading;
  }

  Expected<void> set_format(CameraFacts& facts) {
    Reason reason;
    guint count = 0;
    const char** list = arv_camera_dup_available_pixel_formats_as_strings(camera_.get(), &count, &reason);
    std::vector<std::string> there;
    for (guint i = 0; list != nullptr && i < count; ++i) there.emplace_back(list[i]);
    g_free(list);
    for (const auto& known : kGenicamFormats) {
      if (std::find(there.begin(), there.end(), known.genicam) == there.end()) continue;
      if (!settings_.pixel_format.empty() && name_of(known.format) != settings_.pixel_format) continue;
      arv_camera_set_pixel_format_from_string(camera_.get(), known.genicam, &reason);
      if (reason) return no("refuses {} pictures ({})", known.genicam, reason.words());
      facts.format = known.format;
      return {};
    }
    return no("its pixel formats are {}, and {} is expected",
              excerpt(fmt::format("{}", fmt::join(there, ", ")), 200),
              settings_.pixel_format.empty() ? "one of 8 bits: Bayer, RGB8, BGR8, YUV422_8 or Mono8"
                                             : excerpt(settings_.pixel_format));
  }

  Expected<void> set_size(CameraFacts& facts) {
    Reason reason;
    gint x = 0, y = 0, width = 0, height = 0;
    arv_camera_get_region(camera_.get(), &x, &y, &width, &height, &reason);
    if (reason) return no("does not tell its size ({})", reason.words());
    if (settings_.width > 0) width = settings_.width;
    if (settings_.height > 0) height = settings_.height;
    if (settings_.width > 0 || settings_.height > 0) {
      gint least_w = 0, most_w = 0, least_h = 0, most_h = 0;
      arv_camera_get_width_bounds(camera_.get(), &least_w, &most_w, &reason);
      arv_camera_get_height_bounds(camera_.get(), &least_h, &most_h, &reason);
      // Bounds are what is left beside the present offset.
      if (width > most_w + x || width < least_w || height > most_h + y || height < least_h)
        return no(
            "gives {}x{} to {}x{} px where {}x{} are asked for; calibrate the lens at a size that it has "
            "(palpate calibrate camera)",
            least_w, least_h, most_w + x, most_h + y, width, height);
      // The part of the sensor that was set stays, as far as it fits: the lens calibration is of that part.
      x = std::min(x, std::max(0, most_w + x - width)), y = std::min(y, std::max(0, most_h + y - height));
      arv_camera_set_region(camera_.get(), x, y, width, height, &reason);
      if (reason) return no("refuses {}x{} px ({})", width, height, reason.words());
      gint now_w = 0, now_h = 0;
      arv_camera_get_region(camera_.get(), &x, &y, &now_w, &now_h, &reason);
      if (now_w != width || now_h != height)
        return no(
            "gives {}x{} px where {}x{} are asked for; calibrate the lens at a size that it has "
            "(palpate calibrate camera)",
            now_w, now_h, width, height);
    }
    facts.width = width, facts.height = height;
    return {};
  }

  Expected<void> set_rate(CameraFacts& facts) {
    Reason reason;
    if (!arv_camera_is_frame_rate_available(camera_.get(), &reason)) return {};
    if (settings_.rate_hz > 0.0) {
      arv_camera_set_frame_rate(camera_.get(), settings_.rate_hz, &reason);
      if (reason) return no("its rate cannot be {:g} Hz ({})", settings_.rate_hz, reason.words());
    }
    facts.rate_hz = std::max(0.0, arv_camera_get_frame_rate(camera_.get(), &reason));
    return {};
  }

  Expected<void> set_exposure_and_gain() {
    Reason reason;
    auto* camera = camera_.get();
    if (settings_.exposure_s) {
      if (!arv_camera_is_exposure_time_available(camera, &reason))
        return no("its exposure cannot be set; leave that option out");
      if (arv_camera_is_exposure_auto_available(camera, &reason))
        arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, &reason);
      double least = 0.0, most = 0.0;
      arv_camera_get_exposure_time_bounds(camera, &least, &most, &reason);
      const double wanted = *settings_.exposure_s * 1e6;
      if (!reason && (wanted < least || wanted > most))
        return no("exposure {:g} ms: {:g} to {:g} ms is expected", wanted * 1e-3, least * 1e-3, most * 1e-3);
      arv_camera_set_exposure_time(camera, wanted, &reason);
      if (reason) return no("its exposure cannot be set ({})", reason.words());
    }
    if (settings_.gain) {
      if (!arv_camera_is_gain_available(camera, &reason))
        return no("its gain cannot be set; leave that option out");
      if (arv_camera_is_gain_auto_available(camera, &reason))
        arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, &reason);
      double least = 0.0, most = 0.0;
      arv_camera_get_gain_bounds(camera, &least, &most, &reason);
      if (!reason && (*settings_.gain < least || *settings_.gain > most))
        return no("gain {:g}: {:g} to {:g} is expected", *settings_.gain, least, most);
      arv_camera_set_gain(camera, *settings_.gain, &reason);
      if (reason) return no("its gain cannot be set ({})", reason.words());
    }
    automatic_ = !settings_.exposure_s && arv_camera_is_exposure_auto_available(camera, &reason) &&
                 arv_camera_get_exposure_time_auto(camera, &reason) != ARV_AUTO_OFF;
    return {};
  }

  void ask_exposure() {
    Reason reason;
    const double us = arv_camera_is_exposure_time_available(camera_.get(), &reason)
                          ? arv_camera_get_exposure_time(camera_.get(), &reason)
                          : 0.0;
    if (!reason) exposure_ = seconds(std::clamp(us, 0.0, 1e8) * 1e-6);
    asked_ns_ = aravis_now_ns();
  }

  Expected<void> begin() {
    Reason reason;
    // A trigger that somebody has set stays: cameras side by side are triggered together.
    arv_camera_set_acquisition_mode(camera_.get(), ARV_ACQUISITION_MODE_CONTINUOUS, &reason);
    const guint bytes = arv_camera_get_payload(camera_.get(), &reason);
    if (reason) return no("does not tell how large its pictures are ({})", reason.words());
    const auto burst = std::int64_t{kPicturesInSocket} * bytes;
    const bool fits = arv_camera_is_gv_device(camera_.get()) && most_in_socket() >= burst;
    // With rights for it the library takes packets in blocks, up to 5 ms late; a socket that holds enough is as safe
    // and tells when they came.
    if (fits) arv_camera_gv_set_stream_options(camera_.get(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    stream_.reset(arv_camera_create_stream(camera_.get(), stream_event, nullptr, &reason));
    if (!stream_)
      return no("opens no stream ({}); see that no firewall keeps its packets away", reason.words());
    if (fits && ARV_IS_GV_STREAM(stream_.get()))
      g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   static_cast<gint>(burst), nullptr);
    for (int i = 0; i < kAravisBuffers; ++i)
      arv_stream_push_buffer(stream_.get(), arv_buffer_new(bytes, nullptr));
    arv_camera_start_acquisition(camera_.get(), &reason);
    if (reason) return no("does not begin ({})", reason.words());
    return {};
  }

  void give_back() {
    if (held_ != nullptr) arv_stream_push_buffer(stream_.get(), held_);
    held_ = nullptr;
  }

  // The library notes the wall clock's time of a picture's first packet.
  static std::int64_t arrival_of(ArvBuffer* buffer, std::int64_t now_ns) {
    constexpr std::int64_t kLongest = 1'000'000'000;  // older: the wall clock was set meanwhile
    const auto since =
        g_get_real_time() * 1000 - static_cast<std::int64_t>(arv_buffer_get_system_timestamp(buffer));
    return since >= 0 && since < kLongest ? now_ns - since : now_ns;
  }

  Outcome frame_of(ArvBuffer* buffer) {
    const std::int64_t taken = aravis_now_ns();
    if (automatic_ && taken - asked_ns_ > kAskExposureTimeNs) ask_exposure();
    const std::uint64_t number = count_.count(arv_buffer_get_frame_id(buffer));
    if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS)
      return {Outcome::Kind::damaged,
              {},
              "packets of its pictures are lost; a faster network, jumbo frames or a lower "
              "rate help"};
    const auto code = arv_buffer_get_image_pixel_format(buffer);
    const auto* known = std::find_if(std::begin(kGenicamFormats), std::end(kGenicamFormats),
                                     [&](const auto& format) { return format.code == code; });
    if (known == std::end(kGenicamFormats))
      return {Outcome::Kind::damaged,
              {},
              fmt::format("its pictures are of pixel format 0x{:08x}, which nobody asked for; "
                          "another program changes its settings",
                          code)};
    const auto stamp = static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer));
    const Shutter shutter{exposure_, seconds(settings_.readout_s), settings_.rolling};
    Outcome outcome{Outcome::Kind::frame, {}, {}};
    outcome.frame.number = number;
    outcome.frame.arrived_ns = arrival_of(buffer, taken);
    outcome.frame.mid_exposure_ns =
        stamp > 0
            ? stamp + to_mid_exposure(settings_.stamp_at.value_or(StampAt::exposure_start), shutter).count()
            : taken + to_mid_exposure(StampAt::frame_end, shutter).count();
    if (clock_ && stamp > 0) outcome.frame.taken_ns = clock_->host_ns(outcome.frame.mid_exposure_ns);
    std::size_t size = 0;
    const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
    gint pad_x = 0, pad_y = 0;
    arv_buffer_get_image_padding(buffer, &pad_x, &pad_y);
    const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
    outcome.frame.picture = {
        known->format,
        width,
        height,
        packed_bytes(known->format, width, 1) + static_cast<std::size_t>(std::max(pad_x, 0)),
        {data, size}};
    return outcome;
  }

  const std::string wanted_;
  const CameraSettings settings_;
  const std::string name_;
  Owned<ArvCamera> camera_;
  Owned<ArvStream> stream_;  // after the camera: gone first
  ArvBuffer* held_ = nullptr;
  std::atomic<bool> gone_{false};
  std::unique_ptr<ClockReader> clock_;  // null: the camera does not tell. Asks the camera: gone before it
  std::uint64_t ticks_per_s_ = 0;       // of the camera's clock
  bool automatic_ = false;
  Duration exposure_{0};
  std::int64_t asked_ns_ = 0;
  // GigE Vision 1.x counts 1 to 65535; what counts in 64 bits never wraps in a lifetime, but then a gap of
  // 65535 frames looks like none.
  FrameCount count_{1, 0xFFFF};
};

}  // namespace

std::unique_ptr<FrameSource> make_aravis_source(std::string camera, CameraSettings settings) {
  return std::make_unique<AravisSource>(std::move(camera), std::move(settings));
}

std::vector<AravisLook> list_aravis() {
  const auto lock = aravis_list();
  arv_update_device_list();
  std::vector<AravisLook> found;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    found.push_back({text_or_empty(arv_get_device_id(i)),
                     text_or_empty(arv_get_device_vendor(i)) + " " + text_or_empty(arv_get_device_model(i)),
                     text_or_empty(arv_get_device_serial_nbr(i)), text_or_empty(arv_get_device_address(i)),
                     text_or_empty(arv_get_device_protocol(i))});
  return found;
}

std::string aravis_version() {
  return fmt::format("{}.{}.{}", ARAVIS_MAJOR_VERSION, ARAVIS_MINOR_VERSION, ARAVIS_MICRO_VERSION);
}

}  // namespace palpate::drivers::cameras
