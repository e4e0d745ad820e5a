// The surface that deforms comes back bit by bit, from whichever whole message on; what is damaged or makes no sense is refused.
#include "palpate/record/session/shape_messages.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "palpate/core/random.h"
#include "palpate_recording.pb.h"

namespace palpate::record::session {
namespace {

constexpr std::size_t kFloats = scene::Shape::kFloatsPerVertex;

bool same(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// Forty vertices; every 33 ms a few of them move, for 12 s.
class MovingSurface {
 public:
  MovingSurface() {
    for (float& value : shape_.values) value = number();
  }
  const scene::Shape& shape() const { return shape_; }
  void move() {
    shape_.time = shape_.time + std::chrono::milliseconds(33);
    const auto moved = static_cast<int>(random_.uniform(0.0, 4.0));
    for (int i = 0; i < moved; ++i) {
      const auto vertex = static_cast<std::size_t>(random_.uniform(0.0, 40.0));
      const auto axis = static_cast<std::size_t>(random_.uniform(0.0, 6.0));
      shape_.values[kFloats * vertex + axis] = number();
    }
  }

 private:
  float number() { return static_cast<float>(random_.normal(1.0)); }
  Random random_{5, "surface"};
  scene::Shape shape_{Instant<PhysicsClock>::from_seconds(1.0), std::vector<float>(40 * kFloats)};
};

TEST(RecordedShape, ComesBackBitByBitWithWhatHasMoved) {
  MovingSurface surface;
  ShapeEncoder encoder;
  ShapeDecoder decoder;
  std::size_t whole = 0, longest = 0, first = 0;
  for (int i = 0; i < 364; ++i, surface.move()) {
    const std::string bytes = encoder.encode(surface.shape());
    const auto taken = decoder.decode(bytes);
    ASSERT_TRUE(taken) << taken.error().message;
    ASSERT_TRUE(*taken);
    ASSERT_TRUE(same(decoder.shape().values, surface.shape().values)) << i;
    ASSERT_EQ(decoder.shape().time, surface.shape().time);
    if (i == 0) first = bytes.size();
    if (bytes.size() == first) ++whole;
    if (bytes.size() != first) longest = std::max(longest, bytes.size());
  }
  EXPECT_EQ(whole, 3u) << "one every 5 s";
  EXPECT_LT(longest, first / 5) << "what stands still costs nothing";
}

TEST(RecordedShape, ATinyChangeAndTheSignOfAZeroArriveAsWell) {
  scene::Shape shape{{}, std::vector<float>(2 * kFloats)};
  ShapeEncoder encoder;
  ShapeDecoder decoder;
  ASSERT_TRUE(decoder.decode(encoder.encode(shape)).value());
  shape.values[7] = -0.0f;
  shape.values[3] = std::numeric_limits<float>::denorm_min();
  shape.time = shape.time + std::chrono::milliseconds(33);
  ASSERT_TRUE(decoder.decode(encoder.encode(shape)).value());
  EXPECT_TRUE(same(decoder.shape().values, shape.values));
}

TEST(RecordedShape, AReaderInTheMiddleBeginsAtTheNextWholeOne) {
  MovingSurface surface;
  ShapeEncoder encoder;
  ShapeDecoder late;
  int in_vain = 0;
  for (int i = 0; i < 364; ++i, surface.move()) {
    const std::string bytes = encoder.encode(surface.shape());
    if (i < 10) continue;
    const auto taken = late.decode(bytes);
    ASSERT_TRUE(taken) << taken.error().message;
    if (!*taken) ++in_vain;
    if (*taken) {
      ASSERT_TRUE(same(late.shape().values, surface.shape().values)) << i;
    }
  }
  EXPECT_EQ(in_vain, 142) << "until 5 s are over";
}

TEST(RecordedShape, WhatMakesNoSenseIsRefusedAndChangesNothing) {
  ShapeEncoder encoder;
  MovingSurface surface;
  ShapeDecoder decoder;
  ASSERT_TRUE(decoder.decode(encoder.encode(surface.shape())));
  const auto refuses = [&](const char* words, auto change) {
    recording::Shape message;
    message.set_vertices(40);
    message.add_moved(3);
    for (std::size_t i = 0; i < kFloats; ++i) message.add_values(9.0f);
    change(message);
    const auto taken = decoder.decode(message.SerializeAsString());
    ASSERT_FALSE(taken) << words;
    EXPECT_NE(taken.error().message.find(words), std::string::npos) << taken.error().message;
    EXPECT_TRUE(same(decoder.shape().values, surface.shape().values)) << words;
  };
  refuses("0 vertices", [](auto& m) { m.set_vertices(0); });
  refuses("40001 vertices", [](auto& m) { m.set_vertices(40'001); });
  refuses("7 values where 6", [](auto& m) { m.add_values(1.0f); });
  refuses("6 values where 240", [](auto& m) { m.set_whole(true); });
  refuses("one of more than 40", [](auto& m) { m.set_moved(0, 40); });
  const auto twice = [](std::uint32_t second) {
    return [second](auto& m) {
      m.add_moved(second);
      for (std::size_t i = 0; i < kFloats; ++i) m.add_values(9.0f);
    };
  };
  refuses("out of order", twice(2));
  refuses("out of order", twice(3));
  EXPECT_FALSE(decoder.decode("\x10"));
}

TEST(RecordedShape, ASurfaceOfAnotherSizeIsWaitedForWhole) {
  ShapeEncoder encoder;
  ShapeDecoder decoder;
  ASSERT_TRUE(decoder.decode(encoder.encode({{}, std::vector<float>(5 * kFloats)})).value());
  recording::Shape other;
  other.set_vertices(6);
  EXPECT_FALSE(decoder.decode(other.SerializeAsString()).value());
  EXPECT_TRUE(decoder.decode(encoder.encode({{seconds(1)}, std::vector<float>(6 * kFloats)})).value());
  EXPECT_EQ(decoder.shape().vertices(), 6u);
}

}  // namespace
}  // namespace palpate::record::session
