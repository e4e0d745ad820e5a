#include "palpate/record/session/recorded_tables.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "palpate/core/csv.h"
#include "palpate/core/text.h"
#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/mcap_writer.h"

namespace palpate::record::session {
namespace {

class TableCollector : public ScanHandler {
 public:
  // `name`: of the attachment.
  explicit TableCollector(std::string name) : name_(std::move(name)) {}

  Expected<void> attachment(const Attachment& attachment) override {
    if (attachment.name == name_) table_ = attachment.data;
    if (attachment.name.starts_with("tables/"))
      there_ += (there_.empty() ? "" : ", ") + excerpt(attachment.name.substr(7), 40);
    return {};
  }

  const std::optional<std::string>& table() const { return table_; }
  const std::string& there() const { return there_; }

 private:
  std::string name_;
  std::optional<std::string> table_;
  std::string there_;
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

// `there`: the tables there are.
Expected<std::optional<std::string>> looked_up(const std::filesystem::path& recording,
                                               const std::string& name, const TimeSpan& span,
                                               std::string& there) {
  auto source = open_source(recording);
  if (!source) return tl::unexpected(source.error());
  TableCollector collector(table_attachment(name));
  if (const auto scanned = scan(**source, {}, collector); !scanned) return tl::unexpected(scanned.error());
  there = collector.there();
  if (!collector.table() || span.all()) return collector.table();
  auto part = part_of_table(*collector.table(), name, span);
  if (!part) return tl::unexpected(part.error());
  return std::optional(std::move(*part));
}

}  // namespace

std::string table_attachment(const std::string& name) { return "tables/" + name + ".csv"; }

Expected<std::optional<std::string>> find_attachment(const std::filesystem::path& recording,
                                                     const std::string& name) {
  auto source = open_source(recording);
  if (!source) return tl::unexpected(source.error());
  TableCollector collector(name);
  if (const auto scanned = scan(**source, {}, collector); !scanned) return tl::unexpected(scanned.error());
  return collector.table();
}

Expected<std::string> table_of(const std::filesystem::path& recording, const std::string& name,
                               const TimeSpan& span) {
  std::string there;
  auto table = looked_up(recording, name, span, there);
  if (!table) return tl::unexpected(table.error());
  if (*table) return **table;
  return refused("{}: holds no table '{}'{}", one_line(recording.string()), name,
                 there.empty() ? std::string() : "; it holds " + there);
}

Expected<std::optional<std::string>> find_table(const std::filesystem::path& recording,
                                                const std::string& name, const TimeSpan& span) {
  std::string there;
  return looked_up(recording, name, span, there);
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
