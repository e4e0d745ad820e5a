// What a plug-in includes. One of its source files says
//
//   PALPATE_PLUGIN("jelly", [](palpate::plugin::Guests& guests) { guests.applications.add(jelly::specification()); })
//
// and CMake's palpate_add_plugin() makes the library (docs/guides/library.md). What is called may throw: then nothing
// of the plug-in is added, and the program says why.
#pragma once

#include "palpate/plugin/build.h"
#include "palpate/plugin/entry.h"
#include "palpate/plugin/guests.h"

#define PALPATE_PLUGIN(plugin_name, ...)                                                                  \
  extern "C" __attribute__((visibility("default"))) const PalpatePlugin* palpate_plugin(void) {           \
    static const PalpatePlugin told = {                                                                   \
        PALPATE_PLUGIN_ABI,                                                                               \
        sizeof(PalpatePlugin),                                                                            \
        plugin_name,                                                                                      \
        PALPATE_RELEASE,                                                                                  \
        PALPATE_COMPILER,                                                                                 \
        PALPATE_BUILD_OPTIONS,                                                                            \
        PALPATE_LAYOUT,                                                                                   \
        [](void* all_guests_) { (__VA_ARGS__)(*static_cast<::palpate::plugin::Guests*>(all_guests_)); }}; \
    return &told;                                                                                         \
  }
