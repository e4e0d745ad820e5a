// Keeps account of requests and replies: which came in time, late, twice, out of order, or never.
//
// Request numbers grow; the last 256 are remembered. Pure bookkeeping on the caller's clock, one thread.
#pragma once

#include <array>
#include <cstdint>

#include "palpate/scene/scene_state.h"
#include "palpate/time/instant.h"

namespace palpate::transport {

struct ExchangeCounters {
  std::uint64_t sent = 0;        // requests handed to the wire
  std::uint64_t unsent = 0;      // requests that could not go out: nobody connected
  std::uint64_t replies = 0;     // first replies to requests
  std::uint64_t late = 0;        // of these, came after their frame had been drawn
  std::uint64_t lost = 0;        // no reply within kLostAfter (a reply that comes later still makes it late)
  std::uint64_t duplicated = 0;  // replies that had been there already
  std::uint64_t out_of_order = 0;          // first replies overtaken by the reply to a later request
  std::uint64_t unknown = 0;               // replies to nothing remembered
  std::uint64_t rejected = 0;              // messages that failed the check
  std::uint64_t frames = 0;                // frame_drawn() calls
  std::uint64_t frames_in_time = 0;        // of these, drawn with their own reply there
  std::array<std::uint64_t, 5> answers{};  // first replies by AnswerKind

  bool operator==(const ExchangeCounters&) const = default;
};

class RequestTracker {
 public:
  static constexpr Duration kLostAfter = std::chrono::seconds(1);

  // False (and nothing noted) unless `number` is greater than all before.
  bool may_send(std::uint64_t number) const { return number > newest_sent_; }
  void sent(std::uint64_t number, Instant<GraphicsClock> now);
  void unsent() { ++counters_.unsent; }
  void rejected() { ++counters_.rejected; }

  // Notes a reply. Returns when its request went out, or nothing if the reply is no use (twice, unknown).
  struct Noted {
    bool first = false;   // first reply to this request
    bool newest = false;  // and to the latest request of all that have been answered
    Instant<GraphicsClock> sent;
  };
  Noted reply(std::uint64_t number, AnswerKind kind);

  void drawn(std::uint64_t number);
  // Counts as lost what has waited too long.
  void expire(Instant<GraphicsClock> now);

  const ExchangeCounters& counters() const { return counters_; }

 private:
  struct Entry {
    std::uint64_t number = 0;
    Instant<GraphicsClock> sent;
    bool answered = false, drawn = false, lost = false;
  };
  static constexpr std::size_t kRemembered = 256;

  Entry* find(std::uint64_t number);
  void count_lost(Entry& entry);

  std::array<Entry, kRemembered> entries_{};
  std::uint64_t newest_sent_ = 0;
  std::uint64_t newest_answered_ = 0;
  ExchangeCounters counters_;
};

}  // namespace palpate::transport
