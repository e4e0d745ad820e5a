#include "drivers/cameras/v4l2_source.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>

#include "drivers/cameras/live_camera.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::cameras {
namespace {

// A kernel with one camera at /dev/video0 that remembers what it was told.
class FakeKernel : public V4l2Io {
 public:
  // --- what a test arranges
  int open_error = 0, stream_error = 0, format_error = 0;
  bool node_without_pictures = false, unplugged = false, no_video = false;
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_YUYV};
  std::map<std::uint32_t, double> fastest_hz;  // by format
  int width = 16, height = 8;                  // whatever is asked for, where `stubborn`
  bool stubborn = false;
  std::map<std::uint32_t, std::array<int, 3>> controls = {// least, most, value
                                                          {V4L2_CID_EXPOSURE_ABSOLUTE, {1, 330, 100}},
                                                          {V4L2_CID_GAIN, {0, 64, 8}},
                                                          {V4L2_CID_EXPOSURE_AUTO, {0, 3, 3}}};
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;

  // --- what a test sees
  int opened = 0, closed = 0;
  std::uint32_t chosen = 0;
  bool streaming = false;
  std::deque<unsigned> queued;  // buffers that the camera may fill
  std::size_t mapped = 0;

  // The camera takes a picture, each byte of it of this value.
  void shoot(std::int64_t stamp_ns, std::uint8_t value, std::uint32_t more_flags = 0) {
    ++sequence_;
    if (queued.empty()) return;
    auto done = v4l2_buffer();
    done.index = queued.front();
    queued.pop_front();
    std::fill(memory_[done.index].begin(), memory_[done.index].end(), value);
    done.bytesused = static_cast<__u32>(memory_[done.index].size());
    done.flags = flags | more_flags;
    done.timestamp = {stamp_ns / 1'000'000'000, stamp_ns % 1'000'000'000 / 1000};
    done.sequence = sequence_ - 1;
    full_.push_back(done);
  }
  void skip(unsigned frames) { sequence_ += frames; }

  int open(const char* path) override {
    if (open_error != 0 || unplugged || std::string(path) != "/dev/video0")
      return fails(open_error != 0 ? open_error : ENOENT);
    ++opened;
    return 7;
  }
  void close(int) override { ++closed, streaming = false, queued.clear(), full_.clear(); }
  void* map(int, std::size_t length, std::int64_t offset) override {
    ++mapped;
    auto& memory = memory_[static_cast<std::size_t>(offset)];
    memory.assign(length, 0);
    return memory.data();
  }
  void unmap(void*, std::size_t) override { --mapped; }
  int wait(int, int) override { return unplugged || !full_.empty() ? 1 : 0; }

  int control(int, unsigned long request, void* argument) override {
    if (unplugged) return fails(ENODEV);
    if (no_video) return fails(ENOTTY);
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& about = *static_cast<v4l2_capability*>(argument);
        std::strcpy(reinterpret_cast<char*>(about.card), "Fake Webcam");
        about.capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        about.device_caps = node_without_pictures ? V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING
                                                  : V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto& format = *static_cast<v4l2_fmtdesc*>(argument);
        if (format.index >= formats.size()) return fails(EINVAL);
        format.pixelformat = formats[format.index];
        return 0;
      }
      case VIDIOC_ENUM_FRAMEINTERVALS: {
        auto& interval = *static_cast<v4l2_frmivalenum*>(argument);
        if (interval.index > 0 || fastest_hz.count(interval.pixel_format) == 0) return fails(EINVAL);
        interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
        interval.discrete = {1, static_cast<__u32>(fastest_hz[interval.pixel_format])};
        return 0;
      }
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT: {
        auto& pixels = static_cast<v4l2_format*>(argument)->fmt.pix;
        if (request == VIDIOC_S_FMT) {
          if (format_error != 0) return fails(format_error);
          chosen = pixels.pixelformat;
          if (!stubborn) width = static_cast<int>(pixels.width), height = static_cast<int>(pixels.height);
        }
        pixels.width = static_cast<__u32>(width), pixels.height = static_cast<__u32>(height);
        pixels.bytesperline = 2 * pixels.width;
        pixels.sizeimage = pixels.bytesperline * pixels.height;
        return 0;
      }
      case VIDIOC_G_PARM:
      case VIDIOC_S_PARM: {
        auto& interval = static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe;
        if (request == VIDIOC_G_PARM) interval = {1, 30};
        return 0;
      }
      case VIDIOC_QUERYCTRL: {
        auto& range = *static_cast<v4l2_queryctrl*>(argument);
        if (controls.count(range.id) == 0) return fails(EINVAL);
        range.minimum = controls[range.id][0], range.maximum = controls[range.id][1];
        return 0;
      }
      case VIDIOC_S_CTRL:
      case VIDIOC_G_CTRL: {
        auto& control = *static_cast<v4l2_control*>(argument);
        if (controls.count(control.id) == 0) return fails(EINVAL);
        if (request == VIDIOC_S_CTRL) controls[control.id][2] = control.value;
        control.value = controls[control.id][2];
        return 0;
      }
      case VIDIOC_REQBUFS:
        memory_.resize(static_cast<v4l2_requestbuffers*>(argument)->count);
        return 0;
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.length = static_cast<__u32>(2 * width * height);
        buffer.m.offset = buffer.index;
        return 0;
      }
      case VIDIOC_QBUF:
        queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF: {
        if (full_.empty()) return fails(EAGAIN);
        *static_cast<v4l2_buffer*>(argument) = full_.front();
        full_.pop_front();
        return 0;
      }
      case VIDIOC_STREAMON:
        if (stream_error != 0) return fails(stream_error);
        streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      default:
        return fails(ENOTTY);
    }
  }

 private:
  static int fails(int error) {
    errno = error;
    return -1;
  }
  std::vector<std::vector<std::uint8_t>> memory_;
  std::deque<v4l2_buffer> full_;
  unsigned sequence_ = 0;
};

constexpr const char* kDevice = "/dev/video0";
constexpr Duration kSoon = std::chrono::milliseconds(1);

std::string refusal(FakeKernel& kernel, const CameraSettings& settings = {}, const char* device = kDevice) {
  const auto facts = make_v4l2_source(device, settings, kernel)->open();
  EXPECT_EQ(kernel.opened, kernel.closed);
  EXPECT_EQ(kernel.mapped, 0u);
  return facts ? "accepted" : facts.error().message;
}

TEST(V4l2, TheNewestPictureIsTakenAndEveryBufferGivenBack) {
  FakeKernel kernel;
  const auto source = make_v4l2_source(kDevice, {}, kernel);
  const auto facts = source->open();
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->model, "Fake Webcam");
  EXPECT_EQ(facts->format, PixelFormat::yuyv);
  EXPECT_NEAR(facts->rate_hz, 30.0, 1e-9);
  ASSERT_TRUE(kernel.streaming);
  ASSERT_EQ(kernel.queued.size(), 4u);
  kernel.shoot(1'000'000'000, 16), kernel.shoot(1'033'000'000, 17), kernel.shoot(1'066'000'000, 18);
  const auto outcome = source->wait(kSoon);
  ASSERT_EQ(outcome.kind, Outcome::Kind::frame);
  EXPECT_EQ(outcome.frame.picture.bytes[5], 18);
  EXPECT_EQ(outcome.frame.picture.bytes.size(), 256u);
  // Start of exposure, and half of the 10 ms that the camera tells.
  EXPECT_EQ(outcome.frame.mid_exposure_ns, 1'066'000'000 + 5'000'000);
  EXPECT_EQ(kernel.queued.size(), 3u);  // one is held
  EXPECT_EQ(source->wait(kSoon).kind, Outcome::Kind::nothing);
  EXPECT_EQ(kernel.queued.size(), 4u);
  kernel.skip(2);  // two frames that nobody had a buffer for
  kernel.shoot(1'200'000'000, 19);
  EXPECT_EQ(source->wait(kSoon).frame.number, outcome.frame.number + 3);
  source->close();
  EXPECT_EQ(kernel.closed, 1);
  EXPECT_EQ(kernel.mapped, 0u);
}

TEST(V4l2, AStampIsOfWhatTheKernelsFlagsSay) {
  const std::uint32_t monotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  auto stamp = v4l2_stamp(monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, 5, 9);
  EXPECT_EQ(stamp.ns, 5);
  EXPECT_EQ(stamp.at, StampAt::exposure_start);
  stamp = v4l2_stamp(monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_EOF, 5, 9);
  EXPECT_EQ(stamp.ns, 5);
  EXPECT_EQ(stamp.at, StampAt::frame_end);
  for (const std::uint32_t other : {V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN, V4L2_BUF_FLAG_TIMESTAMP_COPY}) {
    stamp = v4l2_stamp(other | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, 5, 9);
    EXPECT_EQ(stamp.ns, 9);  // another clock's: the time of arrival instead
    EXPECT_EQ(stamp.at, StampAt::frame_end);
  }
  EXPECT_EQ(v4l2_stamp(monotonic, 0, 9).ns, 9);  // some drivers forget it
}

TEST(V4l2, SettingsReachTheCameraAndStampsFollowTheExposure) {
  FakeKernel kernel;
  kernel.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  CameraSettings settings;
  settings.width = 32, settings.height = 24;
  settings.exposure_s = 0.004, settings.gain = 20.0;
  settings.readout_s = 0.010, settings.rolling = true;
  const auto source = make_v4l2_source(kDevice, settings, kernel);
  const auto facts = source->open();
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->width, 32);
  EXPECT_EQ(kernel.controls[V4L2_CID_EXPOSURE_ABSOLUTE][2], 40);  // of 0.1 ms
  EXPECT_EQ(kernel.controls[V4L2_CID_EXPOSURE_AUTO][2], V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(kernel.controls[V4L2_CID_GAIN][2], 20);
  kernel.shoot(2'000'000'000, 1);
  EXPECT_EQ(source->wait(kSoon).frame.mid_exposure_ns, 2'000'000'000 - 7'000'000);
  settings.exposure_s = 0.2;
  EXPECT_NE(refusal(kernel = FakeKernel(), settings).find("exposure 200 ms: 0.1 to 33 ms is expected"),
            std::string::npos);
  settings.exposure_s.reset(), settings.gain = 65.0;
  EXPECT_NE(refusal(kernel = FakeKernel(), settings).find("gain 65: 0 to 64 is expected"), std::string::npos);
  kernel = FakeKernel();
  kernel.controls.erase(V4L2_CID_GAIN);
  EXPECT_NE(refusal(kernel, settings).find("its gain cannot be set; leave that option out"),
            std::string::npos);
}

TEST(V4l2, TheFormatIsTheBestThatIsFastEnoughAtThatSize) {
  CameraSettings settings;
  settings.width = 1280, settings.height = 720;
  FakeKernel kernel;
  kernel.formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_H264};
  kernel.fastest_hz = {{V4L2_PIX_FMT_YUYV, 10}, {V4L2_PIX_FMT_MJPEG, 30}};
  ASSERT_TRUE(make_v4l2_source(kDevice, settings, kernel)->open());
  EXPECT_EQ(kernel.chosen, V4L2_PIX_FMT_MJPEG);
  kernel.fastest_hz[V4L2_PIX_FMT_YUYV] = 30;
  ASSERT_TRUE(make_v4l2_source(kDevice, settings, kernel)->open());
  EXPECT_EQ(kernel.chosen, V4L2_PIX_FMT_YUYV);
  settings.pixel_format = "MJPEG";
  ASSERT_TRUE(make_v4l2_source(kDevice, settings, kernel)->open());
  EXPECT_EQ(kernel.chosen, V4L2_PIX_FMT_MJPEG);
  settings.pixel_format = "RGB8";
  EXPECT_NE(refusal(kernel, settings).find("its pixel formats are MJPEG, YUYV, H264, and RGB8 is expected"),
            std::string::npos);
}

TEST(V4l2, WhatCannotBeHadIsNamedWithItsRemedy) {
  FakeKernel kernel;
  const auto expect_words = [&](const std::string& message, const char* words) {
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_EQ(message.find("camera v4l2:/dev/video"), 0u) << message;
    kernel = FakeKernel();
  };
  expect_words(refusal(kernel, {}, "/dev/video9"), "there is no such device; `palpate camera list`");
  kernel.open_error = EACCES;
  expect_words(refusal(kernel), "usermod -aG video");
  kernel.open_error = EBUSY;
  expect_words(refusal(kernel), "another program uses it");
  kernel.no_video = true;
  expect_words(refusal(kernel), "this is no video device");
  kernel.node_without_pictures = true;
  expect_words(refusal(kernel), "'Fake Webcam' does not capture pictures");
  kernel.format_error = EBUSY;
  expect_words(refusal(kernel), "another program uses it");
  kernel.stream_error = EBUSY;
  expect_words(refusal(kernel), "another program uses it");
  kernel.stream_error = ENOSPC;
  expect_words(refusal(kernel), "the USB has no room");
  kernel.formats = {V4L2_PIX_FMT_H264};
  expect_words(refusal(kernel), "its pixel formats are H264");
  kernel.stubborn = true;
  CameraSettings settings;
  settings.width = 640, settings.height = 480;
  expect_words(refusal(kernel, settings), "gives 16x8 px where 640x480 are asked for");
}

TEST(V4l2, DamageIsSaidAndUnpluggingIsALossThatEnds) {
  FakeKernel kernel;
  const auto source = make_v4l2_source(kDevice, {}, kernel);
  ASSERT_TRUE(source->open());
  kernel.shoot(1'000'000'000, 1, V4L2_BUF_FLAG_ERROR);
  EXPECT_EQ(source->wait(kSoon).kind, Outcome::Kind::damaged);
  kernel.unplugged = true;
  auto outcome = source->wait(kSoon);
  EXPECT_EQ(outcome.kind, Outcome::Kind::lost);
  EXPECT_EQ(outcome.words, "it was unplugged; plug it in again");
  source->close();
  EXPECT_FALSE(source->open());
  kernel.unplugged = false;
  ASSERT_TRUE(source->open());
  kernel.shoot(3'000'000'000, 9);
  outcome = source->wait(kSoon);
  ASSERT_EQ(outcome.kind, Outcome::Kind::frame);
  EXPECT_EQ(outcome.frame.picture.bytes[0], 9);
  EXPECT_EQ(outcome.frame.number, 2u);  // the count goes on
}

TEST(V4l2, AFileThatIsNoDeviceIsSeenThroughTheRealKernel) {
  const ScratchFolder folder;
  std::ofstream(folder / "video0") << "text";
  const auto facts = make_v4l2_source((folder / "video0").string(), {})->open();
  ASSERT_FALSE(facts);
  EXPECT_NE(facts.error().message.find("this is no video device"), std::string::npos);
  EXPECT_NE(look_at_v4l2((folder / "video1").string()).problem.find("there is no such device"),
            std::string::npos);
}

TEST(V4l2, ALookNamesModelAndFormatsWithoutStreaming) {
  FakeKernel kernel;
  kernel.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_H264};
  auto look = look_at_v4l2(kDevice, kernel);
  EXPECT_TRUE(look.camera);
  EXPECT_EQ(look.model, "Fake Webcam");
  EXPECT_EQ(look.formats, (std::vector<std::string>{"YUYV", "H264"}));
  kernel.node_without_pictures = true;
  look = look_at_v4l2(kDevice, kernel);
  EXPECT_FALSE(look.camera);
  EXPECT_TRUE(look.problem.empty());
  EXPECT_FALSE(kernel.streaming);
  EXPECT_EQ(kernel.opened, kernel.closed);
}

}  // namespace
}  // namespace palpate::drivers::cameras
