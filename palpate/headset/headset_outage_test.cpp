// A runtime that is not there, goes, hangs and returns.
#include <gtest/gtest.h>

#include "palpate/headset/headset_for_tests.h"

namespace palpate::headset {
namespace {

bool has(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

class HeadsetOutage : public HeadsetTest {
 protected:
  HeadsetOutage() { settings.retry = std::chrono::milliseconds(20); }
  void show_a_picture() {
    const std::vector<std::uint8_t> rgb(640 * 480 * 3, 77);
    headset->show({rgb, 640, 480, now(), 0.6});
  }
  std::string refusal() {
    const auto opened = Headset::open(settings);
    EXPECT_FALSE(opened);
    const std::string words = opened ? "" : opened.error().message;
    EXPECT_EQ(words.find('\n'), std::string::npos) << words;
    return words;
  }
};

TEST_F(HeadsetOutage, ARuntimeThatHasGoneIsToldAndItsReturnIsFound) {
  open();
  refresh(3);
  show_a_picture();
  refresh();
  EXPECT_FALSE(headset->trouble(now()));
  runtime.vanish();
  ASSERT_TRUE(comes_to_be([this] { return headset->trouble(now()).has_value(); }));
  const std::string words = *headset->trouble(now());
  EXPECT_TRUE(has(words, "XR_ERROR_INSTANCE_LOST")) << words;
  EXPECT_EQ(headset->facts().state, HeadsetState::absent);
  EXPECT_EQ(headset->facts().losses, 1U);
  show_a_picture();  // the frame loop goes on as before
  runtime.return_again();
  ASSERT_TRUE(comes_to_be([this] { return runtime.refresh(0.01); }));
  EXPECT_FALSE(headset->trouble(now()));
  EXPECT_EQ(headset->facts().state, HeadsetState::showing);
  show_a_picture();
  refresh();
  EXPECT_EQ(runtime.counts().quads, 1U);
  EXPECT_EQ(runtime.counts().instances, 2U);
}

// Times are told, so the half second is one of the caller's clock.
TEST_F(HeadsetOutage, ARuntimeThatHangsIsToldWithinHalfASecond) {
  open();
  refresh(3);
  runtime.hang(true);
  EXPECT_FALSE(runtime.refresh(0.05));
  const auto since = now();
  EXPECT_FALSE(headset->trouble(since));
  EXPECT_FALSE(headset->trouble(since + std::chrono::milliseconds(290)));
  const auto words = headset->trouble(since + std::chrono::milliseconds(300));
  ASSERT_TRUE(words);
  EXPECT_TRUE(has(*words, "no longer answers")) << *words;
  show_a_picture();  // and nobody is held up
  runtime.hang(false);
  refresh();
  EXPECT_FALSE(headset->trouble(since + std::chrono::milliseconds(500)));
}

TEST_F(HeadsetOutage, OneThatHangsForGoodIsLeftBehindAtTheEnd) {
  settings.closing = std::chrono::milliseconds(50);
  open();
  refresh(3);
  runtime.hang(true);
  EXPECT_FALSE(runtime.refresh(0.05));
  {
    const LogCapture log;
    headset.reset();  // returns, though its thread does not
    EXPECT_TRUE(has(log.text(), "left to itself")) << log.text();
  }
  EXPECT_TRUE(runtime.counts().waiting);
  runtime.run_by_itself();  // and it ends once it is let go
  EXPECT_TRUE(comes_to_be([this] { return !runtime.counts().waiting && !runtime.instance_open(); }));
}

TEST_F(HeadsetOutage, ARuntimeThatEndsTheSessionIsReachedAnew) {
  open();
  refresh(3);
  runtime.end_session_by_force();
  ASSERT_TRUE(comes_to_be([this] { return headset->facts().losses == 1; }));
  ASSERT_TRUE(comes_to_be([this] { return runtime.refresh(0.01); }));
  EXPECT_EQ(headset->facts().state, HeadsetState::showing);
}

TEST_F(HeadsetOutage, WhatIsMissingIsRefusedWithTheRemedy) {
  using Refusal = TestRuntime::Refusal;
  runtime.refuse(Refusal::no_service);
  EXPECT_TRUE(has(refusal(), "monado-service"));
  EXPECT_FALSE(Headset::look_for());
  runtime.refuse(Refusal::no_headset);
  EXPECT_TRUE(has(refusal(), "plug it in"));
  runtime.refuse(Refusal::no_egl);
  EXPECT_TRUE(has(refusal(), "XR_MNDX_egl_enable"));
  runtime.refuse(Refusal::no_times);
  EXPECT_TRUE(has(refusal(), "XR_KHR_convert_timespec_time"));
  runtime.refuse(Refusal::none);
  // The loader keeps what a runtime offered until an instance has been tried.
  EXPECT_TRUE(comes_to_be([] { return Headset::look_for().has_value(); }));
  runtime.refuse(Refusal::no_srgb);
  EXPECT_TRUE(has(refusal(), "GL_SRGB8_ALPHA8"));
  runtime.refuse(Refusal::none);
  const auto found = Headset::look_for();
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->device, "test headset");
  EXPECT_EQ(found->runtime, "Palpate's test runtime 1.2.3");
}

TEST_F(HeadsetOutage, WithoutAnyRuntimeThereIsNone) {
  setenv("XR_RUNTIME_JSON", "/nonexistent/openxr.json", 1);
  EXPECT_TRUE(has(refusal(), "no OpenXR runtime is there"));
}

TEST_F(HeadsetOutage, OneEyeOrTwoAreExpected) {
  settings.eyes.clear();
  EXPECT_THROW((void)Headset::open(settings), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::headset
