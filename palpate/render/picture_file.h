// Pictures and videos as files, and words written into a picture.
//
// Packed RGB bytes, row 0 on top. PNG files appear whole or not at all; a video appears under its name when
// it is closed. Thread: one per object.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::render {

// The picture as a PNG file's bytes. Throws std::invalid_argument when size and bytes do not agree.
std::string png_bytes(std::span<const std::uint8_t> rgb, int width, int height);
// As a JPEG file's bytes, quality 95. Throws as png_bytes().
std::string jpeg_bytes(std::span<const std::uint8_t> rgb, int width, int height);
// The pixels of a PNG or JPEG file's bytes. False where they are none, or of more than kMostPixels.
bool read_picture(std::string_view bytes, std::vector<std::uint8_t>& rgb, int& width, int& height);
Expected<void> write_png(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                         int height);

// Lines of text on a dark band in the picture's upper left corner, or of each of `eyes` pictures side by
// side. ASCII.
void burn_captions(std::vector<std::uint8_t>& rgb, int width, int height,
                   const std::vector<std::string>& lines, int eyes = 1);

class VideoFile {
 public:
  // MP4, H.264 (plays in browsers) where the machine can encode it, else MPEG-4. Refused where neither is to
  // be had.
  static Expected<VideoFile> create(const std::filesystem::path& path, int width, int height,
                                    double frames_per_s);
  ~VideoFile();  // a video that was not closed leaves nothing behind
  VideoFile(VideoFile&&) noexcept;
  VideoFile& operator=(VideoFile&&) noexcept;

  // Throws std::invalid_argument when the picture has another size.
  void add(std::span<const std::uint8_t> rgb);
  // Ends the file and gives it its name.
  Expected<void> close();
  const std::string& codec() const;  // "h264" or "mpeg4"

 private:
  struct Impl;
  explicit VideoFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// What reads and writes pictures, with the version that runs.
std::string picture_library();

}  // namespace palpate::render
