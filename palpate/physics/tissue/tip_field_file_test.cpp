#include "palpate/physics/tissue/tip_field_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "palpate/physics/tissue/tissue_for_tests.h"
#include "tests/scratch_folder.h"

namespace palpate::physics::tissue {
namespace {

constexpr std::string_view kKey = "0123456789abcdef";

class TipFieldFile : public ::testing::Test {
 protected:
  static const TipField& field() {
    static const TipField made = *block_for_tests({}, {0.02, 0.02, 0.015}, 0.005, 0.01);
    return made;
  }
  // What a file of these bytes is refused with; empty where it is not.
  static std::string refusal(const std::string& bytes, std::string_view key = kKey) {
    const auto read = parse_tip_field(bytes, key, "here");
    return read ? "" : read.error().message;
  }
  std::string stored() const {
    EXPECT_TRUE(write_tip_field(path_, field(), kKey).has_value());
    return *read_file(path_);
  }

  const ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "block.tip";
};

TEST_F(TipFieldFile, WhatIsWrittenIsReadAgainToTheLastBit) {
  stored();
  const auto read = read_tip_field(path_, kKey);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->fields().coefficients(), field().fields().coefficients());
  EXPECT_EQ(read->facts().stiffest_n_m, field().facts().stiffest_n_m);
  EXPECT_EQ(read->facts().strongest_n, field().facts().strongest_n);
  const Vector3 p(0.003, -0.002, 0.02);
  EXPECT_GT(read->at(p).energy, 0.0);
  EXPECT_EQ(read->at(p).force, field().at(p).force);
}

TEST_F(TipFieldFile, WhatIsNotTheOneWantedIsRefusedInWords) {
  const std::string good = stored();
  EXPECT_EQ(refusal(good), "");
  EXPECT_NE(refusal(good, "0123456789abcdee").find("another body"), std::string::npos);
  EXPECT_NE(refusal("").find("no tip field of this version"), std::string::npos);
  EXPECT_NE(refusal("PALPTIP2" + good.substr(8)).find("no tip field of this version"), std::string::npos);
  EXPECT_NE(refusal(good.substr(0, good.size() - 1)).find("damaged"), std::string::npos);
  EXPECT_FALSE(read_tip_field(path_.string() + ".none", kKey).has_value());
}

TEST_F(TipFieldFile, OneByteThatDiffersIsFound) {
  const std::string good = stored();
  Random random(1, "tissue/file");
  for (int i = 0; i < 200; ++i) {
    std::string bad = good;
    bad[random.below(bad.size())] ^= static_cast<char>(1u << random.below(8));
    EXPECT_NE(refusal(bad), "");
  }
}

// Whoever writes a right hash over wrong numbers: no allocation of what a lying lattice says, no crash.
TEST_F(TipFieldFile, NumbersThatCannotBeAreRefusedWhereTheHashIsRight) {
  const std::string good = stored(), content = good.substr(0, good.size() - 16);
  Random random(2, "tissue/file numbers");
  for (std::size_t at = 24; at < 24 + 8 * 8 + 3 * 4; ++at) {
    std::string bad = content;
    bad[at] = static_cast<char>(0xff);
    bad[at + 1] = static_cast<char>(0xff);
    bad += content_hash(bad);
    (void)parse_tip_field(bad, kKey, "here");
  }
  std::string longer = content + "four";
  longer += content_hash(longer);
  EXPECT_NE(refusal(longer).find("bytes for a lattice"), std::string::npos);
  std::string long_axis = content;
  long_axis[24 + 64 + 3] = 1;
  long_axis += content_hash(long_axis);
  EXPECT_NE(refusal(long_axis).find("points along an axis"), std::string::npos);
}

}  // namespace
}  // namespace palpate::physics::tissue
