// What every `calibrate` does with its result: lines for a person, JSON for a script, the rig file, a file of
// its own.
#pragma once

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/core/units.h"
#include "palpate/math/json_values.h"
#include "palpate/rig/rig.h"

namespace palpate::tools::commands {

inline constexpr double kMm = kMillimetresPerMetre;  // what people read is in millimetres

struct ResultOptions {
  std::string json;  // --json FILE
  std::string rig;   // --rig FILE: start values are read there, the result is written there
  std::string out;   // --out FILE: the result alone, as a rig file that holds nothing else
};

void add_result_options(CLI::App& command, ResultOptions& options);
// --camera left|right: which camera of a stereo rig a result belongs to.
void add_camera_option(CLI::App& command, std::string& camera);
// --lens-model brown|fisheye|rational (device::LensKind); left as it is where nothing is said.
void add_lens_model_option(CLI::App& command, std::string& lens);

struct Result {
  Json json;
  std::vector<std::string> summary;  // for a person, a line each
  std::function<void(rig::Rig&)>
      store;  // puts the result, with its provenance, into a rig; none where it has no place there
  struct Table {
    std::string path, content;
  };
  std::vector<Table> tables;  // further files that were asked for
};

// The rig named by --rig, an empty one without. Read it before the work starts: a bad file is told at once.
Expected<rig::Rig> start_rig(const ResultOptions& options);

// Prints the summary (to standard error where standard output carries the JSON) and writes every file asked
// for.
Expected<void> write_result(const ResultOptions& options, const Result& result);

// What is said where a place in the rig file is replaced by one that is known worse by a multiple: with the place of before,
// so that nothing is lost. Standard deviations in m, as covariances of a place; empty where there is nothing to say.
std::string warning_of_worse(const std::string& what, const Vector3& before, const Matrix3& known_before,
                             const Matrix3& known_now);

// "12.345 6.789 -3.000", to 4 digits after the point, for summaries.
std::string shown(const Eigen::Ref<const Eigen::VectorXd>& vector, double scale = 1.0);

}  // namespace palpate::tools::commands
