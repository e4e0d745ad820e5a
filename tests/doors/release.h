// Things that leave a device a fixed time after they were made, however late the laboratory had them: a device's electronics take
// the same time always, and a client has no way to tell what is late from what the device takes. One thread.
#pragma once

#include <deque>
#include <optional>
#include <utility>

#include "palpate/time/instant.h"

namespace palpate::doors {

template <typename T>
class Release {
 public:
  explicit Release(Duration after) : after_(after) {}

  // In the order in which they were made.
  void add(Instant<TrueTime> made, T thing) { waiting_.emplace_back(made + after_, std::move(thing)); }
  // The next whose time has come.
  std::optional<T> take(Instant<TrueTime> now) {
    if (waiting_.empty() || waiting_.front().first > now) return std::nullopt;
    std::optional<T> thing(std::move(waiting_.front().second));
    waiting_.pop_front();
    return thing;
  }
  // When the next is due; nothing: none waits.
  std::optional<Instant<TrueTime>> next() const {
    return waiting_.empty() ? std::nullopt : std::optional(waiting_.front().first);
  }

 private:
  Duration after_;
  std::deque<std::pair<Instant<TrueTime>, T>> waiting_;
};

}  // namespace palpate::doors
