// The pictures of a recording with the markers' poses beside each, as a sequence metafile of PLUS and 3D Slicer (.igs.mha).
//
// A MetaImage file: a text header with fields for each frame (Seq_Frame0007_PointerToTrackerTransform, ...TransformStatus,
// ..._Timestamp), then the pixels of all frames, RGB, a byte each, first row on top. Source: IGSIO, "Sequence metafile"
// (https://plustoolkit.github.io). A transform maps marker coordinates to the tracker's (= World), row-major 4x4, mm. Its pose is
// interpolated to the picture's mid-exposure, and is INVALID, an identity, where one of the two poses around that moment was not seen
// or they are more than 0.1 s apart. Times are seconds after the recording's first message, by the clocks' models.
//
// The recording is read twice, so that no more than one picture is in memory. Ordinary threads. Errors: wrong use for a file that is
// no recording or cannot be written; refused where no picture is there. The file is there whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/record/session/recorded_streams.h"

namespace palpate::record::session {

struct SequenceOptions {
  TimeSpan span;
  std::string camera = "left";
  DecodeJpeg decode{};
  // What the body of a marker is called in the names of transforms.
  std::map<device::MarkerId, std::string> names{{device::MarkerId::tip_marker, "TipMarker"},
                                                {device::MarkerId::camera_marker, "CameraMarker"},
                                                {device::MarkerId::pointer, "Pointer"}};
  double camera_after_tracker_s = 0.0;  // as of a rig's delays
};

struct SequenceReport {
  std::uint64_t frames = 0, left_out = 0;  // pictures of another size than the first
  int width = 0, height = 0;
  struct Counts {
    std::uint64_t valid = 0, invalid = 0;
  };
  std::map<std::string, Counts> transforms;  // by name
};

Expected<SequenceReport> export_sequence(const std::filesystem::path& recording,
                                         const std::filesystem::path& file, const SequenceOptions& options);

}  // namespace palpate::record::session
