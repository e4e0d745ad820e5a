// The console: a page of a running session in a browser, and the same session for common viewers, on one port.
//
// An observer among others: it subscribes to states and asks for the status, as `palpate record` and `palpate status` do.
// Nothing waits for it, and it may end, hang or be killed at any moment. It serves pages to this machine alone unless it is
// told otherwise; it lets nobody do anything unless it is told to, and then only with a token.
//
// One thread, the caller's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/transport/server_place.h"

namespace palpate::tools::console {

struct ConsoleOptions {
  transport::ServerName server;
  std::string address = "127.0.0.1";        // a number of one of this machine's interfaces; 0.0.0.0: all
  std::uint16_t port = 8765;                // 0 = any that is free
  std::vector<std::string> hosts, origins;  // web::WebServerOptions
  bool controls =
      false;  // who has the token may reset, pause and resume, where this machine's key is an operator's
  bool look_with_token = false;  // who has not the token sees nothing either; always so beyond this machine
  bool pictures = true;          // of a graphics server on this machine (transport/shown_picture.h)
  double seconds = 0.0;          // 0 = until asked to stop
  std::function<void()> ready;   // called once, when the page can be opened; the log has where
};

// Figures of what was served. Refused where the address cannot be had or a token cannot be kept.
Expected<Json> run_console(const ConsoleOptions& options);

}  // namespace palpate::tools::console
