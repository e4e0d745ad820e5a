// What the simulated person is told to do by a line of JSON each (palpate/device/person_json.h) on a pipe, and what
// came of it on another: {"ready": GESTURE} once they have got there, or {"refused": WORDS, "no_more": BOOL}.
//
// For a script that does with the laboratory's person what a person would do who reads the instructions of a session.
// One thread; never waits. A line that is no request is answered as refused; the end of the pipe is no fault.
#pragma once

#include <cstdio>
#include <string>

#include "palpate/core/json.h"
#include "palpate/device/person.h"

namespace palpate::sim {

class GestureLines {
 public:
  GestureLines(int in, std::FILE* out) : in_(in), out_(out) {}
  // Reads what has come, and tells whether the person is there; about once a millisecond.
  void look(device::Person& person);

 private:
  void begin(const std::string& line, device::Person& person);
  void answer(const Json& json);

  static constexpr std::size_t kLongestLine = 4096;
  int in_;
  std::FILE* out_;
  std::string line_;
  std::string doing_;  // not there yet
};

}  // namespace palpate::sim
