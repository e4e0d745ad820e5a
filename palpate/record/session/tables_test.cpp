// Tables into recordings and out of them again; streams as tables of their own.
#include <gtest/gtest.h>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/export_tables.h"
#include "palpate/record/session/recorded_tables.h"
#include "palpate/record/session/session_recording.h"
#include "tests/scratch_folder.h"

namespace palpate::record::session {
namespace {

const std::string kTable = "# of a test\nlabel,time_s,x_mm\na,10,1.25\nb,10.5,0.1\n\nc,12,3e-7\n";

TEST(RecordedTables, ComeBackToTheByte) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_tables(folder / "t.mcap", {{"arm", kTable}, {"pivot", "x_mm\n1\n"}}));
  const auto back = table_of(folder / "t.mcap", "arm");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(*back, kTable);
  const auto report = export_attachments(folder / "t.mcap", folder / "files");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(*read_file(folder / "files" / "arm.csv"), kTable);
}

TEST(RecordedTables, APartHasTheRowsOfThoseTimes) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_tables(folder / "t.mcap", {{"arm", kTable}, {"timeless", "x_mm\n1\n"}}));
  const auto part = table_of(folder / "t.mcap", "arm", {0.4, 1.0});
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_EQ(*part, "# of a test\nlabel,time_s,x_mm\nb,10.5,0.1\n");
  const auto refusal = table_of(folder / "t.mcap", "timeless", {0.4, 1.0});
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("no times"), std::string::npos) << refusal.error().message;
}

TEST(RecordedTables, WhatIsNotThereIsRefusedWithWhatIs) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_tables(folder / "t.mcap", {{"arm", kTable}}));
  const auto refusal = table_of(folder / "t.mcap", "hand");
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("arm.csv"), std::string::npos) << refusal.error().message;
}

// Three poses of the tip marker, one of the pointer, one unseen.
std::filesystem::path tracked(const ScratchFolder& folder) {
  const auto recording =
      std::move(*SessionRecording::begin(folder / "s.mcap", {.recorder = "test", .on_error = {}}));
  auto& stream = recording->stream("/tracker/sample", "palpate.recording.TrackerSample");
  RecordedTrackerSample sample;
  for (int i = 0; i < 5; ++i) {
    sample.sample.stamp = {Duration(1'500'000'000 + 10'000'000 * i)};
    sample.sample.seen = i != 4;
    sample.sample.marker = i == 3 ? device::MarkerId::pointer : device::MarkerId::tip_marker;
    sample.sample.translation = {0.1 * i, 1.0 / 3.0, -2.0};
    const auto time = recording->log_time(1'000'000'000ll * i);
    stream.write(time, time, encode(sample));
  }
  recording->close();
  return folder / "s.mcap";
}

TEST(ExportTables, EachTopicIsATableWithAllItsDigits) {
  const ScratchFolder folder;
  const auto report = export_csv(tracked(folder), folder / "csv");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->rows.at("tracker_sample.csv"), 5u);
  const auto text = read_file(folder / "csv" / "tracker_sample.csv");
  ASSERT_TRUE(text);
  const auto table = parse_csv(*text, "tracker_sample", {.text_columns = {"*"}});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->rows[1][*table->find("position_m.y")], 1.0 / 3.0);
  EXPECT_EQ(table->rows[1][*table->find("orientation_wxyz.0")], 1.0);
  EXPECT_EQ(table->text[3][*table->find("marker")], "MARKER_POINTER");
}

TEST(ExportTables, PosesInTheFormatOfTum) {
  const ScratchFolder folder;
  const auto report = export_tum(tracked(folder), folder / "tum");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->rows.at("tip_marker.tum"), 3u);
  EXPECT_EQ(report->rows.at("pointer.tum"), 1u);
  EXPECT_EQ(*read_file(folder / "tum" / "pointer.tum"),
            "1.530000000 0.30000000000000004 0.3333333333333333 -2 0 0 0 1\n");
}

}  // namespace
}  // namespace palpate::record::session
