// Round trip of a state request, beside bare TCP with the same number of bytes, paced like frames.
//
// A second process plays the physics server: our exchange on a unix socket, on TCP and on TCP with CURVE, and
// a bare TCP echo (Nagle off, blocking). In each round all run one after the other, bare TCP at the beginning
// and at the end; a ratio is the median (or p99) of ours over the mean of the round's two of bare TCP, and
// what is printed is the median of the rounds' ratios with their range. The last line of a table compares
// bare TCP with itself: differences of that size mean nothing.
//
// Pinned: all threads of the client on core 0, all of the server on core 1, as a rig would be set up; only
// there a bar applies. Beside the loop: the server also runs a 1 kHz loop under SCHED_FIFO that spins before
// its deadline and writes the history, on whatever core the server has.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

#include "bare_tcp.h"
#include "bare_zeromq.h"
#include "exchange_table.h"
#include "palpate/core/statistics.h"
#include "palpate/scene/scene_history.h"
#include "palpate/scene/shape_history.h"
#include "palpate/time/periodic_loop.h"
#include "palpate/transport/zmq_engine.h"

namespace {

using namespace palpate;
using namespace palpate::exchange_bench;

constexpr std::size_t kRequestBytes = 24;  // of ours, about
constexpr std::size_t kShapeVertices = 10'000;
constexpr std::size_t kShapeBytes = kShapeVertices * scene::Shape::kFloatsPerVertex * sizeof(float);

MonotonicClock<PhysicsClock> physics_clock;
MonotonicClock<GraphicsClock> graphics_clock;

// What both processes see: when the server last looked a state up, on the machine's one clock.
struct Shared {
  std::atomic<std::int64_t> looked_up{0}, answered{0};
  std::atomic<bool> shape_ready{false};  // to the server: send a shape as it is, without looking one up
};

void pin_to(int core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(core, &cores);
  require(::sched_setaffinity(0, sizeof cores, &cores) == 0, "cannot pin to a core");
}

// ---------------------------------------------------------------------------- the server's process

struct Places {
  transport::Endpoint ipc, tcp, curve;
  std::string bare_ipc, bare_tcp, bare_curve;  // of ZeroMQ by itself
  transport::KeyPair server_keys, client_keys;
  std::filesystem::path folder;  // of authorized_keys
};

[[noreturn]] void play_server(int listener, const Places& places, bool pinned, bool beside_loop,
                              Shared& shared) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (pinned) pin_to(1);
  scene::SceneHistory history(Vector3(0, -9.81, 0));
  scene::SceneState state;
  state.body_count = 3;
  for (int i = 0; i < 3; ++i) state.bodies[static_cast<std::size_t>(i)].set_p({0.1 * i, 0.2, 0.3});
  const auto step = [&](Instant<PhysicsClock> now) {
    state.time = now;
    ++state.tick;
    history.push(state);
  };
  const auto begin = physics_clock.now();
  for (int i = 8000; i > 0; --i) step(begin - std::chrono::milliseconds(i));
  const auto source = [&](Instant<PhysicsClock> when) {
    shared.looked_up.store(physics_clock.now().ns(), std::memory_order_relaxed);
    auto answer = history.at(when);
    shared.answered.store(physics_clock.now().ns(), std::memory_order_relaxed);
    return answer;
  };
  // Asked for a time between two shapes, always the same two: nobody writes them where no loop runs.
  scene::ShapeHistory shapes(kShapeVertices);
  for (int i = 1; i <= 20; ++i)
    shapes.push(Instant<PhysicsClock>{std::chrono::milliseconds(8 * i)},
                std::vector<float>(kShapeVertices * scene::Shape::kFloatsPerVertex, static_cast<float>(i)));
  const transport::ShapeSource shape = [&](Instant<PhysicsClock>, std::span<float> out) {
    const Instant<PhysicsClock> between{std::chrono::milliseconds(101)};
    auto time = shared.shape_ready ? std::optional(between) : shapes.at(between, out);
    shared.answered.store(physics_clock.now().ns(), std::memory_order_relaxed);
    return time;
  };
  scene::SceneDescription scene;
  scene.shape_vertices = kShapeVertices;
  const transport::ServiceOptions open{.identity = {}, .status = {}, .shape = shape};
  transport::ServiceOptions guarded = open;
  guarded.identity = transport::ServerIdentity{places.server_keys, places.folder};
  const auto over_ipc = transport::serve_states(places.ipc, physics_clock, source, scene, open);
  const auto over_tcp = transport::serve_states(places.tcp, physics_clock, source, scene, open);
  const auto over_curve = transport::serve_states(places.curve, physics_clock, source, scene, guarded);
  if (!over_ipc || !over_tcp || !over_curve) {
    fmt::print(stderr, "the server cannot listen\n");
    _exit(1);
  }
  bare_zeromq::serve(places.bare_ipc, {});
  bare_zeromq::serve(places.bare_tcp, {});
  bare_zeromq::serve(places.bare_curve, places.server_keys);
  std::optional<PeriodicLoop<PhysicsClock>> loop;
  if (beside_loop) loop.emplace(physics_clock, PeriodicLoopSettings{.name = "haptic"}, step);
  bare_tcp::echo(listener, kRequestBytes);
  _exit(0);
}

// ---------------------------------------------------------------------------- the client's legs

// `exchange` sends the request, whose first eight bytes ask for so many, and takes the reply.
template <typename Exchange>
Times bare_leg(const Load& load, Exchange&& exchange) {
  std::vector<char> request(kRequestBytes);
  const std::uint64_t size = load.reply_bytes;
  std::copy_n(reinterpret_cast<const char*>(&size), sizeof size, request.data());
  Times times;
  for (Pace pace{load.period()}; static_cast<int>(times.size()) < load.requests;) {
    pace.wait();
    const auto sent = graphics_clock.now();
    require(exchange(request), "the bare peer has gone");
    times.push_back(1e6 * to_seconds(graphics_clock.now() - sent));
  }
  return times;
}

Times bare_socket(int fd, const Load& load) {
  std::vector<char> reply(load.reply_bytes);
  return bare_leg(load, [&](std::vector<char>& request) {
    return bare_tcp::transfer_all(fd, request, true) && bare_tcp::transfer_all(fd, reply, false);
  });
}

Times bare_engine(bare_zeromq::Client& client, const Load& load) {
  return bare_leg(
      load, [&](const std::vector<char>& request) { return client.exchange(request, load.reply_bytes); });
}

// Where the time of a round trip goes, us.
struct Parts {
  Times there, look_up, back;
};

class Ours {
 public:
  Ours(const char* name, std::unique_ptr<transport::StateLink> link) : name_(name), link_(std::move(link)) {}
  const char* name() const { return name_; }
  void connect() {
    for (int i = 0; i < 1000 && !link_->peer_alive(); ++i) {
      link_->poll();
      ::usleep(10'000);
    }
    require(link_->peer_alive(), fmt::format("{}: the server does not answer", name_));
  }
  Times leg(const Load& load, const Shared& shared) {
    Times times;
    const auto take = [&] {
      link_->poll();
      for (const transport::ArrivedState& a : link_->arrived()) {
        times.push_back(1e6 * to_seconds(a.received - a.sent));
        if (a.reply.number != number_) continue;  // the marks are of the newest alone
        const auto us = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
        parts.there.push_back(us(shared.looked_up - a.sent.ns()));
        parts.look_up.push_back(us(shared.answered - shared.looked_up));
        parts.back.push_back(us(a.received.ns() - shared.answered));
      }
    };
    Pace pace{load.period()};
    for (int i = 0; i < load.requests; ++i) {
      pace.wait();
      take();
      link_->frame_drawn(number_);
      link_->request(++number_, physics_clock.now() - std::chrono::milliseconds(20), load.shape);
    }
    pace.wait();
    ::usleep(20'000);
    take();
    require(!times.empty(), fmt::format("{}: no replies", name_));
    return times;
  }
  Parts parts;

 private:
  const char* name_;
  std::unique_ptr<transport::StateLink> link_;
  std::uint64_t number_ = 0;
};

// What reading a request and writing a state takes on a core that has slept, us: medians.
struct Wording {
  double decode = 0.0, encode = 0.0;
};
Wording wording() {
  scene::StateAnswer answer;
  answer.state.body_count = 3;
  const transport::ServerMessage reply = transport::StateReply{1000, physics_clock.now(), answer, nullptr};
  const std::string request =
      transport::encode(transport::ClientMessage(transport::StateRequest{1000, physics_clock.now(), false}));
  Times decoded, encoded;
  Pace pace{std::chrono::milliseconds(10)};
  for (int i = 0; i < 50; ++i) {
    pace.wait();
    const auto begin = graphics_clock.now();
    const bool read = transport::decode_client_message(request).has_value();
    const auto between = graphics_clock.now();
    const bool written = !transport::encode(reply).empty();
    const auto end = graphics_clock.now();
    require(read && written, "messages that cannot be read");
    decoded.push_back(1e6 * to_seconds(between - begin));
    encoded.push_back(1e6 * to_seconds(end - between));
  }
  return {median(decoded), median(encoded)};
}

// ---------------------------------------------------------------------------- a table

struct Case {
  const char* what = "state";
  Load load;
  bool shape_ready = false;
  double unix_bar = 0.0, tcp_bar = 0.0, curve_bar = 0.0;
};

// All that runs in a round: ours beside what it stands on.
struct Contest {
  int bare = -1;
  std::vector<Ours> links;
  std::vector<std::unique_ptr<bare_zeromq::Client>> engines;  // each under the link of the same place
};

void measure(const Case& what, int rounds, Contest& contest, Shared& shared) {
  shared.shape_ready = what.shape_ready;
  std::vector<Row> rows;
  const double bars[] = {what.unix_bar, what.tcp_bar, what.curve_bar};
  for (std::size_t i = 0; i < contest.links.size(); ++i) {
    rows.push_back({.name = contest.links[i].name(), .medians = {}, .p99s = {}, .all = {}, .bar = bars[i]});
    rows.push_back({.name = "  ZeroMQ alone", .medians = {}, .p99s = {}, .all = {}});
    contest.links[i].parts = {};
  }
  Row again{.name = "bare TCP again", .medians = {}, .p99s = {}, .all = {}};
  Times all_bare;
  const auto keep = [](Times& all, const Times& leg) { all.insert(all.end(), leg.begin(), leg.end()); };
  for (int round = 0; round < rounds; ++round) {
    const Times first = bare_socket(contest.bare, what.load);
    std::vector<Times> legs;
    for (std::size_t i = 0; i < contest.links.size(); ++i) {
      legs.push_back(contest.links[i].leg(what.load, shared));
      legs.push_back(bare_engine(*contest.engines[i], what.load));
    }
    const Times last = bare_socket(contest.bare, what.load);
    const double base = (median(first) + median(last)) / 2, base99 = (p99(first) + p99(last)) / 2;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].medians.push_back(median(legs[i]) / base);
      rows[i].p99s.push_back(p99(legs[i]) / base99);
      keep(rows[i].all, legs[i]);
    }
    again.medians.push_back(median(last) / median(first));
    again.p99s.push_back(p99(last) / p99(first));
    keep(again.all, last);
    keep(all_bare, first);
    keep(all_bare, last);
  }
  fmt::print(" {}: {} bytes at {:.0f} Hz, {} rounds of {}; bare TCP {:.0f} us, p99 {:.0f} us\n", what.what,
             what.load.reply_bytes, what.load.rate_hz, rounds, what.load.requests, median(all_bare),
             p99(all_bare));
  for (const Row& row : rows) print(row, 2.5);
  print(again, 0.0);
  fmt::print("  Where the time goes:\n");
  for (std::size_t i = 0; i < contest.links.size(); ++i) {
    const Parts& parts = contest.links[i].parts;
    const double base = median(all_bare), engine = median(rows[2 * i + 1].all), all = median(rows[2 * i].all);
    fmt::print(
        "    {:<14} bare TCP {:.0f} us, engine {:+.0f}, ours {:+.0f} us (look-up {:.1f}); there {:.0f}, back "
        "{:.0f} us\n",
        contest.links[i].name(), base, engine - base, all - engine, median(parts.look_up),
        median(parts.there), median(parts.back));
  }
}

// ---------------------------------------------------------------------------- the run

Places make_places(int turn) {
  Places places;
  const int port = 20000 + (::getpid() * 32 + turn * 8) % 20000;
  const auto tcp = [&](int number, bool insecure) {
    return transport::parse_endpoint(fmt::format("tcp://127.0.0.1:{}", number),
                                     transport::EndpointUse::listen, insecure);
  };
  const auto ipc = transport::default_endpoint(fmt::format("bench-{}", ::getpid()));
  const auto plain = tcp(port, true), curve = tcp(port + 2, false);
  const auto server = transport::make_key_pair(), client = transport::make_key_pair();
  require(ipc && plain && curve && server && client, "no endpoint");
  const auto bare = [&](int number) { return fmt::format("tcp://127.0.0.1:{}", number); };
  places = {*ipc,           *plain,  *curve,  ipc->address + ".bare",        bare(port + 4),
            bare(port + 5), *server, *client, ipc->socket.string() + ".keys"};
  std::filesystem::create_directories(places.folder);
  std::filesystem::permissions(places.folder, std::filesystem::perms::owner_all);
  require(transport::authorize_key(places.folder, {transport::Role::graphics, client->public_key, "bench"})
              .has_value(),
          "no keys");
  return places;
}

void remove_traces(const Places& places) {
  std::error_code ignored;
  for (const char* rest : {"", ".lock", ".states", ".states.lock", ".bare"})
    std::filesystem::remove(places.ipc.socket.string() + rest, ignored);
  std::filesystem::remove_all(places.folder, ignored);
}

// In a process of its own: pinning and threads end with it.
void layout(bool pinned, bool beside_loop, int rounds, bool short_run, int engines, Shared& shared) {
  sockaddr_in address{};
  const int listener = bare_tcp::listen_somewhere(address);
  const Places places = make_places((pinned ? 2 : 0) + (beside_loop ? 1 : 0));
  const pid_t server = ::fork();
  if (server == 0) play_server(listener, places, pinned, beside_loop, shared);
  ::close(listener);
  if (pinned) pin_to(0);
  Contest contest{.bare = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), .links = {}, .engines = {}};
  require(::connect(contest.bare, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0,
          "no bare TCP rival");
  bare_tcp::no_delay(contest.bare);
  const auto add = [&](const char* name, const transport::Endpoint& place, const std::string& below,
                       const std::optional<transport::ClientIdentity>& identity) {
    if (static_cast<int>(contest.links.size()) == engines) return;
    auto link = transport::connect_states(place, graphics_clock, "bench", identity);
    require(link.has_value(), "no link");
    contest.links.emplace_back(name, std::move(*link));
    contest.links.back().connect();
    contest.engines.push_back(std::make_unique<bare_zeromq::Client>(below, identity));
  };
  add("unix socket", places.ipc, places.bare_ipc, {});
  add("TCP", places.tcp, places.bare_tcp, {});
  add("TCP, CURVE", places.curve, places.bare_curve,
      transport::ClientIdentity{places.client_keys, places.server_keys.public_key});

  const std::size_t state_bytes = [] {
    scene::StateAnswer answer;
    answer.state.body_count = 3;
    return transport::encode(
               transport::ServerMessage(transport::StateReply{1000, physics_clock.now(), answer}))
        .size();
  }();
  fmt::print("\n{}, {}\n", pinned ? "PINNED" : "UNPINNED (no bar)",
             beside_loop ? "beside the running 1 kHz loop" : "idle");
  const Wording words = wording();
  fmt::print(" One message on a core that has slept: request read in {:.1f} us, state written in {:.1f} us\n",
             words.decode, words.encode);
  // Bars where the threads are pinned; the loop next to it makes every wake-up wait.
  const double b = pinned ? 1.0 : 0.0;
  const Load states{.rate_hz = 100, .requests = 100, .reply_bytes = state_bytes};
  Load shapes{.rate_hz = 60, .requests = 60, .reply_bytes = state_bytes + kShapeBytes, .shape = true};
  Case hundred{.load = states, .tcp_bar = b * 1.6, .curve_bar = b * 1.8};
  if (beside_loop)
    hundred.tcp_bar = b * 2.2, hundred.curve_bar = b * 2.5;
  else
    hundred.unix_bar = b * 1.4;
  Case large{.what = "state and a shape that lies ready", .load = shapes, .shape_ready = true};
  if (!beside_loop) large.tcp_bar = b * 1.8, large.curve_bar = b * 3.2;
  Case looked_up = large;
  looked_up.what = "state and a shape looked up between its neighbours";
  looked_up.shape_ready = false;
  std::vector<Case> cases{hundred, large, looked_up};
  if (!short_run)
    for (const double rate_hz : {60.0, 1000.0})
      cases.push_back(
          {.load = {.rate_hz = rate_hz, .requests = rate_hz > 500 ? 500 : 60, .reply_bytes = state_bytes}});
  for (const Case& one : cases) measure(one, rounds, contest, shared);
  contest.links.clear();
  contest.engines.clear();
  ::kill(server, SIGKILL);
  ::waitpid(server, nullptr, 0);
  ::close(contest.bare);
  remove_traces(places);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Round trips of the exchange beside bare TCP");
  int rounds = 10;
  std::string which = "all";
  bool short_run = false;
  int engines = 3;
  app.add_option("--rounds", rounds, "Rounds per table")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--layout", which,
                 "all, pinned, unpinned, pinned-idle, pinned-loop, unpinned-idle, unpinned-loop")
      ->check(CLI::IsMember(
          {"all", "pinned", "unpinned", "pinned-idle", "pinned-loop", "unpinned-idle", "unpinned-loop"}))
      ->capture_default_str();
  app.add_option("--engines", engines, "Of the three, the first so many")->capture_default_str();
  app.add_flag("--short", short_run, "512 bytes at 100 Hz and the shape of 10,000 vertices at 60 Hz alone");
  CLI11_PARSE(app, argc, argv);
  keep_freed_memory();  // as the servers do
  void* page = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto& shared = *new (page) Shared;
  int failed = 0;
  for (const bool pinned : {true, false}) {
    for (const bool beside_loop : {false, true}) {
      const std::string name =
          fmt::format("{}-{}", pinned ? "pinned" : "unpinned", beside_loop ? "loop" : "idle");
      if (which != "all" && !name.starts_with(which)) continue;
      std::fflush(stdout);
      const pid_t child = ::fork();
      if (child == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        try {
          layout(pinned, beside_loop, rounds, short_run, engines, shared);
          std::fflush(stdout);
          std::_Exit(0);
        } catch (const std::exception& failure) {
          fmt::print(stderr, "exchange_bench: {}\n", failure.what());
          std::_Exit(1);
        }
      }
      int status = 0;
      ::waitpid(child, &status, 0);
      failed += status != 0;
    }
  }
  return failed == 0 ? 0 : 1;
}
