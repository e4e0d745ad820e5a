// A running session for callers that wait: a link to its physics server with a thread that serves it, and the steps of its
// world as they come.
//
// Any thread may call anything; nothing waits for longer than it is told. Python's lock is never asked for here.
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "palpate/scene/step_reader.h"
#include "palpate/time/clock_model.h"
#include "palpate/transport/server_place.h"
#include "palpate/transport/state_watch.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::python {

using Time = Instant<PhysicsClock>;
using Clock = ClockModel<GraphicsClock, PhysicsClock>;

// Steps of one world that follow each other, with as many bodies each.
struct StepBlock {
  std::vector<scene::SceneState> steps;
  bool restarted = false;  // of a server that has come back: its ticks began anew
};

// The steps that one reader of a client has not taken yet. Used under the client's lock alone.
class StepQueue {
 public:
  // 16 s at 1 kHz. What does not fit is left to the server's history, for another 8 s.
  static constexpr std::size_t kMost = 16'384;

  void look(transport::StateLink& link, std::uint64_t& number, Duration now);
  void answer(const transport::StateReply& reply, Duration now);
  void other_session();
  // Those that there are, where they cover `span` of time, or no more of them will come; nothing: there are too few yet.
  std::optional<StepBlock> take(Duration span, Duration now);

 private:
  void put(scene::SceneState&& step);

  scene::StepReader reader_;
  std::deque<StepBlock> blocks_;
  std::vector<scene::SceneState> read_;
  std::uint64_t last_tick_ = 0;
  std::size_t held_ = 0;
  bool restarted_ = false;   // the step to come is a new server's
  bool began_anew_ = false;  // since the last session, by its ticks
  Duration came_{0};         // when the last one did
};

// States at a rate, as the server sends them; the newest.
class LiveWatch {
 public:
  explicit LiveWatch(std::unique_ptr<transport::StateWatch> watch) : watch_(std::move(watch)) {}
  std::optional<transport::StateReply> take();
  std::optional<std::string> refusal() const;
  transport::StateWatch::Counters counters() const;
  void end();

 private:
  mutable std::mutex mutex_;
  std::unique_ptr<transport::StateWatch> watch_;  // null: ended
  transport::StateWatch::Counters counters_;
};

// What is known of the server.
struct ServerFacts {
  std::optional<scene::SceneDescription> scene;
  std::uint64_t session = 0;
  std::optional<transport::Role> role;
  bool alive = false;
  std::string trouble;  // why it cannot be reached or refuses, where that is known
};

struct ClockFacts {
  Clock model;
  ClockPhase phase = ClockPhase::empty;
  double lowest_round_trip_s = 0.0;
};

class LiveClient {
 public:
  // Wrong use, refused: as transport::server_place. Nobody need be there yet.
  static Expected<std::shared_ptr<LiveClient>> connect(const transport::ServerName& server, std::string name);
  explicit LiveClient(transport::ServerPlace place) : place_(std::move(place)) {}
  ~LiveClient() { close(); }
  LiveClient(const LiveClient&) = delete;
  LiveClient& operator=(const LiveClient&) = delete;

  void close();  // again and again, from any thread
  bool closed() const;
  const transport::ServerPlace& place() const { return place_; }

  // Lets the thread work for so long at most; sooner back where something may have come.
  void wait(Duration patience);
  ServerFacts facts() const;
  ClockFacts clock() const;
  Instant<GraphicsClock> now() const { return clock_.now(); }

  // Asks for the state at a time; without one for the newest step.
  std::uint64_t ask(std::optional<Time> time);
  std::optional<transport::StateReply> answer(std::uint64_t number) const;
  void forget(std::uint64_t number);

  // One wish at a time: controls_waiting() is 0 when it is done, controls_dropped() has grown where it was not carried out.
  bool send_control(scene::Control control);
  std::size_t controls_waiting() const;
  std::uint64_t controls_dropped() const;

  std::shared_ptr<StepQueue> begin_steps();
  void end_steps(const std::shared_ptr<StepQueue>& steps);
  std::optional<StepBlock> take_steps(StepQueue& steps, Duration span);

  Expected<std::shared_ptr<LiveWatch>> begin_watch(int rate_hz);
  void end_watch(const std::shared_ptr<LiveWatch>& watch);

 private:
  struct Question {
    std::optional<Time> time;
    Instant<GraphicsClock> asked;
    std::optional<transport::StateReply> reply;
  };

  void run();
  void turn();
  void keep_clock(Instant<GraphicsClock> now);
  bool busy() const;
  void send(std::uint64_t number, Question& question);

  transport::ServerPlace place_;
  MonotonicClock<GraphicsClock> clock_;
  mutable std::mutex mutex_;
  std::condition_variable come_, due_;          // for those who wait; for the thread
  std::unique_ptr<transport::StateLink> link_;  // null: closed
  ClockSync<GraphicsClock, PhysicsClock> sync_;
  std::optional<Instant<GraphicsClock>> synced_;
  Instant<GraphicsClock> looked_;
  std::map<std::uint64_t, Question> questions_;
  std::uint64_t number_ = 0, session_ = 0;
  std::vector<std::shared_ptr<StepQueue>> steps_;
  std::vector<std::shared_ptr<LiveWatch>> watches_;
  std::thread thread_;
};

}  // namespace palpate::python
