// What searches lead to, without an organ: levels, seeds that tell them, and the file that is kept over sessions.
#include "applications/palpation/training.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <vector>

#include "applications/palpation/nodules.h"
#include "applications/palpation/organ_for_tests.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::palpation {
namespace {

FinishedSearch search_for_tests(int trial, int found, int level = -1) {
  FinishedSearch search;
  search.trial = trial;
  search.level = level;
  search.nodules = 2;
  search.found = found;
  search.error = found > 0 ? 0.0042 : std::numeric_limits<double>::quiet_NaN();
  search.seconds = 31.25;
  search.path = 2.5;
  search.peak_force = 1.125;
  return search;
}

PalpationSettings kept_in(const std::filesystem::path& file, Difficulty difficulty = Difficulty::staircase) {
  PalpationSettings settings;
  settings.difficulty = difficulty;
  settings.learning_file = file.string();
  return settings;
}

TEST(DifficultyStaircase, GoesUpAfterTwoThatFoundAllAndDownAfterOneThatDidNot) {
  DifficultyStaircase staircase(3);
  std::vector<int> levels{staircase.level()};
  for (const bool positive : {true, true, true, true, false, true, false, false}) {
    staircase.answer(positive);
    levels.push_back(staircase.level());
  }
  // By two levels until it turns for the first time, by one from then on.
  EXPECT_EQ(levels, (std::vector<int>{3, 3, 5, 5, 7, 6, 6, 5, 4}));
}

TEST(DifficultyStaircase, KeepsToItsEnds) {
  for (const auto& [positive, end] : {std::pair{true, kHardestLevel}, std::pair{false, 0}}) {
    DifficultyStaircase staircase(end == 0 ? 9 : 1);
    for (int i = 0; i < 3000; ++i) staircase.answer(positive);
    EXPECT_EQ(staircase.level(), end);
  }
  for (int level = 0; level <= kHardestLevel; ++level) EXPECT_EQ(DifficultyStaircase(level).level(), level);
  DifficultyStaircase turning(5);
  for (int i = 0; i < 6000; ++i) turning.answer(i % 3 != 2);  // turns more often than a rule can count
  EXPECT_NEAR(turning.level(), 5, 3);
}

TEST(Difficulty, LevelsLeadFromTheLargestAndShallowestToTheSmallestAndDeepest) {
  const NoduleRanges scale{.diameter = {0.006, 0.020}, .depth = {0.003, 0.012}};
  const auto easiest = ranges_at(scale, 0), hardest = ranges_at(scale, kHardestLevel),
             middle = ranges_at(scale, 5);
  EXPECT_EQ(easiest.diameter, (std::array{0.020, 0.020}));
  EXPECT_EQ(easiest.depth, (std::array{0.003, 0.003}));
  EXPECT_EQ(hardest.diameter, (std::array{0.006, 0.006}));
  EXPECT_EQ(hardest.depth, (std::array{0.012, 0.012}));
  EXPECT_DOUBLE_EQ(middle.diameter[0], 0.013);
  EXPECT_EQ(middle.ratio, scale.ratio);
  EXPECT_EQ(ranges_at(scale, 99).diameter, hardest.diameter) << "a level from anywhere";
}

TEST(Difficulty, TheSeedTellsTheLevelAndADrawnOneIsAsItWas) {
  EXPECT_EQ(trial_seed(7, 1), 551659062);
  EXPECT_EQ(trial_seed(7, 2), 1021946394);
  std::set<std::int32_t> seeds;
  for (int trial = 1; trial <= 50; ++trial)
    for (int level = 0; level <= kHardestLevel; ++level) {
      const std::int32_t seed = trial_seed(7, trial, level);
      EXPECT_GT(seed, 0);
      EXPECT_EQ(level_in_seed(seed), level);
      seeds.insert(seed);
    }
  EXPECT_EQ(seeds.size(), 50u * (kHardestLevel + 1));
  for (const std::int32_t seed : {1, 16, 31, 0x7fffffff}) {  // of a peer
    EXPECT_GE(level_in_seed(seed), 0);
    EXPECT_LE(level_in_seed(seed), kHardestLevel);
  }
}

TEST(LearningFile, IsAddedToOverSessionsWhichGoOnWhereTheLastOneEnded) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  {
    Training training(kept_in(file), true);
    EXPECT_TRUE(read_learning(file).value().empty()) << "begun, so that it is known that it can be written";
    EXPECT_EQ(training.level(), 3);
    for (int trial = 1; trial <= 3; ++trial) training.hear(search_for_tests(trial, 2, *training.level()));
  }
  const auto scene = with(with(table_for_tests(), "palpation.difficulty", std::string("staircase")),
                          "palpation.learning_file", file.string());
  scene::SceneDescription second;
  describe(scene::from_payload(setting_schema(), scene.settings).value(), second);
  EXPECT_EQ(palpation_settings(second).level, 5) << "of the newest search there";
  {
    Training training(palpation_settings(second), true);
    training.hear(search_for_tests(1, 0, 5));
  }
  const auto lines = read_learning(file).value();
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2].session, 1);
  EXPECT_EQ(lines[2].trial, 3);
  EXPECT_EQ(lines[2].level, 5);
  EXPECT_EQ(lines[2].found, 2);
  EXPECT_NEAR(lines[2].position_error.value(), 0.0042, 1e-9);
  EXPECT_DOUBLE_EQ(lines[2].seconds, 31.25);
  EXPECT_DOUBLE_EQ(lines[2].path, 2.5);
  EXPECT_DOUBLE_EQ(lines[2].peak_force, 1.125);
  EXPECT_EQ(lines[2].date.size(), 20u);
  EXPECT_EQ(lines[3].session, 2);
  EXPECT_EQ(lines[3].trial, 1);
  EXPECT_FALSE(lines[3].position_error) << "nothing was found";
}

TEST(LearningFile, OfDrawnNodulesHasNoLevelAndChangesNone) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  Training training(kept_in(file, Difficulty::drawn), true);
  EXPECT_FALSE(training.level());
  training.hear(search_for_tests(1, 2));
  EXPECT_FALSE(training.level());
  const auto lines = read_learning(file).value();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_FALSE(lines[0].level);
  EXPECT_FALSE(newest_level(lines));
}

TEST(LearningFile, KeepsWhatAnotherSessionHasAddedMeanwhile) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  Training first(kept_in(file), true);
  first.hear(search_for_tests(1, 2, 3));
  Training second(kept_in(file), true);
  second.hear(search_for_tests(1, 2, 3));
  first.hear(search_for_tests(2, 2, 3));
  std::vector<int> sessions;
  const auto lines = read_learning(file).value();
  for (const auto& line : lines) sessions.push_back(line.session);
  EXPECT_EQ(sessions, (std::vector<int>{1, 2, 1}));
}

TEST(LearningFile, WhatSomebodyHasDamagedMeanwhileIsNotAddedTo) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  auto opened = LearningFile::open(file);
  ASSERT_TRUE(opened) << opened.error().message;
  ASSERT_TRUE(opened->add({.trial = 1, .date = "2026-01-31T12:00:00Z", .seconds = 10.0}));
  const std::string damaged = read_file(file).value() + "1,two\n";
  ASSERT_TRUE(write_file(file, damaged));
  const auto added = opened->add({.trial = 2, .date = "2026-01-31T12:01:00Z", .seconds = 10.0});
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("me.csv"), std::string::npos) << added.error().message;
  EXPECT_EQ(read_file(file).value(), damaged);
}

TEST(LearningFile, WhereNothingIsKeptNothingIsWrittenAndNoFileIsNeeded) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  Training training(kept_in(file), false);
  training.hear(search_for_tests(1, 2, 3));
  training.hear(search_for_tests(2, 2, 3));
  EXPECT_FALSE(is_there(file));
  EXPECT_EQ(training.level(), 5) << "the staircase goes on all the same";
  Training elsewhere(kept_in(folder / "gone" / "me.csv"), false);
}

TEST(LearningFile, ALineThatCannotBeWrittenIsWarnedOfOnceAndTheStaircaseGoesOn) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "there");
  Training training(kept_in(folder / "there" / "me.csv"), true);
  std::filesystem::remove_all(folder / "there");
  const LogCapture log;
  for (int trial = 1; trial <= 2; ++trial) training.hear(search_for_tests(trial, 2, 3));
  ASSERT_EQ(log.lines().size(), 1u) << log.text();
  EXPECT_EQ(log.lines()[0].level, LogLevel::warning);
  EXPECT_NE(log.text().find("a search is not kept: "), std::string::npos) << log.text();
  EXPECT_NE(log.text().find("me.csv"), std::string::npos) << log.text();
  EXPECT_EQ(training.level(), 5);
}

// What a file holds that is refused, and a word of why.
struct Unfit {
  std::string content, words;
};

TEST(LearningFile, WhatIsNoSuchFileIsRefusedInALineAndStaysAsItIs) {
  const std::string header =
      "session,trial,date,level,nodules,found,false_alarms,position_error_mm,seconds,path_m,hard_presses,"
      "force_peak_n\n";
  const std::string row = "1,1,2026-01-31T12:00:00Z,3,2,1,0,4.2,31.25,2.5,0,1.1\n";
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  ASSERT_TRUE(parse_learning(header + row, "me.csv"));
  for (const auto& [content, words] :
       {Unfit{std::string("\x7f"
                          "ELF\0\1\2",
                          7),
              "not a text file"},
        Unfit{"", "is empty"}, Unfit{"time_s,x_mm\n1,2\n", "'session' is missing"},
        Unfit{"1,2,3\n", "no header"}, Unfit{"more," + header, "other columns"},
        Unfit{header + "1,1,,3,2,1,0,4.2,31.25,2.5,0\n", "11 cells"},
        Unfit{header + "0" + row.substr(1), "session is '0'"},
        Unfit{header + "1,1,,11,2,1,0,4.2,31.25,2.5,0,1.1\n", "level is '11'"},
        Unfit{header + "1,1,,2.5,2,1,0,4.2,31.25,2.5,0,1.1\n", "level is '2.5'"},
        Unfit{header + "1,1,,easy,2,1,0,4.2,31.25,2.5,0,1.1\n", "level is 'easy'"},
        Unfit{header + "1,1,,3,2,3,0,4.2,31.25,2.5,0,1.1\n", "3 of 2"},
        Unfit{header + "1,1,,3,2,1,0,4.2,nan,2.5,0,1.1\n", "seconds is 'nan'"},
        Unfit{header + "1000000" + row.substr(1), "name another file"}}) {
    ASSERT_TRUE(write_file(file, content));
    const auto opened = LearningFile::open(file);
    ASSERT_FALSE(opened) << words;
    EXPECT_NE(opened.error().message.find(words), std::string::npos) << opened.error().message;
    EXPECT_EQ(opened.error().message.find('\n'), std::string::npos);
    EXPECT_THROW(Training(kept_in(file), true), std::runtime_error);
    EXPECT_EQ(read_file(file).value(), content);
  }
}

TEST(LearningFile, PipesFoldersAndFilesLargerThanAnyAreRefused) {
  const ScratchFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  ASSERT_TRUE(write_file(folder / "large", std::string(kMostLearningBytes + 1, '#')));
  for (const auto& [name, words] : {std::pair{"pipe", "is a pipe"},
                                    {"large", "at most 4000000"},
                                    {"", "a folder"},
                                    {"gone/me.csv", "does not exist"}}) {
    const auto opened = LearningFile::open(folder / name);
    ASSERT_FALSE(opened) << name;
    EXPECT_NE(opened.error().message.find(words), std::string::npos) << opened.error().message;
  }
}

TEST(LearningFile, ThatIsFullTakesNoMore) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  auto opened = LearningFile::open(file);
  ASSERT_TRUE(opened);
  std::string content = read_file(file).value();
  content += "#" + std::string(kMostLearningBytes - content.size() - 2, '.') + "\n";
  ASSERT_TRUE(write_file(file, content));
  const auto added = opened->add({});
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("is full"), std::string::npos) << added.error().message;
  EXPECT_EQ(read_file(file).value(), content);
}

}  // namespace
}  // namespace palpate::applications::palpation
