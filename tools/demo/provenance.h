// What made a demo's figures, and on what machine: summary.json's "made". The figures against the wall clock belong to it;
// the play in lock-step does not depend on it.
#pragma once

#include <string>

#include "palpate/core/build_info.h"
#include "palpate/core/json.h"

namespace palpate::tools::demo {

// Made when the demo begins.
class Provenance {
 public:
  explicit Provenance(BuildInfo build);

  // At the end. `realtime`: the run against the wall clock; null: there was none. What is not known is null.
  Json told(const Json& realtime) const;

 private:
  BuildInfo build_;
  std::string begun_;
  Json load_before_;
};

}  // namespace palpate::tools::demo
