#include "palpate/experiment/conditions.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::experiment {
namespace {

constexpr std::string_view kGood =
    "name = \"nodules\"\ntask = \"choice\"\nplaces = 4\nstimulus = \"ratio\"\nmethod = \"constant-stimuli\"\n"
    "practice = 3\nrest_after = 20\n[constant]\nlevels = [1.5, 3, 10]\nrepeats = 5\n"
    "[[factor]]\nname = \"depth_mm\"\nlevels = [5, 10.5]\n[[factor]]\nname = \"sight\"\nchoices = [\"with\", "
    "\"without\"]\n";

std::string changed(std::string_view from, std::string_view to) {
  std::string text(kGood);
  const auto at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal_of(const std::string& text) {
  const auto conditions = parse_conditions(text, "c.toml");
  if (conditions) return "none";
  EXPECT_EQ(conditions.error().exit_code(), 2);
  EXPECT_EQ(conditions.error().message.find('\n'), std::string::npos);
  return conditions.error().message;
}

TEST(Conditions, AFileIsRead) {
  const auto read = parse_conditions(kGood, "c.toml");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->name, "nodules");
  EXPECT_EQ(read->places, 4);
  EXPECT_EQ(read->levels, (std::vector<double>{1.5, 3.0, 10.0}));
  EXPECT_EQ(shape_of(*read).guess, 0.25);
  EXPECT_EQ(most_trials(*read), 3 * 5 * 4);
  const auto cells = cells_of(*read);
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[1], (std::vector<std::string>{"5", "without"}));
  EXPECT_EQ(cells[2], (std::vector<std::string>{"10.5", "with"}));
}

TEST(Conditions, ExamplesAreReadAsTheyAreWritten) {
  for (const auto method : {Method::constant_stimuli, Method::staircase}) {
    auto conditions = example_conditions(method);
    for (int i = 0; i < 3; ++i) {
      if (i == 1) conditions.rule.kind = StaircaseKind::weighted;
      if (i == 2) conditions.rule.kind = StaircaseKind::transformed, conditions.rule.down_after = 3;
      const auto text = conditions_text(conditions);
      const auto again = parse_conditions(text, "example.toml");
      ASSERT_TRUE(again) << again.error().message << "\n" << text;
      EXPECT_EQ(conditions_text(*again), text);
      EXPECT_EQ(hash_of(*again), hash_of(conditions));
    }
  }
}

// What stands in the guide: a whole file, and a section to be put in place of another.
TEST(Conditions, TheGuidesFilesAreRead) {
  const auto guide = read_file(PALPATE_DATA_DIR "/../docs/guides/experiments.md");
  ASSERT_TRUE(guide) << guide.error().message;
  std::vector<std::string> blocks;
  constexpr std::string_view kBegin = "```toml\n", kEnd = "```";
  for (auto at = guide->find(kBegin); at != guide->npos; at = guide->find(kBegin, at)) {
    at += kBegin.size();
    blocks.push_back(guide->substr(at, guide->find(kEnd, at) - at));
  }
  ASSERT_EQ(blocks.size(), 2u);
  const auto constant = parse_conditions(blocks[0], "guide");
  ASSERT_TRUE(constant) << constant.error().message;
  EXPECT_EQ(hash_of(*constant), hash_of(example_conditions(Method::constant_stimuli)));
  auto text = blocks[0];
  text = text.substr(0, text.find("method = ")) + blocks[1];
  const auto staircase = parse_conditions(text, "guide");
  ASSERT_TRUE(staircase) << staircase.error().message;
  EXPECT_EQ(staircase->tracks, 2);
}

TEST(Conditions, TheHashIsOfWhatTheFileSays) {
  const auto one = parse_conditions(kGood, "a"),
             spaced = parse_conditions("# mine\n" + std::string(kGood), "b"),
             other = parse_conditions(changed("repeats = 5", "repeats = 6"), "c");
  ASSERT_TRUE(one && spaced && other);
  EXPECT_EQ(hash_of(*one), hash_of(*spaced));
  EXPECT_NE(hash_of(*one), hash_of(*other));
}

TEST(Conditions, MistakesAreNamedWithLineAndKey) {
  const auto refuses = [](std::string_view from, std::string_view to, std::string_view told) {
    const auto message = refusal_of(changed(from, to));
    EXPECT_NE(message.find(told), std::string::npos) << message;
  };
  refuses("name = \"nodules\"", "name = \"a/b\"", "c.toml:1: name: is \"a/b\"");
  refuses("\"choice\"", "\"chioce\"", "c.toml:2: task: is \"chioce\", one of");
  refuses("places = 4", "places = 1", "c.toml:3: places: is 1");
  refuses("constant-stimuli", "staircase", "staircase.rule: is missing");
  refuses("practice", "practise", "c.toml:6: unknown key 'practise'; did you mean 'practice'?");
  refuses("[1.5, 3, 10]", "[1.5]", "c.toml:9: constant.levels: has 1 stimulus");
  refuses("[1.5, 3, 10]", "[1.5, 3, 3]", "names a stimulus twice");
  refuses("[1.5, 3, 10]", "[0, 3]", "constant.levels: is 0, a number above 0 is expected");
  refuses("repeats = 5", "repeats = 0", "c.toml:10: constant.repeats: is 0");
  refuses("repeats = 5", "repeats = 9000", "more than 100000 trials");
  refuses("levels = [5, 10.5]", "", "either levels");
  refuses("levels = [5, 10.5]", "levels = [5, 5]", "names a level twice");
  refuses("name = \"sight\"", "name = \"depth_mm\"", "c.toml:15: factor[2].name: is the name of another");
  refuses("name = \"sight\"", "name = \"answer\"", "is a column of the file of trials");
  refuses("\"without\"", "\"a,b\"", "holds \"a,b\"");
  refuses("\"without\"", "\"without\", \"\"", "holds \"\"");
}

TEST(Conditions, AStaircaseMustSeekMoreThanGuessingGives) {
  auto conditions = example_conditions(Method::staircase);
  conditions.rule.kind = StaircaseKind::weighted;
  conditions.rule.target = 0.5;
  EXPECT_NE(refusal_of(conditions_text(conditions)).find("staircase.target: closes in on 0.5 right"),
            std::string::npos);
  conditions.rule.target = 0.75;
  conditions.rule.start = 100.0;
  EXPECT_NE(refusal_of(conditions_text(conditions)).find("staircase.start: is 100, lowest to highest"),
            std::string::npos);
}

TEST(Conditions, TooManyCellsAreRefused) {
  std::string text(kGood);
  for (int i = 0; i < 9; ++i)
    text += "[[factor]]\nname = \"f" + std::to_string(i) + "\"\nchoices = [\"a\", \"b\", \"c\"]\n";
  EXPECT_NE(refusal_of(text).find("more than 1000 combinations"), std::string::npos);
}

TEST(Conditions, MissingFilesAreNamed) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_conditions(folder / "none.toml"));
  ASSERT_TRUE(write_file(folder / "c.toml", kGood));
  EXPECT_TRUE(read_conditions(folder / "c.toml"));
}

}  // namespace
}  // namespace palpate::experiment
