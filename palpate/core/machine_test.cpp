#include "palpate/core/machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "palpate/core/build_info.h"
#include "palpate/core/text.h"

namespace palpate::inline core {
namespace {

// Another machine says other things; each that is said is one line of words.
TEST(Machine, SaysWhatItIs) {
  const Machine here = this_machine();
  EXPECT_GE(here.cores, 1u);
  EXPECT_LE(here.cores, std::max(1u, std::thread::hardware_concurrency()));
  EXPECT_TRUE(here.kernel.starts_with("Linux ")) << here.kernel;
  for (const auto& words : {here.processor, here.kernel, here.system}) {
    EXPECT_TRUE(is_plain(words)) << words;
    EXPECT_EQ(words.find('"'), std::string::npos) << words;
    EXPECT_FALSE(words.starts_with(' ') || words.ends_with(' ')) << words;
  }
  const auto load = load_of_machine();
  ASSERT_TRUE(load);
  EXPECT_GE(*load, 0.0);
}

TEST(BuildInfo, SaysWhereTheCommitIsNotKnown) {
  EXPECT_EQ(text_of({"0.1.0", "3d8d93f1-dirty", "GNU 12.2.0", "-O2 -g1"}),
            "0.1.0 (3d8d93f1-dirty, GNU 12.2.0, -O2 -g1)");
  EXPECT_EQ(text_of({"0.1.0", "", "Clang 14.0.6", "Release"}),
            "0.1.0 (commit not known, Clang 14.0.6, Release)");
}

}  // namespace
}  // namespace palpate::inline core
