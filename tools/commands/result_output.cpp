#include "tools/commands/result_output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/toml.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/source_names.h"

namespace palpate::tools::commands {

void add_camera_option(CLI::App& command, std::string& camera) {
  command
      .add_option("--camera", camera,
                  "Of two cameras on one marker, the one this is: its place in the rig file")
      ->check(one_of({"left", "right"}))
      ->capture_default_str();
}

void add_lens_model_option(CLI::App& command, std::string& lens) {
  command
      .add_option(
          "--lens-model", lens,
          "The lens's kind: brown, up to some 110 deg; rational, up to some 130; fisheye, for wide ones (by "
          "the angle from the axis); default: as the rig has it, else brown")
      ->check(one_of({device::kLensWords.begin(), device::kLensWords.end()}));
}

void add_result_options(CLI::App& command, ResultOptions& options) {
  // An unset variable of a script would otherwise lose the result without a word.
  const CLI::Validator named(
      [](const std::string& name) {
        return name.empty() ? std::string("is empty; a file's name is expected") : "";
      },
      "");
  command.add_option("--json", options.json, "Write the result as JSON to FILE (- = standard output)")
      ->check(named)
      ->type_name("FILE");
  command
      .add_option(
          "--rig", options.rig,
          "Rig file (palpate rig new makes one): start values are read there, the result is written there")
      ->check(named)
      ->type_name("FILE");
  command.add_option("--out", options.out, "Write the result alone, as a rig file of one part")
      ->check(named)
      ->type_name("FILE");
}

Expected<rig::Rig> start_rig(const ResultOptions& options) {
  if (options.rig.empty()) return rig::Rig{};
  auto rig = rig::read_rig(options.rig);
  if (!rig && options.rig != "-" && !is_there(options.rig))
    return wrong_use("{}: no such file; palpate rig new {} makes one", options.rig, options.rig);
  return rig;
}

namespace {

// The names of the files that a result's `data` says it came from.
void add_names(const Json& data, std::vector<std::string>& names) {
  if (data.is_string()) names.push_back(data.get<std::string>());
  if (data.is_structured())
    for (const auto& part : data) add_names(part, names);
}

// In the order in which they are told.
std::vector<std::string> outputs_of(const ResultOptions& options, const Result& result) {
  std::vector<std::string> outputs;
  for (const auto& table : result.tables) outputs.push_back(table.path);
  for (const auto* output : {&options.out, &options.json, &options.rig}) outputs.push_back(*output);
  std::erase_if(outputs, [](const std::string& output) { return output.empty() || output == "-"; });
  return outputs;
}

// No two results in one file, none over a recording.
Expected<void> check_apart(const ResultOptions& options, const Result& result) {
  std::vector<std::string> taken;
  if (result.json.contains("data")) add_names(result.json["data"], taken);
  for (const auto& output : outputs_of(options, result)) {
    for (const auto& other : taken)
      if (same_file(output, other))
        return wrong_use("{}: is read or written already by this command; give the result a file of its own",
                         output);
    taken.push_back(output);
  }
  return {};
}

// The file's keys where it is a rig; none where it is anything else, or nothing.
std::vector<std::string> keys_of_rig(const std::string& path) {
  const auto file = is_there(path) ? read_toml(path) : Expected<TomlTable>(wrong_use("{}", path));
  return file && file->has("rig_version") ? file->keys() : std::vector<std::string>{};
}

// --out and --json make new files, --rig adds to one: taken for each other they would cost a whole rig.
Expected<void> check_no_rig_lost(const ResultOptions& options, const Result& result) {
  if (!options.json.empty() && options.json != "-" && !keys_of_rig(options.json).empty())
    return wrong_use("--json {0}: is a rig file; --rig {0} adds the result to it", options.json);
  if (options.out.empty() || !result.store) return {};
  rig::Rig alone;
  result.store(alone);
  const auto written = parse_toml(rig::rig_text(alone), options.out);
  if (!written) return tl::unexpected(written.error());
  for (const auto& key : keys_of_rig(options.out))
    if (!written->has(key))
      return wrong_use(
          "--out {0}: is a rig file with more than this result ({1}), which would be lost; --rig "
          "{0} adds the result to it",
          options.out, excerpt(key, 60));
  return {};
}

}  // namespace

Expected<void> write_result(const ResultOptions& options, const Result& result) {
  if (const auto apart = check_apart(options, result); !apart) return apart;
  if ((!options.rig.empty() || !options.out.empty()) && !result.store)
    return wrong_use("--rig and --out: this result has no place in a rig file; --json writes it");
  if (const auto kept = check_no_rig_lost(options, result); !kept) return kept;
  for (const auto& table : result.tables)
    if (const auto done = write_file(table.path, table.content); !done) return done;
  // The rig last: it is the one that was there before, and stays as it was where anything else fails.
  if (!options.out.empty()) {
    rig::Rig alone;
    result.store(alone);
    if (const auto done = rig::write_rig(options.out, alone); !done) return done;
  }
  if (!options.json.empty()) {
    Json json = result.json;
    with_sources_named(json);
    if (const auto done = write_json(options.json, json); !done) return done;
  }
  if (!options.rig.empty()) {
    auto rig = start_rig(options);
    if (!rig) return tl::unexpected(rig.error());
    result.store(*rig);
    if (const auto done = rig::write_rig(options.rig, *rig); !done) return done;
  }
  std::FILE* const stream = lines_beside(options.json);
  for (const auto& line : result.summary) print_line(with_sources_named(line), stream);
  for (const auto& output : outputs_of(options, result))
    print_line(fmt::format("written to   {}", output), stream);
  return {};
}

std::string warning_of_worse(const std::string& what, const Vector3& before, const Matrix3& known_before,
                             const Matrix3& known_now) {
  constexpr double kMultiple = 3.0, kMatters = 2e-4;  // m
  const auto largest = [](const Matrix3& covariance) {
    return std::sqrt(std::max(0.0, covariance.diagonal().maxCoeff()));
  };
  const double was = largest(known_before), is = largest(known_now);
  if (!(was > 0.0) || !(is > kMatters) || is < kMultiple * was) return "";
  return fmt::format(
      "the rig file knew {} to {:.3f} mm, {} mm; it holds this one now, known to {:.3f} mm: check which is "
      "wanted",
      what, kMm * was, shown(before, kMm), kMm * is);
}

std::string shown(const Eigen::Ref<const Eigen::VectorXd>& vector, double scale) {
  std::string text;
  for (Eigen::Index i = 0; i < vector.size(); ++i)
    text += fmt::format("{}{:.4f}", i > 0 ? " " : "", scale * vector[i]);
  return text;
}

}  // namespace palpate::tools::commands
