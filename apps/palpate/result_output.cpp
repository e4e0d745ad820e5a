#include "apps/palpate/result_output.h"

#include <cstdio>
#include <filesystem>

namespace palpate::app {

void add_result_options(CLI::App& command, ResultOptions& options) {
  command.add_option("--json", options.json, "Write the result as JSON to FILE (- = standard output)")
      ->type_name("FILE");
  command
      .add_option(
          "--rig", options.rig,
          "Rig file (palpate rig new makes one): start values are read there, the result is written there")
      ->type_name("FILE");
  command.add_option("--out", options.out, "Write the result alone, as a rig file of one part")
      ->type_name("FILE");
}

Expected<Rig> start_rig(const ResultOptions& options) {
  if (options.rig.empty()) return Rig{};
  auto rig = read_rig(options.rig);
  if (!rig && !std::filesystem::exists(options.rig))
    return wrong_use("{}: no such file; palpate rig new {} makes one", options.rig, options.rig);
  return rig;
}

Expected<void> write_result(const ResultOptions& options, const Result& result) {
  if ((!options.rig.empty() || !options.out.empty()) && !result.store)
    return wrong_use("--rig and --out: this result has no place in a rig file; --json writes it");
  if (!options.rig.empty()) {
    auto rig = start_rig(options);
    if (!rig) return tl::unexpected(rig.error());
    result.store(*rig);
    if (const auto done = write_rig(options.rig, *rig); !done) return done;
  }
  if (!options.out.empty()) {
    Rig alone;
    result.store(alone);
    if (const auto done = write_rig(options.out, alone); !done) return done;
  }
  if (!options.json.empty())
    if (const auto done = write_json(options.json, result.json); !done) return done;
  std::FILE* const stream = options.json == "-" ? stderr : stdout;
  for (const auto& line : result.summary) std::fprintf(stream, "%s\n", line.c_str());
  return {};
}

Json json_list(const Eigen::Ref<const Eigen::VectorXd>& vector, double scale) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) list.push_back(scale * vector[i]);
  return list;
}

Json json_rows(const Eigen::Ref<const Eigen::MatrixXd>& matrix, double scale) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    rows.push_back(json_list(matrix.row(i).transpose(), scale));
  return rows;
}

Json json_quaternion(const Quaternion& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  return Json::array({sign * rotation.w(), sign * rotation.x(), sign * rotation.y(), sign * rotation.z()});
}

Json json_covariance(const std::vector<std::string>& names, const Eigen::MatrixXd& covariance,
                     const Eigen::VectorXd& scales) {
  const Eigen::MatrixXd scaled = scales.asDiagonal() * covariance * scales.asDiagonal();
  return Json{{"order", names}, {"matrix", json_rows(scaled)}};
}

Eigen::VectorXd standard_deviations(const Eigen::MatrixXd& covariance) {
  return covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

std::string shown(const Eigen::Ref<const Eigen::VectorXd>& vector, double scale) {
  std::string text;
  for (Eigen::Index i = 0; i < vector.size(); ++i)
    text += fmt::format("{}{:.4f}", i > 0 ? " " : "", scale * vector[i]);
  return text;
}

}  // namespace palpate::app
