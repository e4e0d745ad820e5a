// The same in the forms of this program and of others. Pure, any thread.
//
// Errors: wrong use where a form cannot hold what there is: poses as a lens, an affine transform as a rigid one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/formats/content.h"

namespace palpate::formats {

struct WrittenForm {
  std::string name;    // "tum"
  std::string ending;  // that names it by itself: ".tum"
  std::string told;    // its columns, frames and units
};
const std::vector<WrittenForm>& written_forms();

// The form of a file by its ending; `wanted`, of written_forms(), where it is not empty.
Expected<WrittenForm> written_form(const std::filesystem::path& path, const std::string& wanted);

Expected<std::string> text_of(const Content& content, const WrittenForm& form);

}  // namespace palpate::formats
