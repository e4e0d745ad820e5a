#include "palpate/haptics/trip_writer.h"

#include <gtest/gtest.h>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/haptics/haptic_bench_test.h"
#include "tests/scratch_folder.h"

namespace palpate::haptics {
namespace {

TEST(TripWriter, TheLastSecondsBeforeATripAreInAFile) {
  const ScratchFolder scratch;
  const LogCapture told;
  HapticSettings settings = without_ramp();
  settings.record_s = 0.05;
  HapticBench bench(settings);
  bench.message.continuous = {0.0, 1.0, 0.0};
  TripWriter writer(bench.loop, scratch.path());
  bench.live(100);
  bench.arm.sample.connected = false;
  bench.live(20);
  writer.stop();
  EXPECT_EQ(writer.written(), 1u);
  EXPECT_EQ(writer.left_out(), 0u);
  ASSERT_EQ(told.lines().size(), 1u);
  EXPECT_EQ(told.lines()[0].level, LogLevel::warning);
  EXPECT_EQ(told.text().find("physics: forces tripped (arm lost"), 0u) << told.text();
  const auto file = scratch.path() / "trip_1.csv";
  EXPECT_NE(told.text().find(file.string()), std::string::npos) << told.text();

  const auto content = read_file(file);
  ASSERT_TRUE(content);
  EXPECT_EQ(content->find("# tripped: arm lost in tick 101;"), 0u) << content->substr(0, 80);
  CsvOptions options;
  options.text_columns = {"state", "fault"};
  const auto table = parse_csv(*content, "trip_1.csv", options);
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->rows.size(), 50u);
  const auto column = [&](const char* name) { return *table->find(name); };
  EXPECT_EQ(table->text.front()[column("state")], "running");
  EXPECT_EQ(table->text.front()[column("fault")], "none");
  EXPECT_EQ(table->text.back()[column("state")], "safe");
  EXPECT_EQ(table->text.back()[column("fault")], "arm lost");
  EXPECT_NEAR(table->rows.front()[column("asked_y_n")], 1.0, 1e-12);
  EXPECT_GT(std::abs(table->rows.front()[column("commanded_y_n")]), 0.8);
  EXPECT_EQ(table->rows.back()[column("commanded_y_n")], 0.0);
  EXPECT_NEAR(table->rows.back()[column("time_s")], bench.now.seconds(), 1e-9);
}

TEST(TripWriter, WithoutATripThereIsNoFile) {
  const ScratchFolder scratch;
  HapticBench bench(without_ramp());
  TripWriter writer(bench.loop, scratch.path());
  bench.live(100);
  writer.stop();
  EXPECT_EQ(writer.written(), 0u);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

TEST(TripWriter, ATripThatCannotBeWrittenIsTold) {
  const LogCapture told;
  HapticBench bench(without_ramp());
  TripWriter writer(bench.loop, "/nowhere/at/all");
  bench.live(10);
  bench.arm.sample.connected = false;
  bench.live();
  writer.stop();
  EXPECT_EQ(writer.written(), 0u);
  EXPECT_EQ(writer.left_out(), 1u);
  ASSERT_EQ(told.lines().size(), 2u);
  EXPECT_NE(told.text().find("/nowhere/at/all/trip_1.csv"), std::string::npos) << told.text();
  EXPECT_NE(told.text().find("/nowhere/at/all/realtime_trips.csv"), std::string::npos) << told.text();
}

TEST(TripWriter, TheHapticThreadGoesOnWhileTheFileIsWritten) {
  const ScratchFolder scratch;
  HapticBench bench(without_ramp());
  TripWriter writer(bench.loop, scratch.path());
  bench.live(10);
  bench.arm.sample.connected = false;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (writer.written() == 0 && std::chrono::steady_clock::now() < end) bench.live();
  EXPECT_EQ(writer.written(), 1u);
  EXPECT_TRUE(read_csv(scratch.path() / "trip_1.csv", {.text_columns = {"state", "fault"}}));
}

}  // namespace
}  // namespace palpate::haptics
