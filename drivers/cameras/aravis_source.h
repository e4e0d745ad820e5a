// A GenICam camera (GigE Vision, USB3 Vision) through the Aravis library.
//
// Stamps: the camera's own clock at the start of the exposure, as most cameras have it (stamp_at corrects
// those that differ), brought to mid-exposure with its ExposureTime; the time of arrival where a camera sends
// none. Aravis keeps its list of cameras for the whole process: these functions lock it, so any thread may
// call them. Source: GigE Vision 2.2 (AIA, 2022), the stream protocol's leader; GenICam SFNC 2.7.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/cameras/frame_source.h"

namespace palpate::drivers::cameras {

// `camera`: what the list below shows as name, serial number or address; empty for the first there is.
std::unique_ptr<FrameSource> make_aravis_source(std::string camera, CameraSettings settings);

struct AravisLook {
  std::string name, model, serial, address, protocol;
};
// Asks around in all networks and at USB, for a second.
std::vector<AravisLook> list_aravis();

// "0.8.26": the library's version that this was built with.
std::string aravis_version();

}  // namespace palpate::drivers::cameras
