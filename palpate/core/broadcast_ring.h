// A ring that one thread writes and any number of threads (or processes, in shared memory) read without
// locks; and a mailbox, the same thing when only the newest value matters.
//
// Memory model. Each slot is a sequence lock whose payload is made of atomic words, so there is no data race
// to begin with and the thread sanitizer has nothing to excuse. Entry k is valid while its slot's state reads
// 2k + 2. The writer first makes the state odd, then stores the words with release order: whoever loads such
// a word (acquire) also sees the odd state, or a later one, and throws the copy away. No fences (the
// sanitizer cannot follow them); on x86 the orders used cost nothing. After Boehm, "Can seqlocks get along
// with programming language memory models?", MSPC 2012.
//
// The newest entry is never the slot being written, so a reader does not wait for a writer that was put to
// sleep in the middle of a write (as it would with a single slot): a real-time thread may read. push() and
// read() do not allocate, lock or throw. All-zero memory is an empty ring. A writer that died in the middle
// of a write loses that one entry; its successor goes on at the same place.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <optional>
#include <type_traits>

namespace palpate::inline core {

using AtomicWord = std::atomic<std::uint64_t>;
static_assert(AtomicWord::is_always_lock_free && sizeof(AtomicWord) == sizeof(std::uint64_t));

inline constexpr std::size_t words_for(std::size_t bytes) { return (bytes + 7) / 8; }

// Copies through atomic words; `to` resp. `from` holds words_for(bytes) of them.
inline void store_words(AtomicWord* to, const void* from, std::size_t bytes) noexcept {
  const char* source = static_cast<const char*>(from);
  std::size_t i = 0;
  for (; i < bytes / 8; ++i) {
    std::uint64_t word;
    std::memcpy(&word, source + 8 * i, 8);
    to[i].store(word, std::memory_order_release);
  }
  if (bytes % 8 != 0) {
    std::uint64_t word = 0;
    std::memcpy(&word, source + 8 * i, bytes % 8);
    to[i].store(word, std::memory_order_release);
  }
}

inline void load_words(void* to, const AtomicWord* from, std::size_t bytes) noexcept {
  char* target = static_cast<char*>(to);
  std::size_t i = 0;
  for (; i < bytes / 8; ++i) {
    const std::uint64_t word = from[i].load(std::memory_order_acquire);
    std::memcpy(target + 8 * i, &word, 8);
  }
  if (bytes % 8 != 0) {
    const std::uint64_t word = from[i].load(std::memory_order_acquire);
    std::memcpy(target + 8 * i, &word, bytes % 8);
  }
}

// Room for a T that is about to be copied into: spares setting every byte twice.
template <typename T>
class Room {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  T& value() { return *std::launder(reinterpret_cast<T*>(bytes_)); }

 private:
  alignas(T) unsigned char bytes_[sizeof(T)];
};

// A value whose end often carries nothing: used_bytes() says how many of its first bytes do, clear_unused()
// sets the rest after only these have been copied.
template <typename T>
concept PartlyUsed = requires(T value) {
  { value.used_bytes() }
  noexcept;
  { value.clear_unused() }
  noexcept;
};

// The state word of a slot, and with it the whole protocol: whoever lays out slots elsewhere, as for images of a size that
// is known at run time, uses these as well.
namespace sequence_lock {
inline void begin_entry(AtomicWord& state, std::uint64_t k) noexcept {
  state.store(2 * k + 1, std::memory_order_relaxed);
}
inline void end_entry(AtomicWord& state, std::uint64_t k) noexcept {
  state.store(2 * k + 2, std::memory_order_release);
}
// Before its words are loaded.
inline bool holds_entry(const AtomicWord& state, std::uint64_t k) noexcept {
  return state.load(std::memory_order_acquire) == 2 * k + 2;
}
// After they have been: whether they are all of this entry.
inline bool still_holds_entry(const AtomicWord& state, std::uint64_t k) noexcept {
  return state.load(std::memory_order_relaxed) == 2 * k + 2;
}
}  // namespace sequence_lock

template <typename T, std::size_t N>
class BroadcastRing {
  static_assert(std::is_trivially_copyable_v<T>);
  static_assert(N >= 2, "the newest entry must not be the slot that is written next");

 public:
  static constexpr std::size_t capacity() { return N; }

  // The one writer.
  void push(const T& value) noexcept {
    const std::uint64_t k = count_.load(std::memory_order_relaxed);
    Slot& slot = slots_[k % N];
    sequence_lock::begin_entry(slot.state, k);
    std::size_t bytes = sizeof(T);
    if constexpr (PartlyUsed<T>) {
      bytes = value.used_bytes();
      slot.bytes.store(bytes, std::memory_order_release);
    }
    store_words(slot.words.data(), &value, bytes);
    sequence_lock::end_entry(slot.state, k);
    count_.store(k + 1, std::memory_order_release);
  }

  // How many entries were ever pushed: the newest is count() - 1.
  std::uint64_t count() const noexcept { return count_.load(std::memory_order_acquire); }

  // Copies entry k; false if it has been overwritten (or is not there yet), and `out` is then meaningless.
  bool read(std::uint64_t k, T& out) const noexcept {
    const Slot& slot = slots_[k % N];
    if (!sequence_lock::holds_entry(slot.state, k)) return false;
    std::size_t bytes = sizeof(T);
    if constexpr (PartlyUsed<T>) bytes = slot.bytes.load(std::memory_order_acquire);
    load_words(&out, slot.words.data(), bytes);
    if (!sequence_lock::still_holds_entry(slot.state, k)) return false;
    if constexpr (PartlyUsed<T>) out.clear_unused();
    return true;
  }

 private:
  struct alignas(64) Slot {
    AtomicWord state{0};
    AtomicWord bytes{0};  // where not all of T is copied
    std::array<AtomicWord, words_for(sizeof(T))> words{};
  };
  alignas(64) AtomicWord count_{0};
  std::array<Slot, N> slots_{};
};

// The newest value, from one writer to any number of readers, also of another process that may die or write anything: T is
// plain bytes. What holds matrices or poses goes from one thread to one other by a TripleBuffer
// (palpate/time/triple_buffer.h), which copies T as T, and whose reader never tries twice.
template <typename T>
class Mailbox {
 public:
  void write(const T& value) noexcept { ring_.push(value); }
  // How many values were ever written: a reader sees by it whether there is a new one.
  std::uint64_t count() const noexcept { return ring_.count(); }
  // False while nothing was ever written. Tries again only if the writer went right round the ring meanwhile,
  // and not for ever: in shared memory the count may be anything.
  bool read(T& out) const noexcept {
    constexpr int kTries = 1000;
    for (int i = 0; i < kTries; ++i) {
      const std::uint64_t n = ring_.count();
      if (n == 0) return false;
      if (ring_.read(n - 1, out)) return true;
    }
    return false;
  }
  std::optional<T> newest() const noexcept {
    Room<T> room;
    return read(room.value()) ? std::optional<T>(room.value()) : std::nullopt;
  }

 private:
  BroadcastRing<T, 4> ring_;
};

}  // namespace palpate::inline core
