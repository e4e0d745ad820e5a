// The true error of ClockSync through the real exchange, beside processes that only compute.
//
// A second process plays the physics server at a unix socket and at an encrypted TCP address; its clock wears
// an offset of seconds, a drift and a slow wander, and because both processes read the same monotonic clock
// underneath the truth is known. This process goes through a link to each as the graphics server does: a
// round a millisecond, a state asked for at 30 Hz, clock exchanges when ClockSync wants them. The error is
// taken at every image, from the first second on; each load begins with new links.
//
//   clock_sync_bench [seconds per load = 25] [file for the time stamps]
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <vector>

#include "palpate/time/clock_model.h"
#include "palpate/time/jitter_histogram.h"
#include "palpate/transport/zmq_engine.h"

namespace {

using namespace palpate;

// Leads by 3 s and gains 80 ppm, with 2 ppm of wander in a period of 30 s.
class WornClock : public Clock<PhysicsClock> {
 public:
  explicit WornClock(std::int64_t base_ns) : base_ns_(base_ns) {}
  Instant<PhysicsClock> now() const override { return at(MonotonicClock<PhysicsClock>::monotonic_ns()); }
  void sleep_until(Instant<PhysicsClock>) override {}
  Instant<PhysicsClock> at(std::int64_t monotonic_ns) const {
    const double t = static_cast<double>(monotonic_ns - base_ns_) * 1e-9, w = 2.0 * M_PI / 30.0;
    return {
        Duration(monotonic_ns + std::llround(1e9 * (3.0 + 80e-6 * t + 2e-6 / w * (1.0 - std::cos(w * t)))))};
  }

 private:
  std::int64_t base_ns_;
};

void require(bool condition, const std::string& what) {
  if (!condition) throw std::runtime_error(what);
}

pid_t child(auto work) {
  const pid_t pid = ::fork();
  if (pid != 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  work();
  ::_exit(1);
}

void end(pid_t pid) {
  ::kill(pid, SIGKILL);
  ::waitpid(pid, nullptr, 0);
}

scene::StateAnswer answer_at(Instant<PhysicsClock> time) {
  scene::StateAnswer answer;
  answer.kind = AnswerKind::interpolated;
  answer.state.time = time;
  return answer;
}

struct Leg {
  const char* name;
  std::unique_ptr<transport::StateLink> link;
  ClockSync<GraphicsClock, PhysicsClock> sync;
  std::optional<Instant<GraphicsClock>> first, asked;
  std::uint64_t number = 0;
  JitterHistogram errors, round_trips, uncertainties;
  int outside = 0, checked = 0;

  void round(Instant<GraphicsClock> now, std::FILE* stamps, int hogs) {
    link->poll();
    while (const auto s = link->take_sync()) {
      sync.add(s->t1, s->t2, s->t3, s->t4);
      round_trips.add((s->t4 - s->t1) - (s->t3 - s->t2));
      if (stamps != nullptr)
        fmt::print(stamps, "{},{},{},{},{},{}\n", name, hogs, s->t1.ns(), s->t2.ns(), s->t3.ns(), s->t4.ns());
    }
    if (asked && now - *asked < sync.interval()) return;
    if (link->send_sync()) asked = now;
  }
  void image(Instant<GraphicsClock> now, const WornClock& truth) {
    link->frame_drawn(number);
    link->request(++number, sync.model().to(now));
    if (sync.exchanges() == 0) return;
    if (!first) first = now;
    const Duration error(std::abs((sync.model().to(now) - truth.at(now.ns())).count()));
    const Duration stated = sync.model().uncertainty(now);
    outside += error > stated ? 1 : 0;
    ++checked;
    if (now - *first < seconds(1.0)) return;
    errors.add(error);
    uncertainties.add(stated);
  }
  void report(int hogs) const {
    const auto us = [](Duration d) { return 1e6 * to_seconds(d); };
    fmt::print(
        "{:<12} {:>5}   {:>5.0f} {:>6.0f} {:>6.0f}   {:>6.1f} {:>6.1f} {:>6.1f}   {:>6.0f} {:>6.0f}   {:>4} "
        "of "
        "{:<5} {:>6.1f} {:>9} {:>8}\n",
        name, hogs, us(sync.lowest_round_trip()), us(round_trips.quantile(0.5)),
        us(round_trips.quantile(0.99)), us(errors.quantile(0.5)), us(errors.quantile(0.99)), us(errors.max()),
        us(uncertainties.quantile(0.5)), us(uncertainties.quantile(0.99)), outside, checked,
        sync.model().drift_ppm(), sync.exchanges(), sync.restarts());
    std::fflush(stdout);
  }
};

void run(double length_s, const char* stamps_file) {
  const std::int64_t base_ns = MonotonicClock<PhysicsClock>::monotonic_ns();
  const WornClock truth(base_ns);
  MonotonicClock<GraphicsClock> clock;
  char folder[] = "/tmp/palpate-bench-XXXXXX";
  require(::mkdtemp(folder) != nullptr, "no folder");
  const auto own = transport::make_key_pair(), keys = transport::make_key_pair();
  require(own && keys && transport::write_key_pair(folder, *own, false) &&
              transport::authorize_key(folder, {transport::Role::graphics, keys->public_key, "bench"}),
          "no keys");
  const auto local =
      transport::parse_endpoint(fmt::format("ipc://{}/physics.sock", folder), transport::EndpointUse::listen);
  const std::string address = fmt::format("tcp://127.0.0.1:{}", 20000 + ::getpid() % 20000);
  const auto tcp = transport::parse_endpoint(address, transport::EndpointUse::listen);
  require(local && tcp, "no endpoint");

  const pid_t server = child([&] {
    const auto over_ipc = transport::serve_states(*local, truth, answer_at, scene::SceneDescription{});
    const auto over_tcp = transport::serve_states(*tcp, truth, answer_at, scene::SceneDescription{},
                                                  {*transport::server_identity(folder), {}});
    while (over_ipc && over_tcp) ::pause();
  });
  std::FILE* stamps = stamps_file != nullptr ? std::fopen(stamps_file, "w") : nullptr;
  if (stamps != nullptr) fmt::print(stamps, "base,{}\n", base_ns);
  fmt::print("{:<12} {:>5}   {:<19}   {:<20}   {:<13}   {:<13} {:>6} {:>9} {:>8}\n", "us", "busy",
             "trip low, p50, p99", "error p50, p99, max", "stated p50, p99", "outside", "ppm", "exchanges",
             "restarts");
  for (const int hogs : {0, 1, 2, 4}) {
    std::vector<pid_t> busy;
    for (int i = 0; i < hogs; ++i)
      busy.push_back(child([] {
        for (volatile std::uint64_t x = 0;;) x = x + 1;
      }));
    Leg legs[] = {{"unix socket", nullptr, {}, {}, {}}, {"TCP, CURVE", nullptr, {}, {}, {}}};
    auto over_ipc = transport::connect_states(*local, clock),
         over_tcp = transport::connect_states(*tcp, clock, "graphics",
                                              transport::ClientIdentity{*keys, own->public_key});
    require(over_ipc && over_tcp, "no link");
    legs[0].link = std::move(*over_ipc);
    legs[1].link = std::move(*over_tcp);
    const auto begun = clock.now();
    auto next = begun, image = begun;
    while (clock.now() - begun < seconds(length_s)) {
      next = std::max(next + std::chrono::milliseconds(1), clock.now());
      std::this_thread::sleep_for(next - clock.now());
      for (Leg& leg : legs) leg.round(clock.now(), stamps, hogs);
      if (clock.now() < image) continue;
      image += std::chrono::milliseconds(33);
      for (Leg& leg : legs) leg.image(clock.now(), truth);
    }
    for (const pid_t pid : busy) end(pid);
    for (const Leg& leg : legs) {
      require(leg.checked > 0, fmt::format("{}: no clock exchange", leg.name));
      leg.report(hogs);
    }
  }
  end(server);
  if (stamps != nullptr) std::fclose(stamps);
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc > 1 ? std::max(2.0, std::atof(argv[1])) : 25.0, argc > 2 ? argv[2] : nullptr);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "clock_sync_bench: {}\n", failure.what());
    return 1;
  }
}
