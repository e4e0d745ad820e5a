#include "tools/console/token.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::tools::console {
namespace {

TEST(Token, IsNewEachTimeAndItsFileThisUsersAlone) {
  const ScratchFolder folder;
  const auto file = folder / "token";
  const auto first = make_token(file), second = make_token(file);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->size(), 32u);
  EXPECT_NE(*first, *second);
  EXPECT_EQ(read_file(file).value(), *second + "\n");
  struct stat info {};
  ASSERT_EQ(::stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
}

TEST(Token, IsFoundInAQueryWhole) {
  EXPECT_TRUE(holds_token("/?token=abc", "abc"));
  EXPECT_TRUE(holds_token("/live?x=1&token=abc&y", "abc"));
  for (const char* none :
       {"/", "/?", "/?token=", "/?token=ab", "/?token=abcd", "/?tokens=abc", "/token=abc", "/?x=token=abc"})
    EXPECT_FALSE(holds_token(none, "abc")) << none;
  EXPECT_FALSE(holds_token("/?token=", ""));  // none was made
  EXPECT_FALSE(same_token("", ""));
}

}  // namespace
}  // namespace palpate::tools::console
