#include "tools/commands/lens_file.h"

#include "palpate/core/file.h"
#include "palpate/core/file_form.h"
#include "palpate/formats/read.h"

namespace palpate::tools::commands {
namespace {

// Of whatever program.
Expected<std::optional<device::CameraModel>> lens_of_others(const std::string& file,
                                                            const std::string& content) {
  const auto read = formats::parse(content, file);
  if (!read) return tl::unexpected(read.error());
  const auto* lens = std::get_if<formats::Lens>(&read->value);
  if (lens == nullptr)
    return wrong_use(
        "{}: is {}; a lens is expected: a rig file, what calibrate camera --json writes, or a lens of "
        "another program",
        file, read->form);
  if (!lens->size)
    return wrong_use("{}: is {} without the picture's size, which is needed: add its width and height", file,
                     read->form);
  return device::CameraModel{(*lens->size)[0], (*lens->size)[1], lens->fx,         lens->fy,
                             lens->cx,         lens->cy,         lens->distortion, lens->kind};
}

std::optional<device::CameraModel> lens_of(const rig::Rig& rig, const std::string& camera) {
  const auto& calibration = camera == "right" ? rig.right_camera : rig.camera;
  if (!calibration) return std::nullopt;
  return calibration->model;
}

}  // namespace

device::LensKind lens_model(const std::string& word, const rig::Rig& rig, const std::string& camera) {
  if (const auto named = device::lens_kind(word)) return *named;
  const auto known = lens_of(rig, camera);
  return known ? known->kind : device::LensKind::brown;
}

Expected<std::optional<device::CameraModel>> given_lens(const std::string& file, const rig::Rig& rig,
                                                        const std::string& camera) {
  if (file.empty()) return lens_of(rig, camera);
  const auto content = read_file(file);
  if (!content) return tl::unexpected(content.error());
  if (!is_toml(form_of(*content))) return lens_of_others(file, *content);
  const auto other = rig::read_rig(file);
  if (!other) return tl::unexpected(other.error());
  const auto lens = lens_of(*other, camera);
  if (!lens) return wrong_use("{}: has no lens of the {} camera; calibrate camera writes one", file, camera);
  return lens;
}

}  // namespace palpate::tools::commands
