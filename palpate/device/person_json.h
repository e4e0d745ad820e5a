// What a person is asked for, as a line of JSON: for a display of one's own, and for a simulated person in another
// process.
//
// {"gesture": "touch", "what": "table", "index": 2}; a pose that is shown has "tip_m" (World) and
// "marker_rotation_qwxyz". Pure. Errors: what the line lacks.
#pragma once

#include <string_view>

#include "palpate/core/json.h"
#include "palpate/device/person.h"

namespace palpate::device {

std::string_view name_of(Gesture gesture);
Json json_of(const Request& request);
Expected<Request> request_of(const Json& json);

}  // namespace palpate::device
