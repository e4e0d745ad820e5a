#include "palpate/record/session/export_sequence.h"

#include <fmt/format.h>

#include <vector>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/record/record_file.h"

namespace palpate::record::session {
namespace {

// Frames of one size.
struct SequenceFrames {
  int width = 0, height = 0;
  std::vector<Instant<CameraClock>> stamps;
  std::uint64_t left_out = 0;

  bool takes(const device::CameraImage& image) {
    if (width == 0) width = image.width, height = image.height;
    return image.width == width && image.height == height;
  }
};

struct MarkerStream {
  std::string transform;  // "PointerToTracker"
  std::vector<device::TrackedPose> poses;
};

std::string matrix_text(const device::TrackerSample& pose) {
  const Matrix3 R = pose.rotation.toRotationMatrix();
  const Vector3 mm = kMillimetresPerMetre * pose.translation;
  std::string text;
  for (int i = 0; i < 3; ++i) text += fmt::format("{} {} {} {} ", R(i, 0), R(i, 1), R(i, 2), mm[i]);
  return text + "0 0 0 1";
}

std::string header_text(const SequenceFrames& frames) {
  return fmt::format(
      "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\nBinaryData = True\n"
      "BinaryDataByteOrderMSB = False\nCenterOfRotation = 0 0 0\nCompressedData = False\nDimSize = {} {} {}\n"
      "ElementNumberOfChannels = 3\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nKinds = domain domain "
      "list\n"
      "Offset = 0 0 0\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nUltrasoundImageOrientation = MFA\n"
      "UltrasoundImageType = RGB_COLOR\n",
      frames.width, frames.height, frames.stamps.size());
}

// The fields of one frame; counts what is valid.
std::string frame_text(std::size_t number, double time_s, const std::vector<MarkerStream>& markers,
                       double delay_s, SequenceReport& report) {
  const std::string frame = fmt::format("Seq_Frame{:04}_", number);
  std::string text;
  for (const auto& marker : markers) {
    const auto pose = device::pose_between(marker.poses, time_s - delay_s);
    auto& counts = report.transforms[marker.transform];
    ++(pose ? counts.valid : counts.invalid);
    text += fmt::format("{}{}Transform = {}\n{}{}TransformStatus = {}\n", frame, marker.transform,
                        matrix_text(pose ? pose->marker : device::TrackerSample{}), frame, marker.transform,
                        pose ? "OK" : "INVALID");
  }
  return text + fmt::format("{}Timestamp = {:.9f}\n{}ImageStatus = OK\n", frame, time_s, frame);
}

StreamsToRead streams_of(const SequenceOptions& options) {
  StreamsToRead what;
  what.span = options.span;
  what.camera = options.camera;
  what.decode = options.decode;
  return what;
}

}  // namespace

Expected<SequenceReport> export_sequence(const std::filesystem::path& recording,
                                         const std::filesystem::path& file, const SequenceOptions& options) {
  SequenceFrames frames;
  StreamsToRead what = streams_of(options);
  what.picture = [&](const device::CameraImage& image) {
    if (frames.takes(image))
      frames.stamps.push_back(image.mid_exposure);
    else
      ++frames.left_out;
  };
  const auto read = read_streams(recording, what);
  if (!read) return tl::unexpected(read.error());
  if (frames.stamps.empty())
    return refused("{}: holds no pictures of the {} camera; record with --pictures jpeg",
                   one_line(recording.string()), options.camera);
  SequenceReport report;
  report.frames = frames.stamps.size();
  report.left_out = frames.left_out;
  report.width = frames.width, report.height = frames.height;
  std::vector<MarkerStream> markers;
  for (const auto& [marker, name] : options.names)
    if (auto poses = read->streams.marker_poses(marker); !poses.empty())
      markers.push_back({name + "ToTracker", std::move(poses)});

  auto out = RecordFile::whole(file);
  if (!out) return tl::unexpected(out.error());
  if (auto done = out->append(header_text(frames)); !done) return tl::unexpected(done.error());
  for (std::size_t i = 0; i < frames.stamps.size(); ++i)
    if (auto done = out->append(frame_text(i, read->streams.host_time(frames.stamps[i]), markers,
                                           options.camera_after_tracker_s, report));
        !done)
      return tl::unexpected(done.error());
  // The last line of a header: pixels follow.
  if (auto done = out->append("ElementDataFile = LOCAL\n"); !done) return tl::unexpected(done.error());
  Expected<void> written;
  std::uint64_t again = 0;
  what.picture = [&](const device::CameraImage& image) {
    if (!written || !frames.takes(image)) return;
    ++again;
    written = out->append({reinterpret_cast<const char*>(image.rgb.data()), image.rgb.size()});
  };
  if (const auto second = read_streams(recording, what); !second) return tl::unexpected(second.error());
  if (!written) return tl::unexpected(written.error());
  if (again != report.frames) return refused("{}: changed while it was read", one_line(recording.string()));
  if (auto done = out->finish(); !done) return tl::unexpected(done.error());
  return report;
}

}  // namespace palpate::record::session
