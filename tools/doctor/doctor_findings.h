// How the doctor's judges word what they found. Pure functions, any thread.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpate/core/text.h"
#include "tools/doctor/doctor_evaluate.h"

namespace palpate::tools::doctor {

inline Finding finding(const char* area, const char* name, Verdict verdict, std::string value,
                       std::string remedy = "") {
  return {area, name, verdict, excerpt(value, 400), excerpt(remedy, 400)};
}
inline Finding fine(const char* area, const char* name, std::string value) {
  return finding(area, name, Verdict::ok, std::move(value));
}
inline Finding note(const char* area, const char* name, std::string value, std::string remedy) {
  return finding(area, name, Verdict::worth_knowing, std::move(value), std::move(remedy));
}
inline Finding obstacle(const char* area, const char* name, std::string value, std::string remedy) {
  return finding(area, name, Verdict::in_the_way, std::move(value), std::move(remedy));
}

inline std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// "what; remedy" as our messages have it, in two.
inline Finding told(Verdict verdict, const char* area, const char* name, const std::string& message) {
  const auto at = message.rfind("; ");
  if (at == std::string::npos)
    return finding(area, name, verdict, message, "mend it and ask palpate doctor again");
  return finding(area, name, verdict, message.substr(0, at), message.substr(at + 2));
}

}  // namespace palpate::tools::doctor
