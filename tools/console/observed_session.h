// A running session as an observer sees it: its scene, its states, its status; and a wish now and then. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/time/clock.h"
#include "palpate/transport/server_place.h"
#include "palpate/transport/state_link.h"
#include "palpate/transport/state_watch.h"
#include "tools/console/lights.h"

namespace palpate::tools::console {

class ObservedSession {
 public:
  static constexpr int kRate_hz = 250;  // of the states

  // There need not be a server: it is waited for, and found again when it returns. Wrong use, refused: as server_place().
  static Expected<ObservedSession> open(const transport::ServerName& server);

  void look();
  void ask_status() { link_->ask_status(); }
  std::optional<scene::SceneState> take_state();

  // Of the server that answers; null: none has answered yet.
  const scene::SceneDescription* scene() const {
    return link_->description() ? &*link_->description() : nullptr;
  }
  std::uint64_t descriptions() const { return link_->descriptions(); }
  SystemView view() const;
  std::uint64_t states_missed() const { return watch_ ? watch_->counters().missed : 0; }
  bool of_this_machine() const { return of_this_machine_; }

  // Refused where this machine's key is not an operator's, or nobody answers.
  Expected<void> send(scene::Control control);

 private:
  ObservedSession() = default;

  transport::ServerPlace place_;
  std::unique_ptr<MonotonicClock<GraphicsClock>> clock_ = std::make_unique<MonotonicClock<GraphicsClock>>();
  std::unique_ptr<transport::StateLink> link_;
  std::unique_ptr<transport::StateWatch> watch_;
  bool of_this_machine_ = false;
  std::uint64_t statuses_before_ = 0, session_ = 0;
};

}  // namespace palpate::tools::console
