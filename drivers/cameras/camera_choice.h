// Which camera: the words that a person writes, and what there is to choose from.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "drivers/cameras/frame_source.h"
#include "drivers/cameras/live_camera.h"

namespace palpate::drivers::cameras {

enum class Kind : std::uint8_t { aravis, v4l2, images, video };

struct Choice {
  Kind kind = Kind::v4l2;
  std::string which;  // name, device or path; empty: the first there is
};

// "aravis", "aravis:NAME", "v4l2", "v4l2:DEVICE" (a path or the number in /dev/videoN), "images:FOLDER",
// "video:FILE". Wrong use: anything else.
Expected<Choice> parse_choice(std::string_view text);
inline constexpr std::string_view kChoices = "aravis[:NAME], v4l2[:DEVICE], images:FOLDER or video:FILE";

// Wrong use: settings outside their range, or given to a recording, which has none.
Expected<void> check_settings(const Choice& choice, const CameraSettings& settings);

std::unique_ptr<FrameSource> make_source(const Choice& choice, const CameraSettings& settings);

struct CameraRequest {
  Choice choice;
  CameraSettings settings;
};
// The camera running. With a size in the settings a camera is set to it, and a recording has to have it.
Expected<std::unique_ptr<LiveCamera>> open_camera(const CameraRequest& request);

// "Basler acA640 (serial 42), 640x480 px, BayerRG8, 30.0 Hz, exposure 5.00 ms".
std::string description(const CameraFacts& facts);

}  // namespace palpate::drivers::cameras
