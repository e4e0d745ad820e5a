#include "palpate/record/session/recorded_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "palpate/core/csv.h"
#include "palpate/core/text.h"
#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/mcap_writer.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/session/device_messages.h"

namespace palpate::record::session {
namespace {

std::optional<device::MarkerId> marker_of_table(const std::string& name) {
  if (name == "pivot") return device::MarkerId::tip_marker;
  if (name == "pointer_pivot") return device::MarkerId::pointer;
  if (name == "hand") return device::MarkerId::camera_marker;
  return std::nullopt;
}

// The attachment, and the poses of the marker where there is none.
class TableCollector : public ScanHandler {
 public:
  TableCollector(std::string name, const TimeSpan& span)
      : name_(std::move(name)), span_(span), marker_(marker_of_table(name_)) {}

  Expected<void> attachment(const Attachment& attachment) override {
    if (attachment.name == table_attachment(name_)) table_ = attachment.data;
    if (attachment.name.starts_with("tables/"))
      there_ += (there_.empty() ? "" : ", ") + excerpt(attachment.name.substr(7), 40);
    return {};
  }
  Expected<void> message(const HeardMessage& heard) override {
    if (!begun_) begun_ = heard.message.log_time_ns;
    if (!marker_ || heard.schema == nullptr || heard.schema->name != "palpate.recording.TrackerSample")
      return {};
    if (heard.message.log_time_ns < later(*begun_, span_.from_s) ||
        heard.message.log_time_ns > later(*begun_, span_.to_s))
      return {};
    const auto sample = decode_tracker_sample(heard.message.data);
    if (!sample || !sample->sample.seen || sample->sample.marker != *marker_) return {};
    const auto& q = sample->sample.rotation;
    const Vector3 mm = 1000.0 * sample->sample.translation;
    poses_ += fmt::format("{}.{:09},{},{},{},{},{},{},{}\n", sample->sample.stamp.ns() / 1'000'000'000,
                          sample->sample.stamp.ns() % 1'000'000'000, mm.x(), mm.y(), mm.z(), q.w(), q.x(),
                          q.y(), q.z());
    return {};
  }

  bool attached() const { return table_.has_value(); }
  Expected<std::string> table(const std::string& file) const {
    if (table_) return *table_;
    if (!poses_.empty()) return "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + poses_;
    return refused("{}: holds no table '{}'{}{}", file, name_,
                   marker_ ? " and no poses of that marker there" : "",
                   there_.empty() ? std::string() : "; it holds " + there_);
  }

 private:
  std::string name_;
  TimeSpan span_;
  std::optional<device::MarkerId> marker_;
  std::optional<std::string> table_;
  std::optional<std::uint64_t> begun_;
  std::string poses_, there_;
};

// Rows by their time after the first, as they stand there: no number is read and written again.
Expected<std::string> part_of_table(const std::string& text, const std::string& name, const TimeSpan& span) {
  CsvOptions words;
  words.text_columns = {"*"};
  const auto table = parse_csv(text, name, words);
  if (!table) return tl::unexpected(table.error());
  const auto time = table->find("time_s");
  if (!time) return refused("the table '{}' has no times (time_s) of which a part could be taken", name);
  std::vector<std::string_view> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(std::string_view(text).substr(at, end - at));
    at = end + 1;
  }
  std::string part;
  const std::size_t first_row =
      table->line.empty() ? lines.size() : static_cast<std::size_t>(table->line.front()) - 1;
  for (std::size_t i = 0; i < std::min(first_row, lines.size()); ++i) part += std::string(lines[i]) + "\n";
  for (std::size_t row = 0; row < table->rows.size(); ++row) {
    const double since = table->rows[row][*time] - table->rows.front()[*time];
    if (since < span.from_s || since > span.to_s) continue;
    part += std::string(lines.at(static_cast<std::size_t>(table->line[row]) - 1)) + "\n";
  }
  return part;
}

}  // namespace

std::string table_attachment(const std::string& name) { return "tables/" + name + ".csv"; }

Expected<std::string> table_of(const std::filesystem::path& recording, const std::string& name,
                               const TimeSpan& span) {
  const std::string file = one_line(recording.string());
  auto source = open_source(recording);
  if (!source) return tl::unexpected(source.error());
  TableCollector collector(name, span);
  if (const auto scanned = scan(**source, {}, collector); !scanned) return tl::unexpected(scanned.error());
  auto table = collector.table(file);
  if (!table || span.all() || !collector.attached()) return table;
  return part_of_table(*table, name, span);
}

Expected<void> write_tables(const std::filesystem::path& recording,
                            const std::vector<std::pair<std::string, std::string>>& tables) {
  auto file = RecordFile::whole(recording);
  if (!file) return tl::unexpected(file.error());
  auto writer = McapWriter::begin(std::move(*file));
  if (!writer) return tl::unexpected(writer.error());
  for (const auto& [name, text] : tables)
    if (auto done = writer->attach(Attachment{0, 0, table_attachment(name), "text/csv", text}); !done)
      return done;
  const auto closed = writer->close();
  if (!closed) return tl::unexpected(closed.error());
  return {};
}

}  // namespace palpate::record::session
