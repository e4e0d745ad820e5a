// The jelly as a plug-in, for a palpate that knows nothing of it.
#include "palpate/plugin/plugin.h"

#include "specification.h"

PALPATE_PLUGIN("jelly",
               [](palpate::plugin::Guests& guests) { guests.applications.add(jelly::specification()); })
