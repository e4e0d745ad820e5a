#include "tests/doors/arm_door.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "drivers/openhaptics/stub/arm_line.h"
#include "palpate/core/system_error.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"
#include "tests/doors/release.h"

namespace palpate::doors {
namespace {

// A reading of the laboratory is looked for this often, and goes out so long after it was made.
constexpr Duration kReadingLook = std::chrono::microseconds(200), kArmTakes = std::chrono::milliseconds(2);

Expected<FileDescriptor> listen_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    return wrong_use("{}: a path of less than {} bytes is expected", path, sizeof address.sun_path);
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  unlink(path.c_str());
  FileDescriptor listening(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listening || bind(listening.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listening.get(), 1) != 0)
    return refused("{}: nobody can listen there: {}", path, reason_of(errno));
  return listening;
}

class ArmAtCable {
 public:
  ArmAtCable(drivers::laboratory::LabArm& arm, FileDescriptor listening)
      : arm_(arm), listening_(std::move(listening)) {}

  // Waits at most so long for somebody to connect or to command; what is new goes both ways.
  void work(Duration longest) {
    const timespec wait{0, static_cast<long>(std::max<std::int64_t>(0, longest.count()))};
    std::array<pollfd, 2> items{{{listening_.get(), POLLIN, 0}, {client_.get(), POLLIN, 0}}};
    if (ppoll(items.data(), items.size(), &wait, nullptr) > 0) {
      if (items[0].revents != 0 && !client_)
        client_ = FileDescriptor(accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (items[1].revents != 0) take_force();
    }
  }

  void look() {
    const auto sample = arm_.read();
    if (sample.stamp != last_) release_.add(clock_.now() - sample.waited, sample);
    last_ = sample.stamp;
  }
  void send_readings() {
    while (const auto sample = release_.take(clock_.now())) send_reading(*sample);
  }
  // Until which one may sleep.
  Instant<TrueTime> next() const {
    const auto look = clock_.now() + kReadingLook;
    return std::min(look, release_.next().value_or(look));
  }

 private:
  void send_reading(const device::ArmSample& sample) {
    hd_stub::ArmReading reading;
    reading.number = ++readings_;
    std::copy_n(sample.joints.data(), 3, reading.turned);
    // In the library's sense: right, up, clockwise.
    reading.gimbal[0] = sample.gimbal[0];
    reading.gimbal[1] = -sample.gimbal[1];
    reading.gimbal[2] = -sample.gimbal[2];
    reading.buttons = sample.buttons;
    if (client_ && send(client_.get(), &reading, sizeof reading, MSG_NOSIGNAL | MSG_DONTWAIT) < 0 &&
        errno != EAGAIN)
      leave();
  }
  void take_force() {
    hd_stub::ArmForce force;
    const auto got = recv(client_.get(), &force, sizeof force, MSG_DONTWAIT);
    if (got == static_cast<ssize_t>(sizeof force)) return arm_.command(Vector3(force.force));
    if (got >= 0 || (errno != EAGAIN && errno != EINTR)) leave();
  }
  void leave() {
    arm_.command(Vector3::Zero());
    client_.close();
  }

  const MonotonicClock<TrueTime> clock_;
  drivers::laboratory::LabArm& arm_;
  Release<device::ArmSample> release_{kArmTakes};
  FileDescriptor listening_, client_;
  Instant<ArmClock> last_;
  std::uint64_t readings_ = 0;
};

}  // namespace

Expected<void> serve_arm(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                         const std::string& path, const std::atomic<bool>& stop, void (*ready)()) {
  auto arm = drivers::laboratory::LabArm::open(laboratory);
  if (!arm) return tl::unexpected(arm.error());
  auto listening = listen_at(path);
  if (!listening) return tl::unexpected(listening.error());
  ArmAtCable cable(**arm, std::move(*listening));
  enter_real_time(70);  // a device's own electronics wait for nobody
  const MonotonicClock<TrueTime> clock;
  ready();
  while (!stop && laboratory->alive()) {
    cable.look();
    cable.send_readings();
    cable.work(cable.next() - clock.now());
  }
  unlink(path.c_str());
  return {};
}

}  // namespace palpate::doors
