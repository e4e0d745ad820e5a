#include "palpate/experiment/trial_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/system_error.h"
#include "palpate/core/text.h"
#include "palpate/experiment/trial_columns.h"

namespace palpate::experiment {
namespace {

constexpr std::string_view kFirstWords = "# palpate trials 1, conditions ", kSeedWords = ", seed ";

std::string header_of(const Conditions& conditions, std::uint64_t seed) {
  std::string text = fmt::format("{}{}{}{}\n# {}, stimulus {}\n", kFirstWords, hash_of(conditions),
                                 kSeedWords, seed, conditions.name, conditions.stimulus);
  for (const auto column : kTrialColumns)
    text += fmt::format("{}{}", column == kTrialColumns.front() ? "" : ",", column);
  for (const auto& factor : conditions.factors) text += "," + factor.name;
  return text + "\n";
}

std::string line_of(const TrialRecord& record, const std::vector<std::string>& cell) {
  const auto& [trial, answer, positive] = record;
  std::string text =
      fmt::format("{},{:d},{},{},{},{},{},{},{:d},{},{},{:d},{}", trial.number, trial.practice, trial.block,
                  trial.track, trial.repeated, number_text(trial.stimulus), trial.target, answer.place,
                  positive, number_text(answer.response_s), number_text(answer.time_s),
                  answer.exclusion != Exclusion::none, name_of(answer.exclusion));
  for (const auto& level : cell) text += "," + level;
  return text + "\n";
}

// The first line's hash and seed.
Expected<void> read_first_line(std::string_view content, const std::string& source, TrialTable& table) {
  const auto line = content.substr(0, content.find('\n'));
  const auto seed_at = line.find(kSeedWords);
  if (!line.starts_with(kFirstWords) || seed_at == line.npos)
    return wrong_use("{}:1: is '{}'; '{}HASH{}N' is expected", source, excerpt(line), kFirstWords,
                     kSeedWords);
  table.conditions_hash = line.substr(kFirstWords.size(), seed_at - kFirstWords.size());
  const auto digits = line.substr(seed_at + kSeedWords.size());
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), table.seed);
  if (error != std::errc() || end != digits.data() + digits.size())
    return wrong_use("{}:1: seed is '{}', a whole number is expected", source, excerpt(digits));
  return {};
}

class RowReader {
 public:
  RowReader(const CsvTable& table, std::size_t row) : table_(&table), row_(row) {}

  // A whole number within bounds; the first complaint counts.
  int whole(std::size_t column, double low, double high) {
    const double value = table_->rows[row_][column];
    if (!(value >= low && value <= high) || value != std::floor(value)) {
      complain(column, fmt::format("a whole number of {} to {} is expected", low, high));
      return 0;
    }
    return static_cast<int>(value);
  }
  double number(std::size_t column, double low) {
    const double value = table_->rows[row_][column];
    if (!(value >= low && value <= 1e12))
      complain(column, fmt::format("a number of at least {} is expected", low));
    return value;
  }
  const std::string& text(std::size_t column) const { return table_->text[row_][column]; }
  void complain(std::size_t column, std::string_view expectation) {
    if (error_.empty())
      error_ = fmt::format("{}:{}: {} is '{}'; {}", table_->source, table_->line[row_],
                           excerpt(table_->header[column]), excerpt(text(column)), expectation);
  }
  const std::string& error() const { return error_; }

 private:
  const CsvTable* table_;
  std::size_t row_;
  std::string error_;
};

Exclusion exclusion_of(RowReader& row, bool excluded, std::size_t column) {
  const auto at = std::find(kExclusionNames.begin(), kExclusionNames.end(), row.text(column));
  const auto exclusion =
      at == kExclusionNames.end() ? Exclusion::none : static_cast<Exclusion>(at - kExclusionNames.begin());
  if (at == kExclusionNames.end() || excluded != (exclusion != Exclusion::none))
    row.complain(column,
                 "force-limited, tripped or interrupted is expected where excluded is 1, else nothing");
  return exclusion;
}

Expected<TrialRecord> record_of(const CsvTable& table, std::size_t index,
                                const std::vector<std::vector<std::string>>& cells) {
  RowReader row(table, index);
  TrialRecord record;
  auto& [trial, answer, positive] = record;
  trial.number = row.whole(0, 1, 1e9);
  trial.practice = row.whole(1, 0, 1) == 1;
  trial.block = row.whole(2, 0, 1e9);
  trial.track = row.whole(3, 0, 1e9);
  trial.repeated = row.whole(4, 0, 1e9);
  trial.stimulus = row.number(5, 1e-300);
  trial.target = row.whole(6, 1, 1000);
  answer.place = row.whole(7, 0, 1000);
  positive = row.whole(8, 0, 1) == 1;
  answer.response_s = row.number(9, 0.0);
  answer.time_s = row.number(10, 0.0);
  answer.exclusion = exclusion_of(row, row.whole(11, 0, 1) == 1, 12);
  std::vector<std::string> levels;
  for (std::size_t i = kTrialColumns.size(); i < table.columns(); ++i) levels.push_back(row.text(i));
  const auto cell = std::find(cells.begin(), cells.end(), levels);
  if (cell == cells.end())
    row.complain(kTrialColumns.size(), "a combination of the conditions' factors is expected");
  trial.cell = static_cast<std::size_t>(cell - cells.begin());
  if (!row.error().empty()) return wrong_use("{}", row.error());
  return record;
}

Expected<void> lock(const FileDescriptor& fd, const std::filesystem::path& path) {
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return {};
  return refused(ErrorCode::in_use, "{}: another run is writing to it; end that one, or name another file",
                 path.string());
}

}  // namespace

Expected<TrialTable> parse_trials(std::string_view content, std::string source,
                                  const Conditions& conditions) {
  TrialTable trials;
  if (const auto first = read_first_line(content, source, trials); !first)
    return tl::unexpected(first.error());
  if (trials.conditions_hash != hash_of(conditions))
    return refused("{}: belongs to other conditions than {}; use the ones it was begun with, or another file",
                   source, conditions.name);
  trials.whole_bytes = content.rfind('\n') + 1;
  trials.cut_off = trials.whole_bytes < content.size();
  const auto table = parse_csv(content.substr(0, trials.whole_bytes), source, {.text_columns = {"*"}});
  if (!table) return tl::unexpected(table.error());
  const auto header = header_of(conditions, trials.seed);
  if (content.substr(0, header.size()) != header)
    return wrong_use(
        "{}: the first three lines are not those of these conditions; use the file as it was written",
        source);
  const auto cells = cells_of(conditions);
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    auto record = record_of(*table, i, cells);
    if (!record) return tl::unexpected(record.error());
    trials.records.push_back(*record);
  }
  return trials;
}

Expected<TrialTable> read_trials(const std::filesystem::path& path, const Conditions& conditions) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_trials(*content, path.string(), conditions);
}

Expected<TrialFile> TrialFile::begin(const std::filesystem::path& path, const Conditions& conditions,
                                     std::uint64_t seed) {
  FileDescriptor fd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644));
  if (!fd && errno == EEXIST)
    return wrong_use(ErrorCode::in_use, "{}: is there already; take it up, or name another file",
                     path.string());
  if (!fd)
    return wrong_use(code_of(errno), "{}: cannot be written ({}); check the folder and its permissions",
                     path.string(), reason_of(errno));
  if (const auto locked = lock(fd, path); !locked) return tl::unexpected(locked.error());
  TrialFile file(path, cells_of(conditions), std::move(fd));
  if (const auto done = file.write(header_of(conditions, seed)); !done) return tl::unexpected(done.error());
  return file;
}

Expected<std::pair<TrialFile, TrialTable>> TrialFile::take_up(const std::filesystem::path& path,
                                                              const Conditions& conditions) {
  FileDescriptor fd(::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | O_NONBLOCK));
  if (!fd)
    return wrong_use(code_of(errno), "{}: cannot be taken up ({}); check the path and its permissions",
                     path.string(), reason_of(errno));
  if (const auto locked = lock(fd, path); !locked) return tl::unexpected(locked.error());
  auto trials = read_trials(path, conditions);
  if (!trials) return tl::unexpected(trials.error());
  if (trials->cut_off && ::ftruncate(fd.get(), static_cast<off_t>(trials->whole_bytes)) != 0)
    return refused("{}: its last line, which was cut off, cannot be removed ({})", path.string(),
                   reason_of(errno));
  return std::pair(TrialFile(path, cells_of(conditions), std::move(fd)), std::move(*trials));
}

Expected<void> TrialFile::append(const TrialRecord& record) {
  return write(line_of(record, cells_.at(record.trial.cell)));
}

Expected<void> TrialFile::write(const std::string& text) {
  std::string_view left = text;
  while (!left.empty()) {
    const auto written = ::write(fd_.get(), left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      return refused("{}: the answer was not written ({}); free some space and take it up again",
                     path_.string(), reason_of(errno));
    left.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fdatasync(fd_.get()) != 0 && errno != EINVAL && errno != EROFS)
    return refused("{}: the answer did not reach the disk ({})", path_.string(), reason_of(errno));
  return {};
}

}  // namespace palpate::experiment
