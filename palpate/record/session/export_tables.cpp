#include "palpate/record/session/export_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "palpate/core/csv_file.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/record/byte_source.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/frame_messages.h"
#include "palpate/record/session/internal/flat_message.h"

namespace palpate::record::session {
namespace {

// "arm_sample" of "/arm/sample"; what no file name should have is '-'.
std::string file_stem(const std::string& topic) {
  std::string stem;
  for (const char c : topic) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    if (plain)
      stem += c;
    else if (!stem.empty())
      stem += c == '/' || c == '_' ? '_' : '-';
  }
  constexpr std::size_t kLongest = 100;
  return stem.empty() ? "topic" : stem.substr(0, kLongest);
}

struct Table {
  std::optional<FlatMessage> message;
  std::string name;
  std::optional<CsvFile> file;
};
using Tables = std::map<std::string, Table>;  // by topic

// First time round: which columns there are.
class Measure : public ScanHandler {
 public:
  Measure(Tables& tables, ExportReport& report) : tables_(tables), report_(report) {}
  Expected<void> message(const HeardMessage& heard) override {
    const std::string& topic = heard.channel.topic;
    if (!tables_.contains(topic)) add(heard);
    auto& table = tables_.at(topic);
    if (!table.message)
      ++report_.left_out[topic];
    else if (!table.message->measure(heard.message.data))
      ++report_.unread;
    return {};
  }

 private:
  void add(const HeardMessage& heard) {
    Table table;
    if (heard.schema != nullptr && heard.channel.message_encoding == "protobuf")
      if (auto flat = FlatMessage::of(*heard.schema)) table.message.emplace(std::move(*flat));
    table.name = file_stem(heard.channel.topic);
    const auto taken = [&](const auto& other) { return other.second.name == table.name; };
    for (int i = 2; std::any_of(tables_.begin(), tables_.end(), taken); ++i)
      table.name = fmt::format("{}-{}", file_stem(heard.channel.topic), i);
    tables_.emplace(heard.channel.topic, std::move(table));
  }
  Tables& tables_;
  ExportReport& report_;
};

class Rows : public ScanHandler {
 public:
  Rows(Tables& tables, ExportReport& report) : tables_(tables), report_(report) {}
  Expected<void> message(const HeardMessage& heard) override {
    const auto found = tables_.find(heard.channel.topic);
    if (found == tables_.end() || !found->second.file) return {};
    auto cells = found->second.message->cells(heard.message.data);
    if (cells.empty()) return {};
    cells.insert(cells.begin(),
                 {fmt::format("{}", heard.message.log_time_ns), fmt::format("{}", heard.message.sequence)});
    found->second.file->row(cells);
    ++report_.rows[found->second.name + ".csv"];
    return {};
  }

 private:
  Tables& tables_;
  ExportReport& report_;
};

Expected<void> scan_file(const std::filesystem::path& recording, const ScanOptions& which,
                         ScanHandler& handler) {
  auto source = open_source(recording);
  if (!source) return tl::unexpected(source.error());
  const auto scanned = scan(**source, which, handler);
  if (!scanned) return tl::unexpected(scanned.error());
  return {};
}

// Poses by file, as lines.
class TumLines : public ScanHandler {
 public:
  explicit TumLines(ExportReport& report) : report_(report) {}
  Expected<void> message(const HeardMessage& heard) override {
    const std::string type = heard.schema == nullptr ? "" : heard.schema->name;
    if (type == "palpate.recording.TrackerSample") {
      const auto sample = decode_tracker_sample(heard.message.data);
      if (!sample)
        ++report_.unread;
      else if (sample->sample.seen)
        add(marker_file(sample->sample.marker), sample->sample.stamp.ns(), sample->sample.rotation,
            sample->sample.translation);
    } else if (type == "palpate.recording.Frame") {
      const auto frame = decode_frame(heard.message.data);
      if (!frame)
        ++report_.unread;
      else
        add("camera.tum", frame->image_time.ns(), frame->X_world_camera.rotation,
            frame->X_world_camera.translation);
    }
    return {};
  }
  const std::map<std::string, std::string>& files() const { return files_; }

 private:
  static std::string marker_file(device::MarkerId marker) {
    switch (marker) {
      case device::MarkerId::tip_marker:
        return "tip_marker.tum";
      case device::MarkerId::camera_marker:
        return "camera_marker.tum";
      case device::MarkerId::pointer:
        break;
    }
    return "pointer.tum";
  }
  void add(const std::string& file, std::int64_t ns, const Quaternion& q, const Vector3& p) {
    files_[file] +=
        fmt::format("{}{}.{:09} {} {} {} {} {} {} {}\n", ns < 0 ? "-" : "", std::abs(ns) / 1'000'000'000,
                    std::abs(ns) % 1'000'000'000, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
    ++report_.rows[file];
  }
  ExportReport& report_;
  std::map<std::string, std::string> files_;
};

class Attachments : public ScanHandler {
 public:
  Expected<void> attachment(const Attachment& attachment) override {
    files_[file_name(attachment.name)] = attachment.data;
    return {};
  }
  const std::map<std::string, std::string>& files() const { return files_; }

 private:
  // Names of others lead nowhere else.
  static std::string file_name(const std::string& name) {
    const std::filesystem::path last = std::filesystem::path(name).filename();
    return file_stem(last.stem().string()) +
           (last.has_extension() ? "." + file_stem(last.extension().string()) : "");
  }
  std::map<std::string, std::string> files_;
};

}  // namespace

Expected<ExportReport> export_attachments(const std::filesystem::path& recording,
                                          const std::filesystem::path& folder) {
  ExportReport report;
  Attachments attachments;
  if (auto done = scan_file(recording, {}, attachments); !done) return tl::unexpected(done.error());
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  for (const auto& [name, content] : attachments.files()) {
    if (auto done = write_file(folder / name, content); !done) return tl::unexpected(done.error());
    ++report.rows[name];
  }
  return report;
}

Expected<ExportReport> export_csv(const std::filesystem::path& recording, const std::filesystem::path& folder,
                                  const ScanOptions& which) {
  ExportReport report;
  Tables tables;
  Measure measure(tables, report);
  if (auto done = scan_file(recording, which, measure); !done) return tl::unexpected(done.error());
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  for (auto& [topic, table] : tables) {
    if (!table.message) continue;
    auto header = table.message->columns();
    header.insert(header.begin(), {"log_time_ns", "sequence"});
    auto file = CsvFile::begin(folder / (table.name + ".csv"), header);
    if (!file) return tl::unexpected(file.error());
    table.file.emplace(std::move(*file));
  }
  Rows rows(tables, report);
  if (auto done = scan_file(recording, which, rows); !done) return tl::unexpected(done.error());
  for (auto& [topic, table] : tables)
    if (table.file)
      if (auto done = table.file->finish(); !done) return tl::unexpected(done.error());
  return report;
}

Expected<ExportReport> export_tum(const std::filesystem::path& recording, const std::filesystem::path& folder,
                                  const ScanOptions& which) {
  ExportReport report;
  TumLines lines(report);
  if (auto done = scan_file(recording, which, lines); !done) return tl::unexpected(done.error());
  if (lines.files().empty())
    return refused("{}: holds no poses of a tracker or a camera", one_line(recording.string()));
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  for (const auto& [name, content] : lines.files())
    if (auto done = write_file(folder / name, content); !done) return tl::unexpected(done.error());
  return report;
}

}  // namespace palpate::record::session
