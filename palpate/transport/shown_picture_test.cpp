#include "palpate/transport/shown_picture.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "tests/scratch_folder.h"

namespace palpate::transport {
namespace {

ShownPicture picture(std::int64_t writer, std::uint64_t number) {
  ShownPicture p;
  p.writer = writer, p.number = number, p.width = 3, p.height = 2;
  p.pose = "refined", p.landmarks_used = 7, p.landmarks_predicted = 8, p.landmark_rms_px = 0.25;
  p.expected_overlay_px = 0.5;
  p.landmarks = {{1.26, 0.0, true}, {2.0, 1.5, false}};
  return p;
}
const std::vector<std::uint8_t> kRgb{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18};

TEST(ShownPicture, IsWrittenOnlyWhereSomebodyLooks) {
  const ScratchFolder folder;
  ShownPictureWriter writer(folder.path());
  ShownPictureReader reader(folder.path());
  EXPECT_FALSE(writer.due());
  EXPECT_FALSE(reader.take());
  ASSERT_TRUE(reader.want());
  EXPECT_TRUE(writer.due());
  writer.write(picture(7, 1), kRgb);
  EXPECT_FALSE(writer.due());  // not at once again
  // Somebody looked an hour ago.
  const timespec hour_ago[2] = {{::time(nullptr) - 3600, 0}, {::time(nullptr) - 3600, 0}};
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder / "picture_wanted").c_str(), hour_ago, 0), 0);
  std::this_thread::sleep_for(ShownPictureWriter::kAtMostEvery);
  EXPECT_FALSE(writer.due());
  ASSERT_TRUE(reader.want());
  EXPECT_TRUE(writer.due());
}

TEST(ShownPicture, ComesBackWholeAndOnce) {
  const ScratchFolder folder;
  ShownPictureWriter writer(folder.path());
  ShownPictureReader reader(folder.path());
  writer.write(picture(7, 41), kRgb);
  struct stat info {};
  ASSERT_EQ(::stat((folder / "picture").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  const auto got = reader.take();
  ASSERT_TRUE(got);
  EXPECT_EQ(got->rgb, kRgb);
  EXPECT_EQ(got->number, 41u);
  EXPECT_EQ(got->pose, "refined");
  EXPECT_EQ(got->landmarks_used, 7);
  EXPECT_EQ(got->landmarks_predicted, 8);
  EXPECT_EQ(got->landmark_rms_px, 0.25);
  EXPECT_EQ(got->expected_overlay_px, 0.5);
  ASSERT_EQ(got->landmarks.size(), 2u);
  EXPECT_EQ(got->landmarks[0].x, 1.3);
  EXPECT_TRUE(got->landmarks[0].used);
  EXPECT_EQ(got->landmarks[1].y, 1.5);
  EXPECT_FALSE(got->landmarks[1].used);
  EXPECT_FALSE(reader.take());
  writer.write(picture(7, 42), kRgb);
  EXPECT_TRUE(reader.take());
  // Another graphics server's is not mixed in.
  writer.write(picture(8, 43), kRgb);
  EXPECT_FALSE(reader.take());
}

// A console that is opened later shows nothing of a session that has ended.
TEST(ShownPicture, ThatOfAServerWhichHasEndedIsNone) {
  const ScratchFolder folder;
  ShownPictureWriter writer(folder.path());
  writer.write(picture(7, 41), kRgb);
  const timespec long_ago[2] = {{::time(nullptr) - 60, 0}, {::time(nullptr) - 60, 0}};
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder / "picture").c_str(), long_ago, 0), 0);
  ShownPictureReader reader(folder.path());
  EXPECT_FALSE(reader.take());
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder / "picture").c_str(), nullptr, 0), 0);
  EXPECT_TRUE(reader.take());
}

TEST(ShownPicture, WhatIsNoneIsNoPicture) {
  const ScratchFolder folder;
  ShownPictureReader reader(folder.path());
  const std::string head =
      R"({"writer":7,"number":1,"width":3,"height":2,"pose":"refined","landmarks_used":7,"landmarks_predicted":8,"landmark_rms_px":0.25,"expected_overlay_px":null,"landmarks":[[1,1,true]]})";
  const std::string pixels(18, 'x');
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string other = head;
    return other.replace(other.find(from), from.size(), to) + "\n" + pixels;
  };
  for (const std::string& content :
       {std::string(), std::string(5000, 'x'), "null\n" + pixels, head, head + "\n" + pixels + "x",
        head + "\n" + pixels.substr(1), with("\"width\":3", "\"width\":0"),
        with("\"width\":3", "\"width\":-3"), with("\"width\":3", "\"width\":\"3\""),
        with("\"height\":2", "\"height\":99999999"), with("\"number\":1,", ""),
        with("[[1,1,true]]", "[[1,1]]"), with("[[1,1,true]]", "[[null,1,true]]"), with("[[1,1,true]]", "[1]"),
        with("[[1,1,true]]", "\"x\"")}) {
    std::ofstream(folder / "picture", std::ios::binary) << content;
    EXPECT_FALSE(reader.take()) << content.substr(0, 200);
  }
  std::ofstream(folder / "picture", std::ios::binary) << head << "\n" << pixels;
  EXPECT_TRUE(reader.take());
}

}  // namespace
}  // namespace palpate::transport
