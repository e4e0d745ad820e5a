// Eight graphics servers on one physics server, three of them bad company: one never takes its mail, one
// sends garbage a thousand times a second, one is killed every second. What the five others notice, and the
// loops.
//
// The physics server is a process of its own: a haptic loop and a physics loop at 1 kHz that writes the
// history, and the service. Three legs in the same run: the five alone, with the bad company, alone again.
// Late: the reply was not there 10 ms after the request, when the frame would have been drawn. Overruns and
// memory are the server's.
//
// Then a server whose physics loop moves a surface of 10,000 vertices 120 times a second, and two graphics
// servers that ask for it with every frame, 30 times a second, or for the state alone.
//   crowd_bench [seconds per leg = 20; the second one takes three times as long]
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/scene/scene_history.h"
#include "palpate/scene/shape_history.h"
#include "palpate/time/periodic_loop.h"
#include "palpate/transport/zmq_engine.h"
#include "palpate/transport/zmq_socket.h"

namespace {

using namespace palpate;

constexpr int kHealthy = 5;
constexpr double kFramesHz = 60.0;
constexpr Duration kDrawAfter = std::chrono::milliseconds(10);

MonotonicClock<PhysicsClock> physics_clock;
MonotonicClock<GraphicsClock> graphics_clock;

transport::Endpoint endpoint_at(const std::string& address) { return {address, address.substr(6), false}; }

void require(bool condition, const char* what) {
  if (!condition) throw std::runtime_error(what);
}

// A membrane that swings: what an application would do to a surface.
class Membrane {
 public:
  std::span<const float> at(Instant<PhysicsClock> now) {
    const float phase = static_cast<float>(std::fmod(now.seconds(), 1.0) * 2.0 * M_PI);
    for (std::size_t column = 0; column < kSide; ++column) {
      const float x = static_cast<float>(column) * 0.01F;
      const float height = 0.02F * std::sin(phase + 6.0F * x), slope = -0.12F * std::cos(phase + 6.0F * x);
      for (std::size_t row = 0; row < kSide; ++row) {
        const std::array<float, 6> vertex{x, height, static_cast<float>(row) * 0.01F, slope, 1.0F, 0.0F};
        std::copy(vertex.begin(), vertex.end(),
                  values_.begin() + static_cast<std::ptrdiff_t>(6 * (column * kSide + row)));
      }
    }
    return values_;
  }
  static constexpr std::size_t kSide = 100, kVertices = kSide * kSide;

 private:
  std::vector<float> values_ = std::vector<float>(kVertices * scene::Shape::kFloatsPerVertex);
};

[[noreturn]] void serve(const std::string& address, bool surface) {
  keep_freed_memory();
  Membrane membrane;
  scene::ShapeHistory shapes(surface ? Membrane::kVertices : 0);
  scene::SceneDescription scene;
  scene.shape_vertices = shapes.vertices();
  scene::SceneHistory history(Vector3(0, -9.81, 0));
  scene::SceneState state;
  state.body_count = 3;
  transport::StatusBoard board;
  const auto service = transport::serve_states(
      endpoint_at(address), physics_clock, [&](Instant<PhysicsClock> t) { return history.at(t); }, scene,
      {.identity = {},
       .status = [&] { return board.read(); },
       .shape = [&](Instant<PhysicsClock> t, std::span<float> out) { return shapes.at(t, out); }});
  require(service.has_value(), "the server cannot listen");
  PeriodicLoop<PhysicsClock> haptic(physics_clock, {.name = "haptic", .priority = 80},
                                    [](Instant<PhysicsClock>) {});
  PeriodicLoop<PhysicsClock> physics(physics_clock, {.name = "physics", .priority = 70, .spin = Duration(0)},
                                     [&](Instant<PhysicsClock> now) {
                                       state.time = now;
                                       ++state.tick;
                                       history.push(state);
                                       if (surface && state.tick % 8 == 0) shapes.push(now, membrane.at(now));
                                     });
  const auto start = physics_clock.now();
  while (true) {
    const double up = to_seconds(physics_clock.now() - start);
    board.write(
        {.uptime_s = up,
         .loops = {transport::loop_status("haptic", haptic), transport::loop_status("physics", physics)}});
    ::usleep(50'000);
  }
}

// A graphics server's rhythm: ask, draw a little later, again.
void draw_frames(transport::StateLink& link, std::atomic<bool>& stop, double rate_hz = kFramesHz,
                 bool shape = false) {
  const Duration period = seconds(1.0 / rate_hz);
  std::uint64_t number = 0;
  for (auto next = graphics_clock.now(); !stop; next += period) {
    link.request(++number, physics_clock.now(), shape);
    while (graphics_clock.now() < next + kDrawAfter) {
      ::usleep(1000);
      link.poll();
    }
    link.frame_drawn(number);
    while (graphics_clock.now() < next + period) {
      ::usleep(1000);
      link.poll();
    }
  }
}

[[noreturn]] void be_short_lived(const std::string& address) {
  auto link = transport::connect_states(endpoint_at(address), graphics_clock, "short-lived");
  std::atomic<bool> never{false};
  draw_frames(**link, never);
  _exit(0);
}

[[noreturn]] void be_bad(const std::string& address, bool garbage) {
  auto socket = transport::zmq::Socket::make(ZMQ_DEALER);
  socket->receive_without_bound();  // it reads nothing, and must not end by that
  zmq_connect(socket->get(), address.c_str());
  Random random(7, "crowd");
  for (std::uint64_t number = 1;; ++number) {
    std::string bytes;
    if (garbage) {
      bytes.resize(random.below(60'000));
      for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8) {
        const std::uint64_t word = random.bits();
        std::copy_n(reinterpret_cast<const char*>(&word), 8, bytes.begin() + static_cast<std::ptrdiff_t>(i));
      }
    } else {
      bytes =
          transport::encode(transport::ClientMessage(transport::StateRequest{number, physics_clock.now()}));
    }
    socket->send(bytes);
    ::usleep(garbage ? 1000 : 16'000);
  }
}

pid_t start(const char* part, const std::string& address) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::execl("/proc/self/exe", "crowd_bench", part, address.c_str(), nullptr);
    _exit(127);
  }
  return child;
}

void end(pid_t child) {
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

double resident_mib(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/statm", process));
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

transport::ServerStatus status_of(transport::StateLink& link) {
  const double before = link.status() ? link.status()->uptime_s : -1.0;
  for (int i = 0; i < 500; ++i) {
    if (i % 20 == 0) link.ask_status();
    link.poll();
    if (link.status() && link.status()->uptime_s > before) return *link.status();
    ::usleep(10'000);
  }
  throw std::runtime_error("the server does not answer");
}

struct Leg {
  const char* name;
  double length_s;
  int clients = kHealthy;
  double rate_hz = kFramesHz;
  bool crowd = false, shape = false;
};

void run_leg(const Leg& leg, const std::string& address, pid_t server, transport::StateLink& asking) {
  const bool crowd = leg.crowd;
  std::vector<std::unique_ptr<transport::StateLink>> links;
  for (int i = 0; i < leg.clients; ++i)
    links.push_back(std::move(*transport::connect_states(endpoint_at(address), graphics_clock, "healthy")));
  for (auto& link : links)
    while (!link->peer_alive()) link->poll(), ::usleep(1000);
  std::vector<pid_t> bad;
  if (crowd) bad = {start("stalled", address), start("garbage", address)};
  const transport::ServerStatus first = status_of(asking);
  const double memory = resident_mib(server);
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (auto& link : links) threads.emplace_back([&] { draw_frames(*link, stop, leg.rate_hz, leg.shape); });
  const auto until = graphics_clock.now() + seconds(leg.length_s);
  int killed = 0;
  while (graphics_clock.now() < until) {
    const pid_t child = crowd ? start("short-lived", address) : 0;
    ::usleep(1'000'000);
    if (crowd) end(child), ++killed;
  }
  stop = true;
  for (auto& thread : threads) thread.join();
  const transport::ServerStatus last = status_of(asking);
  for (const pid_t child : bad) end(child);
  std::uint64_t frames = 0, late = 0, lost = 0;
  for (const auto& link : links) {
    frames += link->counters().frames;
    late += link->counters().frames - link->counters().frames_in_time;
    lost += link->counters().lost;
    if (leg.shape && !link->newest_shape()) throw std::runtime_error("the surface never came");
  }
  const double elapsed = last.uptime_s - first.uptime_s;
  const auto per_minute = [&](std::size_t loop) {
    return 60.0 * static_cast<double>(last.loops[loop].overruns - first.loops[loop].overruns) / elapsed;
  };
  fmt::print(
      "{:<24} {:6} frames, late {:.2f} %, lost {}; overruns a minute: haptic {:.1f}, physics {:.1f}; memory "
      "{:.1f} "
      "-> {:.1f} MiB; {} killed, {} messages refused\n",
      leg.name, frames, 100.0 * static_cast<double>(late) / static_cast<double>(frames), lost, per_minute(0),
      per_minute(1), memory, resident_mib(server), killed, last.rejected - first.rejected);
}

void run_legs(const char* part, const std::vector<Leg>& legs) {
  const auto endpoint = transport::default_endpoint(fmt::format("bench-{}", ::getpid()));
  require(endpoint.has_value(), "no endpoint");
  const pid_t server = start(part, endpoint->address);
  auto asking = transport::connect_states(*endpoint, graphics_clock, "bench");
  require(asking.has_value(), "no link");
  status_of(**asking);
  for (const Leg& leg : legs) run_leg(leg, endpoint->address, server, **asking);
  end(server);
  std::error_code ignored;
  for (const char* rest : {"", ".lock", ".states", ".states.lock"})
    std::filesystem::remove(endpoint->socket.string() + rest, ignored);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string part = argc > 2 ? argv[1] : "";
    if (part == "serve" || part == "serve-surface") serve(argv[2], part == "serve-surface");
    if (part == "short-lived") be_short_lived(argv[2]);
    if (part == "stalled" || part == "garbage") be_bad(argv[2], part == "garbage");
    const double length_s = argc > 1 ? std::max(1.0, std::atof(argv[1])) : 20.0;
    run_legs("serve", {{.name = "five graphics servers", .length_s = length_s},
                       {.name = "in bad company", .length_s = 3 * length_s, .crowd = true},
                       {.name = "five, again", .length_s = length_s}});
    const Leg unasked{.name = "surface, not asked for", .length_s = length_s, .clients = 2, .rate_hz = 30.0};
    Leg asked = unasked;
    asked.name = "10,000 vertices at 30 Hz";
    asked.shape = true;
    run_legs("serve-surface", {unasked, asked, unasked, asked, unasked});
  } catch (const std::exception& failure) {
    fmt::print(stderr, "crowd_bench: {}\n", failure.what());
    return 1;
  }
}
