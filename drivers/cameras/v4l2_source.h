// A camera behind Video4Linux: webcams (UVC), capture cards, FireWire and CSI cameras with a kernel driver.
//
// Streams through mapped buffers. Stamps: the kernel's, of CLOCK_MONOTONIC, of the moment that its flags
// name (start of exposure, else end of the frame), brought to mid-exposure with the exposure time that the
// camera tells (V4L2_CID_EXPOSURE_ABSOLUTE); the time of arrival where the kernel gives another clock's.
// Source: Linux media documentation, part I (Video for Linux API), "Buffers" and "Camera Control Reference".
#pragma once

#include <memory>
#include <vector>

#include "drivers/cameras/frame_source.h"
#include "drivers/cameras/v4l2_io.h"

namespace palpate::drivers::cameras {

// `device`: a path such as /dev/video0, or empty for the first camera there is.
std::unique_ptr<FrameSource> make_v4l2_source(std::string device, CameraSettings settings,
                                              V4l2Io& io = kernel_v4l2());

// What is behind a /dev/video*, without streaming.
struct V4l2Look {
  std::string path;
  std::string model;                 // empty where it cannot be opened
  bool camera = false;               // captures and streams: cameras show nodes for other purposes as well
  std::vector<std::string> formats;  // ours by name, others by their four letters
  std::string problem;               // why it cannot be had, with a remedy; or empty
};
V4l2Look look_at_v4l2(const std::string& path, V4l2Io& io = kernel_v4l2());
// All of /dev/video*, in order of number.
std::vector<V4l2Look> list_v4l2(V4l2Io& io = kernel_v4l2());

// --- parts of it that need no camera

// A stamp as the kernel gives it, and when the frame was taken from it, both CLOCK_MONOTONIC in ns.
struct V4l2Stamp {
  std::int64_t ns = 0;
  StampAt at = StampAt::frame_end;
};
V4l2Stamp v4l2_stamp(std::uint32_t flags, std::int64_t stamp_ns, std::int64_t taken_ns);

std::optional<PixelFormat> from_fourcc(std::uint32_t fourcc);

}  // namespace palpate::drivers::cameras
