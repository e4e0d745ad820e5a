#include "python/bindings/live_client.h"

namespace palpate::python {
namespace {

// No further step comes for so long: what there is is handed out.
constexpr Duration kStandsStill = std::chrono::milliseconds(300);

}  // namespace

void StepQueue::look(transport::StateLink& link, std::uint64_t& number, Duration now) {
  if (held_ >= kMost) return;
  reader_.look();
  while (const auto time = reader_.question(now))
    if (!link.look_back(++number, *time)) return;  // nobody is there; it is asked again
}

void StepQueue::answer(const transport::StateReply& reply, Duration now) {
  read_.clear();
  reader_.answer(reply.asked, reply.answer, read_);
  for (auto& step : read_) put(std::move(step));
  if (!read_.empty()) came_ = now;
}

// A new server says so with its first word, or its ticks have said so before.
void StepQueue::other_session() {
  if (last_tick_ == 0 || std::exchange(began_anew_, false)) return;
  reader_ = {};
  restarted_ = true;
}

void StepQueue::put(scene::SceneState&& step) {
  if (step.tick <= last_tick_ && !restarted_) restarted_ = began_anew_ = true;
  if (restarted_ || blocks_.empty() || blocks_.back().steps.front().body_count != step.body_count)
    blocks_.push_back({{}, std::exchange(restarted_, false)});
  last_tick_ = step.tick;
  blocks_.back().steps.push_back(step);
  ++held_;
}

std::optional<StepBlock> StepQueue::take(Duration span, Duration now) {
  if (blocks_.empty()) return std::nullopt;
  const auto& steps = blocks_.front().steps;
  const bool whole = blocks_.size() > 1 || held_ >= kMost || now - came_ >= kStandsStill ||
                     steps.back().time - steps.front().time + std::chrono::milliseconds(1) >= span;
  if (!whole) return std::nullopt;
  StepBlock block = std::move(blocks_.front());
  blocks_.pop_front();
  held_ -= block.steps.size();
  return block;
}

}  // namespace palpate::python
