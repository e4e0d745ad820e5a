// Settings of applications as files have them: TOML, a table for each section, read strictly.
//
// What a file gives goes over what the values are; what it leaves out stays. Complaints name file, line and
// key (palpate/core/toml.h). Any thread. Errors: wrong use.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/toml.h"
#include "palpate/scene/application_registry.h"

namespace palpate::scene {

// The fields of `section`, from the table of that name.
void read_settings(const TomlTable& table, std::string_view section, SettingValues& values);
// What no single value shows: complains where the file has the key, or its section.
void complain_of_relations(const TomlTable& root, const ApplicationRegistry& applications,
                           const SettingValues& values);
// A file setting is named as seen from the file it stands in: relative ones become absolute.
void resolve_files(const std::filesystem::path& folder, SettingValues& values);

// A file of settings alone, over `values`, which hold those of all applications; every key must be one of
// theirs.
Expected<void> read_settings_file(const std::filesystem::path& path, const ApplicationRegistry& applications,
                                  SettingValues& values);

// In the schema's order, each once.
std::vector<std::string> sections_of(const SettingValues& values);
// The lines `key = value` of one section.
std::string settings_text(const SettingValues& values, std::string_view section);

}  // namespace palpate::scene
