// Bytes as text (RFC 4648, section 4). Any thread.
#pragma once

#include <string>
#include <string_view>

namespace palpate::inline core {

std::string base64(std::string_view bytes);

}  // namespace palpate::inline core
