#include "palpate/core/broadcast_ring.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace palpate::inline core {
namespace {

struct Block {  // 19 bytes of payload behind a number that the rest must follow from
  std::uint32_t number = 0;
  std::array<std::uint8_t, 15> rest{};
  static Block of(std::uint32_t n) {
    Block b{n, {}};
    for (std::size_t i = 0; i < b.rest.size(); ++i) b.rest[i] = static_cast<std::uint8_t>(n * 31 + i * n);
    return b;
  }
  bool whole() const { return rest == of(number).rest; }
};

TEST(BroadcastRing, KeepsTheLastOnesAndRefusesTheOthers) {
  BroadcastRing<Block, 4> ring;
  Block b;
  EXPECT_EQ(ring.count(), 0u);
  EXPECT_FALSE(ring.read(0, b));
  for (std::uint32_t i = 0; i < 11; ++i) ring.push(Block::of(i));
  EXPECT_EQ(ring.count(), 11u);
  for (std::uint64_t k = 0; k < 7; ++k) EXPECT_FALSE(ring.read(k, b)) << k;
  for (std::uint64_t k = 7; k < 11; ++k) {
    ASSERT_TRUE(ring.read(k, b));
    EXPECT_EQ(b.number, k);
    EXPECT_TRUE(b.whole());
  }
  EXPECT_FALSE(ring.read(11, b));
}

TEST(BroadcastRing, ZeroedMemoryIsAnEmptyRing) {
  using Ring = BroadcastRing<Block, 3>;
  const auto memory = std::make_unique<std::array<unsigned char, sizeof(Ring) + 64>>();
  memory->fill(0);
  void* place = memory->data();
  std::size_t room = memory->size();
  auto* ring = static_cast<Ring*>(std::align(alignof(Ring), sizeof(Ring), place, room));
  EXPECT_EQ(ring->count(), 0u);
  Block b;
  EXPECT_FALSE(ring->read(0, b));
  ring->push(Block::of(9));
  EXPECT_TRUE(ring->read(0, b) && b.number == 9);
}

TEST(BroadcastRing, ReadersBesideAWriterSeeOnlyWholeEntriesInOrder) {
  BroadcastRing<Block, 8> ring;
  constexpr std::uint32_t kEntries = 20'000;
  std::vector<std::thread> readers;
  std::array<std::uint64_t, 3> broken{}, unordered{}, seen{};
  for (std::size_t r = 0; r < 3; ++r)
    readers.emplace_back([&, r] {
      Block b;
      for (std::uint64_t next = 0; next < kEntries;) {
        const std::uint64_t n = ring.count();
        if (n == next) {
          std::this_thread::yield();
          continue;
        }
        if (n > next + 7) next = n - 7;
        if (ring.read(next, b)) {
          broken[r] += !b.whole();
          unordered[r] += b.number != next;
          ++seen[r];
          ++next;
        }
      }
    });
  for (std::uint32_t i = 0; i < kEntries; ++i) {
    ring.push(Block::of(i));
    if (i % 64 == 0) std::this_thread::yield();
  }
  for (auto& t : readers) t.join();
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_EQ(broken[r], 0u);
    EXPECT_EQ(unordered[r], 0u);
    EXPECT_GT(seen[r], 0u);
  }
}

TEST(Mailbox, HoldsTheNewestValueAndSaysWhenThereWasNone) {
  Mailbox<Block> box;
  EXPECT_FALSE(box.newest().has_value());
  for (std::uint32_t i = 1; i < 30; ++i) {
    box.write(Block::of(i));
    EXPECT_EQ(box.newest()->number, i);
    EXPECT_EQ(box.count(), i);
  }
}

TEST(Mailbox, NeverGoesBackForAReader) {
  Mailbox<Block> box;
  std::uint64_t backwards = 0, broken = 0;
  constexpr std::uint32_t kEntries = 20'000;
  std::thread reader([&] {
    Block b;
    for (std::uint32_t last = 0; last + 1 < kEntries;)
      if (box.read(b)) {
        backwards += b.number < last;
        broken += !b.whole();
        last = b.number;
      }
  });
  for (std::uint32_t i = 0; i < kEntries; ++i) box.write(Block::of(i));
  reader.join();
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(broken, 0u);
}

}  // namespace
}  // namespace palpate::inline core
