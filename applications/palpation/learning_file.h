// What a person has learned, over sessions: a table on the disk, a line for each finished search. A session is one start of
// the physics side. SI inside, units in the header. Errors: wrong use for a file that is no such table, refused where it
// cannot be written.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::applications::palpation {

// Some 50,000 searches, more than a person does in a lifetime of training.
inline constexpr std::size_t kMostLearningBytes = 4'000'000;

struct LearningLine {
  int session = 1, trial = 1;
  std::string date;          // of its end, UTC: 2026-01-31T12:00:00Z
  std::optional<int> level;  // of the staircase; none: the nodules were drawn
  int nodules = 0, found = 0, false_alarms = 0;
  std::optional<double> position_error;  // m, median of those found; none: nothing was found
  double seconds = 0.0;                  // from the first touch on
  double path = 0.0;                     // m, of the tip meanwhile
  int hard_presses = 0;
  double peak_force = 0.0;  // N
};

// In the file's order. Refused with line and column: another header, a number that cannot be.
Expected<std::vector<LearningLine>> parse_learning(std::string_view content, std::string source);
Expected<std::vector<LearningLine>> read_learning(const std::filesystem::path& path);
// The same of a file that need not exist yet.
Expected<std::vector<LearningLine>> read_learning_if_there(const std::filesystem::path& path);

// Of the newest search that a staircase has set; none where there is none.
std::optional<int> newest_level(const std::vector<LearningLine>& lines);

// The file of a person who trains. One thread.
class LearningFile {
 public:
  // Begins it where there is none, and a session in it: its number is one more than the largest there. Writes the file as it
  // is, so that one that cannot be written is known before anybody has trained.
  static Expected<LearningFile> open(std::filesystem::path path);

  int session() const { return session_; }
  // Numbered by session(). The file is read again and written whole: what was added to it meanwhile stays.
  Expected<void> add(LearningLine line);

 private:
  LearningFile(std::filesystem::path path, int session) : path_(std::move(path)), session_(session) {}
  std::filesystem::path path_;
  int session_;
};

}  // namespace palpate::applications::palpation
