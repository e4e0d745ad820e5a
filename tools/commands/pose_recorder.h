// What `palpate tracker listen --out` writes: the poses of one tool as a table. One thread.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "drivers/network/tool_sample.h"
#include "palpate/core/csv.h"
#include "palpate/core/units.h"

namespace palpate::tools::commands {

inline constexpr std::size_t kMostRecorded = 2'000'000;  // poses: five hours at 100 Hz, 200 MB of text

// The poses of one tool as the calibrations read them. Times of the server and of arrival do not mix: the
// first pose decides.
class PoseRecorder {
 public:
  explicit PoseRecorder(std::string tool) : tool_(std::move(tool)) {}

  // Without a name, the first tool that is seen.
  void add(const drivers::network::ToolSample& sample) {
    if (tool_.empty()) tool_ = sample.tool;
    if (sample.tool != tool_ || !sample.seen || full()) return;
    if (rows_ == 0) server_time_ = sample.server_time;
    if (sample.server_time != server_time_) {
      ++other_clock_;
      return;
    }
    ++rows_;
    const auto& q = sample.pose.rotation;
    const Vector3 p = kMillimetresPerMetre * sample.pose.translation;
    std::vector<std::string> cells{
        fmt::format("{}.{:09}", sample.stamp.ns() / 1'000'000'000, sample.stamp.ns() % 1'000'000'000)};
    for (const double value : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()})
      cells.push_back(number_text(value));
    csv_.row(cells);
  }

  bool full() const { return rows_ == kMostRecorded; }
  std::size_t rows() const { return rows_; }
  std::uint64_t other_clock() const { return other_clock_; }
  const std::string& tool() const { return tool_; }
  const std::string& content() const { return csv_.content(); }

 private:
  std::string tool_;
  bool server_time_ = false;
  std::size_t rows_ = 0;
  std::uint64_t other_clock_ = 0;
  CsvWriter csv_{{"time_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"}};
};

}  // namespace palpate::tools::commands
