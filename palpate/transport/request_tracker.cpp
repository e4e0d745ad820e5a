#include "palpate/transport/request_tracker.h"

namespace palpate::transport {

RequestTracker::Entry* RequestTracker::find(std::uint64_t number) {
  Entry& entry = entries_[number % kRemembered];
  return number != 0 && entry.number == number ? &entry : nullptr;
}

void RequestTracker::count_lost(Entry& entry) {
  if (entry.number == 0 || entry.answered || entry.lost) return;
  entry.lost = true;
  ++counters_.lost;
}

void RequestTracker::sent(std::uint64_t number, Instant<GraphicsClock> now) {
  Entry& entry = entries_[number % kRemembered];
  count_lost(entry);  // what is forgotten unanswered is lost, however young
  entry = {.number = number, .sent = now};
  newest_sent_ = number;
  ++counters_.sent;
}

RequestTracker::Noted RequestTracker::reply(std::uint64_t number, AnswerKind kind) {
  Entry* entry = find(number);
  if (entry == nullptr) {
    ++counters_.unknown;
    return {};
  }
  if (entry->answered) {
    ++counters_.duplicated;
    return {};
  }
  entry->answered = true;
  if (entry->lost) {
    entry->lost = false;
    --counters_.lost;
  }
  ++counters_.replies;
  ++counters_.answers[static_cast<std::size_t>(kind)];
  if (entry->drawn) ++counters_.late;
  const bool newest = number > newest_answered_;
  if (newest) {
    newest_answered_ = number;
  } else {
    ++counters_.out_of_order;
  }
  return {.first = true, .newest = newest, .sent = entry->sent};
}

void RequestTracker::drawn(std::uint64_t number) {
  ++counters_.frames;
  Entry* entry = find(number);
  if (entry == nullptr || entry->drawn) return;
  entry->drawn = true;
  if (entry->answered) ++counters_.frames_in_time;
}

void RequestTracker::expire(Instant<GraphicsClock> now) {
  for (Entry& entry : entries_) {
    if (now - entry.sent > kLostAfter) count_lost(entry);
  }
}

}  // namespace palpate::transport
