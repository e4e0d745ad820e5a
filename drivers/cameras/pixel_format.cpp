#include "drivers/cameras/pixel_format.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "palpate/core/picture_size.h"

namespace palpate::drivers::cameras {
namespace {

constexpr std::string_view kFormatNames[] = {"RGB8",     "BGR8",     "Mono8", "BayerRG8", "BayerGR8",
                                             "BayerGB8", "BayerBG8", "YUYV",  "UYVY",     "MJPEG"};

std::size_t bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::rgb8:
    case PixelFormat::bgr8:
      return 3;
    case PixelFormat::yuyv:
    case PixelFormat::uyvy:
      return 2;
    case PixelFormat::mjpeg:
      return 0;
    default:
      return 1;
  }
}

// OpenCV names a Bayer pattern by the second row's second and third pixel, GenICam by the first row's first
// two: the pattern that begins with red and green is RG there and BG here.
int conversion(PixelFormat format) {
  switch (format) {
    case PixelFormat::bgr8:
      return cv::COLOR_BGR2RGB;
    case PixelFormat::mono8:
      return cv::COLOR_GRAY2RGB;
    case PixelFormat::bayer_rg8:
      return cv::COLOR_BayerBG2RGB;
    case PixelFormat::bayer_gr8:
      return cv::COLOR_BayerGB2RGB;
    case PixelFormat::bayer_gb8:
      return cv::COLOR_BayerGR2RGB;
    case PixelFormat::bayer_bg8:
      return cv::COLOR_BayerRG2RGB;
    case PixelFormat::yuyv:
      return cv::COLOR_YUV2RGB_YUYV;
    default:
      return cv::COLOR_YUV2RGB_UYVY;
  }
}

// The decoder fills what is missing of a JPEG with grey and says so on standard error only; but each whole
// one ends in a marker, after which cameras may leave a few bytes of an older, longer picture.
bool whole_jpeg(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t kBegin[] = {0xFF, 0xD8}, kEnd[] = {0xFF, 0xD9};
  return bytes.size() > 4 && std::equal(std::begin(kBegin), std::end(kBegin), bytes.begin()) &&
         std::find_end(bytes.begin() + 2, bytes.end(), std::begin(kEnd), std::end(kEnd)) != bytes.end();
}

Expected<void> decode_jpeg(const RawPicture& picture, std::vector<std::uint8_t>& rgb) {
  if (!whole_jpeg(picture.bytes)) return refused("a JPEG of {} bytes is cut off", picture.bytes.size());
  const auto size =
      picture_size({reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size()}, "a JPEG");
  if (!size) return refused("a JPEG of {} bytes is damaged", picture.bytes.size());
  if (size->width != picture.width || size->height != picture.height)
    return refused("a JPEG is {}x{} px where {}x{} were agreed", size->width, size->height, picture.width,
                   picture.height);
  cv::Mat decoded;
  try {
    const cv::Mat bytes(1, static_cast<int>(picture.bytes.size()), CV_8UC1,
                        const_cast<std::uint8_t*>(picture.bytes.data()));
    decoded = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {  // sizes that no memory holds
  }
  if (decoded.empty()) return refused("a JPEG of {} bytes is damaged", picture.bytes.size());
  if (decoded.cols != picture.width || decoded.rows != picture.height)
    return refused("a JPEG of {} bytes is not what its head says", picture.bytes.size());
  cv::Mat out(picture.height, picture.width, CV_8UC3, rgb.data());
  cv::cvtColor(decoded, out, cv::COLOR_BGR2RGB);
  return {};
}

}  // namespace

std::string_view name_of(PixelFormat format) { return kFormatNames[static_cast<std::size_t>(format)]; }

std::optional<PixelFormat> format_named(std::string_view name) {
  const auto* at = std::find(std::begin(kFormatNames), std::end(kFormatNames), name);
  if (at == std::end(kFormatNames)) return std::nullopt;
  return static_cast<PixelFormat>(at - std::begin(kFormatNames));
}

std::size_t packed_bytes(PixelFormat format, int width, int height) {
  return bytes_per_pixel(format) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

Expected<void> to_rgb(const RawPicture& picture, std::vector<std::uint8_t>& rgb) {
  const auto [format, width, height, wanted_stride, bytes] = picture;
  if (width <= 0 || height <= 0) return refused("a picture of {}x{} px", width, height);
  rgb.resize(packed_bytes(PixelFormat::rgb8, width, height));
  if (format == PixelFormat::mjpeg) return decode_jpeg(picture, rgb);
  const std::size_t row = packed_bytes(format, width, 1);
  const std::size_t stride = wanted_stride == 0 ? row : wanted_stride;
  const std::size_t needed = stride * static_cast<std::size_t>(height - 1) + row;
  if (stride < row || bytes.size() < needed)
    return refused("{} bytes came where a {} picture of {}x{} px has {}", bytes.size(), name_of(format),
                   width, height, needed);
  const bool paired = format == PixelFormat::yuyv || format == PixelFormat::uyvy;
  const bool bayer = format >= PixelFormat::bayer_rg8 && format <= PixelFormat::bayer_bg8;
  if ((paired && width % 2 != 0) || (bayer && (width < 4 || height < 4)))
    return refused("{} pictures of {}x{} px make no sense", name_of(format), width, height);
  if (format == PixelFormat::rgb8) {
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
      std::memcpy(rgb.data() + y * row, bytes.data() + y * stride, row);
    return {};
  }
  const cv::Mat in(height, width, CV_8UC(static_cast<int>(bytes_per_pixel(format))),
                   const_cast<std::uint8_t*>(bytes.data()), stride);
  cv::Mat out(height, width, CV_8UC3, rgb.data());
  cv::cvtColor(in, out, conversion(format));
  return {};
}

}  // namespace palpate::drivers::cameras
