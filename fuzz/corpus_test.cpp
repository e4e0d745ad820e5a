// Every file of the fuzzers' corpora through its target; every refusal among them, read as a person would.
//
// refusals.txt holds all of them on one page. After a change of words: PALPATE_WRITE_REFUSALS=1
// build/dev/.../palpate_fuzz_test writes it anew; then read it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>

#include "fuzz/targets.h"
#include "palpate/core/file.h"

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = PALPATE_FUZZ_DIR;

struct Refused {
  std::string target, file;
  Refusals messages;  // each once
};

// Numbers out of a solver may differ in their last digits from compiler to compiler.
std::string without_numbers(const std::string& text) {
  return std::regex_replace(text, std::regex("[-+]?[0-9]+(\\.[0-9]+)?(e[-+]?[0-9]+)?"), "#");
}

const std::vector<Refused>& whole_corpus() {
  static const std::vector<Refused> all = [] {
    std::vector<Refused> found;
    for (const auto& target : all_targets()) {
      std::vector<fs::path> files;
      for (const auto& entry : fs::directory_iterator(kFolder / "corpus" / target.name))
        files.push_back(entry.path());
      std::sort(files.begin(), files.end());
      for (const auto& file : files) {
        const auto messages = target.run(*read_file(file));
        auto& refused = found.emplace_back(Refused{std::string(target.name), file.filename().string(), {}});
        for (const auto& message : messages)
          if (std::find(refused.messages.begin(), refused.messages.end(), message) == refused.messages.end())
            refused.messages.push_back(message);
      }
    }
    return found;
  }();
  return all;
}

// The targets themselves end the process where a promise of check.h is broken.
TEST(Corpus, EveryFileOfEveryTargetKeepsThePromises) {
  std::set<std::string> targets;
  for (const auto& entry : whole_corpus()) targets.insert(entry.target);
  EXPECT_EQ(targets.size(), all_targets().size()) << "each target has files to start from";
}

// Else no solver behind the reader would be reached.
TEST(Corpus, EveryCalibrationAcceptsAtLeastOneFile) {
  for (const char* target :
       {"arm_models", "arm_samples", "corners", "flights", "hand_eye", "points", "poses", "surfaces"})
    EXPECT_TRUE(
        std::any_of(whole_corpus().begin(), whole_corpus().end(),
                    [&](const auto& entry) { return entry.target == target && entry.messages.empty(); }))
        << target << " refuses all of its files";
}

TEST(Refusals, SayWhatIsExpectedOrWhatToDo) {
  const std::regex remedy(
      "expected|make |copy |needed|needs|missing|remove|repair|check|touch|tilt|turn "
      "|swing|spread|measure|move|choose|use |give|"
      "did you mean|known here|say which|accepted|must|record");
  for (const auto& entry : whole_corpus())
    for (const auto& message : entry.messages)
      EXPECT_TRUE(std::regex_search(message, remedy)) << entry.target << '/' << entry.file << ": " << message;
}

TEST(Refusals, ReadAsOnThePage) {
  std::string page =
      "# What Palpate says to each broken file of fuzz/corpus. Written by palpate_fuzz_test "
      "(corpus_test.cpp).\n";
  for (const auto& entry : whole_corpus()) {
    if (entry.messages.empty()) continue;
    page += "\n" + entry.target + "/" + entry.file + "\n";
    for (const auto& message : entry.messages) page += "  " + message + "\n";
  }
  if (std::getenv("PALPATE_WRITE_REFUSALS") != nullptr) {
    ASSERT_TRUE(write_file(kFolder / "refusals.txt", page));
  }
  EXPECT_EQ(without_numbers(*read_file(kFolder / "refusals.txt")), without_numbers(page));
}

}  // namespace
}  // namespace palpate::fuzz
