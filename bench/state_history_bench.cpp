// Look-up of the world's state at a time: SceneHistory against a std::deque behind a mutex that is searched
// by halves. Both hold the same 8191 states, both interpolate with the same function; "beside a writer" means
// that another thread pushes ten thousand states a second. The physical limit: copying the bytes of the two
// states between which the time lies, from where they lie, and nothing else. Ten alternating rounds; the
// rival runs twice, the difference is the noise.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/scene/scene_history.h"
#include "palpate/time/real_time.h"

namespace palpate {
namespace {

constexpr std::int64_t kStep = 1'000'000;  // ns
constexpr std::size_t kKept = 8191;
const Vector3 kGravity(0, -9.81, 0);

scene::SceneState state(std::int64_t tick) {
  scene::SceneState w;
  w.time = {Duration(tick * kStep)};
  w.tick = static_cast<std::uint64_t>(tick);
  w.body_count = 2;  // ball and bat
  for (std::size_t i = 0; i < 2; ++i) w.bodies[i].set_v({1.0, 2.0, static_cast<double>(i)});
  return w;
}

class MutexDeque {
 public:
  void push(const scene::SceneState& w) {
    const std::scoped_lock lock(mutex_);
    states_.push_back(w);
    if (states_.size() > kKept) states_.pop_front();
  }
  scene::StateAnswer at(Instant<PhysicsClock> when) const {
    const std::scoped_lock lock(mutex_);
    const auto after =
        std::upper_bound(states_.begin(), states_.end(), when,
                         [](Instant<PhysicsClock> t, const scene::SceneState& w) { return t < w.time; });
    if (after == states_.begin()) return {AnswerKind::too_old, Duration(0), states_.front()};
    const scene::SceneState& a = *(after - 1);
    if (after == states_.end())
      return {AnswerKind::extrapolated, when - a.time, scene::extrapolate(a, when - a.time)};
    return {AnswerKind::interpolated, Duration(0),
            scene::interpolate(a, *after, to_seconds(when - a.time) / to_seconds(after->time - a.time),
                               kGravity)};
  }

 private:
  mutable std::mutex mutex_;
  std::deque<scene::SceneState> states_;
};

struct Ours : scene::SceneHistory {
  Ours() : scene::SceneHistory(kGravity) {}
};

// The limit: no search, no interpolation, nobody else.
class Copy {
 public:
  void push(const scene::SceneState& w) {
    states_[static_cast<std::size_t>(w.time.ns() / kStep) % kSlots] = w;
  }
  scene::StateAnswer at(Instant<PhysicsClock> when) const {
    const auto k = static_cast<std::size_t>(when.ns() / kStep);
    scene::StateAnswer answer;
    std::memcpy(&answer.state, &states_[k % kSlots], sizeof(scene::SceneState));
    benchmark::DoNotOptimize(answer.state);
    std::memcpy(&answer.state, &states_[(k + 1) % kSlots], sizeof(scene::SceneState));
    benchmark::DoNotOptimize(answer.state);
    answer.state.time = when;
    return answer;
  }

 private:
  static constexpr std::size_t kSlots = 8192;
  std::vector<scene::SceneState> states_ = std::vector<scene::SceneState>(kSlots);
};

// Asked for at most 100 ms back, as graphics servers do.
template <typename History>
void look_up(benchmark::State& run, bool writer_beside) {
  const auto history = std::make_unique<History>();
  std::atomic<std::int64_t> newest{0};
  const auto push = [&] {
    const std::int64_t tick = newest.load(std::memory_order_relaxed) + 1;
    history->push(state(tick));
    newest.store(tick, std::memory_order_relaxed);
  };
  for (std::size_t i = 0; i < 2 * kKept; ++i) push();
  std::atomic<bool> done{false};
  std::thread writer;
  if (writer_beside)
    writer = std::thread([&] {
      sharpen_sleep();
      auto due = std::chrono::steady_clock::now();
      while (!done.load(std::memory_order_relaxed)) {
        push();
        std::this_thread::sleep_until(due += std::chrono::microseconds(100));
      }
    });
  Random random(1, "look-up");
  std::vector<std::int64_t> back(4096);
  for (auto& b : back) b = static_cast<std::int64_t>(random.below(100 * kStep));
  std::size_t i = 0;
  std::int64_t wrong = 0;
  for (auto _ : run) {
    const Instant<PhysicsClock> when{
        Duration(newest.load(std::memory_order_relaxed) * kStep - back[i++ % back.size()])};
    const scene::StateAnswer answer = history->at(when);
    wrong += answer.state.time.ns() / 2 != when.ns() / 2 && answer.state.time.ns() / 2 != (when.ns() + 1) / 2;
    benchmark::DoNotOptimize(answer);
  }
  done.store(true);
  if (writer.joinable()) writer.join();
  run.counters["wrong"] = static_cast<double>(wrong);
}

template <typename History>
void push_one(benchmark::State& run) {
  const auto history = std::make_unique<History>();
  std::int64_t tick = 0;
  const scene::SceneState w = state(0);
  for (auto _ : run) {
    scene::SceneState next = w;
    next.time = {Duration(++tick * kStep)};
    history->push(next);
  }
}

void add(const std::string& name, void (*function)(benchmark::State&)) {
  benchmark::RegisterBenchmark(name.c_str(), function)
      ->Repetitions(10)
      ->ReportAggregatesOnly(true)
      ->UseRealTime();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  using namespace palpate;
  std::vector<char*> arguments(argv, argv + argc);
  std::string interleave = "--benchmark_enable_random_interleaving=true";
  arguments.insert(arguments.begin() + 1, interleave.data());
  int count = static_cast<int>(arguments.size());
  add("look-up/history", [](benchmark::State& s) { look_up<Ours>(s, false); });
  add("look-up/copy", [](benchmark::State& s) { look_up<Copy>(s, false); });
  add("look-up/deque", [](benchmark::State& s) { look_up<MutexDeque>(s, false); });
  add("look-up/deque-again", [](benchmark::State& s) { look_up<MutexDeque>(s, false); });
  add("look-up-beside-writer/history", [](benchmark::State& s) { look_up<Ours>(s, true); });
  add("look-up-beside-writer/deque", [](benchmark::State& s) { look_up<MutexDeque>(s, true); });
  add("look-up-beside-writer/deque-again", [](benchmark::State& s) { look_up<MutexDeque>(s, true); });
  add("push/history", push_one<Ours>);
  add("push/deque", push_one<MutexDeque>);
  benchmark::Initialize(&count, arguments.data());
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
