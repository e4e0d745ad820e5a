// The version of the rig file, which its reader and its writer share.
#pragma once

namespace palpate::rig {

inline constexpr int kRigVersion = 1;

}  // namespace palpate::rig
