// A camera's lens as a person names it: --lens FILE, a rig file, what `calibrate camera --json` writes or a lens of another
// program (palpate/formats), else the rig at hand.
//
// Errors: wrong use: a file that is none of these, or has no lens of that camera, or not the picture's size.
#pragma once

#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/device/camera_model.h"
#include "palpate/rig/rig.h"

namespace palpate::tools::commands {

// `camera`: left or right. None where neither `file`, empty, nor the rig has one.
Expected<std::optional<device::CameraModel>> given_lens(const std::string& file, const rig::Rig& rig,
                                                        const std::string& camera);

// The kind that --lens-model names, else that of the rig's camera, else Brown's.
device::LensKind lens_model(const std::string& word, const rig::Rig& rig, const std::string& camera = "left");

}  // namespace palpate::tools::commands
