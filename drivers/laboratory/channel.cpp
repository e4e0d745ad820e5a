#include "drivers/laboratory/channel.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/laboratory/memory.h"
#include "palpate/core/file_lock.h"
#include "palpate/core/system_error.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::laboratory {
namespace {

std::int64_t monotonic_ns() { return MonotonicClock<TrueTime>::monotonic_ns(); }

// Whether it has ended, waited for by its parent or not.
bool process_gone(std::int32_t pid) {
  if (pid == 0) return false;
  if (kill(pid, 0) != 0) return errno == ESRCH;
  char line[512] = {};
  const FileDescriptor file(::open(fmt::format("/proc/{}/stat", pid).c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return false;
  const ssize_t length = ::read(file.get(), line, sizeof line - 1);
  if (length <= 0) return false;
  const char* name_end = std::strrchr(line, ')');  // "pid (name) state ..."
  return name_end != nullptr && name_end[1] == ' ' && name_end[2] == 'Z';
}

// Takes what only one client may have: from nobody, or from a process that is no more.
Expected<void> take(std::atomic<std::uint32_t>& holder, const LabClient& client, const char* what) {
  std::uint32_t current = holder.load();
  while (true) {
    if (current != 0 && current <= kPeers) {
      const std::int32_t pid = client.memory()->peers[current - 1].pid.load();
      if (pid != 0 && !process_gone(pid))
        return refused("the {} of laboratory '{}' is held by process {}: stop it first", what, client.name(),
                       pid);
    }
    if (holder.compare_exchange_weak(current, client.peer() + 1)) return {};
  }
}

// Where a reader goes on that has come as far as `next` of `count` entries: at the oldest of the last `kept`.
// Whatever the memory says of its count, no more than a ring is looked through.
std::uint64_t next_within(std::uint64_t kept, std::uint64_t next, std::uint64_t count) {
  return std::clamp(next, count - std::min(count, kept), count);
}

void give_up(std::atomic<std::uint32_t>& holder, const LabClient& client) {
  std::uint32_t mine = client.peer() + 1;
  holder.compare_exchange_strong(mine, 0);
}

std::filesystem::path lock_of(const std::filesystem::path& file) { return file.string() + ".lock"; }

}  // namespace

// --- server

Expected<std::unique_ptr<LabServer>> LabServer::open(const std::string& name, const LabSettings& settings) {
  if (settings.cameras < 1 || settings.cameras > 2 || settings.width < 1 || settings.width > 8192 ||
      settings.height < 1 || settings.height > 8192)
    return wrong_use("laboratory '{}': {} cameras of {} x {} pixels, expected 1 or 2 of at most 8192 x 8192",
                     name, settings.cameras, settings.width, settings.height);
  const auto file = file_of(name, settings.folder);
  if (!file) return tl::unexpected(file.error());
  auto lock = lock_file(lock_of(*file));
  if (!lock) return tl::unexpected(lock.error());
  if (!*lock)
    return refused(
        "laboratory '{}': address in use: another process serves {}; stop it or choose another name", name,
        file->string());
  auto mapping =
      create(*file, Layout{settings.cameras, settings.width, settings.height, settings.states_place});
  if (!mapping) return tl::unexpected(mapping.error());
  return std::unique_ptr<LabServer>(
      new LabServer(std::make_unique<Mapping>(std::move(*mapping)), *file, std::move(**lock)));
}

LabServer::LabServer(std::unique_ptr<Mapping> mapping, std::filesystem::path file, FileDescriptor lock)
    : mapping_(std::move(mapping)),
      memory_(mapping_->memory()),
      file_(std::move(file)),
      lock_(std::move(lock)),
      arm_silence_(kSilenceNs),
      hand_silence_(kSilenceNs) {
  heartbeat();
}

LabServer::~LabServer() {
  memory_->closed.store(1, std::memory_order_release);
  unlink(file_.c_str());
  unlink(lock_of(file_).c_str());  // while it is still held
}

void LabServer::heartbeat() noexcept { memory_->beat_ns.store(monotonic_ns(), std::memory_order_release); }

void LabServer::publish_arm(const device::ArmSample& sample) noexcept {
  ArmWire wire = pack(sample);
  wire.read_ns = monotonic_ns() - sample.waited.count();
  memory_->arm.write(wire);
}

std::optional<ForceCommand> LabServer::take_force() const noexcept {
  ForceWire wire;
  const std::uint64_t count = memory_->force.count();
  if (!memory_->force.read(wire)) return std::nullopt;
  const Duration age(monotonic_ns() - wire.sent_ns);
  if (count <= memory_->let_go.load()) return ForceCommand{Vector3::Zero(), age, count, true};
  return ForceCommand{Vector3(wire.force.data()), age, count};
}

void LabServer::publish_tracker(const device::TrackerSample& sample) noexcept {
  TrackerWire wire = pack(sample);
  wire.arrived_ns = monotonic_ns() - sample.waited.count();
  memory_->tracker.push(wire);
}

bool LabServer::publish_image(const device::CameraImage& image, int camera) noexcept {
  const ImageWire info{image.mid_exposure.ns(), image.frame, image.width, image.height,
                       monotonic_ns() - image.waited.count()};
  const Layout& layout = mapping_->layout();
  if (camera < 0 || camera >= layout.cameras || !fits(info, layout) ||
      image.rgb.size() != 3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height))
    return false;
  mapping_->image_slots(camera).push(info, image.rgb.data());
  return true;
}

std::optional<device::HandTarget> LabServer::take_hand_target() noexcept {
  const std::uint64_t count = memory_->hand.count();
  HandWire wire;
  if (count == hand_targets_ || !memory_->hand.read(wire)) return std::nullopt;
  hand_targets_ = count;
  return unpack(wire);
}

std::vector<ShownTimecode> LabServer::take_timecodes() {
  const auto& ring = memory_->display;
  const std::uint64_t count = ring.count();
  timecodes_ = next_within(ring.capacity() - 1, timecodes_, count);
  std::vector<ShownTimecode> timecodes;
  TimecodeWire wire;
  for (; timecodes_ < count; ++timecodes_)
    if (ring.read(timecodes_, wire)) timecodes.push_back({wire.sent_ns, Duration(wire.code_ns)});
  return timecodes;
}

LabServer::Peers LabServer::peers() noexcept {
  Peers peers;
  const std::int64_t now = monotonic_ns();
  for (const Peer& peer : memory_->peers)
    peers.clients += peer.pid.load() != 0 && now - peer.beat_ns.load() < kSilenceNs;
  const auto held = [&](const std::atomic<std::uint32_t>& holder, device::HeartbeatMonitor& silence) {
    const std::uint32_t index = holder.load();
    return index != 0 && index <= kPeers && !silence.gone(now, memory_->peers[index - 1].beat_ns.load());
  };
  peers.arm = held(memory_->arm_holder, arm_silence_);
  peers.hand = held(memory_->hand_holder, hand_silence_);
  peers.arm_lost = !peers.arm && memory_->arm_holder.load() != 0;
  return peers;
}

// --- clients

Expected<std::shared_ptr<LabClient>> LabClient::open(const std::string& name,
                                                     const std::filesystem::path& folder) {
  const auto file = file_of(name, folder);
  if (!file) return tl::unexpected(file.error());
  auto mapping = attach(name, *file);
  if (!mapping) return tl::unexpected(mapping.error());
  auto held = std::make_unique<Mapping>(std::move(*mapping));
  LabMemory* memory = held->memory();
  for (std::uint32_t i = 0; i < kPeers; ++i) {
    Peer& peer = memory->peers[i];
    std::int32_t pid = peer.pid.load();
    if (pid != 0 && !process_gone(pid)) continue;
    if (!peer.pid.compare_exchange_strong(pid, static_cast<std::int32_t>(getpid()))) continue;
    // What a process held that died in this place is nobody's now.
    std::uint32_t left_behind = i + 1;
    memory->arm_holder.compare_exchange_strong(left_behind, 0);
    left_behind = i + 1;
    memory->hand_holder.compare_exchange_strong(left_behind, 0);
    left_behind = i + 1;
    memory->display_holder.compare_exchange_strong(left_behind, 0);
    std::shared_ptr<LabClient> client(new LabClient(name, std::move(held), i));
    if (const auto living = client->check(); !living) return tl::unexpected(living.error());
    return client;
  }
  return refused("laboratory '{}': {} clients already, no more places: stop one", name, kPeers);
}

LabClient::LabClient(std::string name, std::unique_ptr<Mapping> mapping, std::uint32_t peer)
    : name_(std::move(name)),
      mapping_(std::move(mapping)),
      memory_(mapping_->memory()),
      peer_(peer),
      silence_(kSilenceNs) {
  heartbeat();
}

LabClient::~LabClient() {
  memory_->peers[peer_].beat_ns.store(0);
  memory_->peers[peer_].pid.store(0);
}

void LabClient::heartbeat() noexcept {
  memory_->peers[peer_].beat_ns.store(monotonic_ns(), std::memory_order_relaxed);
}

bool LabClient::alive() noexcept {
  if (memory_->closed.load(std::memory_order_acquire) != 0) return false;
  const std::int64_t beat = memory_->beat_ns.load(std::memory_order_acquire), now = monotonic_ns();
  silent_ = silence_.gone(now, beat);
  return !silent_ || (now - beat < kPatienceNs && !process_gone(memory_->server_pid));
}

Expected<void> LabClient::check() {
  if (alive()) return {};
  if (memory_->closed.load() != 0)
    return refused("laboratory '{}' has been closed: start it with palpate world run", name_);
  return refused(
      "laboratory '{}' has been silent for {:.1f} s, expected a sign of life every second: process {} has "
      "died or stands still; start it again with palpate world run",
      name_, static_cast<double>(monotonic_ns() - memory_->beat_ns.load()) * 1e-9, memory_->server_pid);
}

int LabClient::cameras() const noexcept { return mapping_->layout().cameras; }
bool LabClient::states_place() const noexcept { return mapping_->layout().states_place; }
const Mapping& LabClient::mapping() const noexcept { return *mapping_; }

LabArm::LabArm(std::shared_ptr<LabClient> client) : client_(std::move(client)), memory_(client_->memory()) {}

Expected<std::unique_ptr<LabArm>> LabArm::open(std::shared_ptr<LabClient> client) {
  if (const auto taken = take(client->memory()->arm_holder, *client, "arm"); !taken)
    return tl::unexpected(taken.error());
  std::unique_ptr<LabArm> arm(new LabArm(std::move(client)));
  arm->command(Vector3::Zero());
  // A device that has nothing to say yet would have to invent its first sample.
  const std::int64_t until = monotonic_ns() + kSilenceNs;
  while (arm->client_->memory()->arm.count() == 0) {
    if (monotonic_ns() > until)
      return refused("the arm of laboratory '{}' gave no sample within a second", arm->client_->name());
    usleep(1000);
  }
  return arm;
}

LabArm::~LabArm() {
  command(Vector3::Zero());
  give_up(client_->memory()->arm_holder, *client_);
}

device::ArmSample LabArm::read() {
  client_->heartbeat();
  ArmWire wire;
  const bool there = client_->memory()->arm.read(wire);  // open() has seen that there is one
  device::ArmSample sample = unpack(wire);
  sample.waited = Duration(std::max<std::int64_t>(0, monotonic_ns() - wire.read_ns));
  sample.connected = there && client_->memory()->closed.load(std::memory_order_acquire) == 0;
  return sample;
}

void LabArm::command(const Vector3& force) {
  client_->heartbeat();
  client_->memory()->force.write({monotonic_ns(), {force.x(), force.y(), force.z()}});
}

void LabArm::let_go() noexcept { memory_->let_go.store(memory_->force.count()); }

LabTracker::LabTracker(std::shared_ptr<LabClient> client)
    : client_(std::move(client)), next_(client_->memory()->tracker.count()) {}

std::vector<device::TrackerSample> LabTracker::poll() {
  client_->heartbeat();
  const auto& ring = client_->memory()->tracker;
  std::vector<device::TrackerSample> samples;
  TrackerWire wire;
  const std::uint64_t count = ring.count(), first = next_within(ring.capacity(), next_, count);
  lost_ += first - std::min(next_, first);
  for (next_ = first; next_ < count; ++next_) {
    const auto sample =
        ring.read(next_, wire) ? unpack(wire) : std::optional<device::TrackerSample>(std::nullopt);
    if (!sample) {
      ++lost_;
      continue;
    }
    samples.push_back(*sample);
    samples.back().waited = Duration(std::max<std::int64_t>(0, monotonic_ns() - wire.arrived_ns));
  }
  return samples;
}

Expected<std::unique_ptr<LabCamera>> LabCamera::open(std::shared_ptr<LabClient> client, int camera) {
  if (camera < 0 || camera >= client->cameras())
    return wrong_use("laboratory '{}': no camera {}, it has {}", client->name(), camera, client->cameras());
  return std::unique_ptr<LabCamera>(new LabCamera(std::move(client), camera));
}

LabCamera::LabCamera(std::shared_ptr<LabClient> client, int camera)
    : client_(std::move(client)), camera_(camera), next_(client_->mapping().image_slots(camera).count()) {}

std::optional<device::CameraImage> LabCamera::poll() {
  client_->heartbeat();
  const Layout& layout = client_->mapping().layout();
  const ImageSlots slots = client_->mapping().image_slots(camera_);
  ImageWire info;
  device::CameraImage image;
  constexpr int kTries = 8;
  for (int i = 0; i < kTries && slots.count() > next_; ++i) {
    if (image.rgb.empty()) image.rgb = spare_.take();
    image.rgb.resize(static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height) * 3);
    const std::uint64_t newest = slots.count() - 1;
    if (!slots.read(newest, info, image.rgb.data())) continue;  // lapped by four images: there is a newer one
    next_ = newest + 1;
    if (!fits(info, layout)) continue;
    image.mid_exposure = {Duration(info.mid_exposure_ns)};
    image.frame = info.frame;
    image.width = info.width;
    image.height = info.height;
    image.waited = Duration(monotonic_ns() - info.arrived_ns);  // the copying, too: asked for is what one has
    image.rgb.resize(3 * static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height));
    return image;
  }
  take_back(std::move(image));
  return std::nullopt;
}

Expected<std::unique_ptr<LabHand>> LabHand::open(std::shared_ptr<LabClient> client) {
  if (const auto taken = take(client->memory()->hand_holder, *client, "hand"); !taken)
    return tl::unexpected(taken.error());
  return std::unique_ptr<LabHand>(new LabHand(std::move(client)));
}

LabHand::~LabHand() { give_up(client_->memory()->hand_holder, *client_); }

void LabHand::move_to(const device::HandTarget& target) {
  client_->heartbeat();
  client_->memory()->hand.write(pack(target));
}

Expected<std::unique_ptr<LabDisplay>> LabDisplay::open(std::shared_ptr<LabClient> client) {
  if (const auto taken = take(client->memory()->display_holder, *client, "display"); !taken)
    return tl::unexpected(taken.error());
  return std::unique_ptr<LabDisplay>(new LabDisplay(std::move(client)));
}

LabDisplay::~LabDisplay() { give_up(client_->memory()->display_holder, *client_); }

std::int64_t LabDisplay::show_timecode(Duration code) {
  client_->heartbeat();
  const std::int64_t now = monotonic_ns();
  client_->memory()->display.push({now, code.count()});
  return now;
}

}  // namespace palpate::drivers::laboratory
