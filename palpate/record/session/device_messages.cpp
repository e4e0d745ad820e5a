#include "palpate/record/session/device_messages.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "palpate/record/session/internal/message_parts.h"
#include "palpate/record/session/internal/viewer_messages.h"
#include "palpate/transport/wire_numbers.h"

namespace palpate::record::session {
namespace {

recording::Marker wire_marker(device::MarkerId marker) {
  switch (marker) {
    case device::MarkerId::tip_marker:
      return recording::MARKER_TIP_MARKER;
    case device::MarkerId::camera_marker:
      return recording::MARKER_CAMERA_MARKER;
    case device::MarkerId::pointer:
      return recording::MARKER_POINTER;
  }
  return recording::MARKER_NONE;
}

std::optional<device::MarkerId> marker_of(int number) {
  for (const auto marker :
       {device::MarkerId::tip_marker, device::MarkerId::camera_marker, device::MarkerId::pointer})
    if (wire_marker(marker) == number) return marker;
  return std::nullopt;
}

}  // namespace

std::string encode(const RecordedTrackerSample& recorded) {
  const device::TrackerSample& sample = recorded.sample;
  recording::TrackerSample out;
  out.set_stamp_ns(sample.stamp.ns());
  out.set_arrived_ns(recorded.arrived_ns);
  out.set_marker(wire_marker(sample.marker));
  out.set_seen(sample.seen);
  out.set_leds(static_cast<std::uint32_t>(std::max(sample.leds, 0)));
  if (!sample.seen) return out.SerializeAsString();
  put_orientation(out.mutable_orientation_wxyz(), sample.rotation);
  put(out.mutable_position_m(), sample.translation);
  put_upper<6>(out.mutable_covariance(), sample.covariance);
  put_upper<3>(out.mutable_systematic_m2(), sample.systematic);
  return out.SerializeAsString();
}

std::string encode(const RecordedCameraStamp& recorded) {
  recording::CameraStamp out;
  out.set_mid_exposure_ns(recorded.image.mid_exposure.ns());
  out.set_arrived_ns(recorded.arrived_ns);
  out.set_frame(recorded.image.frame);
  out.set_width(static_cast<std::uint32_t>(recorded.image.width));
  out.set_height(static_cast<std::uint32_t>(recorded.image.height));
  return out.SerializeAsString();
}

Expected<RecordedTrackerSample> decode_tracker_sample(std::string_view bytes) {
  const auto in = parse<recording::TrackerSample>(bytes, "a TrackerSample");
  if (!in) return tl::unexpected(in.error());
  const auto marker = marker_of(in->marker());
  if (!marker)
    return refused("a TrackerSample is of the marker {}, which means nothing here",
                   static_cast<int>(in->marker()));
  RecordedTrackerSample recorded;
  device::TrackerSample& sample = recorded.sample;
  sample.stamp = {Duration(in->stamp_ns())};
  recorded.arrived_ns = in->arrived_ns();
  sample.marker = *marker;
  sample.seen = in->seen();
  sample.leds = static_cast<int>(std::min(in->leds(), 1000u));
  if (!sample.seen) return recorded;
  const auto rotation = orientation_of(in->orientation_wxyz());
  if (!rotation) return refused("a TrackerSample has an orientation that is none");
  sample.rotation = *rotation;
  sample.translation = vector_of(in->position_m());
  if (!sample.translation.allFinite()) return refused("a TrackerSample has a position that is none");
  if (!read_upper<6>(in->covariance(), sample.covariance) ||
      !read_upper<3>(in->systematic_m2(), sample.systematic))
    return refused("a TrackerSample has no covariance of 21 and 6 numbers");
  return recorded;
}

Expected<RecordedCameraStamp> decode_camera_stamp(std::string_view bytes) {
  const auto in = parse<recording::CameraStamp>(bytes, "a CameraStamp");
  if (!in) return tl::unexpected(in.error());
  constexpr std::uint32_t kMost = 20000;  // px
  if (in->width() > kMost || in->height() > kMost)
    return refused("a CameraStamp is of an image of {} x {} pixels", in->width(), in->height());
  RecordedCameraStamp recorded;
  recorded.image.mid_exposure = {Duration(in->mid_exposure_ns())};
  recorded.image.frame = in->frame();
  recorded.image.width = static_cast<int>(in->width());
  recorded.image.height = static_cast<int>(in->height());
  recorded.arrived_ns = in->arrived_ns();
  return recorded;
}

std::string encode_condition(device::HealthCode code, bool holds, const std::string& words) {
  recording::Condition out;
  out.set_code(static_cast<wire::HealthCode>(transport::wire_number(code)));
  out.set_holds(holds);
  out.set_words(words);
  return out.SerializeAsString();
}

std::string encode_raw_image(const device::CameraImage& image, std::uint64_t time, const std::string& frame) {
  foxglove::RawImage out;
  set_time(*out.mutable_timestamp(), time);
  out.set_frame_id(frame);
  out.set_width(static_cast<std::uint32_t>(image.width));
  out.set_height(static_cast<std::uint32_t>(image.height));
  out.set_encoding("rgb8");
  out.set_step(3 * static_cast<std::uint32_t>(image.width));
  out.set_data(image.rgb.data(), image.rgb.size());
  return out.SerializeAsString();
}

std::string encode_compressed_image(std::string jpeg, std::uint64_t time, const std::string& frame) {
  foxglove::CompressedImage out;
  set_time(*out.mutable_timestamp(), time);
  out.set_frame_id(frame);
  out.set_format("jpeg");
  out.set_data(std::move(jpeg));
  return out.SerializeAsString();
}

bool decode_picture(std::string_view bytes, std::string_view type,
                    const std::function<bool(std::string_view, device::CameraImage&)>& decode_jpeg,
                    device::CameraImage& image) {
  const int width = image.width, height = image.height;
  if (type == "foxglove.RawImage") {
    const auto in = parse<foxglove::RawImage>(bytes, "a RawImage");
    const std::size_t size = 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (!in || in->encoding() != "rgb8" || in->data().size() != size) return false;
    image.rgb.assign(in->data().begin(), in->data().end());
    return true;
  }
  if (type != "foxglove.CompressedImage" || !decode_jpeg) return false;
  const auto in = parse<foxglove::CompressedImage>(bytes, "a CompressedImage");
  return in && in->format() == "jpeg" && decode_jpeg(in->data(), image) && image.width == width &&
         image.height == height;
}

// What viewers call the kinds of a lens; pixels count from the centre of the first one there, too.
const char* distortion_model(device::LensKind kind) {
  return kind == device::LensKind::fisheye    ? "kannala_brandt"
         : kind == device::LensKind::rational ? "rational_polynomial"
                                              : "plumb_bob";
}

std::string encode_calibration(const device::CameraModel& model, std::uint64_t time,
                               const std::string& frame) {
  foxglove::CameraCalibration out;
  set_time(*out.mutable_timestamp(), time);
  out.set_frame_id(frame);
  out.set_width(static_cast<std::uint32_t>(model.width));
  out.set_height(static_cast<std::uint32_t>(model.height));
  out.set_distortion_model(distortion_model(model.kind));
  for (const double d : model.coefficients()) out.add_d(d);
  for (const double k : {model.fx, 0.0, model.cx, 0.0, model.fy, model.cy, 0.0, 0.0, 1.0}) out.add_k(k);
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) out.add_r(r);
  for (const double p : {model.fx, 0.0, model.cx, 0.0, 0.0, model.fy, model.cy, 0.0, 0.0, 0.0, 1.0, 0.0})
    out.add_p(p);
  return out.SerializeAsString();
}

}  // namespace palpate::record::session
