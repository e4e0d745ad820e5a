// What lies in the memory that the simulated laboratory shares with the servers: used by lab_channel.cpp
// only.
//
// Raw device samples, forces and hand targets; never truth. Every part is a ring or mailbox of its own with
// one writer (memory model: palpate/core/broadcast_ring.h). Laid out for processes of the same build on one
// machine; `version` and the sizes in the header say so and are checked. Behind LabMemory follow the images,
// see ImageSlots.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

#include "palpate/core/broadcast_ring.h"
#include "palpate/core/expected.h"
#include "palpate/device/devices.h"

namespace palpate::drivers::laboratory {

inline constexpr std::uint64_t kMagic = 0x62616c2d70616c70;  // "plap-lab" as it lies in memory
inline constexpr std::uint32_t kVersion = 9;
inline constexpr std::size_t kPeers = 16;
inline constexpr std::uint32_t kImageSlots = 4;
// After this long without a heartbeat a process is silent; it is gone when it has ended, or after this much
// longer.
inline constexpr std::int64_t kSilenceNs = 1'000'000'000, kPatienceNs = 10'000'000'000;

struct ArmWire {
  std::int64_t stamp_ns = 0;
  std::array<double, 3> joints{}, gimbal{};
  std::int64_t read_ns = 0;  // CLOCK_MONOTONIC, when the readings were made
  std::array<double, 3> held{};
  std::int64_t holds = 0;  // whether `held` is told
};
struct ForceWire {
  std::int64_t sent_ns = 0;  // CLOCK_MONOTONIC
  std::array<double, 3> force{};
};
struct TrackerWire {
  std::int64_t stamp_ns = 0;
  std::int32_t marker = 0, seen = 0, leds = 0, unused = 0;
  std::array<double, 4> rotation{};  // w x y z
  std::array<double, 3> translation{};
  std::array<double, 36> covariance{};  // row by row
  std::array<double, 9> systematic{};
  std::int64_t arrived_ns = 0;  // CLOCK_MONOTONIC
};
struct HandWire {
  std::array<double, 3> tip{}, velocity{};
  std::array<double, 4> rotation{};  // w x y z
  std::int64_t head_still = 0;
};
struct TimecodeWire {
  std::int64_t sent_ns = 0, code_ns = 0;  // sent: CLOCK_MONOTONIC
};
struct ImageWire {
  std::int64_t mid_exposure_ns = 0;
  std::uint64_t frame = 0;
  std::int32_t width = 0, height = 0;  // px; at most the laboratory's (fits())
  std::int64_t arrived_ns = 0;         // CLOCK_MONOTONIC
};

struct Peer {
  std::atomic<std::int32_t> pid{0};  // 0: free
  std::atomic<std::int64_t> beat_ns{0};
};

struct LabMemory {
  std::uint64_t magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t memory_size = 0;  // of this struct
  std::uint64_t total_size = 0;   // of the file
  std::int32_t cameras = 0, width = 0, height = 0;
  std::int32_t server_pid = 0;
  std::int64_t states_place = 0;  // whether the arm's readings are a place, m

  std::atomic<std::int64_t> beat_ns{0};
  std::atomic<std::uint32_t> closed{0};
  std::array<Peer, kPeers> peers{};
  std::atomic<std::uint32_t> arm_holder{0}, hand_holder{0},
      display_holder{0};  // index of the peer + 1; 0: nobody

  std::atomic<std::uint64_t> let_go{0};  // forces up to this count are given no more
  Mailbox<ArmWire> arm;
  Mailbox<ForceWire> force;
  Mailbox<HandWire> hand;
  BroadcastRing<TrackerWire, 1024> tracker;   // three markers at 100 Hz: 3.4 s
  BroadcastRing<TimecodeWire, 4096> display;  // each millisecond: 4 s
};

// The image ring of one camera, over memory that is all atomic words:
// [count] then kImageSlots x [state, ImageWire, pixels]. The sequence lock is BroadcastRing's; the ring is another, as a
// slot's size is that of the images, known at run time.
class ImageSlots {
 public:
  ImageSlots(AtomicWord* words, std::size_t pixels_bytes) : words_(words), bytes_(pixels_bytes) {}
  static std::size_t words_needed(std::size_t bytes) { return 8 + kImageSlots * stride(bytes); }

  // As many pixels as the info says.
  void push(const ImageWire& info, const std::uint8_t* pixels) noexcept;
  std::uint64_t count() const noexcept { return words_[0].load(std::memory_order_acquire); }
  bool read(std::uint64_t k, ImageWire& info, std::uint8_t* pixels) const noexcept;

 private:
  static std::size_t stride(std::size_t bytes) {
    return (1 + words_for(sizeof(ImageWire)) + words_for(bytes) + 7) / 8 * 8;
  }
  AtomicWord* slot(std::uint64_t k) const { return words_ + 8 + (k % kImageSlots) * stride(bytes_); }
  AtomicWord* words_;
  std::size_t bytes_;
};

struct Layout {
  int cameras = 0, width = 0, height = 0;  // px; as read and checked once
  bool states_place = false;
};
std::size_t total_size(const Layout& layout);

// A file mapped for reading and writing; unmapped at the end. Whoever else writes into it can write anything:
// places and sizes come from the layout that was checked, and every number from the memory is looked at before it
// is used as one.
class Mapping {
 public:
  Mapping() = default;
  Mapping(void* address, std::size_t size, const Layout& layout)
      : address_(address), size_(size), layout_(layout) {}
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();
  LabMemory* memory() const { return static_cast<LabMemory*>(address_); }
  const Layout& layout() const { return layout_; }
  ImageSlots image_slots(int camera) const;

 private:
  void* address_ = nullptr;
  std::size_t size_ = 0;
  Layout layout_;
};

// Letters, digits, '.', '_' and '-', at most 64, not beginning with a dot.
Expected<std::filesystem::path> file_of(const std::string& name, const std::filesystem::path& folder);
Expected<Mapping> create(const std::filesystem::path& file, const Layout& layout);
Expected<Mapping> attach(const std::string& name, const std::filesystem::path& file);

ArmWire pack(const device::ArmSample& sample);
device::ArmSample unpack(const ArmWire& wire);
TrackerWire pack(const device::TrackerSample& sample);
// Nothing where the numbers are no sample.
std::optional<device::TrackerSample> unpack(const TrackerWire& wire);
HandWire pack(const device::HandTarget& target);
std::optional<device::HandTarget> unpack(const HandWire& wire);  // the same
bool fits(const ImageWire& info, const Layout& layout);

}  // namespace palpate::drivers::laboratory
