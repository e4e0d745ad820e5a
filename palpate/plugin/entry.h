/* What a plug-in tells the program that loads it: a shared library with one C function, palpate_plugin(). Plain C, so
 * that it can be asked whatever compiler or release it comes from; `abi` and `size` stay where they are for good.
 *
 * Beyond this a plug-in is C++ of the same release and options as the program, by GCC or clang (docs/decisions/0011): where
 * any of them differs it is refused, and nothing else of it is called. Source of the form, one C entry that leads to
 * everything: CLAP's clap_entry. Strings are UTF-8, end in 0 and live as long as the library. */
#ifndef PALPATE_PLUGIN_ENTRY_H
#define PALPATE_PLUGIN_ENTRY_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Of this structure. */
#define PALPATE_PLUGIN_ABI 1u
#define PALPATE_PLUGIN_ENTRY "palpate_plugin"

typedef struct PalpatePlugin {
  uint32_t abi;         /* PALPATE_PLUGIN_ABI */
  uint32_t size;        /* of this structure, bytes */
  const char* name;     /* for messages: "jelly" */
  const char* release;  /* of Palpate's headers: "0.1.0" */
  const char* compiler; /* "gcc 12"; GCC and clang fit together, others only with themselves */
  const char* options;  /* what else decides how types lie in memory */
  uint32_t layout[4];   /* sizes of the types that guests fill, bytes (palpate/plugin/build.h) */
  /* Adds to a palpate::plugin::Guests. Called once, by the main thread, before any other thread is there; may
   * throw a C++ exception, and then nothing of it is added. */
  void (*add_guests)(void* guests);
} PalpatePlugin;

/* What a plug-in exports. Not null. */
typedef const PalpatePlugin* (*PalpatePluginEntry)(void);

#ifdef __cplusplus
}
#endif

#endif
