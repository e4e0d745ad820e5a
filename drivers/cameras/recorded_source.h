// Recordings as a camera: a folder of images with a table of their times, or a video.
//
// Each picture comes when as much time has passed since the first one as between their stamps, so that the
// rest runs at the pace of the recording. Stamps are the recording's own, taken as mid-exposure. With `loop` the first
// picture follows the last one, as long after it as that after the one before it; stamps and numbers go on rising.
//
// A folder is one of palpate/device/recorded_images.h. A video has the times of its
// container. Refused at opening: no table, no image, times that do not rise, an image that is not there. Said
// while it runs, the recording going on: an image that cannot be read.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drivers/cameras/frame_source.h"
#include "palpate/device/recorded_images.h"

namespace palpate::drivers::cameras {

using device::kStampsFile;

std::unique_ptr<FrameSource> make_folder_source(std::filesystem::path folder, bool loop = false);
std::unique_ptr<FrameSource> make_video_source(std::filesystem::path file, bool loop = false);

struct RecordedImage {
  std::filesystem::path file;
  std::int64_t mid_exposure_ns = 0;
  std::uint64_t number = 0;
};
Expected<std::vector<RecordedImage>> read_stamps(const std::filesystem::path& folder);

}  // namespace palpate::drivers::cameras
