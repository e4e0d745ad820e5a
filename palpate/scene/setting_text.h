// Settings as a person types them on a command line, where the shell has words and no types: "touch.stiffness_n_m=700",
// numbers of a list with commas between them. Pure, any thread. Errors: wrong use, which names the setting.
#pragma once

#include <string_view>

#include "palpate/scene/setting_schema.h"

namespace palpate::scene {

// `called`: what the complaint calls the setting. Whether the value is in range says check().
Expected<SettingValue> value_of_text(const SettingField& field, std::string_view text,
                                     std::string_view called);

// NAME=VALUE, over `values`; the name must be one of the schema.
Expected<void> set_by_text(const SettingSchema& schema, std::string_view said, SettingValues& values);

}  // namespace palpate::scene
