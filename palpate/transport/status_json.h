// A system's status as JSON, for programs and pages. Pure; any thread. Units are in the names.
#pragma once

#include "palpate/core/json.h"
#include "palpate/transport/status.h"

namespace palpate::transport {

Json status_json(const ServerStatus& status);

}  // namespace palpate::transport
