// A study that an application brings: `palpate study NAME`. Figures, files and a page from simulation, without a rig.
//
// The study's settings are its options on the command line: the key trials_per_level becomes --trials-per-level. The same
// seed gives the same result to the last bit on one machine. Values are in the units that their keys name. run() is called
// in one thread; `progress` is called there, too. Errors: wrong use for settings that make no sense together (check() has
// passed each), refused where the study cannot be made; what run() throws is told as a refusal by whoever calls it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/figures/section.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::scene {

struct StudyRequest {
  SettingValues settings;  // of ApplicationStudy::settings
  std::uint64_t seed = 1;
  bool quick = false;  // fewer trials, a minute at most
  // What is being done, and the share of the whole that is; may be empty.
  std::function<void(std::string_view what, double share)> progress{};
};

struct StudyOutcome {
  Json values = Json::object();                              // key figures, for --json
  std::vector<std::pair<std::string, std::string>> files{};  // beside the page: name and content
  std::vector<std::string> lines{};                          // key figures, for a person
  std::vector<figures::Section> sections{};                  // of the page
};

struct ApplicationStudy {
  std::string name{};     // a word of the command line, named as applications are
  std::string summary{};  // one line for a person
  SettingSchema settings{};
  std::function<Expected<StudyOutcome>(const StudyRequest&)> run{};
};

}  // namespace palpate::scene
