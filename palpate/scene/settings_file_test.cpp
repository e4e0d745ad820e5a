#include "palpate/scene/settings_file.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::scene {
namespace {

ApplicationRegistry one_of_each_kind() {
  ApplicationSpec spec;
  spec.name = "game";
  spec.summary = "Has settings";
  spec.settings.fields = {
      {.section = "a",
       .key = "length_mm",
       .initial = std::vector<double>{2.5},
       .unit = 1e-3,
       .range = {0.0, 10.0}},
      {.section = "b",
       .key = "span_s",
       .kind = SettingKind::numbers,
       .initial = std::vector<double>{1.0, 2.0}},
      {.section = "a", .key = "how", .kind = SettingKind::choice, .initial = "so", .choices = {"so", "else"}},
      {.section = "a", .key = "name", .kind = SettingKind::text, .initial = "it\"s"},
      {.section = "b", .key = "file", .kind = SettingKind::file, .initial = ""}};
  spec.settings.relations = [](const SettingValues& values) -> std::vector<SettingComplaint> {
    const auto span = values.range("b.span_s");
    if (span[0] <= span[1]) return {};
    return {{"b", "span_s", "[from, until] with from <= until is expected"}};
  };
  spec.make_physics = [](const auto&, const auto&) { return nullptr; };
  spec.make_view = [](const auto&) { return nullptr; };
  return {spec};
}

class SettingsFile : public testing::Test {
 protected:
  SettingsFile() { values_ = all_.settings(); }

  Expected<void> read(const std::string& text) {
    EXPECT_TRUE(write_file(folder_ / "s.toml", text));
    return read_settings_file(folder_ / "s.toml", all_, values_);
  }

  ScratchFolder folder_;
  ApplicationRegistry all_ = one_of_each_kind();
  SettingValues values_;
};

TEST_F(SettingsFile, WhatItGivesGoesOverWhatIsThereAndTheRestStays) {
  values_.set("b.span_s", std::vector<double>{3.0, 4.0});
  const auto done = read("[a]\nlength_mm = 7\nhow = \"else\"\n[b]\nfile = \"x.stl\"\n");
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_DOUBLE_EQ(values_.number("a.length_mm"), 0.007);
  EXPECT_EQ(values_.text("a.how"), "else");
  EXPECT_EQ(values_.text("a.name"), "it\"s");
  EXPECT_EQ(values_.range("b.span_s")[1], 4.0);
  EXPECT_EQ(values_.text("b.file"), (folder_ / "x.stl").string()) << "as seen from the file";
}

TEST_F(SettingsFile, WhatIsWrittenReadsBackTheSame) {
  values_.set("a.length_mm", 1.0 / 3.0);
  values_.set("b.file", "/x/y z.stl");
  EXPECT_EQ(sections_of(values_), (std::vector<std::string>{"a", "b"}));
  std::string text;
  for (const auto& section : sections_of(values_))
    text += "[" + section + "]\n" + settings_text(values_, section);
  const SettingValues before = values_;
  values_ = all_.settings();
  ASSERT_TRUE(read(text)) << text;
  for (const auto& setting : before.all())
    EXPECT_EQ(values_.at(setting.field.name()).value, setting.value) << setting.field.name();
}

TEST_F(SettingsFile, MistakesAreNamedWithFileLineAndKeyAndChangeNothing) {
  for (const auto& [text, line, word] : {std::tuple{"[a]\nlenght_mm = 1\n", "s.toml:2", "lenght_mm"},
                                         {"[a]\n\nlength_mm = 11\n", "s.toml:3", "0 to 10"},
                                         {"[a]\nlength_mm = [1]\n", "s.toml:2", "a number is expected"},
                                         {"[a]\nhow = \"thus\"\n", "s.toml:2", "else"},
                                         {"[b]\nspan_s = [1]\n", "s.toml:2", "span_s"},
                                         {"[b]\nspan_s = [2, 1]\n", "s.toml:2", "from <= until"},
                                         {"[b]\nfile = 3\n", "s.toml:2", "file"},
                                         {"[c]\nx = 1\n", "s.toml:1", "c"},
                                         {"a = 3\n", "s.toml:1", "a"}}) {
    const auto done = read(text);
    ASSERT_FALSE(done) << text;
    EXPECT_EQ(done.error().kind, Error::Kind::wrong_use);
    EXPECT_NE(done.error().message.find(line), std::string::npos) << done.error().message;
    EXPECT_NE(done.error().message.find(word), std::string::npos) << done.error().message;
  }
  EXPECT_DOUBLE_EQ(values_.number("a.length_mm"), 0.0025);
  EXPECT_EQ(values_.range("b.span_s")[0], 1.0);
}

}  // namespace
}  // namespace palpate::scene
