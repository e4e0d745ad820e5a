// How raw files and summaries name what a frame's record tells.
#pragma once

#include "palpate/server/graphics/frame_record.h"
#include "palpate/time/answer.h"

namespace palpate::server::graphics {

const char* answer_name(AnswerKind kind);
const char* pose_source_name(PoseSource source);

}  // namespace palpate::server::graphics
