#include "drivers/laboratory/memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "palpate/core/file_descriptor.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/system_error.h"

namespace palpate::drivers::laboratory {
namespace {

std::size_t image_bytes(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3;
}

std::size_t image_offset() { return (sizeof(LabMemory) + 63) / 64 * 64; }

}  // namespace

std::size_t total_size(const Layout& layout) {
  return image_offset() + static_cast<std::size_t>(layout.cameras) *
                              ImageSlots::words_needed(image_bytes(layout.width, layout.height)) * 8;
}

ImageSlots Mapping::image_slots(int camera) const {
  const std::size_t bytes = image_bytes(layout_.width, layout_.height);
  auto* words = reinterpret_cast<AtomicWord*>(static_cast<char*>(address_) + image_offset());
  return {words + static_cast<std::size_t>(camera) * ImageSlots::words_needed(bytes), bytes};
}

namespace {
std::size_t bytes_of(const ImageWire& info, std::size_t most) {
  return std::min(most, 3 * static_cast<std::size_t>(std::max(info.width, 0)) *
                            static_cast<std::size_t>(std::max(info.height, 0)));
}
}  // namespace

void ImageSlots::push(const ImageWire& info, const std::uint8_t* pixels) noexcept {
  const std::uint64_t k = words_[0].load(std::memory_order_relaxed);
  AtomicWord* words = slot(k);
  sequence_lock::begin_entry(words[0], k);
  store_words(words + 1, &info, sizeof info);
  store_words(words + 1 + words_for(sizeof info), pixels, bytes_of(info, bytes_));
  sequence_lock::end_entry(words[0], k);
  words_[0].store(k + 1, std::memory_order_release);
}

bool ImageSlots::read(std::uint64_t k, ImageWire& info, std::uint8_t* pixels) const noexcept {
  const AtomicWord* words = slot(k);
  if (!sequence_lock::holds_entry(words[0], k)) return false;
  load_words(&info, words + 1, sizeof info);
  load_words(pixels, words + 1 + words_for(sizeof info), bytes_of(info, bytes_));
  return sequence_lock::still_holds_entry(words[0], k);
}

Mapping::Mapping(Mapping&& other) noexcept
    : address_(std::exchange(other.address_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      layout_(other.layout_) {}
Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(address_, other.address_);
  std::swap(size_, other.size_);
  std::swap(layout_, other.layout_);
  return *this;
}
Mapping::~Mapping() {
  if (address_ != nullptr) munmap(address_, size_);
}

Expected<std::filesystem::path> file_of(const std::string& name, const std::filesystem::path& folder) {
  const bool plain =
      name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
      std::string::npos;
  if (name.empty() || name.size() > 64 || name.front() == '.' || !plain)
    return wrong_use("laboratory '{}': expected a name of 1 to 64 letters, digits, '.', '_', '-'", name);
  const auto place = folder.empty() ? run_directory() : private_directory(folder);
  if (!place) return tl::unexpected(place.error());
  return *place / (name + ".lab");
}

// Made whole under another name, then renamed: a client never sees half a laboratory. The caller holds the
// lock, so nobody else works on either name.
Expected<Mapping> create(const std::filesystem::path& file, const Layout& layout) {
  const std::filesystem::path draft = file.string() + ".new";
  unlink(draft.c_str());
  const FileDescriptor fd(::open(draft.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) return refused("{}: cannot make shared memory: {}", draft.string(), reason_of(errno));
  const std::size_t size = total_size(layout);
  // Reserved now: a memory file that cannot grow later would kill whoever touches it.
  const int no_room = posix_fallocate(fd.get(), 0, static_cast<off_t>(size));
  void* address =
      no_room == 0 ? mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, fd.get(), 0) : MAP_FAILED;
  if (address == MAP_FAILED) {
    const int reason = no_room != 0 ? no_room : errno;
    unlink(draft.c_str());
    return refused("{}: cannot have {} bytes of shared memory: {}", file.string(), size, reason_of(reason));
  }
  Mapping mapping(address, size, layout);
  auto* memory = new (address) LabMemory;
  memory->memory_size = sizeof(LabMemory);
  memory->total_size = size;
  memory->cameras = layout.cameras;
  memory->width = layout.width;
  memory->height = layout.height;
  memory->states_place = layout.states_place ? 1 : 0;
  memory->server_pid = static_cast<std::int32_t>(getpid());
  if (rename(draft.c_str(), file.c_str()) != 0) {
    const int reason = errno;
    unlink(draft.c_str());
    return refused("{}: cannot put shared memory in place: {}", file.string(), reason_of(reason));
  }
  return mapping;
}

Expected<Mapping> attach(const std::string& name, const std::filesystem::path& file) {
  const FileDescriptor fd(::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!fd && errno == ENOENT)
    return refused("laboratory '{}' is not there (looked for {}): start it with palpate world run", name,
                   file.string());
  if (!fd) return refused("laboratory '{}': cannot open {}: {}", name, file.string(), reason_of(errno));
  struct stat info {};
  if (fstat(fd.get(), &info) != 0 || !S_ISREG(info.st_mode) || info.st_uid != geteuid())
    return refused("laboratory '{}': {} is not a file of this user", name, file.string());
  const auto size = static_cast<std::size_t>(info.st_size);
  if (size < sizeof(LabMemory))
    return refused("laboratory '{}': {} has {} bytes, expected at least {}: not a laboratory of this build",
                   name, file.string(), size, sizeof(LabMemory));
  void* address = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, fd.get(), 0);
  if (address == MAP_FAILED)
    return refused("laboratory '{}': cannot map {}: {}", name, file.string(), reason_of(errno));
  const auto& m = *static_cast<const LabMemory*>(address);
  const Layout layout{m.cameras, m.width, m.height, m.states_place != 0};
  Mapping mapping(address, size, layout);
  const bool sane = m.magic == kMagic && layout.cameras >= 1 && layout.cameras <= 2 && layout.width > 0 &&
                    layout.width <= 8192 && layout.height > 0 && layout.height <= 8192;
  if (!sane) return refused("laboratory '{}': {} does not hold a laboratory; remove it", name, file.string());
  if (m.version != kVersion || m.memory_size != sizeof(LabMemory))
    return refused(
        "laboratory '{}': served by another build (layout {} of {} bytes, expected {} of {}); use the same "
        "build on both sides",
        name, m.version, m.memory_size, kVersion, sizeof(LabMemory));
  if (m.total_size != size || size != total_size(layout))
    return refused("laboratory '{}': {} has {} bytes, expected {}; remove it", name, file.string(), size,
                   total_size(layout));
  return mapping;
}

namespace {

std::array<double, 3> array(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
std::array<double, 4> array(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
Vector3 vector(const std::array<double, 3>& a) { return Vector3(a.data()); }
Quaternion quaternion(const std::array<double, 4>& a) { return {a[0], a[1], a[2], a[3]}; }

}  // namespace

ArmWire pack(const device::ArmSample& sample) {
  ArmWire wire{.stamp_ns = sample.stamp.ns(), .joints = array(sample.joints), .gimbal = array(sample.gimbal)};
  if (sample.held) {
    wire.held = array(*sample.held);
    wire.holds = 1;
  }
  return wire;
}
device::ArmSample unpack(const ArmWire& wire) {
  device::ArmSample sample{
      .stamp = {Duration(wire.stamp_ns)}, .joints = vector(wire.joints), .gimbal = vector(wire.gimbal)};
  if (wire.holds != 0) sample.held = vector(wire.held);
  return sample;
}

TrackerWire pack(const device::TrackerSample& sample) {
  TrackerWire wire{.stamp_ns = sample.stamp.ns(),
                   .marker = static_cast<std::int32_t>(sample.marker),
                   .seen = sample.seen ? 1 : 0,
                   .leds = sample.leds,
                   .rotation = array(sample.rotation),
                   .translation = array(sample.translation)};
  for (int i = 0; i < 36; ++i) wire.covariance[static_cast<std::size_t>(i)] = sample.covariance(i / 6, i % 6);
  for (int i = 0; i < 9; ++i) wire.systematic[static_cast<std::size_t>(i)] = sample.systematic(i / 3, i % 3);
  return wire;
}
std::optional<device::TrackerSample> unpack(const TrackerWire& wire) {
  constexpr auto kLastMarker = static_cast<std::int32_t>(device::MarkerId::pointer);
  if (wire.marker < 0 || wire.marker > kLastMarker) return std::nullopt;
  device::TrackerSample sample{.stamp = {Duration(wire.stamp_ns)},
                               .marker = static_cast<device::MarkerId>(wire.marker),
                               .seen = wire.seen != 0,
                               .rotation = quaternion(wire.rotation),
                               .translation = vector(wire.translation),
                               .leds = wire.leds};
  for (int i = 0; i < 36; ++i) sample.covariance(i / 6, i % 6) = wire.covariance[static_cast<std::size_t>(i)];
  for (int i = 0; i < 9; ++i) sample.systematic(i / 3, i % 3) = wire.systematic[static_cast<std::size_t>(i)];
  const bool sound = sample.rotation.coeffs().allFinite() && sample.translation.allFinite() &&
                     sample.covariance.allFinite() && sample.systematic.allFinite();
  return sample.seen && !sound ? std::nullopt : std::optional(sample);
}

HandWire pack(const device::HandTarget& target) {
  return {array(target.tip.m), array(target.velocity), array(target.R_world_tip), target.head_still ? 1 : 0};
}
std::optional<device::HandTarget> unpack(const HandWire& wire) {
  const device::HandTarget target{Point<World>{vector(wire.tip)}, vector(wire.velocity),
                                  quaternion(wire.rotation), wire.head_still != 0};
  const bool sound =
      target.tip.m.allFinite() && target.velocity.allFinite() && target.R_world_tip.coeffs().allFinite();
  return sound ? std::optional(target) : std::nullopt;
}

bool fits(const ImageWire& info, const Layout& layout) {
  return info.width > 0 && info.width <= layout.width && info.height > 0 && info.height <= layout.height;
}

}  // namespace palpate::drivers::laboratory
