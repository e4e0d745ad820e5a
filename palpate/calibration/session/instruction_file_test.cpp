#include "palpate/calibration/session/instruction_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::calibration::session {
namespace {

TEST(InstructionFile, TellsARequestAndItsWordsInALine) {
  const ScratchFolder folder;
  const auto name = folder / "instructions.jsonl";
  {
    auto file = InstructionFile::open(name);
    ASSERT_TRUE(file) << file.error().message;
    (*file)->write({device::Gesture::hold, "", 2}, "to the right");
    (*file)->write({{"released", true}});
  }
  const auto text = read_file(name);
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(*text, "{\"gesture\":\"hold\",\"index\":2,\"text\":\"to the right\"}\n{\"released\":true}\n");
}

TEST(InstructionFile, TellsWhatTheTrackerSeesWhereItChangesOnceASecond) {
  const ScratchFolder folder;
  const auto name = folder / "seen.jsonl";
  {
    auto file = InstructionFile::open(name);
    ASSERT_TRUE(file) << file.error().message;
    PersonView view;
    view.head.seen = true;
    for (int i = 0; i < 60; ++i) {  // 3 s, the pointer from 1.5 s on, the stylus at 2.1 s for a moment
      view.now_s = 100.0 + 0.05 * i;
      view.pointer.seen = i >= 30;
      view.stylus.seen = i == 42;
      (*file)->write_seen(view);
    }
  }
  const auto text = read_file(name);
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(*text,
            "{\"seen\":{\"stylus\":false,\"pointer\":false,\"camera\":true}}\n"
            "{\"seen\":{\"stylus\":false,\"pointer\":true,\"camera\":true}}\n");
}

TEST(InstructionFile, ADisplayThatGoesAwayDoesNotEndTheSession) {
  const ScratchFolder folder;
  const auto name = folder / "instructions.pipe";
  ASSERT_EQ(mkfifo(name.c_str(), 0600), 0);
  const int display = ::open(name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(display, 0);
  auto file = InstructionFile::open(name);
  ASSERT_TRUE(file) << file.error().message;
  (*file)->write({{"taken", true}});
  EXPECT_TRUE((*file)->is_open());
  ::close(display);
  for (int i = 0; i < 3; ++i) (*file)->write({{"taken", true}});  // a signal would have ended this test
  EXPECT_FALSE((*file)->is_open());
}

TEST(InstructionFile, WhatCannotBeWrittenIsRefusedInWords) {
  const auto none = InstructionFile::open("/nowhere/there/instructions");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("--instructions /nowhere/there/instructions: "), std::string::npos);
  const auto unnamed = InstructionFile::open("");
  ASSERT_TRUE(unnamed);
  (*unnamed)->write({{"taken", true}});
}

}  // namespace
}  // namespace palpate::calibration::session
