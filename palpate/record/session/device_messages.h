// What devices measure, as messages of palpate_recording.proto and, of pictures, of foxglove.proto. Pure. decode checks what it
// reads as any file of others.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/device/camera_model.h"
#include "palpate/device/devices.h"
#include "palpate/device/health.h"

namespace palpate::record::session {

// `arrived_ns`: the machine's monotonic clock.
struct RecordedTrackerSample {
  device::TrackerSample sample;
  std::int64_t arrived_ns = 0;
};
// Without its pixels.
struct RecordedCameraStamp {
  device::CameraImage image;
  std::int64_t arrived_ns = 0;
};

std::string encode(const RecordedTrackerSample& sample);  // palpate.recording.TrackerSample
std::string encode(const RecordedCameraStamp& stamp);     // palpate.recording.CameraStamp
Expected<RecordedTrackerSample> decode_tracker_sample(std::string_view bytes);
Expected<RecordedCameraStamp> decode_camera_stamp(std::string_view bytes);

// palpate.recording.Condition: something is wrong with a device, or no more.
std::string encode_condition(device::HealthCode code, bool holds, const std::string& words);

// For viewers. `time`: log time, ns; `frame`: of the camera, "camera_left".
std::string encode_raw_image(const device::CameraImage& image, std::uint64_t time, const std::string& frame);
std::string encode_compressed_image(std::string jpeg, std::uint64_t time, const std::string& frame);
// A recorded picture's pixels, by the name of its message's type; `decode_jpeg` as of recording_driver.h. False where it is none, or
// of another size than its stamp says.
bool decode_picture(std::string_view bytes, std::string_view type,
                    const std::function<bool(std::string_view, device::CameraImage&)>& decode_jpeg,
                    device::CameraImage& image);
std::string encode_calibration(const device::CameraModel& model, std::uint64_t time,
                               const std::string& frame);

}  // namespace palpate::record::session
