#include "palpate/transport/shown_picture.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "palpate/core/file.h"
#include "palpate/core/file_descriptor.h"
#include "palpate/core/text.h"

namespace palpate::transport {
namespace {

constexpr const char *kWanted = "picture_wanted", *kPicture = "picture";
constexpr std::size_t kMostHead = 1000 + 30 * ShownPicture::kMostLandmarks;

Json head_of(const ShownPicture& p) {
  return {{"writer", p.writer},
          {"number", p.number},
          {"width", p.width},
          {"height", p.height},
          {"pose", p.pose},
          {"landmarks_used", p.landmarks_used},
          {"landmarks_predicted", p.landmarks_predicted},
          {"landmark_rms_px", p.landmark_rms_px},
          {"expected_overlay_px", p.expected_overlay_px ? Json(*p.expected_overlay_px) : Json()},
          {"landmarks", landmarks_json(p)}};
}

std::vector<ShownPicture::Landmark> read_landmarks(const Json& list) {
  std::vector<ShownPicture::Landmark> landmarks;
  for (const Json& one : list)
    if (landmarks.size() < ShownPicture::kMostLandmarks)
      landmarks.push_back({one.at(0).get<double>(), one.at(1).get<double>(), one.at(2).get<bool>()});
  return landmarks;
}

// Nothing where it is none: another process of this user may have written anything there.
std::optional<ShownPicture> read_head(std::string_view line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  try {
    ShownPicture p;
    p.writer = json.at("writer").get<std::int64_t>();
    p.number = json.at("number").get<std::uint64_t>();
    p.width = json.at("width").get<int>();
    p.height = json.at("height").get<int>();
    p.pose = excerpt(json.at("pose").get<std::string>(), 40);
    p.landmarks_used = json.at("landmarks_used").get<int>();
    p.landmarks_predicted = json.at("landmarks_predicted").get<int>();
    p.landmark_rms_px = json.at("landmark_rms_px").get<double>();
    if (!json.at("expected_overlay_px").is_null())
      p.expected_overlay_px = json["expected_overlay_px"].get<double>();
    p.landmarks = read_landmarks(json.at("landmarks"));
    const auto fits = [](int side) { return side > 0 && side <= ShownPicture::kMostSide; };
    return fits(p.width) && fits(p.height) ? std::optional(std::move(p)) : std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

// Within kWantedFor of now, by whichever clock the files have.
bool touched_lately(const std::filesystem::path& file) {
  constexpr auto kFor = ShownPictureWriter::kWantedFor;
  struct stat info {};
  timespec now{};
  if (::stat(file.c_str(), &info) != 0 || ::clock_gettime(CLOCK_REALTIME, &now) != 0) return false;
  const auto age = std::chrono::seconds(now.tv_sec - info.st_mtim.tv_sec);
  return age >= -kFor && age <= kFor;
}

}  // namespace

Json landmarks_json(const ShownPicture& picture) {
  Json list = Json::array();
  const auto tenths = [](double px) { return std::round(10.0 * px) / 10.0; };
  for (const auto& one : picture.landmarks) list.push_back({tenths(one.x), tenths(one.y), one.used});
  return list;
}

bool ShownPictureWriter::due() const {
  if (written_ && std::chrono::steady_clock::now() - *written_ < kAtMostEvery) return false;
  return touched_lately(folder_ / kWanted);
}

void ShownPictureWriter::write(const ShownPicture& picture, std::span<const std::uint8_t> rgb) {
  written_ = std::chrono::steady_clock::now();
  // Not as write_file(), which waits until it is on the disk.
  const auto part = folder_ / fmt::format("{}.{}", kPicture, ::getpid());
  FileDescriptor file(::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (file.get() < 0) return;
  std::string head = head_of(picture).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  iovec parts[2] = {{head.data(), head.size()}, {const_cast<std::uint8_t*>(rgb.data()), rgb.size()}};
  const bool whole = ::writev(file.get(), parts, 2) == static_cast<ssize_t>(head.size() + rgb.size());
  if (!whole || std::rename(part.c_str(), (folder_ / kPicture).c_str()) != 0) ::unlink(part.c_str());
}

bool ShownPictureReader::want() {
  const auto name = folder_ / kWanted;
  const FileDescriptor file(
      ::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600));
  return file.get() >= 0 && ::futimens(file.get(), nullptr) == 0;
}

std::optional<ShownPicture> ShownPictureReader::take() {
  const auto name = folder_ / kPicture;
  if (!touched_lately(name)) return std::nullopt;
  constexpr std::size_t kSide = ShownPicture::kMostSide;
  const auto bytes = read_file(name, kMostHead + 3 * kSide * kSide);
  if (!bytes) return std::nullopt;
  const auto end = bytes->substr(0, kMostHead).find('\n');
  if (end == std::string::npos) return std::nullopt;
  auto picture = read_head(std::string_view(*bytes).substr(0, end));
  if (!picture) return std::nullopt;
  const auto size = static_cast<std::size_t>(picture->width) * static_cast<std::size_t>(picture->height) * 3;
  if (bytes->size() - end - 1 != size) return std::nullopt;
  const auto now = std::chrono::steady_clock::now();
  if (picture->writer == writer_) {
    if (picture->number == number_) return std::nullopt;
  } else if (writer_ != 0 && now - came_ < std::chrono::seconds(1)) {
    return std::nullopt;  // another one's
  }
  writer_ = picture->writer, number_ = picture->number, came_ = now;
  picture->rgb.assign(bytes->begin() + static_cast<std::ptrdiff_t>(end) + 1, bytes->end());
  return picture;
}

}  // namespace palpate::transport
