// Network addresses as people type them.
#include "fuzz/check.h"
#include "palpate/transport/local_endpoint.h"

namespace palpate::fuzz {

Refusals endpoints(std::string_view file) {
  Refusals refusals;
  for (const auto use : {transport::EndpointUse::listen, transport::EndpointUse::connect})
    for (const bool insecure : {false, true})
      answered(transport::parse_endpoint(file, use, insecure), refusals);
  return refusals;
}

}  // namespace palpate::fuzz
