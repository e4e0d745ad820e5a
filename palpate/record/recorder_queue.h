// Messages on their way from the threads that record to the one that writes: a ring of bytes of a fixed size.
//
// push(): any thread, any number of them; it takes no lock, allocates nothing, calls no system and waits for nobody. Where
// there is no room, the new message is the one that is left out. pop(): one thread. A thread that is stopped in the middle of
// push() holds up the messages behind its own, and nobody who pushes.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/record/mcap.h"

namespace palpate::record {

class RecorderQueue {
 public:
  // Room for this many bytes, 32 of each message among them, and for this many messages. The memory is taken at once.
  RecorderQueue(std::size_t bytes, std::size_t messages)
      : ring_(std::max<std::size_t>(bytes / kWord, 8)), most_messages_(messages) {}

  // False: there is no room.
  bool push(const Message& message) noexcept {
    const std::size_t need = room_of(message.data.size());
    if (need > capacity()) return false;
    if (messages_.fetch_add(1, std::memory_order_relaxed) >= most_messages_) return give_up();
    std::uint64_t at = reserved_.load(std::memory_order_relaxed);
    do {
      // Below zero where `at` is old: then the exchange fails, and gives a newer one.
      const auto used = static_cast<std::int64_t>(at + need - read_.load(std::memory_order_acquire));
      if (used > static_cast<std::int64_t>(capacity())) return give_up();
    } while (!reserved_.compare_exchange_weak(at, at + need, std::memory_order_relaxed));
    const Head head{message.log_time_ns, message.publish_time_ns, message.sequence, message.channel};
    copy_in(at + kWord, &head, sizeof head);
    copy_in(at + kWord + sizeof head, message.data.data(), message.data.size());
    // From here on it can be read. Zero says that it cannot.
    word(at).store(message.data.size() + 1, std::memory_order_release);
    return true;
  }

  // Hands the oldest message to `take`, whose view of the data is valid as long as the call lasts. False: there is none.
  template <typename Take>
  bool pop(Take&& take) {
    const std::uint64_t at = read_.load(std::memory_order_relaxed);
    const std::uint64_t told = word(at).load(std::memory_order_acquire);
    if (told == 0) return false;
    const std::size_t size = told - 1, need = room_of(size);
    Head head;
    copy_out(at + kWord, &head, sizeof head);
    const Message message{head.channel, head.sequence, head.log_time_ns, head.publish_time_ns,
                          view(at + kWord + sizeof head, size)};
    take(message);
    // Whatever comes to stand there says first that it cannot be read yet.
    clear(at, need);
    messages_.fetch_sub(1, std::memory_order_relaxed);
    read_.store(at + need, std::memory_order_release);
    return true;
  }

 private:
  struct Head {
    std::uint64_t log_time_ns, publish_time_ns;
    std::uint32_t sequence;
    std::uint16_t channel;
    std::uint16_t none = 0;
  };
  static constexpr std::size_t kWord = sizeof(std::uint64_t);
  static_assert(sizeof(Head) % kWord == 0);

  static constexpr std::size_t room_of(std::size_t size) {
    return kWord + sizeof(Head) + (size + kWord - 1) / kWord * kWord;
  }
  std::size_t capacity() const { return ring_.size() * kWord; }
  char* bytes() { return reinterpret_cast<char*>(ring_.data()); }
  std::atomic_ref<std::uint64_t> word(std::uint64_t at) {
    return std::atomic_ref<std::uint64_t>(ring_[at % capacity() / kWord]);
  }
  bool give_up() {
    messages_.fetch_sub(1, std::memory_order_relaxed);
    return false;
  }
  // The ring's end cuts what lies across it in two.
  std::size_t until_end(std::uint64_t at, std::size_t size) const {
    return std::min<std::size_t>(size, capacity() - at % capacity());
  }
  void copy_in(std::uint64_t at, const void* from, std::size_t size) {
    if (size == 0) return;
    const std::size_t first = until_end(at, size);
    std::memcpy(bytes() + at % capacity(), from, first);
    if (first < size) std::memcpy(bytes(), static_cast<const char*>(from) + first, size - first);
  }
  void copy_out(std::uint64_t at, void* to, std::size_t size) {
    const std::size_t first = until_end(at, size);
    std::memcpy(to, bytes() + at % capacity(), first);
    if (first < size) std::memcpy(static_cast<char*>(to) + first, bytes(), size - first);
  }
  std::string_view view(std::uint64_t at, std::size_t size) {
    if (until_end(at, size) == size) return {bytes() + at % capacity(), size};
    across_.resize(size);
    copy_out(at, across_.data(), size);
    return across_;
  }
  void clear(std::uint64_t at, std::size_t size) {
    const std::size_t first = until_end(at, size);
    std::memset(bytes() + at % capacity(), 0, first);
    std::memset(bytes(), 0, size - first);
  }

  std::vector<std::uint64_t> ring_;
  const std::size_t most_messages_;
  std::string across_;  // a message that lies across the ring's end
  // Bytes since the beginning, apart, for they are written by different threads.
  alignas(64) std::atomic<std::uint64_t> reserved_{0};
  alignas(64) std::atomic<std::uint64_t> read_{0};
  alignas(64) std::atomic<std::size_t> messages_{0};
};

}  // namespace palpate::record
