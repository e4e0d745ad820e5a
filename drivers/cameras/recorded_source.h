// Recordings as a camera: a folder of images with a table of their times, or a video.
//
// Each picture comes when as much time has passed since the first one as between their stamps, so that the
// rest runs at the pace of the recording. Stamps are the recording's own, taken as mid-exposure.
//
// A folder holds `stamps.csv` with the columns image (a file's name in the folder) and time_s (mid-exposure
// on the camera's clock, rising), and optionally frame (the camera's count). A video has the times of its
// container. Refused at opening: no table, no image, times that do not rise, an image that is not there. Said
// while it runs, the recording going on: an image that cannot be read.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/cameras/frame_source.h"

namespace palpate::drivers::cameras {

inline constexpr const char* kStampsFile = "stamps.csv";

std::unique_ptr<FrameSource> make_folder_source(std::filesystem::path folder);
std::unique_ptr<FrameSource> make_video_source(std::filesystem::path file);

struct RecordedImage {
  std::filesystem::path file;
  std::int64_t mid_exposure_ns = 0;
  std::uint64_t number = 0;
};
Expected<std::vector<RecordedImage>> read_stamps(const std::filesystem::path& folder);

// A line of that table: time in s with all digits of ns.
std::string seconds_text(std::int64_t ns);

}  // namespace palpate::drivers::cameras
