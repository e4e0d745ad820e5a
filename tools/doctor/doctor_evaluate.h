// What facts about a machine mean for whoever wants to run the servers on it, and what to do.
//
// Pure functions; any thread. In the way: a server, or the connection asked for, will not work. Worth
// knowing: it works, but less well or less safely than it could, or something is left to do.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/json.h"
#include "tools/doctor/doctor_facts.h"

namespace palpate::tools::doctor {

enum class Verdict { ok, worth_knowing, in_the_way };
std::string_view verdict_name(Verdict verdict);

struct Finding {
  std::string area, name;
  Verdict verdict = Verdict::ok;
  std::string value;   // what was found, one line
  std::string remedy;  // what to do; empty where nothing needs doing
};
using Findings = std::vector<Finding>;

Findings evaluate(const RealTimeFacts& facts);
Findings evaluate(const ClockFacts& facts);
Findings evaluate(const SocketFacts& facts);
Findings evaluate(const ListenFacts& facts);
Findings evaluate(const KeyFacts& facts);
Findings evaluate(const GraphicsFacts& facts);
Findings evaluate(const DesktopFacts& facts);
Findings evaluate(const LibraryFacts& facts);
Findings evaluate(const DeviceFacts& facts);
Findings evaluate(const SpaceFacts& facts);
Findings evaluate(const plugin::Report& plugins);
Findings evaluate(const Facts& facts);  // all of it

// {"findings": [{area, name, verdict, value, remedy}], "ok": n, "worth_knowing": n, "in_the_way": n}
Json to_json(const Findings& findings);

}  // namespace palpate::tools::doctor
