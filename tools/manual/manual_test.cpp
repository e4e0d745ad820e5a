#include <gtest/gtest.h>

#include <filesystem>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"
#include "tools/manual/completion.h"
#include "tools/manual/pages.h"

namespace palpate::tools::manual {
namespace {

class Manual : public ::testing::Test {
 protected:
  Manual() {
    auto* calibrate = program.add_subcommand("calibrate", "Where is what?");
    calibrate->require_subcommand(1);
    auto* pivot = calibrate->add_subcommand("pivot", "The tip; see C:\\docs");
    pivot->add_option("-p,--poses", file, ".igs.mha files, --raw ones too")->type_name("FILE")->required();
    pivot->add_option("--method", word, "How")
        ->default_val("robust")
        ->check(CLI::Validator([](std::string&) { return std::string(); }, "algebraic, robust"));
    pivot->add_option("--seconds", number, "How long")
        ->check(CLI::Validator([](std::string&) { return std::string(); }, "0.1 to 60"));
    pivot->add_option("--hidden", word, "Nobody's")->group("");
    pivot->add_flag("--raw", flag, "As it is");
    calibrate->add_subcommand("secret", "Nobody's")->group("");
    program.add_subcommand("show", "A file")
        ->add_option("FILE", file, "Which")
        ->type_name("FILE")
        ->required();
    whole = describe(program);
  }
  CLI::App program{"A program", "palpate"};
  std::string file, word;
  double number = 0.0;
  bool flag = false;
  Command whole;
};

TEST_F(Manual, DescribesWhatTheParserKnowsAndHidesWhatIsHidden) {
  ASSERT_EQ(whole.commands.size(), 2u);
  ASSERT_EQ(whole.commands[0].commands.size(), 1u);
  const auto* pivot = find(whole, {"calibrate", "pivot"});
  ASSERT_NE(pivot, nullptr);
  ASSERT_EQ(pivot->options.size(), 5u);  // --help with it
  EXPECT_EQ(pivot->options[1].names, (std::vector<std::string>{"-p", "--poses"}));
  EXPECT_EQ(pivot->options[1].value, Value::file);
  EXPECT_TRUE(pivot->options[1].required);
  EXPECT_EQ(pivot->options[2].choices, (std::vector<std::string>{"algebraic", "robust"}));
  EXPECT_EQ(pivot->options[2].standard, "robust");
  EXPECT_EQ(pivot->options[3].type, "NUMBER (0.1 to 60)");
  EXPECT_EQ(pivot->options[3].value, Value::other);
  EXPECT_EQ(pivot->options[4].value, Value::none);
  EXPECT_EQ(find(whole, {"calibrate", "secret"}), nullptr);
  EXPECT_EQ(find(whole, {"show"})->arguments.front().names.front(), "FILE");
}

TEST_F(Manual, APageShowsTextUnchanged) {
  const auto page = manual_page(*find(whole, {"calibrate", "pivot"}), "1.2");
  EXPECT_NE(page.find(".TH PALPATE\\-CALIBRATE\\-PIVOT 1 \"\" \"palpate 1.2\""), page.npos);
  EXPECT_NE(page.find("C:\\edocs"), page.npos);
  EXPECT_NE(page.find("\n\\&.igs.mha files, \\-\\-raw ones too.\n"), page.npos);
  EXPECT_NE(page.find("\\fB\\-p\\fR, \\fB\\-\\-poses\\fR \\fIFILE\\fR"), page.npos);
  EXPECT_NE(page.find("\\fIalgebraic|robust\\fR"), page.npos);
  EXPECT_NE(page.find("Without it: \\fBrobust\\fR."), page.npos);
  EXPECT_NE(page.find(".BR palpate\\-calibrate (1)"), page.npos);
}

TEST_F(Manual, EachCommandHasAFile) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_manual_pages(whole, "1.2", folder.path().string()));
  for (const char* name : {"palpate", "palpate-calibrate", "palpate-calibrate-pivot", "palpate-show"})
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string(name) + ".1"))) << name;
  EXPECT_FALSE(write_manual_pages(whole, "1.2", (folder / "none").string()));
}

TEST_F(Manual, CompletionKnowsCommandsOptionsAndChoices) {
  const auto script = bash_completion(whole);
  EXPECT_NE(script.find("/calibrate/pivot:--method) _palpate_offer 'algebraic robust'; return ;;"),
            script.npos);
  EXPECT_NE(script.find("/calibrate/pivot:-p | /calibrate/pivot:--poses) _palpate_names -f; return ;;"),
            script.npos);
  EXPECT_NE(script.find("words='calibrate show'"), script.npos);
  EXPECT_EQ(script.find("secret"), script.npos);
}

}  // namespace
}  // namespace palpate::tools::manual
