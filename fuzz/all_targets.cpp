#include "fuzz/targets.h"

namespace palpate::fuzz {

const std::vector<NamedTarget>& all_targets() {
  static const std::vector<NamedTarget> targets = {
      {"arm_models", arm_models},
      {"arm_samples", arm_samples},
      {"conditions", conditions},
      {"corners", corners},
      {"endpoints", endpoints},
      {"files_of_others", files_of_others},
      {"flights", flights},
      {"hand_eye", hand_eye},
      {"keys", keys},
      {"matrices", matrices},
      {"meshes", meshes},
      {"messages", messages},
      {"ndi_replies", ndi_replies},
      {"openigtlink", openigtlink},
      {"points", points},
      {"poses", poses},
      {"recordings", recordings},
      {"rigs", rigs},
      {"sequences", sequences},
      {"session_messages", session_messages},
      {"surfaces", surfaces},
      {"trials", trials},
      {"viewers", viewers},
      {"vrpn_messages", vrpn_messages},
      {"haply_states", haply_states},
      {"worlds", worlds},
  };
  return targets;
}

}  // namespace palpate::fuzz
