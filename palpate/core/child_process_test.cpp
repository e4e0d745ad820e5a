#include "palpate/core/child_process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::inline core {
namespace {

using std::chrono::milliseconds;

class ChildProcessTest : public testing::Test {
 protected:
  // A shell stands for a program of ours: it writes lines to the descriptor that it is told.
  ChildProcess shell(const std::string& script) {
    auto child = ChildProcess::start("/bin/sh", {"-c", script}, log_);
    EXPECT_TRUE(child.has_value());
    return std::move(*child);
  }

  const ScratchFolder folder_;
  const std::filesystem::path log_ = folder_ / "child.log";
};

TEST_F(ChildProcessTest, TellsThatItIsReadyAndWhatItMeasured) {
  auto child = shell(
      "echo '{\"event\": \"ready\"}' >&$PALPATE_REPORT_FD; read -t 1 x; "
      "echo '{\"event\": \"result\", \"figures\": {\"frames\": 3}}' >&$PALPATE_REPORT_FD");
  for (int i = 0; i < 500 && !child.reports().ready(); ++i) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_TRUE(child.reports().ready());
  ASSERT_EQ(child.wait(std::chrono::seconds(10)), 0);
  ASSERT_TRUE(child.reports().result().has_value());
  EXPECT_EQ((*child.reports().result())["frames"], 3);
  EXPECT_FALSE(child.reports().error().has_value());
}

TEST_F(ChildProcessTest, IsAskedForItsOwnWordsFirstWhenItHasEnded) {
  auto child = shell(
      "echo '{\"event\": \"error\", \"message\": \"no arm\"}' >&$PALPATE_REPORT_FD; echo other >&2; exit 3");
  ASSERT_EQ(child.wait(std::chrono::seconds(10)), 3);
  EXPECT_EQ(child.why_it_ended(), "no arm");
}

TEST_F(ChildProcessTest, ThatIsKilledIsSaidToBe) {
  auto child = shell("kill -SEGV $$");
  ASSERT_EQ(child.wait(std::chrono::seconds(10)), 128 + SIGSEGV);
  EXPECT_EQ(child.why_it_ended(), "it was ended by signal 11 (Segmentation fault)");
}

TEST_F(ChildProcessTest, ThatToldNothingLeavesItsLog) {
  auto child = shell("echo out of luck >&2; exit 1");
  ASSERT_EQ(child.wait(std::chrono::seconds(10)), 1);
  EXPECT_EQ(child.why_it_ended(), "it told nothing; its log: " + log_.string());
  EXPECT_EQ(*read_file(log_), "out of luck\n");
}

TEST_F(ChildProcessTest, MayWriteWhatIsNoReport) {
  auto child = shell(
      "printf 'nonsense\\n[1]\\n{\"event\": 7}\\n{\"event\": \"error\"}\\n{\"event\": "
      "\"ready\"}\\n{\"event\": \"err' "
      ">&$PALPATE_REPORT_FD");
  ASSERT_EQ(child.wait(std::chrono::seconds(10)), 0);
  EXPECT_TRUE(child.reports().ready());
  EXPECT_FALSE(child.reports().error().has_value());
  EXPECT_EQ(child.why_it_ended(), "it told nothing; its log: " + log_.string());
}

// This process as the child of a shell's pipe: what it tells arrives whole, however long.
TEST(ChildReport, OfManyKilobytesArrivesWholeAndAParentThatIsGoneEndsNobody) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  ::setenv(kReportVariable, std::to_string(pipe[1]).c_str(), 1);
  {
    ReportReader reader{FileDescriptor(pipe[0])};
    Json figures = Json::array();
    for (int i = 0; i < 60000; ++i) figures.push_back(i);
    std::jthread child([&] { tell_parent_result(figures); });
    for (int i = 0; i < 500 && !reader.result(); ++i) {
      reader.read();
      std::this_thread::sleep_for(milliseconds(1));
    }
    ASSERT_TRUE(reader.result().has_value());
    EXPECT_EQ(*reader.result(), figures);
  }
  EXPECT_EQ(std::getenv(kReportVariable), nullptr) << "a child of the child has no part in it";
  tell_parent_error("nobody hears this");
  tell_parent_ready();
}

// Started anew by the death test, this process is a child whose parent reads first, and then is gone.
void live_until_the_parent_is_gone() {
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) return;
  ::setenv(kReportVariable, std::to_string(pipe[1]).c_str(), 1);
  end_with_parent();
  std::this_thread::sleep_for(milliseconds(100));
  ::write(STDERR_FILENO, "it lives", 8);
  ::close(pipe[0]);
  std::this_thread::sleep_for(std::chrono::seconds(20));
}

TEST(ChildReportDeathTest, AChildEndsWhenItsParentIsGoneAndNotBefore) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(live_until_the_parent_is_gone(), testing::KilledBySignal(SIGTERM), "it lives");
}

}  // namespace
}  // namespace palpate::inline core
