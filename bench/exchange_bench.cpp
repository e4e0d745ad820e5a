// Round trip of a state request, beside bare TCP with the same number of bytes, paced like frames.
//
// A second process plays the physics server: our exchange on a unix socket and on TCP, and a bare TCP echo
// (Nagle off, blocking). In each round the three run one after the other, bare TCP at the beginning and at
// the end; a ratio is the median of ours over the mean of the round's two bare medians, and what is printed
// is the median of the rounds' ratios with their range. The last line compares bare TCP with itself:
// differences of that size mean nothing.
//   exchange_bench [rounds = 10] [requests per leg = 200] [rate_hz = 100]
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "palpate/network/zmq_engine.h"

namespace {

using namespace palpate;

constexpr std::size_t kRequestBytes = 24;  // of ours, about
using Times = std::vector<double>;         // us

MonotonicClock<PhysicsClock> physics_clock;
MonotonicClock<GraphicsClock> graphics_clock;

StateAnswer answer_at(Instant<PhysicsClock> time) {
  StateAnswer answer;
  answer.kind = AnswerKind::interpolated;
  answer.state.time = time;
  answer.state.body_count = 3;
  for (int i = 0; i < 3; ++i) answer.state.bodies[static_cast<std::size_t>(i)].set_p({0.1 * i, 0.2, 0.3});
  return answer;
}

void require(bool condition, const char* what) {
  if (!condition) throw std::runtime_error(what);
}

bool transfer_all(int fd, std::vector<char>& buffer, bool out) {
  for (std::size_t done = 0; done < buffer.size();) {
    const ssize_t n = out ? ::send(fd, buffer.data() + done, buffer.size() - done, MSG_NOSIGNAL)
                          : ::recv(fd, buffer.data() + done, buffer.size() - done, 0);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

void no_delay(int fd) {
  const int one = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
}

[[noreturn]] void play_server(int listener, const Endpoint& ipc, const Endpoint& tcp,
                              std::size_t reply_bytes) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto over_ipc = serve_states(ipc, physics_clock, answer_at, SceneDescription{});
  const auto over_tcp = serve_states(tcp, physics_clock, answer_at, SceneDescription{});
  if (!over_ipc || !over_tcp) _exit(1);
  const int peer = ::accept(listener, nullptr, nullptr);
  no_delay(peer);
  std::vector<char> request(kRequestBytes), reply(reply_bytes);
  while (transfer_all(peer, request, false) && transfer_all(peer, reply, true)) {
  }
  _exit(0);
}

struct Pace {
  Duration period;
  std::int64_t next = MonotonicClock<GraphicsClock>::monotonic_ns();
  void wait() {
    next += period.count();
    graphics_clock.sleep_until({Duration(next)});
  }
};

Times bare_tcp(int fd, int count, Duration period, std::size_t reply_bytes) {
  std::vector<char> request(kRequestBytes), reply(reply_bytes);
  Times times;
  for (Pace pace{period}; static_cast<int>(times.size()) < count;) {
    pace.wait();
    const auto sent = graphics_clock.now();
    require(transfer_all(fd, request, true) && transfer_all(fd, reply, false), "the bare TCP peer has gone");
    times.push_back(1e6 * to_seconds(graphics_clock.now() - sent));
  }
  return times;
}

Times ours(StateLink& link, std::uint64_t& number, int count, Duration period) {
  Times times;
  const auto late_before = link.counters().late;
  Pace pace{period};
  for (int i = 0; i < count; ++i) {
    pace.wait();
    link.poll();
    for (const ArrivedState& a : link.arrived()) times.push_back(1e6 * to_seconds(a.received - a.sent));
    link.frame_drawn(number);
    link.request(++number, physics_clock.now());
  }
  pace.wait();
  link.poll();
  for (const ArrivedState& a : link.arrived()) times.push_back(1e6 * to_seconds(a.received - a.sent));
  require(!times.empty(), "no replies");
  if (link.counters().late != late_before) {
    fmt::print("late in this leg: {}\n", link.counters().late - late_before);
  }
  return times;
}

double quantile(Times values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

void report(const char* name, const Times& ratios, const Times& all) {
  fmt::print("{:<22} ratio {:.2f} ({:.2f} to {:.2f})   median {:.0f} us  p99 {:.0f} us  max {:.0f} us\n",
             name, quantile(ratios, 0.5), quantile(ratios, 0.0), quantile(ratios, 1.0), quantile(all, 0.5),
             quantile(all, 0.99), quantile(all, 1.0));
}

void run(int rounds, int count, double rate_hz) {
  const Duration period = seconds(1.0 / rate_hz);
  const std::size_t reply_bytes =
      encode(ServerMessage(StateReply{1000, physics_clock.now(), answer_at(physics_clock.now())})).size();
  const auto ipc = default_endpoint(fmt::format("bench-{}", ::getpid()));
  const auto tcp = parse_endpoint(fmt::format("tcp://127.0.0.1:{}", 20000 + ::getpid() % 20000),
                                  EndpointUse::listen, true);
  require(ipc && tcp, "no endpoint");

  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  require(::bind(listener, generic, size) == 0 && ::listen(listener, 1) == 0, "no TCP port");
  ::getsockname(listener, generic, &size);
  const pid_t server = ::fork();
  if (server == 0) play_server(listener, *ipc, *tcp, reply_bytes);

  const int bare = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  require(::connect(bare, generic, size) == 0, "cannot connect the bare TCP rival");
  no_delay(bare);
  auto over_ipc = connect_states(*ipc, graphics_clock), over_tcp = connect_states(*tcp, graphics_clock);
  require(over_ipc && over_tcp, "no link");
  std::uint64_t ipc_number = 0, tcp_number = 0;
  // Warm-up, and until both are connected.
  for (int i = 0; i < 1000 && !((*over_ipc)->peer_alive() && (*over_tcp)->peer_alive()); ++i) {
    (*over_ipc)->poll();
    (*over_tcp)->poll();
    ::usleep(10'000);
  }
  require((*over_ipc)->peer_alive() && (*over_tcp)->peer_alive(), "the server does not answer");
  bare_tcp(bare, 50, period, reply_bytes);
  ours(**over_ipc, ipc_number, 50, period);
  ours(**over_tcp, tcp_number, 50, period);

  Times bare_all, ipc_all, tcp_all, ipc_ratios, tcp_ratios, bare_ratios;
  const auto keep = [](Times& all, const Times& leg) { all.insert(all.end(), leg.begin(), leg.end()); };
  for (int round = 0; round < rounds; ++round) {
    const Times first = bare_tcp(bare, count, period, reply_bytes);
    const Times a = ours(**over_ipc, ipc_number, count, period);
    const Times b = ours(**over_tcp, tcp_number, count, period);
    const Times last = bare_tcp(bare, count, period, reply_bytes);
    const double base = (quantile(first, 0.5) + quantile(last, 0.5)) / 2;
    ipc_ratios.push_back(quantile(a, 0.5) / base);
    tcp_ratios.push_back(quantile(b, 0.5) / base);
    bare_ratios.push_back(quantile(last, 0.5) / quantile(first, 0.5));
    keep(ipc_all, a);
    keep(tcp_all, b);
    keep(bare_all, first);
    keep(bare_all, last);
  }
  ::kill(server, SIGKILL);
  ::waitpid(server, nullptr, 0);
  std::error_code ignored;
  std::filesystem::remove(ipc->socket, ignored);
  std::filesystem::remove(ipc->socket.string() + ".lock", ignored);

  fmt::print("{} rounds of {} requests at {} Hz, reply {} bytes; ratios to bare TCP of the same round\n",
             rounds, count, rate_hz, reply_bytes);
  report("ours, unix socket", ipc_ratios, ipc_all);
  report("ours, TCP", tcp_ratios, tcp_all);
  report("bare TCP, last/first", bare_ratios, bare_all);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc > 1 ? std::max(1, std::atoi(argv[1])) : 10, argc > 2 ? std::max(10, std::atoi(argv[2])) : 200,
        argc > 3 ? std::max(1.0, std::atof(argv[3])) : 100.0);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "exchange_bench: {}\n", failure.what());
    return 1;
  }
}
