#include "drivers/cameras/internal/v4l2_text.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "palpate/core/text.h"

namespace palpate::drivers::cameras {
namespace {

constexpr FourccName kFourccs[] = {
    {V4L2_PIX_FMT_RGB24, PixelFormat::rgb8},       {V4L2_PIX_FMT_BGR24, PixelFormat::bgr8},
    {V4L2_PIX_FMT_SRGGB8, PixelFormat::bayer_rg8}, {V4L2_PIX_FMT_SGRBG8, PixelFormat::bayer_gr8},
    {V4L2_PIX_FMT_SGBRG8, PixelFormat::bayer_gb8}, {V4L2_PIX_FMT_SBGGR8, PixelFormat::bayer_bg8},
    {V4L2_PIX_FMT_YUYV, PixelFormat::yuyv},        {V4L2_PIX_FMT_UYVY, PixelFormat::uyvy},
    {V4L2_PIX_FMT_MJPEG, PixelFormat::mjpeg},      {V4L2_PIX_FMT_JPEG, PixelFormat::mjpeg},
    {V4L2_PIX_FMT_GREY, PixelFormat::mono8},
};

}  // namespace

std::span<const FourccName> known_fourccs() { return kFourccs; }

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(fourcc >> shift & 0x7F);
  return excerpt(text);
}

std::string opening_problem(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return fmt::format("{}: there is no such device; `palpate camera list` names those there are", path);
    case EACCES:
    case EPERM:
      return fmt::format(
          "{}: you may not read and write it; join group video (usermod -aG video USER), log in anew", path);
    case EBUSY:
      return fmt::format("{}: another program uses it; end that one", path);
    default:
      return fmt::format("{}: opening failed ({}); plug it in again", path, std::strerror(error));
  }
}

std::string text_of(const __u8* bytes, std::size_t size) {
  const auto* text = reinterpret_cast<const char*>(bytes);
  return excerpt({text, strnlen(text, size)});
}

bool can_capture(const v4l2_capability& about) {
  const auto can = (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps : about.capabilities;
  return (can & V4L2_CAP_VIDEO_CAPTURE) != 0 && (can & V4L2_CAP_STREAMING) != 0;
}

std::vector<std::uint32_t> formats_of(V4l2Io& io, int fd) {
  std::vector<std::uint32_t> found;
  for (unsigned i = 0; i < 64; ++i) {
    auto format = zeroed<v4l2_fmtdesc>();
    format.index = i;
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (io.control(fd, VIDIOC_ENUM_FMT, &format) != 0) break;
    found.push_back(format.pixelformat);
  }
  return found;
}

std::vector<std::string> names_of(const std::vector<std::uint32_t>& fourccs) {
  std::vector<std::string> names;
  for (const auto fourcc : fourccs) {
    const auto known = from_fourcc(fourcc);
    names.push_back(known ? std::string(name_of(*known)) : fourcc_text(fourcc));
  }
  return names;
}

std::optional<PixelFormat> from_fourcc(std::uint32_t fourcc) {
  for (const auto& known : kFourccs)
    if (known.fourcc == fourcc) return known.format;
  return std::nullopt;
}

V4l2Look look_at_v4l2(const std::string& path, V4l2Io& io) {
  V4l2Look look;
  look.path = path;
  const int fd = io.open(path.c_str());
  if (fd < 0) {
    look.problem = opening_problem(path, errno);
    return look;
  }
  auto about = zeroed<v4l2_capability>();
  if (io.control(fd, VIDIOC_QUERYCAP, &about) != 0) {
    look.problem = path + ": this is no video device; see what made that file";
  } else {
    look.model = text_of(about.card, sizeof about.card);
    look.camera = can_capture(about);
    if (look.camera) look.formats = names_of(formats_of(io, fd));
  }
  io.close(fd);
  return look;
}

std::vector<V4l2Look> list_v4l2(V4l2Io& io) {
  std::vector<std::pair<int, std::string>> paths;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", ignored)) {
    const std::string name = entry.path().filename();
    const bool numbered = name.size() > 5 && name.size() < 12 && name.starts_with("video") &&
                          name.find_first_not_of("0123456789", 5) == std::string::npos;
    if (numbered) paths.emplace_back(std::stoi(name.substr(5)), entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<V4l2Look> found;
  for (const auto& [number, path] : paths) found.push_back(look_at_v4l2(path, io));
  return found;
}

}  // namespace palpate::drivers::cameras
