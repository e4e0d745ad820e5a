#include "palpate/formats/read.h"

#include <algorithm>
#include <array>

#include "palpate/core/file.h"
#include "palpate/core/file_form.h"
#include "palpate/core/text.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/text_table.h"
#include "palpate/formats/tables.h"

namespace palpate::formats {
namespace {

struct Form {
  std::string_view name;
  bool (*is)(std::string_view);
  Expected<Content> (*read)(const Source&);
};

// The first that says yes.
constexpr Form kForms[] = {
    {"npy", is_numpy, read_numpy},
    {"tfm", is_itk_transform, read_itk_transform},
    {"fcsv", is_fiducials, read_fiducials},
    {"sequence", is_sequence, read_sequence},
    {"nrrd", is_nrrd_sequence, read_nrrd_sequence},
    {"mrk-json", is_markups, read_markups},
    {"json", is_lens_json, read_lens_json},
    {"xml", is_xml, read_xml},
    {"motive", is_motive, read_motive},
    {"table", is_table, read_table},
    {"numbers", is_rows_of_numbers, read_rows_of_numbers},  // TUM, KITTI, matrices, points
    {"yaml", is_yaml, read_yaml},
};

// Of a kind that can be named, and not read at all.
Expected<void> may_be_read(const Source& source) {
  const auto form = form_of(source.content);
  const auto words = words_of(form);
  if (source.content.starts_with("NRRD000"))
    return wrong_use("{}: is an NRRD file without a sequence of transforms in its head, which is expected",
                     source.name);
  if (source.content.find("[image]") != std::string_view::npos &&
      source.content.find("camera matrix") != std::string_view::npos)
    return wrong_use(
        "{}: is a lens as ROS' camera_calibration prints it (ost.txt), which is not read; take the ost.yaml "
        "beside it",
        source.name);
  if (words.empty()) return {};
  if (form != FileForm::commas)
    return wrong_use("{}: {}; poses, points, a lens or a transform are expected (docs/files-of-others.md)",
                     source.name, words);
  const std::string_view content = source.content;
  return wrong_use(
      "{}: {} with the first row '{}'; poses, points, a lens or a transform are expected, poses for example "
      "in columns time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz (docs/files-of-others.md)",
      source.name, words, excerpt(std::string(content.substr(0, content.find_first_of("\r\n")))));
}

// A text that ends in zero bytes, as a machine leaves it that lost its power.
Expected<void> is_whole_text(std::string_view content, const std::string& name) {
  const auto at = content.find('\0');
  if (at == 0 || at == std::string_view::npos ||
      content.find_first_not_of('\0', at) != std::string_view::npos || is_numpy(content) ||
      is_sequence(content) || is_nrrd_sequence(content))
    return {};
  return wrong_use("{}: ends in zero bytes (from byte {}): it was cut off while it was written; remove them",
                   name, at);
}

Expected<void> check_tool(const Source& source, std::string_view form) {
  constexpr std::array kWithout = {"npy", "tfm", "fcsv", "mrk-json", "json", "numbers"};
  if (source.options.tool.empty() || std::find(kWithout.begin(), kWithout.end(), form) == kWithout.end())
    return {};
  return wrong_use("{}: holds nothing side by side of which one could be named; remove --tool {}",
                   source.name, excerpt(source.options.tool, 40));
}

// A series in which the body is seen nowhere is of no use to anybody.
Expected<Content> with_poses(Expected<Content> read, const std::string& name) {
  if (!read) return read;
  const auto* poses = std::get_if<Poses>(&read->value);
  if (poses == nullptr || !poses->poses.empty()) return read;
  return wrong_use("{}: is {} in which the body is seen in none of {}; poses are expected", name, read->form,
                   counted(poses->left_out, "row"));
}

}  // namespace

std::vector<std::string> form_names() {
  std::vector<std::string> names;
  for (const auto& form : kForms) names.emplace_back(form.name);
  return names;
}

bool is_of_others(std::string_view content) {
  content = without_byte_order_mark(content);
  for (const auto& form : kForms) {
    if (!form.is(content)) continue;
    if (form.name == "table") return !is_own_table(content);
    if (form.name == "numbers") return separation_of(content).separator != ',';
    return form.name != "sequence";
  }
  return false;
}

Expected<Content> parse(std::string_view content, const std::string& name, const ReadOptions& options) {
  const Source source{without_byte_order_mark(content), name, options};
  if (source.content.empty()) return wrong_use("{}: is empty", name);
  for (const auto& fine : {may_be_text(content, name), is_whole_text(content, name)})
    if (!fine) return tl::unexpected(fine.error());
  for (const auto& form : kForms) {
    if (options.form.empty() ? !form.is(source.content) : form.name != options.form) continue;
    if (auto fine = check_tool(source, form.name); !fine) return tl::unexpected(fine.error());
    return with_poses(form.read(source), name);
  }
  if (!options.form.empty())
    return wrong_use("'{}' is no form that is read; there are {}", options.form,
                     fmt::join(form_names(), ", "));
  if (auto known = may_be_read(source); !known) return tl::unexpected(known.error());
  return wrong_use(
      "{}: is of no form that is known here; poses, points, a lens or a transform are expected "
      "(docs/files-of-others.md)",
      name);
}

Expected<Content> read(const std::filesystem::path& path, const ReadOptions& options) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse(*content, path.string(), options);
}

}  // namespace palpate::formats
