// The surface that deforms, as messages of palpate_recording.proto: most of it stands still most of the time, so each
// message holds what has moved since the one before, and now and then all of it, where a reader may begin.
//
// One thread each. What comes back is equal to the last bit, whatever is no number included.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/scene/shape.h"

namespace palpate::record::session {

class ShapeEncoder {
 public:
  static constexpr Duration kWholeEvery = std::chrono::seconds(5);

  // A palpate.recording.Shape. Times must not decrease.
  std::string encode(const scene::Shape& shape);

 private:
  scene::Shape last_;
  Instant<PhysicsClock> next_whole_;
};

class ShapeDecoder {
 public:
  // False: it tells of changes of a surface of which nothing whole has come yet. Refused, and nothing changed: a
  // message that is none.
  Expected<bool> decode(std::string_view bytes);
  // As the last message left it; no vertices before the first.
  const scene::Shape& shape() const { return shape_; }

 private:
  scene::Shape shape_;
};

}  // namespace palpate::record::session
