#include "tools/commands/drivers.h"

#include "drivers/laboratory/driver.h"
#include "drivers/openhaptics/driver.h"
#ifndef PALPATE_PHYSICS_ALONE
#include "drivers/cameras/driver.h"
#include "drivers/openigtlink/driver.h"
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
  return registry;
}

}  // namespace palpate::tools::commands
