#include "palpate/server/graphics/record_names.h"

namespace palpate::server::graphics {

const char* answer_name(AnswerKind kind) {
  switch (kind) {
    case AnswerKind::exact:
      return "exact";
    case AnswerKind::interpolated:
      return "interpolated";
    case AnswerKind::extrapolated:
      return "extrapolated";
    case AnswerKind::too_old:
      return "too_old";
    case AnswerKind::too_new:
      return "too_new";
  }
  return "unknown";
}

const char* pose_source_name(PoseSource source) {
  switch (source) {
    case PoseSource::none:
      return "none";
    case PoseSource::tracker:
      return "tracker";
    case PoseSource::refined:
      return "refined";
    case PoseSource::landmarks:
      return "landmarks";
  }
  return "unknown";
}

}  // namespace palpate::server::graphics
