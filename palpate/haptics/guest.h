// Whose code the haptic loop depends on: who is named when forces go.
#pragma once

#include <cstdint>
#include <string>

namespace palpate::haptics {

enum class Guest : std::uint8_t {
  none,
  application,  // its step, in the physics loop
  contact_law,  // its law, in the haptic tick
  arm           // the arm's driver, in the haptic tick
};

// "the contact law of 'touch'"; empty for none.
inline std::string name_of(Guest guest, const std::string& application) {
  switch (guest) {
    case Guest::none:
      break;
    case Guest::application:
      return "the application '" + application + "'";
    case Guest::contact_law:
      return "the contact law of '" + application + "'";
    case Guest::arm:
      return "the arm's driver";
  }
  return {};
}

}  // namespace palpate::haptics
