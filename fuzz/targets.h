// What the fuzzers feed: one function per file format, from the bytes of a file through its reader into the
// calibrations that use such files.
//
// A target holds what the program promises for any file: it ends, in a value whose numbers are finite or in
// an error of one line (check.h), and it never throws. It returns the errors it met, so that a test can read
// them; the fuzzer ignores them. A broken promise ends the process. Deterministic, no state.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::fuzz {

using Refusals = std::vector<std::string>;
using Target = Refusals (*)(std::string_view file);

Refusals arm_models(std::string_view file);
Refusals arm_samples(std::string_view file);
Refusals conditions(std::string_view file);
Refusals corners(std::string_view file);
Refusals endpoints(std::string_view file);
Refusals files_of_others(std::string_view file);
Refusals flights(std::string_view file);
Refusals hand_eye(std::string_view file);
Refusals keys(std::string_view file);
Refusals matrices(std::string_view file);
Refusals meshes(std::string_view file);
Refusals messages(std::string_view file);
Refusals ndi_replies(std::string_view file);
Refusals openigtlink(std::string_view file);
Refusals points(std::string_view file);
Refusals poses(std::string_view file);
Refusals recordings(std::string_view file);
Refusals rigs(std::string_view file);
Refusals sequences(std::string_view file);
Refusals session_messages(std::string_view file);
Refusals surfaces(std::string_view file);
Refusals trials(std::string_view file);
Refusals viewers(std::string_view file);
Refusals vrpn_messages(std::string_view file);
Refusals haply_states(std::string_view file);
Refusals worlds(std::string_view file);

struct NamedTarget {
  std::string_view name;  // of the program fuzz_NAME and the folder corpus/NAME
  Target run;
};
const std::vector<NamedTarget>& all_targets();

}  // namespace palpate::fuzz
