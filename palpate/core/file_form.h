// What a file seems to be that came from elsewhere, told by its first lines: so that a reader which expects
// something else says what it was given, instead of which cell of it is no number. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::inline core {

enum class FileForm {
  unknown,
  binary,
  commas,  // a table as this program reads them
  blanks,
  tabs,
  semicolons,
  decimal_commas,  // cells separated by semicolons or tabs, numbers written 0,5
  json,
  xml,
  nrrd,
  metaimage,
  fiducials,      // 3D Slicer's .fcsv
  itk_transform,  // ITK's and 3D Slicer's .tfm
  ndi,            // what NDI's own programs export
  rig,
  toml,  // worlds, settings, boards
};

// What spreadsheets put before UTF-8 taken away.
std::string_view without_byte_order_mark(std::string_view content);

FileForm form_of(std::string_view content);
bool is_toml(FileForm form);

// "is JSON": to stand behind the file's name. Empty where the form is unknown.
std::string_view words_of(FileForm form);

// Wrong use, with what to do, where the file's first bytes say that it is no text: packed, UTF-16, of MATLAB.
Expected<void> may_be_text(std::string_view content, const std::string& source);

// Wrong use, with what to do, where the file is no text, or of a known form other than a table with commas.
Expected<void> may_be_table(std::string_view content, const std::string& source);

}  // namespace palpate::inline core
