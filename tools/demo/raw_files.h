// The files that a demo leaves in its folder, those in raw/ beside the application's own tables. docs/raw-files.md tells their columns.
#pragma once

#include <vector>

#include "palpate/core/json.h"
#include "palpate/figures/play_folder.h"
#include "palpate/scene/application_registry.h"

namespace palpate::tools::demo {

// Each that a demo may write, with a few words on what it holds: calibration, play in lock-step, real time.
const std::vector<scene::PlayTable>& raw_files();

// Those that are there, for the page: file, table_rows (null for what is no table), holds. The application's tables come
// before those of the real-time run; what nobody has announced comes last, without words. `application`: null where it is
// not known.
Json files_of(const figures::PlayFolder& play, const scene::ApplicationSpec* application);

// What else the folder holds beside the page: file, holds.
Json files_beside(const figures::PlayFolder& play);

}  // namespace palpate::tools::demo
