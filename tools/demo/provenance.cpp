#include "tools/demo/provenance.h"

#include "palpate/core/machine.h"
#include "palpate/render/context.h"
#include "palpate/rig/rig.h"

namespace palpate::tools::demo {
namespace {

Json known(const std::string& words) { return words.empty() ? Json() : Json(words); }

Json load() {
  const auto now = load_of_machine();
  return now ? Json(*now) : Json();
}

}  // namespace

Provenance::Provenance(BuildInfo build)
    : build_(std::move(build)), begun_(rig::utc_now()), load_before_(load()) {}

Json Provenance::told(const Json& realtime) const {
  const Machine machine = this_machine();
  const auto drawing = render::Context::of_this_thread();
  const Json::json_pointer scheduling("/haptic/scheduling");
  return {{"version", build_.version},
          {"commit", known(build_.commit)},
          {"compiler", known(build_.compiler)},
          {"options", known(build_.options)},
          {"date", begun_},
          {"processor", known(machine.processor)},
          {"cores", machine.cores},
          {"kernel", known(machine.kernel)},
          {"system", known(machine.system)},
          {"load_before", load_before_},
          {"load_after", load()},
          {"renderer", drawing ? known((*drawing)->renderer()) : Json()},
          {"scheduling", realtime.contains(scheduling) ? realtime[scheduling] : Json()}};
}

}  // namespace palpate::tools::demo
