// A GigE Vision camera in the network of this machine, made of Aravis' own pretended one, that shows pictures
// of ours: so the whole way of a real camera's pictures is walked, packets included.
//
// It sends Mono8 (the green channel), RGB8 or one of the four Bayer patterns, as it is told over the network,
// 640x480 px of whatever size it is set to, each picture `repeats` times before the next. Its clock is the
// machine's CLOCK_REALTIME, or that of whoever gives the pictures; who asks for it is answered by fake_camera_clock.h. Gone with the
// object, as if its plug were pulled.
//
// There is one place for such a camera on a machine: port 3956 of 127.0.0.1. Who tries one holds a
// NetworkCameraTurn meanwhile, so that tests of several checkouts do not take each other's camera.
#pragma once

#include <arpa/inet.h>
#include <arv.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate {

// Waits until nobody else on this machine pretends a network camera; tests/program/cameras_test.py waits at
// the same file.
class NetworkCameraTurn {
 public:
  NetworkCameraTurn() : file_(open(kFile, O_RDONLY | O_CLOEXEC)) {
    // Not O_CREAT at once: the kernel may refuse that for another user's file in /tmp.
    if (file_ < 0) file_ = open(kFile, O_RDONLY | O_CREAT | O_CLOEXEC, 0644);
    if (file_ < 0 || flock(file_, LOCK_EX) != 0)
      throw std::runtime_error(std::string(kFile) + " cannot be locked");
  }
  ~NetworkCameraTurn() { close(file_); }
  NetworkCameraTurn(const NetworkCameraTurn&) = delete;
  NetworkCameraTurn& operator=(const NetworkCameraTurn&) = delete;

 private:
  static constexpr const char* kFile = "/tmp/palpate_network_camera.lock";
  int file_;
};

class FakeNetworkCamera {
 public:
  using Picture = std::vector<std::uint8_t>;  // RGB
  static constexpr int kWidth = 640, kHeight = 480;

  // What it sends: a picture, and where they are not 0 its stamp, ns, and its number; where it is said, what waits
  // for the moment at which it goes out, all being ready.
  struct Shown {
    const Picture* picture = nullptr;
    std::uint64_t stamp_ns = 0, number = 0;
    std::function<void()> wait;
  };

  // `next` gives one picture after the other, in the camera's thread, and may wait for it; `picture` is used until the next.
  FakeNetworkCamera(const std::string& serial, std::function<Shown()> next) : next_(std::move(next)) {
    // The library's camera runs also where it could not take its port, deaf to everybody: so look before, and
    // whether it has it afterwards.
    if (!port_is_free())
      throw std::runtime_error(
          "no GigE Vision camera can be pretended: port 3956 of 127.0.0.1 is taken; end who pretends one");
    camera_ = arv_gv_fake_camera_new("127.0.0.1", serial.c_str());
    if (camera_ == nullptr || !arv_gv_fake_camera_is_running(camera_) || port_is_free()) {
      g_clear_object(&camera_);
      throw std::runtime_error("no GigE Vision camera can be pretended at 127.0.0.1: nobody listens at 3956");
    }
    arv_fake_camera_set_fill_pattern(arv_gv_fake_camera_get_fake_camera(camera_), fill, this);
  }
  FakeNetworkCamera(const std::string& serial, std::vector<Picture> pictures, unsigned repeats = 1)
      : FakeNetworkCamera(serial, [pictures = std::move(pictures), repeats, shown = 0u]() mutable {
          return Shown{&pictures[shown++ / repeats % pictures.size()]};
        }) {}
  ~FakeNetworkCamera() { g_object_unref(camera_); }
  FakeNetworkCamera(const FakeNetworkCamera&) = delete;
  FakeNetworkCamera& operator=(const FakeNetworkCamera&) = delete;

  // A register of Aravis' camera (arvfakecamera.h), as its client would read and write it.
  void set(std::uint32_t address, std::uint32_t value) {
    arv_fake_camera_write_register(arv_gv_fake_camera_get_fake_camera(camera_), address, value);
  }
  void set_size() {
    set(ARV_FAKE_CAMERA_REGISTER_WIDTH, kWidth);
    set(ARV_FAKE_CAMERA_REGISTER_HEIGHT, kHeight);
  }

  // The channel that a Bayer camera has at this place: 0 red, 1 green, 2 blue.
  static int channel(ArvPixelFormat format, int x, int y) {
    using Pattern = std::array<int, 4>;
    const Pattern pattern = format == ARV_PIXEL_FORMAT_BAYER_RG_8   ? Pattern{0, 1, 1, 2}
                            : format == ARV_PIXEL_FORMAT_BAYER_GR_8 ? Pattern{1, 0, 2, 1}
                            : format == ARV_PIXEL_FORMAT_BAYER_GB_8 ? Pattern{1, 2, 0, 1}
                                                                    : Pattern{2, 1, 1, 0};
    return pattern[static_cast<std::size_t>(y % 2 * 2 + x % 2)];
  }

 private:
  static bool port_is_free() {
    const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(3956);
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const bool is_free = bind(probe, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
    close(probe);
    return is_free;
  }
  static void fill(ArvBuffer* buffer, void* self, guint32, guint32, ArvPixelFormat format) {
    static_cast<FakeNetworkCamera*>(self)->fill(buffer, format);
  }
  void fill(ArvBuffer* buffer, ArvPixelFormat format) {
    std::size_t ignored = 0;
    auto* out = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &ignored)));
    if (arv_buffer_get_image_width(buffer) != kWidth || arv_buffer_get_image_height(buffer) != kHeight)
      return;
    const Shown shown = next_();
    const Picture& picture = *shown.picture;
    if (picture.size() != std::size_t{3} * kWidth * kHeight) return;
    if (shown.stamp_ns != 0) arv_buffer_set_timestamp(buffer, shown.stamp_ns);
    if (shown.number != 0) arv_buffer_set_frame_id(buffer, shown.number);
    if (format == ARV_PIXEL_FORMAT_RGB_8_PACKED)
      std::memcpy(out, picture.data(), picture.size());
    else
      fill_mosaic(picture, format, out);
    if (shown.wait) shown.wait();
  }
  static void fill_mosaic(const Picture& picture, ArvPixelFormat format, std::uint8_t* out) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const auto at = static_cast<std::size_t>(y * kWidth + x);
        const int c = format == ARV_PIXEL_FORMAT_MONO_8 ? 1 : channel(format, x, y);
        out[at] = picture[3 * at + static_cast<std::size_t>(c)];
      }
  }

  const std::function<Shown()> next_;  // of the camera's thread
  ArvGvFakeCamera* camera_ = nullptr;
};

}  // namespace palpate
