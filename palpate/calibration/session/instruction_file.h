// What a session shows, as a line of JSON each, for a display of one's own or a script in a person's place: `--instructions FILE`, which
// may be a pipe.
//
// One thread at a time; each line is whole and written at once. A display that goes away does not end the session: nothing more is
// written then. Errors: wrong use for a file that cannot be written.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "palpate/calibration/session/guided_person.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/person.h"

namespace palpate::calibration::session {

class InstructionFile {
 public:
  // Without a name none of it is written.
  static Expected<std::shared_ptr<InstructionFile>> open(const std::string& name);

  // Whether what is written goes anywhere.
  bool is_open() const { return file_ != nullptr; }
  void write(const Json& instruction);
  // What the person is asked for, and in which words.
  void write(const device::Request& request, const std::string& text);
  // Which of stylus, pointer and camera the tracker sees, where that has changed; once a second at most.
  void write_seen(const PersonView& view);

 private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  Json seen_;
  double seen_s_ = 0.0;
};

}  // namespace palpate::calibration::session
