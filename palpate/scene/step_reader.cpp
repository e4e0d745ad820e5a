#include "palpate/scene/step_reader.h"

#include <algorithm>

namespace palpate::scene {
namespace {

constexpr Duration kStep = std::chrono::milliseconds(1);
// A loop that stood for longer is not looked for step by step.
constexpr Duration kLongestWalk = std::chrono::seconds(10);
constexpr std::size_t kMostHeld = 4096;  // answers, should one before them not come
constexpr std::int64_t kParts = 16;      // in which an interval is narrowed down at once
// A step that began late is off the grid, and those after it on it again; after so many the grid lies elsewhere.
constexpr int kMostOffGrid = 3;

}  // namespace

std::optional<StepReader::Time> StepReader::question(Duration now) {
  const auto time = next(now);
  if (time) asked_[*time] = now;
  return time;
}

std::optional<StepReader::Time> StepReader::next(Duration now) {
  for (const auto& [time, when] : asked_)
    if (now - when > kLostAfter) return time;
  if (asked_.size() >= kMostAsked) return std::nullopt;
  const bool further = answers_.size() < kMostHeld;
  if (look_ && further && asked_.count(kFarAhead) == 0) {
    look_ = false;
    return kFarAhead;
  }
  if (!wanted_.empty()) {
    const Time time = wanted_.front();
    wanted_.pop_front();
    return time;
  }
  if (!floor_ || !further || probe_ + kStep >= newest_) return std::nullopt;
  // A long stand, and then all that came since are narrowed down.
  if (newest_ - probe_ > kLongestWalk) {
    probe_ = newest_;
    return std::nullopt;
  }
  return probe_ += kStep;
}

void StepReader::answer(Time asked, const StateAnswer& answer, std::vector<SceneState>& steps) {
  if (asked_.erase(asked) == 0) return;  // twice, or of a question that was given up
  if (asked == kFarAhead) {
    const SceneState& newest = answer.state;
    if (newest.empty() || newest.time >= kFarAhead) return;
    if (!floor_) return begin(newest, steps);
    if (newest.time <= floor_->time) return;
    newest_ = std::max(newest_, newest.time);
    answers_[newest.time] = {AnswerKind::exact, Duration(0), newest};
  } else if (answer.kind == AnswerKind::too_old) {
    floor_.reset();
    answers_.clear(), asked_.clear(), wanted_.clear();
    look_ = true;
    return;
  } else if (answer.kind == AnswerKind::exact || answer.kind == AnswerKind::interpolated) {
    answers_[asked] = answer;
  } else {
    wanted_.push_back(asked);  // of a time that the history has: it says otherwise in a moment
    return;
  }
  settle(steps);
}

void StepReader::begin(const SceneState& newest, std::vector<SceneState>& steps) {
  floor_ = Floor{};
  newest_ = newest.time;
  deliver(newest, steps);
  probe_ = newest.time;
  off_grid_ = 0;
}

bool StepReader::asked_below(Time time) const {
  return probe_ + kStep < time || (!asked_.empty() && asked_.begin()->first < time) ||
         std::any_of(wanted_.begin(), wanted_.end(), [time](Time wanted) { return wanted < time; });
}

void StepReader::settle(std::vector<SceneState>& steps) {
  while (!answers_.empty()) {
    const auto [time, answer] = *answers_.begin();
    const std::uint64_t tick = answer.state.tick;
    if (time <= floor_->time) {
      answers_.erase(answers_.begin());
    } else if (tick <= floor_->tick) {  // nothing until there
      floor_->time = time;
    } else if (answer.kind == AnswerKind::exact && tick == floor_->tick + 1) {
      deliver(answer.state, steps);
    } else if (asked_below(time)) {
      return;
    } else if (time - floor_->time > Duration(1)) {
      return narrow(time);
    } else if (answer.kind == AnswerKind::exact) {  // what lies between the ticks the history does not have
      deliver(answer.state, steps);
    } else {  // no history says this
      floor_ = Floor{time, tick};
    }
  }
}

void StepReader::narrow(Time until) {
  narrowed_ = true;
  const Duration span = until - floor_->time;
  const std::int64_t parts = std::min(kParts, span.count());
  for (std::int64_t k = 1; k < parts; ++k)
    wanted_.push_back(floor_->time + span / parts * k + span % parts * k / parts);
}

void StepReader::deliver(const SceneState& step, std::vector<SceneState>& steps) {
  steps.push_back(step);
  floor_ = Floor{step.time, step.tick};
  off_grid_ = narrowed_ ? off_grid_ + 1 : 0;
  narrowed_ = false;
  if (off_grid_ < kMostOffGrid) return;
  off_grid_ = 0;
  probe_ = step.time;
  wanted_.clear();
}

}  // namespace palpate::scene
