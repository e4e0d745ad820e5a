#include "drivers/cameras/recorded_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <thread>

#include "drivers/cameras/live_camera.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::cameras {
namespace {

class Recorded : public testing::Test {
 protected:
  void image(const std::string& name, int width, int height, int value) {
    cv::imwrite((folder_ / name).string(), cv::Mat(height, width, CV_8UC3, cv::Scalar(value, value, value)));
  }
  void stamps(const std::string& text) { std::ofstream(folder_ / kStampsFile) << text; }
  std::string refusal() {
    const auto images = read_stamps(folder_.path());
    return images ? "accepted" : images.error().message;
  }
  ScratchFolder folder_;
};

bool ended(const LiveCamera& camera) {
  const auto health = camera.status().health;
  return health && health->code == device::HealthCode::recording_ended;
}

std::vector<Outcome> play(FrameSource& source) {
  std::vector<Outcome> outcomes;
  while (outcomes.size() < 1000) {
    auto outcome = source.wait(std::chrono::seconds(1));
    if (outcome.kind == Outcome::Kind::nothing) continue;
    if (outcome.kind == Outcome::Kind::ended) break;
    outcomes.push_back(std::move(outcome));
  }
  return outcomes;
}

struct Frames {
  std::vector<int> values;  // of the first byte
  std::vector<std::uint64_t> numbers;
  std::vector<std::int64_t> times;
};

// Fewer where something else than a frame comes.
Frames first_frames(FrameSource& source, std::size_t count) {
  Frames frames;
  while (frames.values.size() < count) {
    const auto outcome = source.wait(std::chrono::seconds(1));
    if (outcome.kind == Outcome::Kind::nothing) continue;
    if (outcome.kind != Outcome::Kind::frame) break;
    frames.values.push_back(outcome.frame.picture.bytes[0]);
    frames.numbers.push_back(outcome.frame.number);
    frames.times.push_back(outcome.frame.mid_exposure_ns);
  }
  return frames;
}

TEST_F(Recorded, ImagesComeInOrderWithTheirOwnStampsAndCounts) {
  for (const char* name : {"a.png", "b.png", "c.png"}) image(name, 16, 8, 50 + name[0] - 'a');
  stamps(
      "image,time_s,frame\na.png,1795376724.000000250,7\nb.png,1795376724.010,8\nc.png,1795376724.03,10\n");
  const auto source = make_folder_source(folder_.path());
  const auto facts = source->open();
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->width, 16);
  const auto [values, numbers, times] = first_frames(*source, 3);
  EXPECT_EQ(values, (std::vector<int>{50, 51, 52}));
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{7, 8, 10}));
  ASSERT_EQ(times.size(), 3u);
  // A double holds such a time to 0.24 us.
  EXPECT_NEAR(static_cast<double>(times[2] - times[0]), 30e6, 500);
  EXPECT_EQ(source->wait(std::chrono::seconds(1)).kind, Outcome::Kind::ended);
}

TEST_F(Recorded, LoopedItBeginsAgainWithStampsAndNumbersThatGoOn) {
  image("a.png", 16, 8, 50), image("b.png", 16, 8, 51);
  stamps("image,time_s,frame\na.png,5.00,7\nb.png,5.02,9\n");
  const auto source = make_folder_source(folder_.path(), true);
  ASSERT_TRUE(source->open());
  const auto [values, numbers, times] = first_frames(*source, 5);
  EXPECT_EQ(values, (std::vector<int>{50, 51, 50, 51, 50}));
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{7, 9, 10, 12, 13}));
  ASSERT_EQ(times.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(times[i], 5'000'000'000 + static_cast<int>(i) * 20'000'000);
}

TEST_F(Recorded, ALoneImageLoopedComesAsOftenAsAFilm) {
  image("a.png", 16, 8, 50);
  stamps("image,time_s\na.png,1\n");
  const auto source = make_folder_source(folder_.path(), true);
  ASSERT_TRUE(source->open());
  std::vector<std::int64_t> times;
  while (times.size() < 3) {
    const auto outcome = source->wait(std::chrono::seconds(1));
    if (outcome.kind == Outcome::Kind::frame) times.push_back(outcome.frame.mid_exposure_ns);
  }
  EXPECT_EQ(times[1] - times[0], 33'333'333);
  EXPECT_EQ(times[2] - times[1], 33'333'333);
}

TEST_F(Recorded, ALongPauseBetweenTwoImagesDoesNotBeginItAnew) {
  image("a.png", 16, 8, 1), image("b.png", 16, 8, 2);
  const double pause_s = 0.3 + to_seconds(std::max(LiveCamera::kOpenAnew, LiveCamera::kFirstPicture));
  stamps("image,time_s\na.png,0\nb.png," + std::to_string(pause_s) + "\n");
  const auto camera = LiveCamera::open(make_folder_source(folder_.path()));
  ASSERT_TRUE(camera);
  for (int i = 0; i < 2000 && !ended(**camera); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(ended(**camera));
  EXPECT_EQ((*camera)->status().pictures, 2u);
  EXPECT_EQ((*camera)->status().times_opened, 1u);
}

TEST_F(Recorded, ADamagedImageIsSaidAndTheRestGoesOn) {
  image("a.png", 16, 8, 1), image("c.png", 16, 8, 3);
  std::ofstream(folder_ / "b.png") << "no image";
  stamps("image,time_s\na.png,0\nb.png,0.001\nc.png,0.002\n");
  const auto source = make_folder_source(folder_.path());
  ASSERT_TRUE(source->open());
  const auto outcomes = play(*source);
  ASSERT_EQ(outcomes.size(), 3u);
  EXPECT_EQ(outcomes[1].kind, Outcome::Kind::damaged);
  EXPECT_EQ(outcomes[1].words,
            "b.png cannot be read as an image; record it anew or take its line out of stamps.csv");
  EXPECT_EQ(outcomes[2].kind, Outcome::Kind::frame);
  std::ofstream(folder_ / "a.png") << "no image";
  std::ofstream(folder_ / "c.png") << "no image";
  EXPECT_NE(
      make_folder_source(folder_.path())->open().error().message.find("none of its 3 images can be read"),
      std::string::npos);
}

TEST_F(Recorded, TablesThatCannotBeARecordingAreRefusedWithTheirLine) {
  EXPECT_NE(refusal().find("columns image,time_s are expected"), std::string::npos);
  image("a.png", 16, 8, 1), image("b.png", 16, 8, 2);
  const std::pair<const char*, const char*> tables[] = {
      {"image,time_s\nb.png,2\na.png,1\n", "stamps.csv:3: a.png comes after b.png and is no later"},
      {"image,time_s\na.png,1\nb.png,1\n", "stamps.csv:3: b.png comes after a.png"},
      {"image,time_s,frame\na.png,1,5\nb.png,2,5\n", "times and frames must rise"},
      {"image,time_s,frame\na.png,1,0.5\n", "a whole number is expected"},
      {"image,time_s\na.png,1\nc.png,2\n", "stamps.csv:3: there is no file"},
      {"image,time_s\na.png,1000\nb.png,2000\n", "is time_s in s?"},
      {"image,time_s\na.png,1e300\n", "stamps.csv:2: "},
      {"image,time_s\na.png,nan\n", "stamps.csv:2: "},
      {"image,when\na.png,1\n", "time_s"},
      {"image,time_s\n", "names no image"},
  };
  for (const auto& [text, words] : tables) {
    stamps(text);
    EXPECT_NE(refusal().find(words), std::string::npos) << text << refusal();
  }
  EXPECT_NE(read_stamps(folder_ / "none").error().message.find("there is no such folder"), std::string::npos);
}

TEST_F(Recorded, ImagesOfAnotherSizeThanTheLensAreSaidByTheCamera) {
  image("a.png", 16, 8, 1), image("b.png", 20, 8, 2);
  stamps("image,time_s\na.png,0\nb.png,0.001\n");
  auto camera = LiveCamera::open(make_folder_source(folder_.path()), 16, 8);
  ASSERT_TRUE(camera);
  while (!ended(**camera)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ((*camera)->status().pictures, 1u);
  EXPECT_EQ((*camera)->status().damaged, 1u);
}

TEST_F(Recorded, AVideoHasTheTimesOfItsContainer) {
  const auto file = folder_ / "film.avi";
  {
    cv::VideoWriter writer(file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 50.0,
                           {64, 48});
    ASSERT_TRUE(writer.isOpened());
    for (int i = 0; i < 6; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(40 * i)));
  }
  const auto source = make_video_source(file);
  const auto facts = source->open();
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->width, 64);
  for (int i = 0; i < 6;) {
    const auto outcome = source->wait(std::chrono::seconds(1));
    if (outcome.kind == Outcome::Kind::nothing) continue;
    ASSERT_EQ(outcome.kind, Outcome::Kind::frame) << outcome.words;
    EXPECT_EQ(outcome.frame.mid_exposure_ns, i * 20'000'000) << i;
    EXPECT_NEAR(outcome.frame.picture.bytes[3000], 40 * i, 3);  // JPEG
    ++i;
  }
  EXPECT_EQ(source->wait(std::chrono::seconds(1)).kind, Outcome::Kind::ended);
  const auto looped = make_video_source(file, true);
  ASSERT_TRUE(looped->open());
  for (int i = 0; i < 8;) {
    const auto outcome = looped->wait(std::chrono::seconds(1));
    if (outcome.kind == Outcome::Kind::nothing) continue;
    ASSERT_EQ(outcome.kind, Outcome::Kind::frame) << outcome.words;
    EXPECT_EQ(outcome.frame.mid_exposure_ns, i * 20'000'000) << i;
    EXPECT_NEAR(outcome.frame.picture.bytes[3000], 40 * (i % 6), 3);
    ++i;
  }
  std::ofstream(folder_ / "text.mp4") << "no film";
  EXPECT_NE(make_video_source(folder_ / "text.mp4")->open().error().message.find("cannot be read as a video"),
            std::string::npos);
  EXPECT_NE(make_video_source(folder_ / "none.mp4")->open().error().message.find("no such file"),
            std::string::npos);
}

// Its head says 20000x20000 px, and nothing unpacks it.
TEST_F(Recorded, AnImageLargerThanAnyCamerasIsOneThatCannotBeRead) {
  image("b.png", 16, 8, 50);
  std::ifstream in(folder_ / "b.png", std::ios::binary);
  std::string content(std::istreambuf_iterator<char>(in), {});
  ASSERT_GT(content.size(), 24u);
  content.replace(16, 8, std::string("\x00\x00\x4E\x20\x00\x00\x4E\x20", 8));
  std::ofstream(folder_ / "a.png", std::ios::binary) << content;
  stamps("image,time_s\na.png,1.0\nb.png,1.01\n");
  const auto source = make_folder_source(folder_.path());
  const auto facts = source->open();
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->width, 16) << "of the one that can be read";
  const auto outcomes = play(*source);
  ASSERT_EQ(outcomes.size(), 2u);
  EXPECT_EQ(outcomes[0].kind, Outcome::Kind::damaged);
  EXPECT_EQ(outcomes[1].kind, Outcome::Kind::frame);
}

TEST(RecordedTimes, KeepTheirNanoseconds) {
  EXPECT_EQ(device::stamp_text(1'795'376'724'824'567'001), "1795376724.824567001");
  EXPECT_EQ(device::stamp_text(-1), "-0.000000001");
}

}  // namespace
}  // namespace palpate::drivers::cameras
