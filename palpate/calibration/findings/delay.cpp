#include "palpate/calibration/findings/delay.h"

namespace palpate::calibration::findings {

Json delay_json(const MotionDelay& found, const std::vector<std::string>& warnings) {
  Json json;
  json["delay_s"] = found.delay_s;
  json["delay_std_s"] = found.delay_std_s;
  json["correlation"] = found.correlation;
  json["warnings"] = warnings;
  json["overlap_s"] = found.overlap_s;
  json["samples"] = found.samples;
  json["noise_memory_s"] = found.noise_memory_s;
  json["std_grown_by"] = found.std_grown_by;
  json["other_delays"] = Json::array();
  for (const auto& other : found.others)
    json["other_delays"].push_back({{"delay_s", other.delay_s}, {"correlation", other.correlation}});
  json["std"] = {{"delay_s", found.delay_std_s}};
  json["covariance"] =
      json_covariance({"delay_s"}, Eigen::MatrixXd::Constant(1, 1, found.delay_std_s * found.delay_std_s),
                      Eigen::VectorXd::Ones(1));
  return json;
}

}  // namespace palpate::calibration::findings
