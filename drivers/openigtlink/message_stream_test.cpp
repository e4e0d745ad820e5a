#include "drivers/openigtlink/message_stream.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate::drivers::openigtlink {
namespace {

std::string transform_of(const std::string& device) { return *encode({device, {}, Transform{}}); }

// A message of a kind that is not read: another word in the header of one that is.
std::string image_of(std::size_t bytes) {
  std::string message = transform_of("Camera").substr(0, kHeaderBytes);
  message.replace(2, 12, std::string("IMAGE\0\0\0\0\0\0\0", 12));
  for (std::size_t i = 0; i < 8; ++i) message[42 + i] = static_cast<char>(bytes >> (8 * (7 - i)));
  return message + std::string(bytes, 'p');
}

struct Heard {
  MessageStream stream;
  std::vector<std::string> devices;
  bool take(std::string_view bytes) {
    return stream.take(bytes, [this](Message&& message) { devices.push_back(message.device); });
  }
};

TEST(MessageStream, PiecesOfAnySizeGiveTheSameMessages) {
  const std::string bytes = transform_of("a") + image_of(5000) + *encode({"b", {}, StopTracking{}}) +
                            image_of(0) + transform_of("c");
  Random random(1, "igtl/pieces");
  for (int round = 0; round < 50; ++round) {
    Heard heard;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t count = round == 0 ? 1 : round == 1 ? bytes.size() : 1 + random.below(300);
      ASSERT_TRUE(heard.take(std::string_view(bytes).substr(at, count)));
      at += count;
    }
    EXPECT_EQ(heard.devices, (std::vector<std::string>{"a", "b", "c"}));
    EXPECT_EQ(heard.stream.counts().messages, 3u);
    EXPECT_EQ(heard.stream.counts().skipped, 2u);
  }
}

TEST(MessageStream, GoesOnBehindADamagedOrSenselessMessage) {
  std::string damaged = transform_of("damaged");
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  std::string senseless = transform_of("senseless");
  senseless.replace(2, 12, std::string("TDATA\0\0\0\0\0\0\0", 12));  // whose body would be a multiple of 70
  Heard heard;
  EXPECT_TRUE(heard.take(damaged + transform_of("a") + senseless + transform_of("b")));
  EXPECT_EQ(heard.devices, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(heard.stream.counts().bad_crc, 1u);
  EXPECT_EQ(heard.stream.counts().refused, 1u);
  EXPECT_NE(heard.stream.complaint().find("senseless"), std::string::npos);
}

TEST(MessageStream, IsLostWhereNoHeaderStands) {
  Heard heard;
  EXPECT_TRUE(heard.take("GET / HTTP/1.1\r\n"));
  EXPECT_FALSE(heard.take(std::string(100, 'x')));
  EXPECT_FALSE(heard.take(transform_of("a"))) << "there is no way back";
  EXPECT_TRUE(heard.devices.empty());
  EXPECT_NE(heard.stream.complaint().find("not OpenIGTLink"), std::string::npos);
}

TEST(MessageStream, NeverWaitsForMoreThanItsBound) {
  std::string large = transform_of("large");
  large[46] = 1;  // of the body's length: 16 MiB
  Heard heard;
  EXPECT_FALSE(heard.take(large));
  std::string endless = image_of(0);
  endless[42] = 0x7F;
  Heard other;
  EXPECT_FALSE(other.take(endless));
}

TEST(MessageStream, NoiseNeitherThrowsNorBringsMessages) {
  Random random(1, "igtl/noise");
  for (int round = 0; round < 300; ++round) {
    std::string noise(1 + random.below(2000), '\0');
    for (char& c : noise) c = static_cast<char>(random.bits());
    if (round % 2 == 0) noise.insert(0, transform_of("a").substr(0, 2 + random.below(kHeaderBytes)));
    Heard heard;
    heard.take(noise);
    EXPECT_TRUE(heard.devices.empty());
  }
}

}  // namespace
}  // namespace palpate::drivers::openigtlink
