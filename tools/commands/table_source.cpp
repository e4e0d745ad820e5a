#include "tools/commands/table_source.h"

#include <cstdlib>

#include "palpate/calibration/session/stream_tables.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/record/session/recorded_arm.h"
#include "palpate/record/session/recorded_streams.h"
#include "tools/commands/checks.h"
#include "tools/commands/source_names.h"

namespace palpate::tools::commands {

TableSource::~TableSource() {
  if (folder_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void TableSource::add(std::string option, std::string& path, std::function<std::string()> name, bool needed) {
  tables_.push_back({std::move(option), &path, std::move(name), needed});
}

void TableSource::add_options(CLI::App& command, bool with_times) {
  command
      .add_option("--recording", recording_, "Take the tables that are not named from this recording (MCAP)")
      ->type_name("FILE");
  if (!with_times) return;
  command.add_option("--from", span_.from_s, "Of the recording: from so many seconds after its beginning")
      ->check(at_least_zero())
      ->type_name("S");
  command.add_option("--to", span_.to_s, "Of the recording: until so many seconds after its beginning")
      ->check(above_zero())
      ->type_name("S");
}

Expected<void> TableSource::supply() {
  if (!named() && !span_.all()) return wrong_use("--from and --to go with --recording FILE");
  for (const auto& table : tables_) {
    if (!table.path->empty() || table.name().empty()) continue;
    if (!named()) {
      if (table.needed) return wrong_use("{} is required, or --recording", table.option);
      continue;
    }
    auto taken = take(table);
    if (!taken && table.needed) return taken;
  }
  return {};
}

// The table that the recording holds, else what its raw streams make of it.
Expected<std::string> TableSource::text_of(const std::string& name) const {
  auto held = record::session::find_table(recording_, name, span_);
  if (!held) return tl::unexpected(held.error());
  if (*held) return **held;
  const auto raw = record::session::read_streams(recording_, {.span = span_, .camera = {}});
  if (!raw) return tl::unexpected(raw.error());
  auto made = calibration::session::table_from_streams(
      raw->streams, name, Vector3::Zero(),
      record::session::recorded_arm(recording_).value_or(device::ArmModel{}));
  if (!made) {
    const auto refusal = record::session::table_of(recording_, name, span_);
    if (refusal || raw->arm + raw->tracker == 0) return refusal;
    return refused("{}; of its raw streams: {}", refusal.error().message, made.error().message);
  }
  notice(fmt::format("{}: holds no table '{}'; it is made of what arm and tracker said", one_line(recording_),
                     name));
  return made;
}

Expected<void> TableSource::take(const Table& table) {
  const std::string name = table.name();
  const auto text = text_of(name);
  if (!text) return tl::unexpected(text.error());
  if (folder_.empty()) {
    std::error_code code;
    std::string pattern = (std::filesystem::temp_directory_path(code) / "palpate-tables-XXXXXX").string();
    if (code || ::mkdtemp(pattern.data()) == nullptr)
      return refused("no folder for the recording's tables can be made");
    folder_ = pattern;
  }
  const auto file = folder_ / (name + ".csv");
  if (auto done = write_file(file, *text); !done) return done;
  *table.path = file.string();
  name_source(*table.path, fmt::format("{}: table {}", one_line(recording_), name));
  return {};
}

}  // namespace palpate::tools::commands
