// What a program is filled with, by itself and by plug-ins: applications and drivers, each under its name. One thread
// until all are there; then read from any.
#pragma once

#include "palpate/device/driver_registry.h"
#include "palpate/scene/application_registry.h"

namespace palpate::plugin {

struct Guests {
  scene::ApplicationRegistry applications;
  device::DriverRegistry drivers;
};

}  // namespace palpate::plugin
