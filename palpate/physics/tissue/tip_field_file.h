// A tip field in a file, for the cache: what takes seconds to build is read in milliseconds.
//
// Little-endian: "PALPTIP1", the key of what it was built of (tip_field_key, 16 letters), tip's radius, deepest,
// stiffest, strongest (doubles, SI), the lattice's origin and spacing (doubles) and counts (uint32), for each point
// the coefficients of depth and kappa (floats), and at the end the content_hash of all that, 16 letters. Written
// whole or not at all. Any thread.
#pragma once

#include <filesystem>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/physics/tissue/tip_field.h"

namespace palpate::physics::tissue {

Expected<void> write_tip_field(const std::filesystem::path& path, const TipField& field,
                               std::string_view key);

// Refused: a file that is damaged, of another version, or built of other things than `key` says. Wrong use: no such
// file. Whoever gets an error builds the field anew.
Expected<TipField> read_tip_field(const std::filesystem::path& path, std::string_view key);

// The same from bytes, whose source the words name.
Expected<TipField> parse_tip_field(std::string_view bytes, std::string_view key, std::string_view source);

}  // namespace palpate::physics::tissue
