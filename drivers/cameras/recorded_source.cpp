#include "drivers/cameras/recorded_source.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <system_error>
#include <thread>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/picture_size.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::cameras {
namespace {

// A longer way between two images is no recording of one go, and would look like a dead camera.
constexpr double kLongestGapS = 60.0;
constexpr double kLatestS = 1e10;  // three centuries: beyond the integer range of nanoseconds, and no clock

std::int64_t player_ns() { return MonotonicClock<GraphicsClock>::monotonic_ns(); }

// Empty where it is no picture, or one larger than any camera's.
cv::Mat read_picture(const std::filesystem::path& file) {
  const auto bytes = read_file(file, kMostPictureBytes);
  if (!bytes || !picture_size(*bytes, file.string())) return {};
  try {
    const cv::Mat raw(1, static_cast<int>(bytes->size()), CV_8UC1, const_cast<char*>(bytes->data()));
    return cv::imdecode(raw, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

// What folder and video have in common: the pace.
class Recording : public FrameSource {
 public:
  Recording(std::string name, bool loop) : name_(std::move(name)), loop_(loop) {}
  const std::string& name() const override { return name_; }

  Outcome wait(Duration longest) override {
    if (!ready_) {
      ready_ = next_or_first();
      if (!ready_) return {Outcome::Kind::ended, {}, {}};
    }
    if (!begun_ns_) begun_ns_ = player_ns(), first_ns_ = ready_->frame.mid_exposure_ns;
    const std::int64_t due = *begun_ns_ + ready_->frame.mid_exposure_ns - first_ns_;
    const Duration ahead(due - player_ns());
    if (ahead > Duration(0)) std::this_thread::sleep_for(std::min(ahead, longest));
    if (ahead > longest) return {};
    Outcome outcome = std::move(*ready_);
    ready_.reset();
    shown_ = coming_;
    outcome.frame.picture = {
        PixelFormat::bgr8,
        shown_.cols,
        shown_.rows,
        shown_.step[0],
        {shown_.data, shown_.empty() ? 0 : shown_.step[0] * static_cast<std::size_t>(shown_.rows)}};
    return outcome;
  }

  void close() override {
    ready_.reset(), begun_ns_.reset(), before_.reset();
    later_ns_ = 0, more_ = 0;
  }
  bool keeps_its_own_pace() const override { return true; }

 protected:
  // The next frame's time and number, its picture left in coming_; nothing at the end.
  virtual std::optional<Outcome> next() = 0;
  // The first one is the next again; false where it cannot be had.
  virtual bool rewind() = 0;
  cv::Mat coming_;

 private:
  static constexpr std::int64_t kLoneIntervalNs = 33'333'333;  // where there is one picture alone

  std::optional<Outcome> next_or_first() {
    auto outcome = next();
    if (!outcome && loop_ && before_ && rewind()) {
      outcome = next();
      if (!outcome) return std::nullopt;
      later_ns_ = before_->mid_exposure_ns + interval_ns_ - outcome->frame.mid_exposure_ns;
      more_ = before_->number + 1 - outcome->frame.number;
    }
    if (!outcome) return std::nullopt;
    outcome->frame.mid_exposure_ns += later_ns_;
    outcome->frame.number += more_;
    if (before_ && outcome->frame.mid_exposure_ns > before_->mid_exposure_ns)
      interval_ns_ = outcome->frame.mid_exposure_ns - before_->mid_exposure_ns;
    before_ = Before{outcome->frame.mid_exposure_ns, outcome->frame.number};
    return outcome;
  }

  struct Before {
    std::int64_t mid_exposure_ns = 0;
    std::uint64_t number = 0;
  };
  std::string name_;
  bool loop_;
  std::optional<Before> before_;
  std::int64_t interval_ns_ = kLoneIntervalNs, later_ns_ = 0;
  std::uint64_t more_ = 0;
  std::optional<Outcome> ready_;
  cv::Mat shown_;
  std::optional<std::int64_t> begun_ns_;
  std::int64_t first_ns_ = 0;
};

class FolderSource : public Recording {
 public:
  FolderSource(std::filesystem::path folder, bool loop)
      : Recording("images:" + folder.string(), loop), folder_(std::move(folder)) {}

  Expected<CameraFacts> try_open() override {
    auto images = read_stamps(folder_);
    if (!images)
      return tl::unexpected(Error{images.error().kind, "camera images: " + images.error().message});
    images_ = std::move(*images);
    at_ = 0;
    CameraFacts facts;
    facts.model = counted(images_.size(), "image");
    facts.format = PixelFormat::bgr8;
    facts.stamp = "mid-exposure, as recorded";
    // The longest way decides when silence is one.
    std::int64_t longest = 0;
    for (std::size_t i = 1; i < images_.size(); ++i)
      longest = std::max(longest, images_[i].mid_exposure_ns - images_[i - 1].mid_exposure_ns);
    if (longest > 0) facts.rate_hz = 1e9 / static_cast<double>(longest);
    for (const auto& image : images_) {  // of the first that can be read
      const cv::Mat picture = read_picture(image.file);
      if (picture.empty()) continue;
      facts.width = picture.cols, facts.height = picture.rows;
      break;
    }
    if (facts.width == 0)
      return refused("camera {}: none of its {} can be read; PNG or JPEG files are expected", name(),
                     counted(images_.size(), "image"));
    return facts;
  }

 private:
  bool rewind() override {
    at_ = 0;
    return true;
  }
  std::optional<Outcome> next() override {
    if (at_ == images_.size()) return std::nullopt;
    const auto& image = images_[at_++];
    Outcome outcome{Outcome::Kind::frame, {}, {}};
    outcome.frame.mid_exposure_ns = image.mid_exposure_ns;
    outcome.frame.number = image.number;
    coming_ = read_picture(image.file);
    if (coming_.empty()) {
      outcome.kind = Outcome::Kind::damaged;
      outcome.words = fmt::format("{} cannot be read as an image; record it anew or take its line out of {}",
                                  image.file.filename().string(), kStampsFile);
    }
    return outcome;
  }

  const std::filesystem::path folder_;
  std::vector<RecordedImage> images_;
  std::size_t at_ = 0;
};

class VideoSource : public Recording {
 public:
  VideoSource(std::filesystem::path file, bool loop)
      : Recording("video:" + file.string(), loop), file_(std::move(file)) {}

  Expected<CameraFacts> try_open() override {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file_, ignored))
      return wrong_use("camera {}: there is no such file; the path of a video is expected", name());
    number_ = 0, last_ns_ = -1;
    // FFmpeg would print its own opinion of a damaged file; ours is one line.
    ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
    if (!video_.open(file_.string(), cv::CAP_FFMPEG) || video_.get(cv::CAP_PROP_FRAME_WIDTH) < 1.0)
      return refused(
          "camera {}: cannot be read as a video; MP4, AVI or another that FFmpeg knows is expected", name());
    CameraFacts facts;
    facts.model = "video";
    facts.width = static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH));
    facts.height = static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT));
    if (static_cast<double>(facts.width) * facts.height > static_cast<double>(kMostPixels))
      return refused("camera {}: its pictures have {}x{} px; at most {} million pixels are expected", name(),
                     facts.width, facts.height, kMostPixels / 1'000'000);
    facts.rate_hz = video_.get(cv::CAP_PROP_FPS);
    if (!(facts.rate_hz > 0.0 && facts.rate_hz < 1e4)) facts.rate_hz = 0.0;
    facts.format = PixelFormat::bgr8;
    facts.stamp = "the container's times, taken as mid-exposure";
    return facts;
  }

  void close() override {
    video_.release();
    Recording::close();
  }

 private:
  bool rewind() override {
    video_.release();
    number_ = 0, last_ns_ = -1;
    return video_.open(file_.string(), cv::CAP_FFMPEG);
  }
  std::optional<Outcome> next() override {
    cv::Mat picture;
    if (!video_.read(picture) || picture.empty()) return std::nullopt;
    coming_ = picture.clone();  // the decoder's own memory
    Outcome outcome{Outcome::Kind::frame, {}, {}};
    outcome.frame.number = ++number_;
    outcome.frame.mid_exposure_ns = std::llround(video_.get(cv::CAP_PROP_POS_MSEC) * 1e6);
    if (outcome.frame.mid_exposure_ns <= last_ns_) {
      outcome.kind = Outcome::Kind::damaged;
      outcome.words = fmt::format("picture {} of the video has no later time than the one before", number_);
      outcome.frame.mid_exposure_ns = last_ns_;
    }
    last_ns_ = outcome.frame.mid_exposure_ns;
    return outcome;
  }

  const std::filesystem::path file_;
  cv::VideoCapture video_;
  std::uint64_t number_ = 0;
  std::int64_t last_ns_ = -1;
};

}  // namespace

Expected<std::vector<RecordedImage>> read_stamps(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored))
    return wrong_use("{}: there is no such folder; one with images and {} is expected", folder.string(),
                     kStampsFile);
  const auto file = folder / kStampsFile;
  if (!std::filesystem::exists(file, ignored))
    return wrong_use(
        "{}: there is no such table; columns image,time_s are expected, as `palpate camera record` writes "
        "them",
        file.string());
  const auto table = read_csv(file);
  if (!table) return tl::unexpected(table.error());
  const auto image = table->require("image");
  if (!image) return tl::unexpected(image.error());
  const auto time = table->require("time_s");
  if (!time) return tl::unexpected(time.error());
  if (auto sane = table->require_within({*time}, kLatestS); !sane) return tl::unexpected(sane.error());
  const auto frame = table->find("frame");
  if (frame)
    if (auto fine = table->require_numbers({*frame}); !fine) return tl::unexpected(fine.error());
  if (table->rows.empty()) return refused("{}: names no image", file.string());
  std::vector<RecordedImage> images;
  for (std::size_t row = 0; row < table->rows.size(); ++row) {
    const auto place = [&] { return fmt::format("{}:{}", file.string(), table->line[row]); };
    RecordedImage next{folder / table->text[row][*image], std::llround(table->rows[row][*time] * 1e9),
                       row + 1};
    if (frame) {
      const double number = table->rows[row][*frame];
      if (!(number >= 0.0 && number < 9e15 && number == std::floor(number)))
        return wrong_use("{}: frame is {:g}; a whole number is expected", place(), number);
      next.number = static_cast<std::uint64_t>(number);
    }
    if (!images.empty()) {
      const auto& last = images.back();
      if (next.mid_exposure_ns <= last.mid_exposure_ns || next.number <= last.number)
        return wrong_use("{}: {} comes after {} and is no later; times{} must rise, sort the table", place(),
                         excerpt(next.file.filename().string()), excerpt(last.file.filename().string()),
                         frame ? " and frames" : "");
      const double gap_s = 1e-9 * static_cast<double>(next.mid_exposure_ns - last.mid_exposure_ns);
      if (gap_s > kLongestGapS)
        return wrong_use("{}: {:g} s after the image before; at most {:g} s are expected, is time_s in s?",
                         place(), gap_s, kLongestGapS);
    }
    if (!std::filesystem::is_regular_file(next.file, ignored))
      return wrong_use("{}: there is no file {}; put it there or take its line out", place(),
                       excerpt(next.file.string(), 120));
    images.push_back(std::move(next));
  }
  return images;
}

std::unique_ptr<FrameSource> make_folder_source(std::filesystem::path folder, bool loop) {
  return std::make_unique<FolderSource>(std::move(folder), loop);
}
std::unique_ptr<FrameSource> make_video_source(std::filesystem::path file, bool loop) {
  return std::make_unique<VideoSource>(std::move(file), loop);
}

}  // namespace palpate::drivers::cameras
