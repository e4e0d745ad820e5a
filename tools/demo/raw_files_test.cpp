#include "tools/demo/raw_files.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tools/demo/play_folder_for_tests.h"
#include "tools/demo/swing_for_tests.h"

namespace palpate::tools::demo {
namespace {

class RawFiles : public PlayFolderTest {
 protected:
  Json files(const scene::ApplicationSpec* application) {
    const auto play = figures::PlayFolder::read(folder_);
    EXPECT_TRUE(play) << play.error().message;
    return play ? files_of(*play, application) : Json();
  }
};

TEST_F(RawFiles, AreListedInTheirOrderWithTheApplicationsAmongThemAndTheUnknownLast) {
  for (const char* name :
       {"own.csv", "realtime_sync.csv", "swing.csv", "pivot.csv", "haptics.csv", "trip_4.csv"})
    write(std::string("raw/") + name, "time_s\n1\n2\n");
  write("raw/truth.json", "{}");
  const auto swing = swing_for_tests();
  std::vector<std::string> names;
  for (const auto& file : files(&swing)) {
    names.push_back(file["file"]);
    EXPECT_EQ(file["table_rows"], names.back() == "truth.json" ? Json() : Json(2)) << names.back();
    EXPECT_EQ(file["holds"] == "", names.back() == "own.csv") << names.back();
  }
  EXPECT_EQ(names, (std::vector<std::string>{"pivot.csv", "truth.json", "haptics.csv", "swing.csv",
                                             "realtime_sync.csv", "trip_4.csv", "own.csv"}));
  EXPECT_EQ(files(nullptr).back()["file"], "swing.csv") << "of an application that is not known";
}

TEST_F(RawFiles, OfTheFolderBesideThePageAreThoseThatAreThere) {
  const auto names = [&] {
    std::vector<std::string> list;
    for (const auto& file : files_beside(*figures::PlayFolder::read(folder_))) {
      list.push_back(file["file"]);
      EXPECT_NE(file["holds"], "") << list.back();
    }
    return list;
  };
  write("summary.json", "{}");
  EXPECT_EQ(names(), (std::vector<std::string>{"summary.json", "report.json"}));
  for (const char* file : {"rig.toml", "world.toml", "video.mp4", "pictures/01-play.png"}) write(file, "x");
  EXPECT_EQ(names(), (std::vector<std::string>{"rig.toml", "world.toml", "summary.json", "report.json",
                                               "video.mp4", "pictures/"}));
}

// Files that few demos write, too; tests/program/raw_files.py looks at the columns of those that one has written.
TEST(RawFilesPage, DescribesEachFile) {
  const std::string page = read_file(PALPATE_DATA_DIR "/../docs/raw-files.md").value_or("");
  for (const auto& [file, holds] : raw_files()) {
    EXPECT_FALSE(holds.empty()) << file;
    const std::string name = file.starts_with("trip_") ? "trip_N.csv" : file;
    const auto told = page.find("\n### " + name + '\n'), first = page.find("\n### " + name + ", "),
               after = page.find(", " + name);
    EXPECT_NE(std::min({told, first, after}), std::string::npos) << file;
  }
}

}  // namespace
}  // namespace palpate::tools::demo
