#include "tools/commands/drivers.h"

#include "drivers/forcedimension/driver.h"
#include "drivers/haply/driver.h"
#include "drivers/laboratory/driver.h"
#include "drivers/openhaptics/driver.h"
#ifndef PALPATE_PHYSICS_ALONE
#include "drivers/cameras/driver.h"
#include "drivers/ndi/driver.h"
#include "drivers/openigtlink/driver.h"
#include "drivers/vrpn/driver.h"
#include "palpate/render/picture_file.h"
#endif

namespace palpate::tools::commands {

device::DriverRegistry built_in_drivers() {
  device::DriverRegistry registry;
  drivers::laboratory::add_to(registry);
  drivers::openhaptics::add_to(registry);
  drivers::haply::add_to(registry);
  drivers::forcedimension::add_to(registry);
#ifndef PALPATE_PHYSICS_ALONE
  drivers::cameras::add_to(registry);
  drivers::openigtlink::add_to(registry);
  drivers::vrpn::add_to(registry);
  drivers::ndi::add_to(registry);
#endif
  record::session::add_to(registry, jpeg_decoder());
  return registry;
}

Expected<void> laboratory_of_desk(const rig::Rig& rig, const std::string& file,
                                  const std::string& laboratory) {
  const bool desk = rig.arm && rig.arm->model.name == rig::kMouseArm;
  if (!desk || drivers::laboratory::is_there(laboratory)) return {};
  return refused(
      "laboratory '{}' is not there, and {} is a desk's rig: `palpate play --rig {}` starts all that a desk "
      "needs, "
      "`palpate world run --arm-only` its arm alone",
      laboratory, file, file);
}

record::session::DecodeJpeg jpeg_decoder() {
#ifndef PALPATE_PHYSICS_ALONE
  return [](std::string_view bytes, device::CameraImage& image) {
    return render::read_picture(bytes, image.rgb, image.width, image.height);
  };
#else
  return {};
#endif
}

}  // namespace palpate::tools::commands
