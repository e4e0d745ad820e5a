// A file of another program: read whatever it is, written in every form that can hold it, and read again.
#include "palpate/formats/read.h"

#include <cmath>

#include "fuzz/check.h"
#include "palpate/core/units.h"
#include "palpate/formats/write.h"

namespace palpate::fuzz {
namespace {

void hold_sound(const formats::Content& content) {
  if (const auto* poses = std::get_if<formats::Poses>(&content.value)) {
    for (const auto& pose : poses->poses) {
      hold_finite(pose.translation, "a pose is finite");
      hold(std::abs(pose.rotation.norm() - 1.0) < 1e-6, "a pose is rigid");
      hold(std::abs(pose.time_s) <= kLatestTime, "a time is one");
    }
  } else if (const auto* points = std::get_if<formats::Points>(&content.value)) {
    hold(points->labels.empty() || points->labels.size() == points->places.size(),
         "each point has a label, or none has");
    for (const auto& place : points->places) hold_finite(place, "a point is finite");
  } else if (const auto* lens = std::get_if<formats::Lens>(&content.value)) {
    hold(lens->fx > 0.0 && lens->fy > 0.0 && std::isfinite(lens->cx) && std::isfinite(lens->cy),
         "a lens is one");
    for (const double k : lens->distortion) hold_finite(k, "a lens's distortion is finite");
  } else {
    hold_finite(std::get<formats::Transform>(content.value).matrix, "a transform is finite");
  }
}

}  // namespace

Refusals files_of_others(std::string_view file) {
  Refusals refusals;
  formats::ReadOptions options;
  auto read = formats::parse(file, "file", options);
  if (!answered(read, refusals)) {
    options.metres_per_unit = 1e-3;
    options.tool = "a";
    read = formats::parse(file, "file", options);
    if (!answered(read, refusals)) return refusals;
  }
  hold_sound(*read);
  for (const auto& form : formats::written_forms()) {
    const auto text = formats::text_of(*read, form);
    if (!text) {
      hold_one_line(text.error());
      continue;
    }
    const auto again = formats::parse(*text, "again", {.metres_per_unit = 1e-3});
    hold(again.has_value() && again->value.index() == read->value.index(),
         "what was written is read again as the same");
  }
  return refusals;
}

}  // namespace palpate::fuzz
