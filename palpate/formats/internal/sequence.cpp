// Sequences of PLUS and 3D Slicer (.igs.mha, .seq.mha), read by device/transform_sequence.h.
#include <set>

#include "palpate/core/text.h"
#include "palpate/device/transform_sequence.h"
#include "palpate/formats/internal/forms.h"

namespace palpate::formats {

bool is_sequence(std::string_view content) { return device::is_transform_sequence(content); }

Expected<Content> read_sequence(const Source& source) {
  Poses poses;
  poses.has_time = true;
  auto read =
      device::parse_transform_sequence(source.content, source.name, source.options.tool, &poses.left_out);
  if (!read) return tl::unexpected(read.error());
  poses.poses = std::move(*read);
  const auto names = device::transform_names(source.content);
  const std::string name =
      source.options.tool.empty() && names.size() == 1 ? names.front() : source.options.tool;
  return Content{"a sequence of PLUS or 3D Slicer, " + excerpt(name, 60), "s and mm", poses};
}

}  // namespace palpate::formats
