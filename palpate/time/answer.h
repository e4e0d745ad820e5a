// What a history answers when asked for the state at a time, and how it knew.
#pragma once

#include <cstdint>

#include "palpate/time/instant.h"

namespace palpate::inline time {

enum class AnswerKind : std::uint8_t {
  exact,         // the very entry
  interpolated,  // between two neighbouring entries
  extrapolated,  // beyond the newest entry, by extrapolated_by
  too_old,       // before the oldest entry that is still kept; the state is that entry, extrapolated_by < 0
  too_new,  // further beyond the newest than may be extrapolated, or nothing was stored yet; the newest entry
};

template <typename State>
struct HistoryAnswer {
  AnswerKind kind = AnswerKind::too_old;
  Duration extrapolated_by{0};  // from the end of what is known to the time asked for
  State state;

  // The state is one for the time asked for (the last two kinds carry one of another time).
  bool usable() const { return kind != AnswerKind::too_old && kind != AnswerKind::too_new; }
};

}  // namespace palpate::inline time
