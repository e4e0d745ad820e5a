#include "palpate/core/log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <thread>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "tests/scratch_folder.h"

namespace palpate::inline core {
namespace {

// A log without sinks before and after each test.
class LogTo : public testing::Test {
 protected:
  LogTo() { log_to_nobody(); }
  ~LogTo() override { log_to_nobody(); }

  ScratchFolder scratch_;
  const std::filesystem::path file_ = scratch_.path() / "run.log";
  static constexpr Log kLog{"physics"};
};

TEST_F(LogTo, NobodyPrintsNothing) {
  testing::internal::CaptureStderr();
  kLog.error("the arm has gone");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(LogTo, StandardErrorIsShortAndWithoutWhatOnlyWhoSearchesAFaultWants) {
  testing::internal::CaptureStderr();
  log_to_standard_error();
  log_to_standard_error();
  kLog.debug("tick {}", 1);
  kLog.info("answers at {}", "ipc:///run/palpate");
  kLog.warning("warning: nobody is admitted");
  Log().error("--rig: no such file");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "palpate: physics: answers at ipc:///run/palpate\n"
            "palpate: physics: warning: nobody is admitted\n"
            "palpate: --rig: no such file\n");
}

TEST_F(LogTo, NoTextOfOthersSteersATerminalWhateverTheSink) {
  testing::internal::CaptureStderr();
  log_to_standard_error();
  ASSERT_TRUE(log_to_file(file_));
  std::string seen;
  log_to([&](const LogLine& line) { seen = line.text; });
  // Escape, line end, C1, and a mark that turns the direction of writing, as a peer might name itself.
  kLog.info("peer '{}'", "\x1b[2J\r\nme\xc2\x9b\xe2\x80\xae");
  EXPECT_EQ(seen,
            "physics: peer '?[2J??me?"
            "?'");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "palpate: " + seen + "\n");
  const auto written = read_file(file_);
  ASSERT_TRUE(written);
  EXPECT_EQ(std::count(written->begin(), written->end(), '\n'), 1);
  EXPECT_TRUE(is_plain(written->substr(0, written->size() - 1))) << *written;
}

TEST_F(LogTo, AFileHasTimeZoneAndLevelOfEveryLineAndIsAddedTo) {
  for (const char* run : {"first", "second"}) {
    log_to_nobody();
    const auto opened = log_to_file(file_);
    ASSERT_TRUE(opened) << opened.error().message;
    kLog.debug("{} run", run);
    kLog.warning("{} run", run);
  }
  const auto written = read_file(file_);
  ASSERT_TRUE(written);
  const std::string stamp = R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d )";
  EXPECT_TRUE(std::regex_match(
      *written,
      std::regex(stamp + "debug +physics: first run\n" + stamp + "warning +physics: first run\n" + stamp +
                 "debug +physics: second run\n" + stamp + "warning +physics: second run\n")))
      << *written;
}

TEST_F(LogTo, AFileThatCannotBeOpenedIsRefusedInWords) {
  const auto nowhere = log_to_file(scratch_.path() / "none" / "run.log");
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().exit_code(), 2);
  EXPECT_NE(nowhere.error().message.find("there is no folder"), std::string::npos) << nowhere.error().message;
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "none"));
  const auto folder = log_to_file(scratch_.path());
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().exit_code(), 2);
}

TEST_F(LogTo, AFullDiskIsToldOnceAndTheOthersGoOn) {
  ASSERT_TRUE(std::filesystem::exists("/dev/full"));  // as on every Linux
  std::vector<LogLine> lines;
  log_to([&](const LogLine& line) { lines.push_back(line); });
  ASSERT_TRUE(log_to_file("/dev/full"));
  kLog.info("one");
  kLog.info("two");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].text, "physics: one");
  EXPECT_EQ(lines[1].level, LogLevel::warning);
  EXPECT_NE(lines[1].text.find("the log ends here"), std::string::npos) << lines[1].text;
  EXPECT_EQ(lines[2].text, "physics: two");
}

TEST_F(LogTo, LinesOfManyThreadsStayWholeAndNoneIsLost) {
  constexpr int kThreads = 4, kLines = 500;
  ASSERT_TRUE(log_to_file(file_));
  std::vector<std::string> seen;
  log_to([&](const LogLine& line) { seen.push_back(line.text); });
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([t] {
      for (int i = 0; i < kLines; ++i) kLog.info("{} of {}", i, t);
    });
  for (auto& thread : threads) thread.join();
  ASSERT_EQ(seen.size(), static_cast<std::size_t>(kThreads * kLines));
  std::sort(seen.begin(), seen.end());
  EXPECT_EQ(std::unique(seen.begin(), seen.end()), seen.end());
  const auto written = read_file(file_);
  ASSERT_TRUE(written);
  EXPECT_EQ(std::count(written->begin(), written->end(), '\n'), kThreads * kLines);
}

TEST_F(LogTo, ACaptureStandsInForTheSinksOnlyWhileItLives) {
  std::vector<std::string> seen;
  log_to([&](const LogLine& line) { seen.push_back(line.text); });
  {
    const LogCapture outer;
    {
      const LogCapture inner;
      kLog.debug("hidden");
      EXPECT_EQ(inner.text(), "physics: hidden\n");
      EXPECT_EQ(inner.lines().front().level, LogLevel::debug);
    }
    kLog.info("kept");
    EXPECT_EQ(outer.text(), "physics: kept\n");
  }
  kLog.info("seen");
  EXPECT_EQ(seen, std::vector<std::string>{"physics: seen"});
}

}  // namespace
}  // namespace palpate::inline core
