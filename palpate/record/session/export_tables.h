// The streams of a recording as tables: one CSV file for each topic whose messages are protobuf, ours and those of others, a row for
// each message and a column for each number or word in it; and the poses among them in the format of TUM.
//
// Columns: log_time_ns, sequence, then the fields by their names, `tip_m.x`, `joints_rad.0`. Numbers have all their digits. A field
// that repeats has as many columns as its longest message, at most 64; bytes (pictures) are counted only. A topic's file is called
// as the topic, '/' as '_'. TUM (https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats): `time tx ty tz qx qy qz qw`, s by
// the device's own stamp, m; of each marker that a tracker saw, and of the camera in each frame.
//
// Ordinary threads. Errors: wrong use for a folder that cannot be made or a file that is no recording; refused on a full disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/record/mcap_reader.h"

namespace palpate::record::session {

struct ExportReport {
  std::map<std::string, std::uint64_t> rows;  // by file
  std::map<std::string, std::uint64_t>
      left_out;              // messages of topics whose encoding is not protobuf, by topic
  std::uint64_t unread = 0;  // messages that are none
};

// `which`: topics and times.
Expected<ExportReport> export_csv(const std::filesystem::path& recording, const std::filesystem::path& folder,
                                  const ScanOptions& which = {});
Expected<ExportReport> export_tum(const std::filesystem::path& recording, const std::filesystem::path& folder,
                                  const ScanOptions& which = {});

// The files that a recording holds: rig, world, whatever was attached. Of several of a name the last.
Expected<ExportReport> export_attachments(const std::filesystem::path& recording,
                                          const std::filesystem::path& folder);

}  // namespace palpate::record::session
