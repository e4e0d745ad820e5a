// What the rig file says of the picture alone: the room's light, registered real objects, the board by which
// a camera knows its place, how a camera writes light. Read and written for rig.cpp. Pure functions.
#pragma once

#include <string>

#include "palpate/core/toml.h"
#include "palpate/rig/rig.h"

namespace palpate::rig {

device::Encoding encoding_of(const TomlTable& camera);
std::string_view encoding_word(device::Encoding encoding);

void read_picture_parts(const TomlTable& file, Rig& rig);
std::string picture_parts_text(const Rig& rig);

}  // namespace palpate::rig
