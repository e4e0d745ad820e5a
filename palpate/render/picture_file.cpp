#include "palpate/render/picture_file.h"

#include <algorithm>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <system_error>

#include "palpate/core/file.h"
#include "palpate/core/picture_size.h"

namespace palpate::render {
namespace {

cv::Mat blue_first(std::span<const std::uint8_t> rgb, int width, int height) {
  if (width <= 0 || height <= 0 ||
      rgb.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3) {
    throw std::invalid_argument("picture: " + std::to_string(rgb.size()) + " bytes for " +
                                std::to_string(width) + "x" + std::to_string(height));
  }
  cv::Mat view(height, width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data())), turned;
  cv::cvtColor(view, turned, cv::COLOR_RGB2BGR);
  return turned;
}

std::string encoded(const char* format, std::span<const std::uint8_t> rgb, int width, int height,
                    const std::vector<int>& how) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(format, blue_first(rgb, width, height), bytes, how))
    throw std::runtime_error(std::string("picture: encoding as ") + format + " failed");
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::string png_bytes(std::span<const std::uint8_t> rgb, int width, int height) {
  return encoded(".png", rgb, width, height, {cv::IMWRITE_PNG_COMPRESSION, 6});
}

std::string jpeg_bytes(std::span<const std::uint8_t> rgb, int width, int height) {
  return encoded(".jpg", rgb, width, height, {cv::IMWRITE_JPEG_QUALITY, 95});
}

bool read_picture(std::string_view bytes, std::vector<std::uint8_t>& rgb, int& width, int& height) {
  if (!picture_size(bytes, "picture")) return false;  // of too many pixels, too
  const cv::Mat packed(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  const cv::Mat picture = cv::imdecode(packed, cv::IMREAD_COLOR);
  if (picture.empty()) return false;
  cv::Mat turned;
  cv::cvtColor(picture, turned, cv::COLOR_BGR2RGB);
  width = turned.cols;
  height = turned.rows;
  rgb.assign(turned.datastart, turned.dataend);
  return true;
}

Expected<void> write_png(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                         int height) {
  return write_file(path, png_bytes(rgb, width, height));
}

void burn_captions(std::vector<std::uint8_t>& rgb, int width, int height,
                   const std::vector<std::string>& lines, int eyes) {
  if (lines.empty()) return;
  const cv::Mat all(height, width, CV_8UC3, rgb.data());
  constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
  const double scale = 0.5 * height / 480.0;
  const int line_height = static_cast<int>(std::lround(22.0 * height / 480.0)), border = line_height / 2;
  int widest = 0;
  for (const auto& line : lines)
    widest = std::max(widest, cv::getTextSize(line, font, scale, 1, nullptr).width);
  const int eye_width = width / eyes;
  const cv::Rect band =
      cv::Rect(0, 0, widest + 2 * border, static_cast<int>(lines.size()) * line_height + border) &
      cv::Rect(0, 0, eye_width, height);
  for (int eye = 0; eye < eyes; ++eye) {
    cv::Mat view = all(cv::Rect(eye * eye_width, 0, eye_width, height));
    view(band) *= 0.35;
    int y = line_height;
    for (const auto& line : lines) {
      cv::putText(view, line, {border, y}, font, scale, {245, 245, 245}, 1, cv::LINE_AA);
      y += line_height;
    }
  }
}

// True where the file consists of whole boxes (ISO 14496-12) with an index among them. The encoder does not
// tell when the disk is full; a film cut off lacks its index, which is written last.
bool whole_film(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  std::uintmax_t at = 0;
  bool index = false;
  while (in && !error && at < size) {
    const auto number = [&in](int bytes) {
      std::uintmax_t value = 0;
      for (; bytes > 0; --bytes) value = value << 8 | static_cast<unsigned char>(in.get());
      return value;
    };
    in.seekg(static_cast<std::streamoff>(at));
    std::uintmax_t length = number(4);
    const std::uintmax_t kind = number(4);
    if (length == 1) length = number(8);
    if (length < 8 || length > size - at) return false;
    index = index || kind == 0x6d6f6f76;  // "moov"
    at += length;
  }
  return index && at == size;
}

struct VideoFile::Impl {
  std::filesystem::path path, unfinished;
  int width = 0, height = 0;
  std::string codec;
  cv::VideoWriter writer;
  bool open = false;
  ~Impl() {
    if (!open) return;
    writer.release();
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
  }
};

VideoFile::VideoFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoFile::VideoFile(VideoFile&&) noexcept = default;
VideoFile& VideoFile::operator=(VideoFile&&) noexcept = default;
VideoFile::~VideoFile() = default;
const std::string& VideoFile::codec() const { return impl_->codec; }

Expected<VideoFile> VideoFile::create(const std::filesystem::path& path, int width, int height,
                                      double frames_per_s) {
  if (width <= 0 || height <= 0 || width % 2 != 0 || height % 2 != 0 || !(frames_per_s > 0)) {
    return wrong_use("video {}: {}x{} at {} frames/s; H.264 needs an even, positive size and a positive rate",
                     path.string(), width, height, frames_per_s);
  }
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->unfinished = path.parent_path() / ("." + path.stem().string() + ".unfinished.mp4");
  impl->width = width;
  impl->height = height;
  const std::pair<int, const char*> codecs[] = {{cv::VideoWriter::fourcc('a', 'v', 'c', '1'), "h264"},
                                                {cv::VideoWriter::fourcc('m', 'p', '4', 'v'), "mpeg4"}};
  for (const auto& [code, name] : codecs) {
    if (impl->writer.open(impl->unfinished.string(), cv::CAP_FFMPEG, code, frames_per_s, {width, height},
                          true)) {
      impl->codec = name;
      impl->open = true;
      return VideoFile(std::move(impl));
    }
  }
  return refused(
      "video {}: cannot be opened for H.264 or MPEG-4; is the folder writable, and does OpenCV have FFmpeg "
      "(libopencv-videoio-dev)?",
      path.string());
}

void VideoFile::add(std::span<const std::uint8_t> rgb) {
  impl_->writer.write(blue_first(rgb, impl_->width, impl_->height));
}

Expected<void> VideoFile::close() {
  if (!impl_->open) return {};
  impl_->writer.release();
  impl_->open = false;
  std::error_code error;
  if (!whole_film(impl_->unfinished)) {
    std::filesystem::remove(impl_->unfinished, error);
    return refused("video {}: could not be written whole; is the disk full? free some space and try again",
                   impl_->path.string());
  }
  std::filesystem::rename(impl_->unfinished, impl_->path, error);
  if (error) return refused("video {}: {}", impl_->path.string(), error.message());
  return {};
}

std::string picture_library() { return "OpenCV " + cv::getVersionString(); }

}  // namespace palpate::render
