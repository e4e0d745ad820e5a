#include "palpate/plugin/loader.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "palpate/plugin/build.h"

namespace palpate::plugin {
namespace {

namespace fs = std::filesystem;

const fs::path kFixtures = PALPATE_PLUGIN_FIXTURES;

// A folder that is this user's alone, with copies of fixtures.
class PlugIn : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/palpate-plugin-XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path fixture(const std::string& name) {
    const fs::path copy = folder_ / (name + ".so");
    fs::copy_file(kFixtures / (name + ".so"), copy, fs::copy_options::overwrite_existing);
    EXPECT_EQ(chmod(copy.c_str(), 0644), 0);
    return copy;
  }
  // Why it is refused; nothing of it stays.
  std::string refusal(const fs::path& file) {
    const auto applications = guests_.applications.names();
    const auto drivers = guests_.drivers.drivers().size();
    const auto done = load(file, guests_, report_);
    EXPECT_FALSE(done) << file;
    EXPECT_EQ(guests_.applications.names(), applications);
    EXPECT_EQ(guests_.drivers.drivers().size(), drivers);
    if (done) return "";
    kind_ = done.error().kind;
    EXPECT_EQ(done.error().message.find('\n'), std::string::npos);
    return done.error().message;
  }
  static bool says(const std::string& message, std::string_view words) {
    return message.find(words) != std::string::npos;
  }

  fs::path folder_;
  Guests guests_;
  Report report_;
  Error::Kind kind_ = Error::Kind::refused;
};

TEST_F(PlugIn, AddsItsApplicationAndItsDriverAndIsToldAsWhereTheyComeFrom) {
  const fs::path file = fixture("guest");
  const auto done = load(file, guests_, report_);
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_NE(guests_.applications.find("guest"), nullptr);
  scene::SceneDescription scene;
  scene.application = "guest";
  const auto view = guests_.applications.make_view(scene);
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ((*view)->captions({}).at(0), "drawn by a plug-in");
  const auto opened = guests_.drivers.open(device::TrackerRequest{.uri = "guest", .tools = {}});
  ASSERT_FALSE(opened);
  EXPECT_TRUE(says(opened.error().message, "there is no such tracker")) << opened.error().message;
  ASSERT_NE(report_.origin_of_application("guest"), nullptr);
  EXPECT_EQ(report_.origin_of_application("guest")->file, fs::canonical(file));
  EXPECT_EQ(report_.origin_of_driver("guest")->name, "guest");
  EXPECT_EQ(report_.origin_of_driver("lab"), nullptr);
  // Once more, by another way to it: passed over.
  ASSERT_TRUE(load(folder_ / "." / "guest.so", guests_, report_));
  EXPECT_EQ(report_.loaded.size(), 1u);
}

// It is called, and refused for what it does then.
TEST_F(PlugIn, OfGccOrClangFitsAProgramOfEither) {
  const std::string family = refusal(fixture("other_family"));
  EXPECT_TRUE(says(family, "adds neither an application nor a driver")) << family;
}

TEST_F(PlugIn, OfAnotherReleaseCompilerOptionsLayoutOrEntryIsRefusedInWordsAndNothingOfItIsCalled) {
  const auto other = [&](const std::string& what) { return refusal(fixture("other_" + what)); };
  const std::string release = other("release");
  EXPECT_TRUE(says(release, "is made for Palpate 0.0.9, and this is " PALPATE_RELEASE)) << release;
  const std::string old = refusal(fixture("old_and_missing"));
  EXPECT_TRUE(says(old, "is made for Palpate 0.0.9")) << old;
  const std::string compiler = other("compiler");
  EXPECT_TRUE(says(compiler, "is compiled by tcc 1, and this program by " PALPATE_COMPILER)) << compiler;
  const std::string options = other("options");
  EXPECT_TRUE(says(options, "is compiled for libc++ 15000, and this program for " PALPATE_BUILD_OPTIONS))
      << options;
  const std::string layout = other("layout");
  EXPECT_TRUE(says(layout, "of other sizes")) << layout;
  const std::string abi = other("abi");
  EXPECT_TRUE(says(abi, "its entry has version 99")) << abi;
  EXPECT_EQ(kind_, Error::Kind::refused);
}

TEST_F(PlugIn, ThatIsNoneIsRefusedInWords) {
  EXPECT_TRUE(says(refusal(folder_ / "absent.so"), "no such file"));
  EXPECT_EQ(kind_, Error::Kind::wrong_use);
  EXPECT_TRUE(says(refusal(folder_), "no such file"));
  std::ofstream(folder_ / "words.so") << "not a library at all\n";
  EXPECT_TRUE(says(refusal(folder_ / "words.so"), "cannot be loaded"));
  EXPECT_EQ(kind_, Error::Kind::refused);
  EXPECT_TRUE(says(refusal(fixture("plain_library")), "without the function palpate_plugin"));
  EXPECT_TRUE(says(refusal(fixture("empty")), "adds neither an application nor a driver"));
  const std::string missing = refusal(fixture("missing_symbol"));
  EXPECT_TRUE(says(missing, "nobody_has_this")) << missing;
}

TEST_F(PlugIn, ThatThrowsOrWantsANameThatIsTakenAddsNothing) {
  const std::string thrown = refusal(fixture("thrower"));
  EXPECT_TRUE(says(thrown, "thrower.so: the licence has run out; renew it")) << thrown;
  EXPECT_TRUE(says(refusal(fixture("odd_thrower")), "threw what is no std::exception"));
  ASSERT_TRUE(load(fixture("guest"), guests_, report_));
  const std::string taken = refusal(fixture("namesake"));
  EXPECT_TRUE(says(taken, "application 'guest': another one has this name")) << taken;
  EXPECT_EQ(guests_.drivers.find("fresh"), nullptr);
}

TEST_F(PlugIn, ThatOthersMayWriteIsRefusedAndSoIsOneInSuchAFolder) {
  const fs::path file = fixture("guest");
  for (const mode_t open : {0664u, 0646u}) {
    ASSERT_EQ(chmod(file.c_str(), open), 0);
    EXPECT_TRUE(says(refusal(file), "others may write to the file")) << open;
  }
  ASSERT_EQ(chmod(file.c_str(), 0644), 0);
  fs::create_directory(folder_ / "inner");
  const fs::path inner = folder_ / "inner" / "guest.so";
  fs::copy_file(file, inner);
  for (const mode_t open : {0775u, 0757u}) {
    ASSERT_EQ(chmod(folder_.c_str(), open), 0);
    EXPECT_TRUE(says(refusal(file), "others may write to the folder")) << open;
    EXPECT_TRUE(says(refusal(inner), "others may write to the folder " + folder_.string()))
        << "further up counts, too";
  }
  ASSERT_EQ(chmod(folder_.c_str(), 0700), 0);
  EXPECT_TRUE(load(inner, guests_, report_));
}

TEST_F(PlugIn, IsJudgedByWhereALinkLeads) {
  const fs::path file = fixture("guest");
  ASSERT_EQ(chmod(file.c_str(), 0646), 0);
  fs::create_directory(folder_ / "links");
  fs::create_symlink(file, folder_ / "links" / "guest.so");
  EXPECT_TRUE(says(refusal(folder_ / "links" / "guest.so"),
                   "others may write to the file " + fs::canonical(file).string()));
}

// Only root can give files away: for others there is no such test.
class PlugInOfAStranger : public PlugIn {
  void TestBody() override {
    const fs::path file = fixture("guest");
    ASSERT_EQ(chown(file.c_str(), 12345, 12345), 0);
    const std::string why = refusal(file);
    EXPECT_TRUE(says(why, "belongs to user 12345, who is neither you nor root")) << why;
  }
};
[[maybe_unused]] const auto* const kOfAStranger =
    geteuid() != 0
        ? nullptr
        : testing::RegisterTest("PlugIn", "ThatBelongsToAStrangerIsRefused", nullptr, nullptr, __FILE__,
                                __LINE__, []() -> PlugIn* { return new PlugInOfAStranger; });

TEST_F(PlugIn, InAFolderIsLoadedInOrderOfNamesAndWhatIsRefusedIsToldAndPassedOver) {
  fixture("guest");
  fixture("namesake");
  fixture("other_release");
  std::ofstream(folder_ / "notes.txt") << "no plug-in";
  load_folder(folder_, guests_, report_);
  ASSERT_EQ(report_.loaded.size(), 1u);
  EXPECT_EQ(report_.loaded[0].name, "guest");
  ASSERT_EQ(report_.skipped.size(), 2u);
  EXPECT_TRUE(says(report_.skipped[0], "namesake.so"));
  EXPECT_TRUE(says(report_.skipped[1], "0.0.9"));
  ASSERT_EQ(chmod(folder_.c_str(), 0777), 0);
  Report open;
  load_folder(folder_, guests_, open);
  ASSERT_EQ(open.skipped.size(), 1u) << "the folder, not each of its files";
  EXPECT_TRUE(says(open.skipped[0], "others may write to the folder"));
  Report none;
  load_folder(folder_ / "absent", guests_, none);
  EXPECT_TRUE(none.loaded.empty() && none.skipped.empty());
}

TEST_F(PlugIn, IsLookedForAlongTheEnvironmentsPathThenAtHomeThenInTheSystem) {
  setenv("PALPATE_PLUGIN_PATH", "/one::/two/x.so", 1);
  setenv("HOME", folder_.c_str(), 1);
  const SearchPath path = search_path("/usr/lib/palpate/plugins");
  unsetenv("PALPATE_PLUGIN_PATH");
  EXPECT_EQ(path.named, (std::vector<fs::path>{"/one", "/two/x.so"}));
  EXPECT_EQ(path.folders,
            (std::vector<fs::path>{folder_ / ".local/lib/palpate/plugins", "/usr/lib/palpate/plugins"}));
  load_all(path, guests_, report_);
  EXPECT_EQ(report_.skipped.size(), 2u) << "what was named has to be there, a folder that may be has not";
  EXPECT_FALSE(has_rights_of_its_own());
}

}  // namespace
}  // namespace palpate::plugin
