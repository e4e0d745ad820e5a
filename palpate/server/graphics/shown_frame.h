// What whoever looks on from another process is told of a frame that was shown. Pure; any thread.
#pragma once

#include "palpate/server/graphics/frame_record.h"
#include "palpate/transport/shown_picture.h"

namespace palpate::server::graphics {

// Without its pixels.
transport::ShownPicture shown_picture(const FrameRecord& frame);

}  // namespace palpate::server::graphics
