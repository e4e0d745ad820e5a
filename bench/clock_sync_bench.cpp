// The true error of ClockSync over a loopback connection: two processes exchange datagrams, the server's
// clock wears a known offset, drift and slow wander, and because both read the same monotonic clock
// underneath the truth is known.
//
//   clock_sync_bench [seconds = 40] [processes that only compute = 0]
//
// User-space time stamps, ordinary scheduling: the least favourable set-up. Prints the error after the first
// 8 s.
#include <arpa/inet.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "palpate/time/clock.h"
#include "palpate/time/clock_model.h"
#include "palpate/time/jitter_histogram.h"

namespace {

using namespace palpate;

// Lead of the server's clock: 1.234567 s, 80 ppm, and 2 ppm of wander with a period of 30 s.
std::int64_t server_ns(std::int64_t monotonic_ns, std::int64_t base_ns) {
  const double t = static_cast<double>(monotonic_ns - base_ns) * 1e-9, w = 2.0 * M_PI / 30.0;
  return monotonic_ns + std::llround(1e9 * (1.234567 + 80e-6 * t + 2e-6 / w * (1.0 - std::cos(w * t))));
}
std::int64_t now_ns() { return MonotonicClock<GraphicsClock>::monotonic_ns(); }

pid_t child(auto work) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  work();
  _exit(0);
}

}  // namespace

int main(int argc, char** argv) {
  const double length_s = argc > 1 ? std::atof(argv[1]) : 40.0;
  const int hogs = argc > 2 ? std::atoi(argv[2]) : 0;
  const std::int64_t base = now_ns();
  const int server = socket(AF_INET, SOCK_DGRAM, 0), client = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(server, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      getsockname(server, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      connect(client, reinterpret_cast<sockaddr*>(&address), size) != 0) {
    std::perror("loopback");
    return 1;
  }
  const timeval patience{0, 200'000};
  setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);

  std::vector<pid_t> children;
  children.push_back(child([&] {
    std::array<std::int64_t, 3> message{};  // t1, t2, t3
    sockaddr_in from{};
    while (true) {
      socklen_t from_size = sizeof from;
      if (recvfrom(server, message.data(), sizeof message, 0, reinterpret_cast<sockaddr*>(&from),
                   &from_size) < 0)
        continue;
      message[1] = server_ns(now_ns(), base);
      message[2] = server_ns(now_ns(), base);
      sendto(server, message.data(), sizeof message, 0, reinterpret_cast<sockaddr*>(&from), from_size);
    }
  }));
  for (int i = 0; i < hogs; ++i)
    children.push_back(child([] {
      volatile std::uint64_t x = 0;
      while (true) {
        const std::uint64_t y = x;
        x = y + 1;
      }
    }));

  ClockSync<GraphicsClock, PhysicsClock> sync;
  MonotonicClock<GraphicsClock> clock;
  JitterHistogram errors, round_trips;
  int outside = 0, checked = 0, lost = 0;
  const Instant<GraphicsClock> end = clock.now() + seconds(length_s);
  double stated = 0.0;
  for (Instant<GraphicsClock> next = clock.now(); next < end; next += sync.interval()) {
    clock.sleep_until(next);
    std::array<std::int64_t, 3> message{now_ns(), 0, 0};
    const std::int64_t t1 = message[0];
    if (send(client, message.data(), sizeof message, 0) < 0) continue;
    do {
      if (recv(client, message.data(), sizeof message, 0) < 0) message[0] = 0;
    } while (message[0] != 0 && message[0] != t1);  // a late answer to an earlier question
    const std::int64_t t4 = now_ns();
    if (message[0] == 0) {
      ++lost;
      continue;
    }
    sync.add({Duration(t1)}, {Duration(message[1])}, {Duration(message[2])}, {Duration(t4)});
    if (static_cast<double>(t4 - base) < 8e9) continue;
    const Instant<GraphicsClock> later = Instant<GraphicsClock>{Duration(t4)} + Duration(50'000'000);
    const Duration error =
        sync.model().to(later) - Instant<PhysicsClock>{Duration(server_ns(later.ns(), base))};
    errors.add(Duration(std::abs(error.count())));
    round_trips.add(Duration(t4 - t1));
    stated += to_seconds(sync.model().uncertainty(later));
    outside += std::abs(error.count()) > sync.model().uncertainty(later).count();
    ++checked;
  }
  for (const pid_t pid : children) {
    kill(pid, SIGKILL);
    waitpid(pid, nullptr, 0);
  }
  const auto us = [](Duration d) { return static_cast<double>(d.count()) * 1e-3; };
  std::printf("round trip us: median %.0f p99 %.0f max %.0f; lowest in the window %.0f\n",
              us(round_trips.quantile(0.5)), us(round_trips.quantile(0.99)), us(round_trips.max()),
              us(sync.lowest_round_trip()));
  std::printf(
      "true error us: median %.1f p99 %.1f max %.1f; stated uncertainty mean %.0f; outside it %d of %d\n",
      us(errors.quantile(0.5)), us(errors.quantile(0.99)), us(errors.max()),
      1e6 * stated / std::max(1, checked), outside, checked);
  std::printf("drift %.2f ppm (truth 80 +- 2), lost %d, restarts %d\n", sync.model().drift_ppm(), lost,
              sync.restarts());
  return 0;
}
