#include "tools/commands/drivers.h"

#include "drivers/laboratory/driver.h"
#include "drivers/openhaptics/driver.h"
#ifndef PALPATE_PHYSICS_ALONE
#include "drivers/cameras/driver.h"
#include "drivers/openigtlink/driver.h"
#include "palpate/render/picture_file.h"
#endif

namespace palpate::tools::commands {

device::DriverRegistry built_in_drivers() {
  device::DriverRegistry registry;
  drivers::laboratory::add_to(registry);
  drivers::openhaptics::add_to(registry);
#ifndef PALPATE_PHYSICS_ALONE
  drivers::cameras::add_to(registry);
  drivers::openigtlink::add_to(registry);
#endif
  record::session::add_to(registry, jpeg_decoder());
  return registry;
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
