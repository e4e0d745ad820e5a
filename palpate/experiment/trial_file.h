// The answers of an experiment as they come: a line of a CSV file for each, on the disk before the next trial begins.
//
// A run that is killed loses at most the trial that was going on: a line that was cut off is dropped when the file is taken up
// again. The first lines, beginning with #, say which conditions and which seed the trials belong to; trial_columns.h names
// the columns, and a column for each factor comes after them. One writer at a time, which the file's lock ensures. One thread.
// Errors: wrong use for a file that is there already, is missing, or is none of these; refused where it belongs to other
// conditions, is written to by somebody else, or the disk is full.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"
#include "palpate/experiment/conditions.h"
#include "palpate/experiment/trial.h"

namespace palpate::experiment {

struct TrialTable {
  std::string conditions_hash;
  std::uint64_t seed = 0;
  std::vector<TrialRecord> records;
  bool cut_off = false;         // the last line was not finished, and is not among them
  std::size_t whole_bytes = 0;  // of the file, without it
};
Expected<TrialTable> read_trials(const std::filesystem::path& path, const Conditions& conditions);

Expected<TrialTable> parse_trials(std::string_view content, std::string source, const Conditions& conditions);

class TrialFile {
 public:
  static Expected<TrialFile> begin(const std::filesystem::path& path, const Conditions& conditions,
                                   std::uint64_t seed);
  // The file and what is in it.
  static Expected<std::pair<TrialFile, TrialTable>> take_up(const std::filesystem::path& path,
                                                            const Conditions& conditions);

  // On the disk when it returns.
  Expected<void> append(const TrialRecord& record);

 private:
  TrialFile(std::filesystem::path path, std::vector<std::vector<std::string>> cells, FileDescriptor fd)
      : path_(std::move(path)), cells_(std::move(cells)), fd_(std::move(fd)) {}
  Expected<void> write(const std::string& text);

  std::filesystem::path path_;
  std::vector<std::vector<std::string>> cells_;
  FileDescriptor fd_;
};

}  // namespace palpate::experiment
