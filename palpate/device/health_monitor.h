// The conditions that hold now, made of reports: decides what begins, goes on and ends, and tells the log of each, once.
//
// Times of one clock, which may be virtual. Of an ordinary thread, and of one only.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/log.h"
#include "palpate/device/health.h"

namespace palpate::device {

template <typename Clock>
class HealthMonitor {
 public:
  using Condition = HealthCondition<Clock>;

  // `log`: where beginnings and ends are told; none: nobody is told.
  explicit HealthMonitor(std::optional<Log> log = std::nullopt) : log_(log) {}
  void set_log(Log log) { log_ = log; }

  // Whether something is wrong with the subject of this report, and since when where that is new. A report of another
  // code, or in other words, takes the place of the one before, and the condition goes on.
  void set(bool holds, HealthReport report, Instant<Clock> since) {
    const auto subject = subject_of(report.code);
    const auto at = std::find_if(conditions_.begin(), conditions_.end(),
                                 [&](const auto& c) { return subject_of(c.code) == subject; });
    if (!holds) {
      if (at != conditions_.end()) end(at);
    } else if (at == conditions_.end()) {
      conditions_.push_back({{std::move(report)}, since});
      begin(conditions_.back());
    } else if (at->code != report.code) {
      static_cast<HealthReport&>(*at) = std::move(report);
      begin(*at);
    } else if (at->words != report.words && !words_stay(at->code)) {
      static_cast<HealthReport&>(*at) = std::move(report);
      tell(*at);
    }
  }
  // All there is to say at `now`, where no more than one thing is watched; none: all is well.
  void follow(std::optional<HealthReport> report, Instant<Clock> now) {
    if (report) return set(true, std::move(*report), now);
    while (!conditions_.empty()) end(conditions_.begin());
  }

  // Of the code itself, not of its subject.
  bool holds(HealthCode code) const {
    return std::any_of(conditions_.begin(), conditions_.end(), [&](const auto& c) { return c.code == code; });
  }
  // In the order in which they began.
  const std::vector<Condition>& conditions() const { return conditions_; }
  // How often each has begun, by its name.
  const std::map<std::string, int>& begun() const { return begun_; }
  // Rises with whatever begins, finds other words or ends.
  std::uint64_t changes() const { return changes_; }

 private:
  void begin(const Condition& condition) {
    ++begun_[std::string(name_of(condition.code))];
    tell(condition);
  }
  void tell(const Condition& condition) {
    ++changes_;
    const bool passes = condition.severity() == Severity::notice;
    if (log_) log_->write(passes ? LogLevel::info : LogLevel::warning, condition.words);
  }
  void end(typename std::vector<Condition>::iterator at) {
    ++changes_;
    if (log_) log_->write(LogLevel::info, at->end.empty() ? end_of(at->code) : std::string_view(at->end));
    conditions_.erase(at);
  }

  std::optional<Log> log_;
  std::vector<Condition> conditions_;
  std::map<std::string, int> begun_;
  std::uint64_t changes_ = 0;
};

}  // namespace palpate::device
