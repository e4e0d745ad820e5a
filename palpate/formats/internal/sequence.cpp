// Sequences of PLUS and 3D Slicer (.igs.mha, .seq.mha), read by device/transform_sequence.h, and the same in NRRD's head
// (.nrrd, .seq.nrrd, .nhdr), where a line is `key:=value`. The picture behind the head is passed over.
#include <algorithm>

#include "palpate/core/text.h"
#include "palpate/device/transform_sequence.h"
#include "palpate/formats/internal/forms.h"

namespace palpate::formats {

namespace {

constexpr std::string_view kNrrd = "NRRD000", kAssigns = ":=";

// An empty line ends it.
std::string_view nrrd_head(std::string_view content) {
  if (!content.starts_with(kNrrd)) return {};
  const auto end = content.find("\n\n"), other = content.find("\r\n\r\n");
  return content.substr(0, std::min(end, other));
}

// Line by line, so that messages name the file's own lines.
std::string as_metaimage(std::string_view head) {
  std::string text;
  while (!head.empty()) {
    const auto end = head.find('\n');
    const auto line = head.substr(0, end);
    head.remove_prefix(end == std::string_view::npos ? head.size() : end + 1);
    const auto at = line.find(kAssigns);
    if (at != std::string_view::npos)
      text.append(line.substr(0, at)).append(" = ").append(line.substr(at + kAssigns.size()));
    text += '\n';
  }
  return text;
}

Expected<Content> read_text(const Source& source, std::string_view content, const char* form) {
  Poses poses;
  poses.has_time = true;
  auto read = device::parse_transform_sequence(content, source.name, source.options.tool, &poses.left_out);
  if (!read) return tl::unexpected(read.error());
  poses.poses = std::move(*read);
  const auto names = device::transform_names(content);
  const std::string name =
      source.options.tool.empty() && names.size() == 1 ? names.front() : source.options.tool;
  return Content{fmt::format("{}, {}", form, excerpt(name, 60)), "s and mm", poses};
}

}  // namespace

bool is_sequence(std::string_view content) { return device::is_transform_sequence(content); }
Expected<Content> read_sequence(const Source& source) {
  return read_text(source, source.content, "a sequence of PLUS or 3D Slicer");
}

bool is_nrrd_sequence(std::string_view content) {
  const auto head = nrrd_head(content);
  return head.find("\nSeq_Frame") != std::string_view::npos;
}
Expected<Content> read_nrrd_sequence(const Source& source) {
  if (!is_nrrd_sequence(source.content))
    return wrong_use(
        "{}: is no sequence in NRRD; lines Seq_Frame0000_AToBTransform:=16 numbers are expected in its head",
        source.name);
  return read_text(source, as_metaimage(nrrd_head(source.content)), "a sequence of PLUS or 3D Slicer (NRRD)");
}

}  // namespace palpate::formats
