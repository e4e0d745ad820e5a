#include "palpate/plugin/plugin.h"

#include "ppm_camera.h"

PALPATE_PLUGIN("ppm_camera", [](palpate::plugin::Guests& guests) { guests.drivers.add(ppm::driver()); })
