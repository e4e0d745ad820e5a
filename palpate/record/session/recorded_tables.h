// The tables that calibrations read, out of a recording that holds them as attachments ("tables/arm.csv"). And into one: a recording
// that holds the tables of other people's files. Those made of raw streams: recorded_streams.h.
//
// A table is CSV text, as `palpate calibrate` reads it. Between two times it has the rows whose `time_s` lies so many seconds after
// its first one. Ordinary threads. Errors:
// wrong use for a file that is no recording; refused where it has no such table, or a part of one is asked for that has no times.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::record::session {

struct TimeSpan {
  double from_s = 0.0, to_s = std::numeric_limits<double>::infinity();
  bool all() const { return from_s <= 0.0 && to_s == std::numeric_limits<double>::infinity(); }
};

// What was attached to it under this name, such as "rig.toml"; nothing where it has none.
Expected<std::optional<std::string>> find_attachment(const std::filesystem::path& recording,
                                                     const std::string& name);

// `name`: arm, pivot, pointer_pivot, hand, eye ...
Expected<std::string> table_of(const std::filesystem::path& recording, const std::string& name,
                               const TimeSpan& span = {});
// The same; nothing where there is no such table.
Expected<std::optional<std::string>> find_table(const std::filesystem::path& recording,
                                                const std::string& name, const TimeSpan& span = {});

// A new recording of tables alone: name and text each. There whole or not at all.
Expected<void> write_tables(const std::filesystem::path& recording,
                            const std::vector<std::pair<std::string, std::string>>& tables);

// The name of the attachment that a table is.
std::string table_attachment(const std::string& name);

}  // namespace palpate::record::session
