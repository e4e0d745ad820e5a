// Where the head was in the last seconds, as the runtime told it.
//
// OpenXR guarantees poses of the last 50 ms only; a picture is older than that when it is finished. One thread adds,
// any ask (palpate/time/state_history.h). Between two entries: the shortest turn, and straight; beyond the newest it
// goes on as it last did, for a tenth of a second.
#pragma once

#include <chrono>

#include "palpate/headset/frames.h"
#include "palpate/math/pose.h"
#include "palpate/time/state_history.h"

namespace palpate::headset {

class HeadHistory {
 public:
  // False where the time is not later than the one before: it is not added.
  bool add(Instant<GraphicsClock> time, const Pose<Local, View>& X_local_view);

  struct Head {
    AnswerKind kind = AnswerKind::too_new;
    Pose<Local, View> X_local_view;
    bool usable() const { return kind != AnswerKind::too_old && kind != AnswerKind::too_new; }
  };
  Head at(Instant<GraphicsClock> time) const;
  std::uint64_t count() const { return entries_.count(); }

 private:
  // Without Eigen's alignment and constructors: entries are copied word by word.
  struct Entry {
    Instant<GraphicsClock> time;
    std::array<double, 4> turn{1.0, 0.0, 0.0, 0.0};  // w x y z
    std::array<double, 3> place{};
    std::array<double, 3> spin{}, velocity{};  // since the entry before; rad/s about Local's axes, m/s
  };
  static Pose<Local, View> pose_of(const Entry& entry);
  static Entry entry_of(Instant<GraphicsClock> time, const Pose<Local, View>& pose);
  static Entry between(const Entry& a, const Entry& b, double s);
  static Entry ahead(const Entry& a, Duration by);

  static constexpr std::size_t kEntries = 512;  // 5.7 s at 90 Hz
  static constexpr Duration kAhead = std::chrono::milliseconds(100);
  StateHistory<Entry, kEntries> entries_{kAhead};
  Entry last_;  // the writer's
};

}  // namespace palpate::headset
