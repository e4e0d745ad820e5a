// What a person may set of the jelly, in the section [jelly] of a world file.
#pragma once

#include "palpate/scene/application.h"
#include "palpate/scene/setting_schema.h"
#include "soft_body.h"

namespace jelly {

const palpate::scene::SettingSchema& setting_schema();
// What a scene says of the jelly, for values that have been checked.
void describe(const palpate::scene::SettingValues& values, palpate::scene::SceneDescription& scene);
// Throws std::invalid_argument for a scene with other settings than these.
Material material_of(const palpate::scene::SceneDescription& scene);

}  // namespace jelly
