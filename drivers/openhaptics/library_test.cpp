#include "drivers/openhaptics/library.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <set>

#include "drivers/openhaptics/error_text.h"
#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::openhaptics {
namespace {

const std::filesystem::path kStubs = HD_STUB_DIR;

class OpenHapticsLibrary : public testing::Test {
 protected:
  ~OpenHapticsLibrary() override { unsetenv("PALPATE_LIBHD"); }
  // The stub with some bytes of its head changed.
  std::filesystem::path with_head(const std::vector<std::pair<std::size_t, char>>& bytes) {
    std::ifstream in(kStubs / "whole" / "libHD.so", std::ios::binary);
    std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    for (const auto& [at, value] : bytes) content.at(at) = value;
    std::ofstream(scratch_ / "libHD.so", std::ios::binary) << content;
    return scratch_ / "libHD.so";
  }
  void expect_problem(const std::filesystem::path& file, LibraryProblem problem,
                      const std::vector<std::string>& words) {
    const auto facts = inspect_library(file);
    EXPECT_EQ(static_cast<int>(facts.problem), static_cast<int>(problem)) << facts.reason();
    EXPECT_FALSE(facts.remedy().empty());
    const auto loaded = Library::load(file);
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().exit_code(), 1);
    for (const auto& word : words)
      EXPECT_NE(loaded.error().message.find(word), std::string::npos) << loaded.error().message;
    EXPECT_EQ(loaded.error().message.find('\n'), std::string::npos);
  }
  ScratchFolder scratch_;
};

TEST_F(OpenHapticsLibrary, IsLoadedFromTheNamedFileOrTheEnvironmentAndTellsItsVersion) {
  const auto whole = kStubs / "whole" / "libHD.so";
  auto loaded = Library::load(whole);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ((*loaded)->facts().version, "3.4.0");
  setenv("PALPATE_LIBHD", whole.c_str(), 1);
  auto again = Library::load();
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(*again, *loaded);
  setenv("PALPATE_LIBHD", (scratch_ / "none.so").c_str(), 1);
  EXPECT_FALSE(Library::load());  // nothing else is tried
}

TEST_F(OpenHapticsLibrary, ThatIsNotThereIsMissedByName) {
  expect_problem(scratch_ / "libHD.so", LibraryProblem::not_found,
                 {(scratch_ / "libHD.so").string(), "is not there", "install", "PALPATE_LIBHD"});
}

TEST_F(OpenHapticsLibrary, ThatIsSomethingElseIsRefused) {
  expect_problem(scratch_.path(), LibraryProblem::unreadable, {"cannot be read"});
  std::ofstream(scratch_ / "text.so") << "letters of somebody, more than a head of them";
  expect_problem(scratch_ / "text.so", LibraryProblem::not_a_library, {"no shared library"});
  std::ofstream(scratch_ / "short.so") << "\x7f"
                                       << "ELF";
  expect_problem(scratch_ / "short.so", LibraryProblem::not_a_library, {"no shared library"});
  std::ofstream(scratch_ / "libHD.a")
      << "!<arch>\n/               0           0     0     0       8         `\n";
  expect_problem(scratch_ / "libHD.a", LibraryProblem::static_library,
                 {"static library", "libHD.so of OpenHaptics"});
}

TEST_F(OpenHapticsLibrary, OfAnotherMachineIsNamedAsSuch) {
  expect_problem(with_head({{4, 1}}), LibraryProblem::thirty_two_bit, {"32-bit", "this machine's processor"});
  expect_problem(with_head({{18, 0x28}, {19, 0}}), LibraryProblem::other_machine, {"built for arm"});
  // A head that promises what the rest does not keep.
  std::filesystem::resize_file(with_head({}), 200);
  expect_problem(scratch_ / "libHD.so", LibraryProblem::not_loadable, {"cannot be loaded", "anew"});
}

TEST_F(OpenHapticsLibrary, WithoutItsOwnLibrariesOrOfAnOldVersionIsRefusedWithWhatItLacks) {
  expect_problem(kStubs / "lonely" / "libHD.so", LibraryProblem::missing_dependency,
                 {"needs libPhantomIOLib42.so", "Device Driver"});
  expect_problem(kStubs / "old" / "libHD.so", LibraryProblem::missing_function,
                 {"lacks hdCheckCalibration, hdUpdateCalibration", "OpenHaptics 3.0 or newer"});
}

TEST_F(OpenHapticsLibrary, EachMissingLibraryHasARemedyOfItsOwn) {
  std::set<std::string> remedies;
  for (const char* name :
       {"libPhantomIOLib42.so", "libusb-0.1.so.4", "libraw1394.so.11", "libncurses.so.5"}) {
    LibraryFacts facts{.library = &maker_library(), .problem = LibraryProblem::missing_dependency};
    facts.detail = name;
    remedies.insert(facts.remedy());
  }
  EXPECT_EQ(remedies.size(), 4u);
}

TEST(OpenHapticsErrors, EachHasANameAReasonAndARemedyOfItsOwn) {
  // As the maker numbers them, written a second time.
  const std::set<unsigned> forces{0x0200, 0x0201, 0x0202, 0x0203, 0x0204, 0x0402};
  const std::set<unsigned> others{0x0100, 0x0101, 0x0102, 0x0103, 0x0104, 0x0300, 0x0301, 0x0302,
                                  0x0303, 0x0304, 0x0400, 0x0401, 0x0500, 0x0501, 0x0600};
  std::set<std::string> names, reasons;
  for (const auto& codes : {forces, others})
    for (const unsigned code : codes) {
      const ErrorWords words = error_text(code);
      EXPECT_EQ(words.kind == ErrorKind::force, forces.contains(code)) << words.name;
      EXPECT_FALSE(words.kind == ErrorKind::none) << words.name;
      EXPECT_TRUE(std::string(words.name).starts_with("HD_"));
      EXPECT_FALSE(std::string(words.remedy).empty());
      names.insert(words.name);
      reasons.insert(words.reason);
    }
  EXPECT_EQ(names.size(), forces.size() + others.size());
  EXPECT_EQ(reasons.size(), forces.size() + others.size());
  EXPECT_EQ(error_text(0).kind, ErrorKind::none);
  EXPECT_EQ(error_text(0xABCD).kind, ErrorKind::device);
}

}  // namespace
}  // namespace palpate::drivers::openhaptics
